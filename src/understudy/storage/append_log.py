"""Append-only files that survive being killed: framed records, each with its length and checksum.

A file cut off anywhere reads as its complete records; appending goes on after the last of them.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from struct import Struct
from typing import Self

from understudy.errors import FileError

_FRAME = Struct("<II")  # length, checksum


class AppendLog:
    """An open log; `write` appends a record, and with `sync` it is on disk when the call returns."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._file = self.path.open("ab")

    @classmethod
    def create(cls, path: Path | str, magic: bytes) -> Self:
        """Begin a log; FileError where the file exists already."""
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            path.touch(exist_ok=False)
        except FileExistsError:
            raise FileError(
                path=path,
                place="",
                problem="this journal exists already",
                remedy="resume it, or name another file",
            ) from None
        log = cls(path)
        log._file.write(magic)
        log.sync()
        directory = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)
        return log

    @classmethod
    def append(cls, path: Path | str, magic: bytes) -> Self:
        """Go on with a log: what follows its last complete record is cut off."""
        end = len(magic)
        for payload in read_log(path, magic):
            end += _FRAME.size + len(payload)
        os.truncate(path, end)
        return cls(path)

    def write(self, payload: bytes, *, sync: bool = False) -> None:
        """Append a record."""
        self._file.write(_FRAME.pack(len(payload), zlib.crc32(payload)) + payload)
        if sync:
            self.sync()
        else:
            self._file.flush()

    def sync(self) -> None:
        """Put everything on disk."""
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Put everything on disk and close."""
        self.sync()
        self._file.close()


def read_log(path: Path | str, magic: bytes) -> Iterator[bytes]:
    """The complete records of a log, oldest first; FileError where it is no such log, or damaged in its middle."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise FileError(
            path=path,
            place="",
            problem=f"cannot be read ({error.strerror})",
            remedy="name a session's journal",
        ) from None
    if not content.startswith(magic):
        known = magic.decode("ascii").strip()
        raise FileError(
            path=path,
            place="its first bytes",
            problem="it is not a journal that this version can read",
            remedy=f"name a session's journal (it begins with {known!r})",
        )
    at = len(magic)
    while (payload := _record(content, at)) is not None:
        yield payload
        at += _FRAME.size + len(payload)
    if at + _FRAME.size < len(content) and _record(content, _following(content, at)) is not None:
        raise FileError(  # going on would cut off what is complete
            path=path,
            place=f"byte {at}",
            problem="it is damaged there, though complete records follow",
            remedy="take it from a backup, or keep a copy and cut the file off there to go on from before",
        )


def _record(content: bytes, at: int) -> bytes | None:
    """The record there; None where it is torn, or, after a power cut, zeros."""
    if at + _FRAME.size > len(content):
        return None
    length, checksum = _FRAME.unpack_from(content, at)
    payload = content[at + _FRAME.size : at + _FRAME.size + length]
    return payload if payload and len(payload) == length and zlib.crc32(payload) == checksum else None


def _following(content: bytes, at: int) -> int:
    """Where the record after this one would begin."""
    length, _ = _FRAME.unpack_from(content, at)
    return at + _FRAME.size + int(length)
