"""Recordings of computers that are held up anywhere, merged: what they say of their clocks is within the stated error.

Time is simulated. Each reading of a clock may take seconds, as where a process is suspended or another one has its
processor, and so may each message.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, count, repeat
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from mcap.reader import make_reader
from tests.bodies import Scripted

from understudy.addons.robots.team_network.agent_recorder import RecordedNetwork
from understudy.clock import PROMPT_S
from understudy.records.header import RunInfo
from understudy.records.merge import TeamClock, merge_recordings
from understudy.records.recorder import RunRecorder
from understudy.runtime.agents.network import Inbox, Observe

S = 10**9
BEGAN_NS = 1_800_000_000 * S
STEP_S = 1e-7
"""The time that a reading of a clock, or sending a message, takes at least, s."""
KEY = "squad"
TICKS, TICK_S = 20, 0.1
EXACT_S = PROMPT_S + 1e-6
"""How exactly the date of a recording is that of its computer, both ways, and how exactly times are written, s."""


@dataclass
class World:
    """The true time, which passes while programs read clocks and messages are under way."""

    holds_s: Iterator[float]
    delays_s: Iterator[float]
    true_s: float = 100.0
    computers: list[Computer] = field(default_factory=list)
    under_way: list[tuple[float, int, Inbox, bytes]] = field(default_factory=list)
    sent: Iterator[int] = field(default_factory=count)

    def hold_up(self) -> None:
        """Let the time pass that a step of a program takes."""
        self.true_s += STEP_S + next(self.holds_s)

    def send(self, inbox: Inbox, message: bytes) -> None:
        """Send a message, which arrives after the next delay."""
        due_s = self.true_s + next(self.delays_s)
        heapq.heappush(self.under_way, (due_s, next(self.sent), inbox, message))

    def pass_time(self, until_s: float) -> None:
        """Deliver what arrives until then; what is held up is later."""
        while self.under_way and self.under_way[0][0] <= until_s:
            due_s, _, inbox, message = heapq.heappop(self.under_way)
            self.true_s = max(self.true_s, due_s)
            inbox.add(message)
        self.true_s = max(self.true_s, until_s)


@dataclass
class Computer:
    """A computer with a clock and a date of its own, and its access to the network."""

    world: World
    name: str
    ahead_s: float
    drift: float
    inboxes: list[Inbox] = field(default_factory=list)
    present = frozenset[str]()

    def show_date(self, true_s: float) -> int:
        """What its date is at a time, ns."""
        return BEGAN_NS + round((true_s * (1 + self.drift) + self.ahead_s) * S)

    def find_time(self, date_ns: int) -> float:
        """The true time at a date of it, s."""
        return ((date_ns - BEGAN_NS) / S - self.ahead_s) / (1 + self.drift)

    def read(self) -> float:
        """Read its monotonic clock, s."""
        self.world.hold_up()
        return self.world.true_s * (1 + self.drift)

    def read_date(self) -> int:
        """Read its date, ns."""
        self.world.hold_up()
        return self.show_date(self.world.true_s)

    def publish(self, key: str, message: bytes) -> None:
        for computer in self.world.computers:
            for inbox in computer.inboxes:
                self.world.send(inbox, message)
        self.world.hold_up()
        self.world.pass_time(self.world.true_s)  # some arrive before this returns

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        self.inboxes.append(inbox := Inbox(observe=observe))
        return inbox

    def announce(self, name: str) -> None:
        """Nobody asks who is there."""

    def close(self) -> None:
        """Nothing is left behind."""

    def record(self, folder: Path) -> tuple[RunRecorder, RecordedNetwork]:
        """Begin a recording, with the network through which it records messages."""
        recorder = RunRecorder(folder / f"{self.name}.mcap", clock=self.read, date=self.read_date)
        recorder.begin(Scripted(1, {}), names=[self.name], ran=RunInfo(agent=self.name))
        return recorder, RecordedNetwork(self, recorder, self.name)


def record_team(world: World, folder: Path) -> list[Path]:
    """Record all computers, which send each other a message at each tick."""
    recorded = [each.record(folder) for each in world.computers]
    for _, network in recorded:
        network.listen(KEY)
    for tick in range(TICKS):
        for computer, (_, network) in zip(world.computers, recorded, strict=True):
            network.publish(KEY, f"{computer.name} {tick}".encode())
            world.pass_time(world.true_s + TICK_S / len(recorded))
    world.pass_time(world.true_s + 10.0)
    for recorder, _ in recorded:
        recorder.close()
    return [recorder.path for recorder, _ in recorded]


def list_times(path: Path, agent: str) -> list[int]:
    """List the times of the messages that an agent recorded, in their order, ns."""
    with path.open("rb") as file:
        return sorted(
            message.log_time
            for _, channel, message in make_reader(file).iter_messages()
            if channel.topic.startswith(f"/{agent}/")
        )


def check_clocks(world: World, clock: TeamClock, merged: Path, paths: list[Path]) -> None:
    """Check that the times of all messages are those of the reference, and what is said of the clocks."""
    reference = world.computers[0]
    for computer, path, found in zip(world.computers, paths, clock.members, strict=True):
        own, shared = list_times(path, computer.name), list_times(merged, computer.name)
        assert found.uneven_s == 0.0, "no message was heard before it was sent"
        bound_s = found.error_s + EXACT_S
        for own_ns, shared_ns in zip(own, shared, strict=True):
            true_ns = reference.show_date(computer.find_time(own_ns))
            assert abs(shared_ns - true_ns) / S <= bound_s
        ahead_s = (own[0] - reference.show_date(computer.find_time(own[0]))) / S
        assert abs(found.ahead_s - ahead_s) <= bound_s


HOLDS = st.just(0.0) | st.floats(0.0, 0.005) | st.floats(0.0, 3.0)
DELAYS = st.floats(0.0, 0.001) | st.floats(0.0, 3.0)
AHEAD = st.floats(-1e4, 1e4)
DRIFTS = st.floats(-4e-4, 4e-4)


@settings(max_examples=40)
@given(
    st.lists(HOLDS, max_size=100), st.lists(DELAYS, min_size=1, max_size=20), AHEAD, st.tuples(DRIFTS, DRIFTS)
)
@example([0.0, 2.6e-3], [1e-3], 0.0, (0.0, 0.0))  # between the clocks of the first computer, at the beginning
@example([0.0] * 6 + [1e-3] * 400, [0.0], 0.0, (0.0, 0.0))  # messages arrive before their sender goes on
def test_clocks_are_found_within_the_stated_error(
    holds_s: list[float], delays_s: list[float], ahead_s: float, drifts: tuple[float, float]
) -> None:
    delays = chain.from_iterable(repeat(delays_s))
    world = World(chain(holds_s, repeat(0.0)), delays)
    world.computers += [Computer(world, "a", 0.0, drifts[0]), Computer(world, "b", ahead_s, drifts[1])]
    with TemporaryDirectory() as folder:
        paths = record_team(world, Path(folder))
        merged = Path(folder) / "team.mcap"
        check_clocks(world, merge_recordings(merged, paths), merged, paths)
