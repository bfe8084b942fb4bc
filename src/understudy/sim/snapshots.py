"""Snapshots: a world's arrays as bytes - one line of JSON that says what follows, then the arrays.

Records are stored without the bytes that fill them up in memory, so that equal states give equal snapshots.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError

VERSION = 1


def pack(world: str, settings: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
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


def unpack(
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
    wanted = json.loads(pack(world, settings, like).partition(b"\n")[0])
    try:
        header = json.loads(line)
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict) or header.get("understudy") != "snapshot":
        raise _refused("", "is not a snapshot", "give the bytes that snapshot() gave")
    lengths = {name: _length(header, name, wanted["arrays"][name]) for name in growing}
    for place in ("version", "world", "settings", "arrays"):
        if header.get(place) != wanted[place]:
            problem = f"is of another {place}: {header.get(place)} where this world has {wanted[place]}"
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
