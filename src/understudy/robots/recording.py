"""Recordings: all messages of a run and all it decided, in one MCAP file that ROS 2 and Foxglove open.

Whoever records only hands bytes over; a thread of its own compresses and writes them, a chunk each second. What is
killed leaves a file that can be read up to its last chunk.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import IO, Any, NamedTuple, Self

import numpy as np

from understudy.errors import FileError, UnderstudyError
from understudy.model.feature import Percept, ReadingKey
from understudy.robots.messages import encode, known, make
from understudy.robots.recording_head import METADATA, Head, Ran, head_entries
from understudy.robots.recording_types import (
    READINGS,
    STATES,
    TEXT,
    TRANSITION,
    Readings,
    States,
    definition,
    known_types,
    label,
    text,
)
from understudy.robots.transitions import transition, within
from understudy.robots.transport import ExtraMissing, Peer, Publish, Received, Transport
from understudy.runtime.body import Body

PROFILE, LIBRARY = "ros2", "understudy"
CHUNK_S = 1.0
"""How often what was handed over is put on disk: a killed run loses that much."""
MOST_WAITING = 256 * 2**20
"""So many bytes may wait for a disk that is slow."""
TOPICS = {READINGS: "understudy/readings", STATES: "understudy/states", TRANSITION: "understudy/switched"}
"""Ours, within the namespace of each robot."""
PRESSES = "understudy/presses"
"""What a person pressed, as std_msgs/String: the name of a state; empty confirms the current one."""
STEPS = "understudy/session"
"""What else was done, as std_msgs/String: test, train or restart, with the body's time."""


class RecordingFailed(UnderstudyError):
    """A recording that cannot go on; what was written until then can be read."""

    exit_code = 1

    def __init__(self, *, path: Path, problem: str) -> None:
        self.path, self.problem = str(path), problem
        super().__init__(f"{path}: recording ended: {problem}; make room, or run it without --record")


class _Topic(NamedTuple):
    """A topic to be made known in the file, before its first message."""

    topic: str
    type: str
    definition: str


class Recorder:
    """Writes a recording, from `begin` on with what is decided; FileError where the file is there or cannot be.

    `clock` is what messages are stamped with on arrival, s: `time.monotonic`, or a simulation's.
    """

    def __init__(self, path: Path | str, *, clock: Callable[[], float] = time.monotonic) -> None:
        known_types()
        writer = _mcap()
        self.path, self._clock = Path(path), clock
        self._began_ns = time.time_ns() - round(clock() * 1e9)
        self._topics: dict[tuple[str, str], int] = {}
        self._queue: SimpleQueue[Any] = SimpleQueue()
        self._waiting, self._lock = 0, Lock()
        self._problem, self._closed = "", False
        self._agents: list[_Agent] = []
        self._names: Sequence[str] = ()
        self._body: Body | None = None
        self._file = _opened(self.path)
        self._whole = 0  # bytes that hold whole chunks
        self._writer = writer(self._file)
        self._writer.start(profile=PROFILE, library=LIBRARY)
        self._thread = Thread(target=self._write, name="recorder", daemon=True)
        self._thread.start()

    def begin(
        self,
        body: Body,
        *,
        names: Sequence[str] = (),
        ran: Ran | None = None,
        files: Mapping[str, str] | None = None,
    ) -> None:
        """Say what is recorded, before its first tick: a body, its agents' namespaces, what runs, files as they are.

        Said again, the run begins anew; replayed is the last one.
        """
        names = names or [f"robot{number}" if body.agents > 1 else "" for number in range(body.agents)]
        self._names, self._body = tuple(names), body
        # Before the topics of its agents, which whoever reads it knows by their names.
        self._queue.put(head_entries(Head.of(body, names, ran or Ran(), files or {})))
        self._agents = [_Agent(self, name) for name in names]

    def tape(self, topic: str, type: str) -> Callable[[bytes, float | None], None]:
        """What keeps messages of a topic, with when they came by the clock (None: now); from any thread."""
        with self._lock:
            number = self._topics.get((topic, type))
            if number is None:
                number = self._topics[topic, type] = len(self._topics)
                self._queue.put(_Topic(topic, type, definition(type) if known(type) else ""))

        def keep(data: bytes, at_s: float | None = None) -> None:
            self._put(number, data, self._clock() if at_s is None else at_s)

        return keep

    def decided(
        self, time_s: float, percept: Percept, paths: Sequence[Sequence[str]], *, at_s: float | None = None
    ) -> None:
        """One tick, once it was decided: the body's time, its readings, and the states of all levels of each agent.

        RecordingFailed where something before could not be written, so that what cannot be recorded stops.
        """
        if self._problem:
            raise RecordingFailed(path=self.path, problem=self._problem)
        at = self._clock() if at_s is None else at_s
        values = np.array(list(percept.values())) if percept else np.empty((0, len(self._agents)))
        keys = tuple(percept)
        for number, (agent, path) in enumerate(zip(self._agents, paths, strict=True)):
            agent.decided(time_s, keys, values[:, number], tuple(path), at)

    def pressed(self, state: str | None, *, agent: int = 0) -> None:
        """A person directed an agent to a state, or confirmed the current one (None): it acts at the next tick."""
        self.noted(PRESSES, state or "", agent=agent)

    def stepped(self, step: str, *, agent: int = 0) -> None:
        """Something else came before the next tick: a session's test or train, a restart in a session or a run."""
        at = "" if self._body is None else f" {self._body.time_s!r}"
        self.noted(STEPS, step + at, agent=agent)

    def noted(self, topic: str, content: str, *, agent: int = 0) -> None:
        """Anything else worth keeping, as text on a topic in the namespace of an agent."""
        name = self._names[agent] if self._names else ""
        self.tape(within(name, topic), TEXT)(text(content), None)

    def close(self) -> None:
        """Finish the file; RecordingFailed where it could not be written."""
        if self._closed:
            return
        self._closed = True
        self._queue.put(None)
        self._thread.join()
        if self._problem:
            raise RecordingFailed(path=self.path, problem=self._problem)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:  # what ended the run matters more than what ended its recording
            with suppress(RecordingFailed):
                self.close()

    def _put(self, number: int, data: bytes, at_s: float) -> None:
        with self._lock:
            if self._waiting > MOST_WAITING:
                self._problem = self._problem or "the disk is too slow"
            if self._problem or self._closed:
                return
            self._waiting += len(data)
        self._queue.put((number, data, self._began_ns + round(at_s * 1e9)))

    def _write(self) -> None:
        """The thread that writes; whatever goes wrong here is told by the next tick."""
        try:
            self._write_all()
        except Exception as error:
            self._problem = (error.strerror or str(error)) if isinstance(error, OSError) else repr(error)
            with suppress(OSError, ValueError):
                self._file.close()
            with suppress(OSError):
                os.truncate(self.path, self._whole)

    def _write_all(self) -> None:
        channels: list[int] = []
        due = time.monotonic() + CHUNK_S
        while True:
            try:
                item = self._queue.get(timeout=max(0.0, due - time.monotonic()))
            except Empty:
                item = ()
            if item is None:
                break
            if isinstance(item, _Topic):
                channels.append(self._registered(item))
            elif isinstance(item, dict):
                self._writer.flush()
                self._writer.add_metadata(METADATA, item)
            elif item:
                number, data, at_ns = item
                with self._lock:
                    self._waiting -= len(data)
                self._writer.add_message(channels[number], at_ns, data, at_ns)
            if time.monotonic() >= due:
                self._flush()
                due = time.monotonic() + CHUNK_S
        self._flush()
        self._writer.finish()
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()

    def _flush(self) -> None:
        self._writer.flush()
        os.fsync(self._file.fileno())
        self._whole = self._file.tell()

    def _registered(self, topic: _Topic) -> int:
        defined = bool(topic.definition)
        schema = self._writer.register_schema(
            topic.type, "ros2msg" if defined else "", topic.definition.encode()
        )
        quality = {"offered_qos_profiles": ""}  # as rosbag2 has it: unknown, so a player takes its default
        return int(self._writer.register_channel(topic.topic, "cdr", schema, quality))


