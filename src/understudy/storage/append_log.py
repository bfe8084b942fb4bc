"""Append-only files that survive the death of the program: records framed by their length and checksum.

A file that was cut off anywhere still reads as its complete records, and appending continues after the last of
them.
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
    """An open append-only file of records."""

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._file = self.path.open("ab")

    @classmethod
    def create(cls, path: Path | str, magic: bytes) -> Self:
        """Create a file that begins with `magic`; refuse a path that exists."""
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
        """Open an existing file to append to it, and cut off anything after its last complete record."""
        end = len(magic)
        for payload in read_log(path, magic):
            end += _FRAME.size + len(payload)
        os.truncate(path, end)
        return cls(path)

    def write(self, payload: bytes, *, sync: bool = False) -> None:
        """Append a record; with `sync`, wait until it is on disk."""
        self._file.write(_FRAME.pack(len(payload), zlib.crc32(payload)) + payload)
        if sync:
            self.sync()
        else:
            self._file.flush()

    def sync(self) -> None:
        """Wait until everything written is on disk."""
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Wait until everything written is on disk, and close the file."""
        self.sync()
        self._file.close()


def read_log(path: Path | str, magic: bytes) -> Iterator[bytes]:
    """Yield the complete records of a file, oldest first.

    Refuse a file that does not begin with `magic`, or that is damaged before further complete records.
    """
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
    """Return the record at a byte; None if it is incomplete, damaged, or all zeros as after a power cut."""
    if at + _FRAME.size > len(content):
        return None
    length, checksum = _FRAME.unpack_from(content, at)
    payload = content[at + _FRAME.size : at + _FRAME.size + length]
    return payload if payload and len(payload) == length and zlib.crc32(payload) == checksum else None


def _following(content: bytes, at: int) -> int:
    """Return the byte at which the next record would begin."""
    length, _ = _FRAME.unpack_from(content, at)
    return at + _FRAME.size + int(length)
