"""Recorder of runs: all messages and all decisions in one MCAP file, which ROS 2 and Foxglove can open.

The recorder only queues the bytes; a thread in `writer.py` writes them.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Any, Self

import numpy as np

from understudy.clock import REAL_TIME, Clock, measure_clock_offset
from understudy.errors import UnderstudyError
from understudy.model.features import Percept, ReadingKey, format_reading_label
from understudy.records.header import RecordingHeader, RunInfo, encode_header
from understudy.records.message_types import (
    READINGS,
    STATES,
    TEXT,
    TRANSITION,
    ReadingsEncoder,
    StatesEncoder,
    detect_state_change,
    encode_text,
    register_message_types,
    resolve_topic_name,
)
from understudy.records.messages import encode_message, make_message
from understudy.records.writer import RecordingWriter
from understudy.runtime.body import Body, Commands

TOPICS = {READINGS: "understudy/readings", STATES: "understudy/states", TRANSITION: "understudy/switched"}
"""The topics of our own messages by type, within the namespace of each robot."""
COMMANDS = "understudy/commands"
"""The topic of the commands of each tick, of the same type as the readings: what was decided, before any limit."""
PRESSES = "understudy/presses"
"""The topic of a person's presses, as std_msgs/String: the name of a state; empty to confirm the current one."""
DUTIES = "understudy/duties"
"""The topic of what an agent of a team begins, within the namespace of the robot, or of the squad and its agent."""
SENT, HEARD = "understudy/sent", "understudy/heard"
"""The topics of the messages between agents, within the namespace of the agent that recorded them."""
STEPS = "understudy/session"
"""The topic of other steps, as std_msgs/String: test, train or restart, with the body's time in s."""


class RecordingFailed(UnderstudyError, json_type="RecordingFailed"):
    """A recording that cannot continue; what was written until then can be read."""

    exit_code = 1

    def __init__(self, *, path: Path | str, problem: str) -> None:
        self.path, self.problem = str(path), problem
        super().__init__(f"{path}: recording ended: {problem}; free space, or continue without a recording")


