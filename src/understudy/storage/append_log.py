"""Append-only files that survive the end of the program: records framed by their length and checksum.

A file that was cut off anywhere still reads as its complete records, and appending continues after the last of
them.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from struct import Struct
from typing import Self

from understudy.errors import FileError

try:
    import fcntl
except ImportError:  # pragma: no cover - Windows: a session that runs is not told from one that was killed
    fcntl = None  # type: ignore[assignment]

_FRAME = Struct("<II")  # length, checksum


class JournalLock:
    """A lock on a log that is being written; the system releases it when the process ends, however it ends."""

    def __init__(self, file: BufferedReader) -> None:
        self._file = file

    @classmethod
    def try_acquire(cls, path: Path | str) -> Self | None:
        """Lock a log; return None if another session has locked it, and raise FileError if it cannot be read."""
        path = Path(path)
        try:
            file = path.open("rb")
        except OSError as error:
            raise _unreadable(path, error) from None
        if fcntl is not None:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                file.close()
                return None
        return cls(file)

    @classmethod
    def acquire(cls, path: Path | str) -> Self:
        """Lock a log; raise FileError if another session has locked it."""
        lock = cls.try_acquire(path)
        if lock is None:
            raise FileError(
                path=Path(path),
                place="",
                problem="another session is writing it",
                remedy="end that session first",
            )
        return lock

    def release(self) -> None:
        """Release the lock."""
        self._file.close()


class AppendLog:
    """An open log, to which `write` appends records; with `sync`, a record is on disk when the call returns.

    It holds the log's lock until it is closed, because records of two writers would mix.
    """

    def __init__(self, path: Path | str, lock: JournalLock | None = None) -> None:
        self.path = Path(path)
        self._lock = lock or JournalLock.acquire(self.path)
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
    def append(cls, path: Path | str, magic: bytes, *, lock: JournalLock | None = None) -> Self:
        """Open a log to continue it, and cut off what follows its last complete record.

        `lock` is the log's lock if the caller holds it already.
        """
        lock = lock or JournalLock.acquire(Path(path))
        try:
            end = len(magic) + sum(_FRAME.size + len(payload) for payload in read_log(path, magic))
            os.truncate(path, end)
            return cls(path, lock)
        except BaseException:
            lock.release()
            raise

    def write(self, payload: bytes, *, sync: bool = False) -> None:
        """Append a record; with `sync`, wait until it is on disk. FileError if the log is closed."""
        if self._file.closed:
            raise FileError(
                path=self.path,
                place="",
                problem="this journal is closed",
                remedy="continue it with Session.resume",
            )
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
        """Wait until everything written is on disk, and close the file; later calls do nothing."""
        if self._file.closed:
            return
        self.sync()
        self._file.close()
        self._lock.release()


def read_log(path: Path | str, magic: bytes) -> Iterator[bytes]:
    """Yield the complete records of a file, oldest first.

    Refuse a file that does not begin with `magic`, or that is damaged before further complete records.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise _unreadable(Path(path), error) from None
    if not content.startswith(magic):
        name = magic.decode("ascii").strip()
        raise FileError(
            path=Path(path),
            place="its first bytes",
            problem="it is not a journal that this version can read",
            remedy=f"name a session's journal (it begins with {name!r})",
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
            remedy="restore a backup, or keep a copy and truncate the file there",
        )


def _unreadable(path: Path, error: OSError) -> FileError:
    problem = f"cannot be read ({error.strerror})"
    return FileError(path=path, place="", problem=problem, remedy="name a session's journal")


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
