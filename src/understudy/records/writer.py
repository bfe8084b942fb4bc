"""Writer of recordings: a thread that compresses queued messages and puts them on disk as a chunk within a second.

If the program is killed, the file can be read up to its last chunk.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from typing import IO, Any, NamedTuple

from understudy.clock import REAL_TIME, Clock
from understudy.errors import FileError
from understudy.extras import ExtraMissing
from understudy.records.header import name_metadata
from understudy.records.message_types import format_type_definition
from understudy.records.messages import is_known_type
from understudy.storage.atomic_write import check_file_place

PROFILE, LIBRARY = "ros2", "understudy"
CHUNK_S = 1.0
"""The longest time until a message is on disk, in s, which is what a killed run loses."""
REMEDY = "name a file in a folder you may write to"
MOST_WAITING = 256 * 2**20
"""The largest number of bytes that may wait for a slow disk."""


class _ChannelSpec(NamedTuple):
    """A topic to be declared in the file before its first message."""

    topic: str
    type: str
    definition: str


class RecordingWriter:
    """A new MCAP file that is being written; all methods may be called from any thread.

    FileError is raised if the file exists already or cannot be written. `clock` says when a chunk is due.
    """

    def __init__(self, path: Path | str, *, clock: Clock = REAL_TIME) -> None:
        writer = _mcap()
        self.problem = ""
        """The reason why nothing more is written; empty if there is none."""
        self._path = Path(path)
        self._file = _opened(self._path)
        self._queue: SimpleQueue[Any] = SimpleQueue()
        self._queued, self._clock = Event(), clock
        self._waiting, self._lock, self._closed = 0, Lock(), False
        self._channels: list[int] = []
        self._whole = 0  # bytes that hold whole chunks
        self._writer = writer(self._file)
        self._writer.start(profile=PROFILE, library=LIBRARY)
        self._thread = Thread(target=self._write, name="recorder", daemon=True)
        self._thread.start()

    def write_header(self, entries: dict[str, str], *, part: str = "") -> None:
        """Write the header of a run, or of a part of the recording."""
        self._put((name_metadata(part), entries))

    def add_topic(self, topic: str, type: str) -> None:
        """Declare a topic; topics are numbered from 0 in this order."""
        self._put(_ChannelSpec(topic, type, format_type_definition(type) if is_known_type(type) else ""))

    def write_message(self, number: int, data: bytes, at_ns: int) -> None:
        """Queue a message of a topic, by the topic's number, with its arrival time (ns since 1970).

        It raises nothing; see `problem`.
        """
        with self._lock:
            if self._waiting > MOST_WAITING:
                self.problem = self.problem or "the disk is too slow"
            if self.problem or self._closed:
                return
            self._waiting += len(data)
        self._put((number, data, at_ns))

    def close(self) -> bool:
        """Finish the file; return whether it was still open."""
        if self._closed:
            return False
        self._closed = True
        self._put(None)
        self._thread.join()
        return True

    def _put(self, item: Any) -> None:
        self._queue.put(item)
        self._queued.set()

    def _take(self) -> Iterator[Any]:
        """Yield what is queued."""
        self._queued.clear()
        with suppress(Empty):
            while True:
                yield self._queue.get_nowait()

    def _write(self) -> None:
        """Write queued messages in the writer's thread; store an error in `problem`, which the next tick reports."""
        try:
            self._write_all()
        except Exception as error:
            self.problem = (error.strerror or str(error)) if isinstance(error, OSError) else repr(error)
            with suppress(OSError, ValueError):
                self._file.close()
            with suppress(OSError):
                if self._whole:
                    os.truncate(self._path, self._whole)
                else:
                    self._path.unlink()

    def _write_all(self) -> None:
        ended, due_s = False, inf  # when what was added since the last chunk has to be on disk
        while not ended:
            self._clock.wait(self._queued, min(CHUNK_S, due_s - self._clock()))
            for item in self._take():
                if item is None:
                    ended = True
                    break
                self._add(item)
                due_s = self._flush_if_due(min(due_s, self._clock() + CHUNK_S))
            due_s = self._flush_if_due(due_s)
        self._flush()
        self._writer.finish()
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def _add(self, item: Any) -> None:
        if isinstance(item, _ChannelSpec):
            self._channels.append(self._registered(item))
        elif len(item) == 2:
            self._writer.flush()
            self._writer.add_metadata(*item)
            self._flush()
        else:
            number, data, at_ns = item
            with self._lock:
                self._waiting -= len(data)
            self._writer.add_message(self._channels[number], at_ns, data, at_ns)

    def _flush_if_due(self, due_s: float) -> float:
        """Put a chunk on disk if that is due; return when it will be, s; infinity if nothing is left."""
        if self._clock() < due_s:
            return due_s
        self._flush()
        return inf

    def _flush(self) -> None:
        self._writer.flush()
        os.fsync(self._file.fileno())
        self._whole = self._file.tell()

    def _registered(self, topic: _ChannelSpec) -> int:
        defined = bool(topic.definition)
        schema = self._writer.register_schema(
            topic.type, "ros2msg" if defined else "", topic.definition.encode()
        )
        quality = {"offered_qos_profiles": ""}  # as rosbag2 has it: unknown, so a player takes its default
        return int(self._writer.register_channel(topic.topic, "cdr", schema, quality))


def check_recording_path(path: Path | str) -> None:
    """Refuse a file that exists or that cannot be written, with FileError, before a recording begins."""
    path = Path(path)
    if path.exists():
        raise _make_error(path, FileExistsError())
    check_file_place(path, "recording", remedy=REMEDY)


def _opened(path: Path) -> IO[bytes]:
    """Open a new file; refuse to overwrite an existing one."""
    try:
        return path.open("xb")
    except OSError as error:
        raise _make_error(path, error) from None


def _make_error(path: Path, error: OSError) -> FileError:
    if isinstance(error, FileExistsError):
        problem, remedy = "is there already", "name another file, or move that one away"
    else:
        problem, remedy = f"cannot be written ({error.strerror or error})", REMEDY
    return FileError(path=path, place="", problem=problem, remedy=remedy)


def _mcap() -> Any:
    """Import the class that writes MCAP; raise ExtraMissing if it is not installed."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    return Writer
