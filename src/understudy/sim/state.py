"""The state of B worlds side by side as plain arrays: what kernels read and change, snapshots keep, frames show.

Robots are rows, world by world: world w has rows w*N to (w+1)*N. What every world has its own of is [B, …].
All is in m, s and rad; in TYPE, per tick. Records keep what is used together in one place of memory.
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
    """What stays the same in every world of a scenario."""

    types: Records
    """TYPE [T]."""
    classes: Records
    """CLASS [C]; the slots of a class lie side by side, and a world's spare ones at the end of its class."""
    class_of: NDArray[np.int32]
    """The class of each object slot [K]."""
    width: float
    height: float
    tick_s: float
    robots: int
    """N, robots in each world."""
    goal: int
    goal_target: int
    """Index of a class of objects."""
    goal_within: float
    goal_count: int
    """Boxes to gather."""
    signals: int
    """How many signals there are."""


class WorldState(NamedTuple):
    """Everything that changes, and everything that a seed lays out."""

    robots: Records
    """ROBOT [B*N]."""
    objects: Records
    """OBJECT [B, K]."""
    discs: Records
    """DISC [B, O]."""
    segments: Records
    """SEGMENT [B, S]: inner walls and edges of polygons; the arena's own bounds are not among them."""
    seeds: NDArray[np.int64]
    """[B]."""
    tick: NDArray[np.int64]
    """Ticks since the last reset [B]."""
    finished: NDArray[np.int64]
    """The tick at which the goal was first reached [B]; -1 not yet."""
    memory: NDArray[np.float64]
    """What sensors remember [B*N, H]: last answers, and ticks at which something was last there."""


VERSION = 1


def encode_snapshot(world: str, settings: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The arrays of a world with these settings."""
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
    """New arrays from a snapshot of a world with these settings and such arrays; FileError for any other.

    Arrays [B, K] that are `growing` may be of another length K.
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
    """The length that a growing array has in a snapshot, which is from now on the one that is wanted."""
    try:
        length = header["arrays"][name][1][1]
    except (LookupError, TypeError):
        length = wanted[1][1]
    if type(length) is int and length >= 0:
        wanted[1][1] = length
    return int(wanted[1][1])


def _stored(kind: np.dtype[Any]) -> np.dtype[Any]:
    """How numbers or records are stored: little-endian, nothing between them."""
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