class RunRecorder:
    """A recorder of a run, which records messages from the start and decisions from `begin` on.

    FileError is raised if the file exists or cannot be written. `clock` gives the time with which messages are
    stamped on arrival, in s: `time.monotonic`, or a simulation's. Stamps are dates: that of `date`, in ns since 1970,
    when the recorder is made, and the time of `clock` since then, so that setting the date changes no interval.
    `chunks` is the clock by which messages are put on disk.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        clock: Callable[[], float] = time.monotonic,
        date: Callable[[], int] = time.time_ns,
        chunks: Clock = REAL_TIME,
    ) -> None:
        register_message_types()
        self.path, self._clock = Path(path), clock
        self._began_ns = measure_clock_offset(clock, date)
        self._topics: dict[tuple[str, str], int] = {}
        self._lock = Lock()
        self._agents: list[AgentChannels] = []
        self._names: Sequence[str] = ()
        self._body: Body | None = None
        self._writer = RecordingWriter(self.path, clock=chunks)

    def begin(
        self,
        body: Body,
        *,
        names: Sequence[str] = (),
        ran: RunInfo | None = None,
        files: Mapping[str, str] | None = None,
    ) -> None:
        """Begin a run, before its first tick, with a body, its agents' namespaces, what runs, and files to store.

        Each call begins a new run; readers take the last one by default.
        """
        names = names or [f"robot{number}" if body.agents > 1 else "" for number in range(body.agents)]
        self._names, self._body = tuple(names), body
        # Before the topics of its agents: a reader needs their names to recognize these.
        self._writer.write_header(
            encode_header(RecordingHeader.from_body(body, names, ran or RunInfo(), files or {}))
        )
        self._agents = [AgentChannels(self, name) for name in names]

    def open_part(
        self, part: str, body: Body, *, ran: RunInfo, files: Mapping[str, str] | None = None
    ) -> AgentChannels:
        """Begin a part of the recording with a body of one agent, and return where its ticks are recorded."""
        self._writer.write_header(
            encode_header(RecordingHeader.from_body(body, [part], ran, files or {})), part=part
        )
        return AgentChannels(self, part)

    def open_topic(self, topic: str, type: str) -> Callable[[bytes, float | None], None]:
        """Make a function that records messages of a topic with their arrival times (s of the clock; None: now).

        The function may be called from any thread.
        """
        with self._lock:
            number = self._topics.get((topic, type))
            if number is None:
                number = self._topics[topic, type] = len(self._topics)
                self._writer.add_topic(topic, type)

        def keep(data: bytes, at_s: float | None = None) -> None:
            at_s = self._clock() if at_s is None else at_s
            self._writer.write_message(number, data, self._began_ns + round(at_s * 1e9))

        return keep

    def write_tick(
        self,
        time_s: float,
        percept: Percept,
        paths: Sequence[Sequence[str]],
        *,
        commands: Commands | None = None,
        at_s: float | None = None,
    ) -> None:
        """Record a tick after its decisions.

        `time_s` is the body's time (s), `percept` its readings, and `paths` has the states of all levels of each
        agent. `commands` has a column per channel (None: not recorded). `at_s` is the time by the recorder's clock
        (None: now). RecordingFailed is raised if something before could not be written, so that a run ends that
        cannot be recorded.
        """
        self.check()
        at = self._clock() if at_s is None else at_s
        values = np.array(list(percept.values())) if percept else np.empty((0, len(self._agents)))
        keys = tuple(percept)
        for number, (agent, path) in enumerate(zip(self._agents, paths, strict=True)):
            agent.write_tick(time_s, keys, values[:, number], tuple(path), at)
            if commands:
                agent.write_commands(
                    time_s, {name: float(column[number]) for name, column in commands.items()}, at
                )

    def check(self) -> None:
        """Raise RecordingFailed if something could not be written."""
        if self._writer.problem:
            raise RecordingFailed(path=self.path, problem=self._writer.problem)

    def write_press(self, state: str | None, *, agent: int = 0) -> None:
        """Record that a person pressed a state for an agent before the next tick, or confirmed it (None)."""
        self.write_note(PRESSES, state or "", agent=agent)

    def write_step(self, step: str, *, agent: int = 0) -> None:
        """Record another step before the next tick: test or train in a session, or a restart."""
        at = "" if self._body is None else f" {self._body.time_s!r}"
        self.write_note(STEPS, step + at, agent=agent)

    def write_note(self, topic: str, content: str, *, agent: int = 0) -> None:
        """Record a text on a topic in the namespace of an agent."""
        name = self._names[agent] if self._names else ""
        self.open_topic(resolve_topic_name(name, topic), TEXT)(encode_text(content), None)

    def close(self) -> None:
        """Finish the file; raise RecordingFailed if it could not be written completely."""
        if self._writer.close() and self._writer.problem:
            raise RecordingFailed(path=self.path, problem=self._writer.problem)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:  # what ended the run matters more than what ended its recording
            with suppress(RecordingFailed):
                self.close()


class AgentChannels:
    """The channels of one agent in a recording."""

    def __init__(self, recorder: RunRecorder, name: str) -> None:
        self._name, self._path = name, tuple[str, ...]()
        self._keys: tuple[ReadingKey, ...] = ()
        self._readings, self._states = ReadingsEncoder(()), StatesEncoder()
        self._recorder, self._commands = recorder, ReadingsEncoder(())
        self._tapes = {
            type: recorder.open_topic(resolve_topic_name(name, topic), type) for type, topic in TOPICS.items()
        }

    def write_tick(
        self,
        time_s: float,
        keys: tuple[ReadingKey, ...],
        values: Any,
        path: tuple[str, ...],
        at_s: float | None = None,
    ) -> None:
        """Record a tick: the readings [K] that the decision used, and the states of all levels after it."""
        if keys != self._keys:
            self._keys, self._readings = keys, ReadingsEncoder([format_reading_label(key) for key in keys])
        self._tapes[READINGS](self._readings.encode(time_s, values), at_s)
        self._tapes[STATES](self._states.encode(time_s, path), at_s)
        changed = detect_state_change(self._path, path)
        if changed is not None:
            self._path = path
            transition = make_message(
                TRANSITION, time_s=time_s, robot=self._name, path=list(path), **changed._asdict()
            )
            self._tapes[TRANSITION](encode_message(TRANSITION, transition), at_s)

    def write_commands(self, time_s: float, commands: Mapping[str, float], at_s: float | None = None) -> None:
        """Record the commands of a tick by channel."""
        if tuple(commands) != self._commands.names:
            self._commands = ReadingsEncoder(tuple(commands))
        keep = self._recorder.open_topic(resolve_topic_name(self._name, COMMANDS), READINGS)
        keep(self._commands.encode(time_s, np.array(list(commands.values()))), at_s)
