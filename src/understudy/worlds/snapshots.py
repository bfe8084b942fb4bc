"""Snapshots: a world's arrays as bytes - one line of JSON that says what follows, then the arrays."""

from __future__ import annotations

import json
from collections.abc import Mapping
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
        "arrays": {name: [array.dtype.newbyteorder("<").str, array.shape] for name, array in arrays.items()},
    }
    body = b"".join(_little(array).tobytes() for array in arrays.values())
    return json.dumps(header).encode() + b"\n" + body


def _little(array: NDArray[Any]) -> NDArray[Any]:
    """An array as every machine writes it, with zeros between the fields of a record, where memory holds anything."""
    little = np.zeros(array.shape, array.dtype.newbyteorder("<"))
    if array.dtype.names is None:
        little[...] = array
    for name in array.dtype.names or ():
        little[name] = array[name]
    return little


def unpack(
    snapshot: bytes, world: str, settings: Mapping[str, Any], like: Mapping[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """New arrays from a snapshot of a world with these settings and such arrays; FileError for any other."""
    line, _, body = snapshot.partition(b"\n")
    wanted = json.loads(pack(world, settings, like).partition(b"\n")[0])
    try:
        header = json.loads(line)
    except ValueError:
        header = None
    if not isinstance(header, dict) or header.get("understudy") != "snapshot":
        raise _refused("", "is not a snapshot", "give the bytes that snapshot() gave")
    for place in ("version", "world", "settings", "arrays"):
        if header.get(place) != wanted[place]:
            problem = f"is of another {place}: {header.get(place)} where this world has {wanted[place]}"
            raise _refused(place, problem, "restore it in a world like the one it was taken of")
    if len(body) != sum(array.nbytes for array in like.values()):
        raise _refused("arrays", "is cut short or too long", "take it again")
    arrays: dict[str, NDArray[Any]] = {}
    for name, array in like.items():
        stored = np.frombuffer(body[: array.nbytes], array.dtype.newbyteorder("<"))
        arrays[name] = stored.reshape(array.shape).astype(array.dtype)
        body = body[array.nbytes :]
    return arrays


def _refused(place: str, problem: str, remedy: str) -> FileError:
    return FileError(path="snapshot", place=place, problem=problem, remedy=remedy)