class _Agent:
    """The messages of one agent."""

    def __init__(self, recorder: Recorder, name: str) -> None:
        self._name, self._path = name, tuple[str, ...]()
        self._keys: tuple[ReadingKey, ...] = ()
        self._readings, self._states = Readings(()), States()
        self._tapes = {type: recorder.tape(within(name, topic), type) for type, topic in TOPICS.items()}

    def decided(
        self, time_s: float, keys: tuple[ReadingKey, ...], values: Any, path: tuple[str, ...], at_s: float
    ) -> None:
        if keys != self._keys:
            self._keys, self._readings = keys, Readings([label(key) for key in keys])
        self._tapes[READINGS](self._readings.encode(time_s, values), at_s)
        self._tapes[STATES](self._states.encode(time_s, path), at_s)
        changed = transition(self._path, path)
        if changed is not None:
            self._path = path
            told = make(TRANSITION, time_s=time_s, robot=self._name, path=list(path), **changed._asdict())
            self._tapes[TRANSITION](encode(TRANSITION, told), at_s)


class Taped:
    """A transport whose messages in and out are recorded as they go over it, beside being handed on."""

    def __init__(self, transport: Transport, recorder: Recorder) -> None:
        self._transport, self._recorder = transport, recorder
        self._heard: set[tuple[str, str]] = set()

    def subscribe(self, topic: str, type: str, received: Received) -> None:
        """Hand each message of a topic to `received`, and keep it; once, however many listen."""
        if (topic, type) in self._heard:
            self._transport.subscribe(topic, type, received)
            return
        self._heard.add((topic, type))
        keep = self._recorder.tape(topic, type)

        def both(data: bytes, at_s: float) -> None:
            keep(data, at_s)
            received(data, at_s)

        self._transport.subscribe(topic, type, both)

    def publisher(self, topic: str, type: str) -> Publish:
        """What publishes on a topic, and keeps what it published."""
        publish, keep = self._transport.publisher(topic, type), self._recorder.tape(topic, type)

        def both(data: bytes) -> None:
            publish(data)
            keep(data, None)

        return both

    def peers(self) -> Sequence[Peer]:
        """All others who publish."""
        return self._transport.peers()

    def close(self) -> None:
        """Leave; the recording goes on until its recorder is closed."""
        self._transport.close()


def _opened(path: Path) -> IO[bytes]:
    """A new file; one that is there is kept."""
    try:
        return path.open("xb")
    except OSError as error:
        there = isinstance(error, FileExistsError)
        problem = "is there already" if there else f"cannot be written ({error.strerror or error})"
        remedy = (
            "name another file, or move that one away"
            if there
            else "name a file in a folder you may write to"
        )
        raise FileError(path=path, place="", problem=problem, remedy=remedy) from None


def _mcap() -> Any:
    """What writes MCAP."""
    try:
        from mcap.writer import Writer
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    return Writer
