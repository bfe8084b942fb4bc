"""The state of B worlds as plain arrays, which kernels change, and snapshots as bytes.

Robots are rows: world w has rows w*N to (w+1)*N. Other arrays begin with the world, [B, …]. Units are m, s and rad;
speeds in TYPE are per tick. The fields of a record are adjacent in memory.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.sim.kernels.dtypes import CLASS, DISC, OBJECT, ROBOT, SEGMENT, TYPE

__all__ = ["CLASS", "DISC", "OBJECT", "ROBOT", "SEGMENT", "TYPE", "Records", "WorldParams", "WorldState"]

Records = NDArray[Any]

GOAL_NONE, GOAL_DELIVERED, GOAL_NEAR, GOAL_ALL_NEAR, GOAL_GATHERED = range(5)


class WorldParams(NamedTuple):
    """The arrays and numbers that are the same in every world of a scenario."""

    types: Records
    """TYPE [T], the robot types."""
    classes: Records
    """CLASS [C], the classes of objects; the slots of a class are adjacent, with its spare ones at the end."""
    class_of: NDArray[np.int32]
    """The index of the class of each object slot [K]."""
    width: float
    height: float
    tick_s: float
    robots: int
    """N, the number of robots in each world."""
    goal: int
    goal_target: int
    """The index of a class of objects; -1 for none."""
    goal_within: float
    goal_count: int
    """The number of boxes to gather."""
    signals: int
    """The number of signals."""
    generator: int
    """The generator of random numbers."""


class WorldState(NamedTuple):
    """The data of worlds that change, or that a seed lays out."""

    robots: Records
    """ROBOT [B*N]."""
    objects: Records
    """OBJECT [B, K]."""
    discs: Records
    """DISC [B, O]."""
    segments: Records
    """SEGMENT [B, S]: inner walls and edges of polygons, without the arena's outer walls."""
    seeds: NDArray[np.int64]
    """The seed of each world [B]."""
    tick: NDArray[np.int64]
    """The number of ticks since the last reset [B]."""
    finished: NDArray[np.int64]
    """The tick at which the goal was first reached [B]; -1 if it was not."""
    memory: NDArray[np.float64]
    """The memory of sensors [B*N, H]: last readings, and ticks at which something was last present."""


VERSION = 1


def encode_snapshot(world: str, settings: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Encode the arrays of a world, with its kind and settings, as bytes."""
    header = {
        "understudy": "snapshot",
        "version": VERSION,
        "world": world,
        "settings": settings,
        "arrays": {name: [_spelled(array.dtype), array.shape] for name, array in arrays.items()},
    }
    body = b"".join(array.astype(_stored(array.dtype)).tobytes() for array in arrays.values())
    return json.dumps(header).encode() + b"\n" + body


def decode_snapshot(
    snapshot: bytes,
    world: str,
    settings: Mapping[str, Any],
    like: Mapping[str, NDArray[Any]],
    *,
    growing: Collection[str] = (),
) -> dict[str, NDArray[Any]]:
    """Decode the arrays of a snapshot; raise FileError if its world, settings, or array types and shapes differ.

    Arrays [B, K] whose names are in `growing` may have another length K.
    """
    if not isinstance(snapshot, bytes):
        raise _refused("", "is not a snapshot", "give the bytes that snapshot() gave")
    line, _, body = snapshot.partition(b"\n")
    wanted = json.loads(encode_snapshot(world, settings, like).partition(b"\n")[0])
    try:
        header = json.loads(line)
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict) or header.get("understudy") != "snapshot":
        raise _refused("", "is not a snapshot", "give the bytes that snapshot() gave")
    lengths = {name: _length(header, name, wanted["arrays"][name]) for name in growing}
    for place in ("version", "world", "settings", "arrays"):
        if header.get(place) != wanted[place]:
            problem = f"belongs to another {place}: {header.get(place)}, but this world has {wanted[place]}"
            raise _refused(place, problem, "restore it in a world like the one it was taken of")
    arrays: dict[str, NDArray[Any]] = {}
    for name, array in like.items():
        shape = (array.shape[0], lengths[name]) if name in lengths else array.shape
        kind, count = _stored(array.dtype), int(np.prod(shape, dtype=np.int64))
        if len(body) < count * kind.itemsize:
            raise _cut()
        stored = np.frombuffer(body, kind, count)
        arrays[name] = np.zeros(shape, array.dtype)
        arrays[name][...] = stored.reshape(shape)
        body = body[count * kind.itemsize :]
    if body:
        raise _cut()
    return arrays


def _length(header: dict[str, Any], name: str, wanted: list[Any]) -> int:
    """Return the length K of a growing array in a snapshot, and write it to `wanted`."""
    try:
        length = header["arrays"][name][1][1]
    except (LookupError, TypeError):
        length = wanted[1][1]
    if type(length) is int and length >= 0:
        wanted[1][1] = length
    return int(wanted[1][1])


def _stored(kind: np.dtype[Any]) -> np.dtype[Any]:
    """Return the type in which numbers or records are stored: little-endian, without padding."""
    little = kind.newbyteorder("<")
    if little.names is None:
        return little
    return np.dtype([(name, little[name]) for name in little.names])


def _spelled(kind: np.dtype[Any]) -> Any:
    return _stored(kind).str if kind.names is None else _stored(kind).descr


def _cut() -> FileError:
    return _refused("arrays", "is cut short or too long", "take it again")


def _refused(place: str, problem: str, remedy: str) -> FileError:
    return FileError(path="snapshot", place=place, problem=problem, remedy=remedy)
