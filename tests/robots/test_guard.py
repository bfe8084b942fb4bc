"""The guard of a robot: what stops it until the next tick, what disarms it, and when it is not armed at all."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Thread
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rigs import CMD, FENCED, HELD, ODOM, SONAR, STOP, Rig
from tests.robots.rovers import ROVER, TWIST, Wire, odometry, sonar
from tests.simulated_clock import HeldUpReadings, SimulatedClock
from tests.waiting import wait_until

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety import self_monitor
from understudy.addons.robots.safety.guard import ArmingRefused, Guard
from understudy.addons.robots.safety.self_monitor import measure_time_asleep
from understudy.addons.robots.safety.speed_limits import Speeds
from understudy.addons.robots.safety.watchdog import MOVING, RESTING, TAKEN_OVER
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.errors import FileError
from understudy.records.messages import encode_twist

AHEAD = (0.4, 0.0)
OTHER = Publisher(CMD, TWIST)


def late(rig: Rig) -> None:
    rig.wait(0.24)


def very_late(rig: Rig) -> None:
    rig.wait(1.26)


def deaf(rig: Rig) -> None:
    rig.move(1.0)
    rig.wait(0.2, deaf=True)
    rig.move(1.0)
    rig.wait(0.2, deaf=True)
    rig.move(1.0)
    rig.wait(0.12, deaf=True)


def outside(rig: Rig) -> None:
    rig.hear(ODOM, odometry(1.1))
    rig.robot.guard.check()


def let_go(rig: Rig) -> None:
    rig.robot.hold_key(0.0)
    rig.robot.guard.check()


def hold_on(rig: Rig) -> None:
    rig.robot.hold_key(0.1)
    rig.wait(0.12)


def let_command(rig: Rig) -> None:
    rig.wire.others.append(OTHER)
    rig.wait(0.22)


STOPS: list[tuple[str, Callable[[Rig], None], str, bool]] = [  # file, what happens, the cause, still armed?
    (FENCED, late, "no command came for 0.24 s", True),
    (FENCED, very_late, "no command came for 1.24 s", False),
    (FENCED, deaf, "sonar_ahead is absent", False),
    (FENCED, outside, "outside its geofence", False),
    (FENCED, let_command, "somebody else publishes on /rover/cmd_vel", False),
    (FENCED, lambda rig: rig.robot.disarm("enough"), "enough", False),
    (FENCED, lambda rig: rig.robot.emergency_stop("a key"), "emergency: a key", False),
    (HELD, let_go, "nobody holds the key", True),
    (HELD, hold_on, "nobody holds the key", True),
]


@pytest.mark.parametrize(("text", "happens", "cause", "armed"), STOPS, ids=[row[2] for row in STOPS])
def test_what_stops_it(text: str, happens: Callable[[Rig], None], cause: str, armed: bool) -> None:
    rig = Rig(text).ready()
    rig.robot.hold_key(1.0)
    assert rig.move(1.0) == AHEAD
    happens(rig)
    assert rig.sent == STOP
    assert (rig.robot.stop_cause, rig.robot.armed) == (cause, armed)
    assert rig.robot.stops[-1].cause == cause
    sent = len(rig.wire.sent)
    rig.hear(ODOM, odometry(0.0))
    rig.wait(0.1)
    assert len(rig.wire.sent) == sent + 5  # over and over
    assert rig.sent == STOP
    rig.wire.others.clear()
    rig.robot.hold_key(1.0)
    assert rig.move(1.0) == (AHEAD if armed else STOP)


def test_between_ticks_the_last_command_is_repeated() -> None:
    rig = Rig().ready()
    rig.move(1.0)
    before = len(rig.wire.sent)
    rig.wait(0.1)
    assert len(rig.wire.sent) == before + 5
    assert len(set(rig.wire.sent[before - 1 :])) == 1


def test_a_stop_is_logged_once_for_as_long_as_it_lasts() -> None:
    rig = Rig().ready()
    for _ in range(2):
        rig.move(1.0)
        rig.wait(0.6)
    assert len(rig.robot.stops) == 2


def test_a_decision_on_old_readings_is_no_command() -> None:
    rig = Rig().ready()
    rig.move(0.0)
    rig.read("sonar_ahead")
    rig.wait(0.3)  # thinking
    assert rig.move(1.0) == STOP
    assert rig.robot.stop_cause == "a command was decided on what was 0.30 s ago"
    rig.read("sonar_ahead")
    assert rig.move(1.0) == AHEAD


def test_a_key_counts_as_held_for_a_second_at_most_and_none_at_first() -> None:
    rig = Rig(HELD).ready()
    assert rig.move(1.0) == STOP
    assert rig.robot.stops == ()
    rig.robot.hold_key(60.0)
    for _ in range(5):
        assert rig.move(1.0) == AHEAD
        rig.wait(0.18)
    assert rig.move(1.0) == AHEAD
    rig.wait(0.12)
    assert rig.move(1.0) == STOP


def test_disarmed_it_is_stopped_for_a_while_and_then_left_to_others() -> None:
    rig = Rig().ready()
    rig.move(1.0)
    rig.robot.disarm()
    rig.wait(5.1)
    sent = len(rig.wire.sent)
    rig.wait(1.0)
    rig.move(1.0)
    assert len(rig.wire.sent) == sent


def test_an_emergency_stops_a_robot_that_others_drive() -> None:
    rig = Rig()
    rig.robot.emergency_stop("a key")
    assert rig.sent == STOP
    assert rig.robot.stops[0].cause == "emergency: a key"


def test_closed_it_sends_nothing_any_more() -> None:
    rig = Rig().ready()
    rig.move(1.0)
    rig.robot.close()
    assert rig.sent == STOP
    sent = len(rig.wire.sent)
    rig.robot.emergency_stop("a key")
    rig.robot.act({"drive": np.ones(1)})
    rig.robot.guard.check()
    assert len(rig.wire.sent) == sent


def test_a_reading_that_is_no_number_for_a_second_disarms() -> None:
    rig = Rig().ready()
    rig.move(1.0)
    for tick in range(13):
        rig.now += 0.1
        rig.hear(SONAR, sonar(float("nan")))
        rig.robot.act({"drive": np.ones(1)})
        assert rig.sent == STOP
        assert rig.robot.armed == (tick < 11)


REFUSED: list[tuple[Callable[[Rig], None], str, str]] = [  # what was before, who arms, what is said
    (lambda rig: None, "Ada", "sonar_ahead is absent"),
    (lambda rig: rig.hear(SONAR, sonar(2.0)), "Ada", "outside its geofence"),
    (lambda rig: heard(rig), "", "no person is named"),
    (lambda rig: heard(rig, OTHER), "Ada", "somebody else publishes on /rover/cmd_vel"),
]


def heard(rig: Rig, *others: Publisher) -> None:
    rig.hear(SONAR, sonar(2.0))
    rig.hear(ODOM, odometry(0.0))
    rig.wire.others.extend(others)


@pytest.mark.parametrize(("before", "by", "said"), REFUSED, ids=[row[2] for row in REFUSED])
def test_arming_is_refused(before: Callable[[Rig], None], by: str, said: str) -> None:
    rig = Rig(FENCED)
    before(rig)
    with pytest.raises(ArmingRefused, match=said):
        rig.robot.arm(by)
    assert not rig.robot.armed
    assert rig.wire.sent == []


class Tame(WatchdogClient):
    """A watchdog's client without a watchdog."""

    said = ""
    stepped_in = False

    def __init__(self) -> None:
        self.told: list[bytes] = []
        self.dropped = False

    @property
    def alive(self) -> bool:
        return True

    def start(self, peers: Sequence[Publisher]) -> None:
        self.found = set(peers)

    def begin(self) -> None: ...

    def send(self, words: bytes) -> None:
        self.told.append(words)

    def problem(self) -> str:
        return self.said

    def poll_intervention(self) -> bool:
        stepped_in, self.stepped_in = self.stepped_in, False
        return stepped_in

    def shut_down(self) -> None: ...

    def close_without_goodbye(self) -> None:
        self.dropped = True


@dataclass
class Guarded(Rig):
    """A robot with a watchdog, but no thread: tests look themselves."""

    folder: Path = field(default=Path())

    def __post_init__(self) -> None:
        self.watchdog = Tame()
        self.robot = Robot(
            parse_robot(self.text),
            self.wire,
            path=self.folder / "rover.toml",
            clock=self.clock,
            watchdog=self.watchdog,
        )


@pytest.fixture
def guard_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Guarded:
    monkeypatch.setattr(Guard, "_watch", lambda self: None)
    return Guarded(folder=tmp_path)


def test_the_watchdog_hears_of_it(guard_folder: Guarded) -> None:
    """And has to find who publishes what the robot reads, but not others."""
    sensor = Publisher(SONAR, "sensor_msgs/msg/Range")
    guard_folder.wire.others.extend([sensor, Publisher("/elsewhere", TWIST)])
    guard_folder.ready()
    assert guard_folder.watchdog.found == {sensor}
    guard_folder.move(1.0)
    guard_folder.wait(0.04)
    guard_folder.robot.disarm()
    guard_folder.wait(0.04)
    guard_folder.wait(5.0)
    assert guard_folder.watchdog.told[:5] == [TAKEN_OVER, MOVING, MOVING, MOVING, MOVING]
    assert guard_folder.watchdog.told[-1] == RESTING


@pytest.mark.parametrize("still_s", [0.13, 1.1])
@pytest.mark.parametrize("finds", ["check", "act"])
def test_a_program_that_stood_still_stops_it_and_long_disarms_it(
    guard_folder: Guarded, still_s: float, finds: str
) -> None:
    guard_folder.ready()
    guard_folder.move(1.0)
    guard_folder.wait(0.1)
    guard_folder.now += still_s
    guard_folder.hear(SONAR, sonar(2.0))
    guard_folder.hear(ODOM, odometry(0.0))
    if finds == "act":
        assert guard_folder.move(1.0) == STOP
    guard_folder.robot.guard.check()
    assert guard_folder.sent == STOP
    assert guard_folder.robot.stop_cause == f"this program stood still for {still_s:.2f} s"
    assert guard_folder.watchdog.told[-1] == (TAKEN_OVER if still_s < 1 else MOVING)
    guard_folder.wait(0.02)
    assert guard_folder.sent == STOP
    assert guard_folder.watchdog.told[-1] == MOVING
    assert guard_folder.move(1.0) == (AHEAD if still_s < 1 else STOP)


@pytest.mark.parametrize("still_s", [0.2, 1.1])
def test_a_program_that_is_frozen_while_it_sends_stops_afterwards(
    guard_folder: Guarded, still_s: float
) -> None:
    guard_folder.ready()
    guard_folder.move(0.0)

    class Slow(list[tuple[str, bytes]]):
        def append(self, sent: tuple[str, bytes]) -> None:
            guard_folder.now += still_s
            super().append(sent)

    guard_folder.wire.sent = Slow(guard_folder.wire.sent)
    guard_folder.robot.act({"drive": np.ones(1)})
    assert guard_folder.sent == STOP
    assert guard_folder.robot.armed == (still_s < 1)


def test_without_a_watchdog_it_does_not_move(guard_folder: Guarded) -> None:
    guard_folder.ready().move(1.0)
    guard_folder.watchdog.said = "the watchdog died"
    guard_folder.wait(0.02)
    assert (guard_folder.sent, guard_folder.robot.stop_cause) == (STOP, "the watchdog died")
    assert not guard_folder.robot.armed


def test_after_the_watchdog_stopped_it_it_waits_for_a_tick(guard_folder: Guarded) -> None:
    guard_folder.ready().move(1.0)
    guard_folder.watchdog.stepped_in = True
    guard_folder.wait(0.02)
    assert guard_folder.watchdog.told[-1] == TAKEN_OVER
    guard_folder.wait(0.02)
    assert (guard_folder.sent, guard_folder.robot.stop_cause) == (STOP, "the watchdog had to stop it")
    assert guard_folder.move(1.0) == AHEAD


def test_a_computer_that_slept_is_armed_again(guard_folder: Guarded, monkeypatch: pytest.MonkeyPatch) -> None:
    guard_folder.ready().move(1.0)
    slept = measure_time_asleep() + 60.0
    monkeypatch.setattr("understudy.addons.robots.safety.self_monitor.measure_time_asleep", lambda: slept)
    guard_folder.wait(0.02)
    assert (guard_folder.sent, guard_folder.robot.stop_cause) == (STOP, "this computer slept")
    guard_folder.ready().wait(0.1)
    assert guard_folder.robot.armed


@pytest.mark.skipif(sys.platform != "linux", reason="it is known on Linux only")
@pytest.mark.parametrize("held", [{}, {1: 2.0}, {2: 2.0}], ids=["not held up", "before", "after"])
def test_a_program_that_is_held_up_did_not_sleep(
    held: dict[int, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between its two clocks, of which one has been going on for a minute longer."""
    readings = HeldUpReadings(held, ahead_s=60)
    clocks = SimpleNamespace(
        monotonic=readings.read,
        clock_gettime=lambda clock: readings.read_other() / 1e9,
        clock_gettime_ns=lambda clock: readings.read_other(),
        CLOCK_BOOTTIME=7,
    )
    monkeypatch.setattr(self_monitor, "time", clocks)
    assert measure_time_asleep() == pytest.approx(60.0, abs=1e-6)


def test_what_cannot_be_sent_is_left_to_the_watchdog(guard_folder: Guarded) -> None:
    guard_folder.ready()
    guard_folder.move(0.0)

    def fail(speeds: Speeds) -> None:
        raise OSError("no buffer")

    guard_folder.robot.guard._send = fail
    with pytest.raises(OSError, match="no buffer"):
        guard_folder.move(1.0)
    assert guard_folder.watchdog.dropped
    assert (guard_folder.robot.armed, guard_folder.robot.stop_cause) == (False, "commands cannot be sent")
    guard_folder.robot.emergency_stop("a key")  # raises nothing: other robots are waiting for theirs
    assert guard_folder.robot.stops[0].cause == "commands cannot be sent"


def test_without_a_log_it_is_not_armed(guard_folder: Guarded) -> None:
    (guard_folder.folder / "rover.stops.jsonl").mkdir()
    with pytest.raises(FileError, match="cannot be written"):
        guard_folder.ready()
    assert not guard_folder.robot.armed


def test_a_stop_while_it_is_armed_wins(guard_folder: Guarded, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        guard_folder.watchdog, "start", lambda peers: guard_folder.robot.emergency_stop("a key")
    )
    with pytest.raises(ArmingRefused, match="it was stopped meanwhile"):
        guard_folder.ready()
    assert not guard_folder.robot.armed


def test_closed_it_is_armed_no_more(guard_folder: Guarded, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even where that was begun before, and then the watchdog is sent home."""
    left: list[str] = []
    monkeypatch.setattr(guard_folder.watchdog, "shut_down", lambda: left.append("left"))
    monkeypatch.setattr(guard_folder.watchdog, "start", lambda peers: guard_folder.robot.close())
    for _ in range(2):
        with pytest.raises(ArmingRefused, match="it was closed; connect to it again"):
            guard_folder.ready()
        assert not guard_folder.robot.armed
        assert len(left) == 2
    with pytest.raises(ArmingRefused, match="it was closed"):
        guard_folder.robot.prepare()


def test_a_guard_that_fails_stops_it(tmp_path: Path) -> None:
    """And goes on stopping it, whatever its watchdog does."""
    wire, clock = Wire(), SimulatedClock()
    robot = Robot(parse_robot(ROVER), wire, path=tmp_path / "rover.toml", clock=clock, watchdog=Tame())
    wire.deliver(SONAR, sonar(2.0), clock())
    robot.arm("Ada")
    clock.expect(1)
    for _ in range(10):
        robot.act({"drive": np.ones(1)})
        clock.advance(0.02)
    assert robot.armed
    wire.others = None  # type: ignore[assignment]
    for _ in range(10):
        wire.deliver(SONAR, sonar(2.0), clock())
        robot.act({"drive": np.ones(1)})
        clock.advance(0.02)
    assert not robot.armed
    assert robot.stop_cause == "the guard failed ('NoneType' object is not iterable)"
    sent = len(wire.sent)
    clock.advance(0.1)
    assert len(wire.sent) == sent + 5
    still = encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=0.0)
    assert {data for _, data in wire.sent[sent - 1 :]} == {still}
    robot.close()


def test_a_close_that_was_interrupted_is_made_up_for(
    guard_folder: Guarded, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second Ctrl-C in the middle of it: as long as it was not stopped, what it is stopped through stays."""
    closed: list[str] = []
    monkeypatch.setattr(guard_folder.wire, "close", lambda: closed.append("closed"))
    guard_folder.ready().move(1.0)
    with monkeypatch.context() as interrupted:
        interrupted.setattr(guard_folder.robot.guard, "close", lambda cause: _interrupt())
        with pytest.raises(KeyboardInterrupt):
            guard_folder.robot.close()
    assert closed == []
    guard_folder.robot.close()
    assert (guard_folder.sent, closed) == (STOP, ["closed"])


def _interrupt() -> None:
    raise KeyboardInterrupt


def test_a_fork_that_ends_leaves_the_robot_alone(
    guard_folder: Guarded, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard_folder.ready().move(1.0)
    with monkeypatch.context() as forked:
        forked.setattr("os.getpid", lambda: -1)
        guard_folder.robot.close()
    assert guard_folder.robot.armed
    assert guard_folder.sent == AHEAD


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads that take turns every few instructions, so that others come between."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("hasty")
def test_no_older_command_overtakes_a_stop(tmp_path: Path) -> None:
    """One thread acts, the guard's repeats, a third stops it: once that has returned, nothing but stop is sent."""
    wire, clock, ended, acts = Wire(), SimulatedClock(), Event(), list[None]()
    robot = Robot(parse_robot(ROVER), wire, path=tmp_path / "rover.toml", clock=clock, watchdog=Tame())
    still = encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=0.0)

    def act() -> None:
        while not ended.is_set():
            robot.act({"drive": np.ones(1)})
            acts.append(None)

    acting = Thread(target=act)
    acting.start()
    try:
        for _ in range(20):
            wire.deliver(SONAR, sonar(2.0), clock())
            robot.arm("Ada")
            clock.expect(1)
            moved = len(wire.sent)
            clock.advance(0.02)
            wait_until(lambda moved=moved: any(data != still for _, data in wire.sent[moved:]))  # type: ignore[misc]
            robot.emergency_stop("a key")
            stopped, acted = len(wire.sent), len(acts)
            clock.advance(0.04)
            wait_until(lambda acted=acted: len(acts) > acted + 1)  # type: ignore[misc]
            assert stopped > moved
            assert all(data == still for _, data in wire.sent[stopped - 1 :])
    finally:
        ended.set()
        acting.join()
        robot.close()


EVENTS = (
    "act",
    "sense",
    "wait",
    "long",
    "hear",
    "mute",
    "out",
    "in",
    "key",
    "disarm",
    "arm",
    "other",
    "alone",
)


@settings(deadline=None)  # machines are busy
@given(st.lists(st.sampled_from(EVENTS), max_size=30))
def test_it_never_moves_but_on_a_command_in_time_with_all_in_order(events: list[str]) -> None:
    """Whatever happens in whatever order: what is sent is a stop unless all that has to hold does."""
    rig = Rig(FENCED)
    place, speaks, acted = 0.0, True, -1e9

    def go_on(seconds: float) -> None:
        for _ in range(round(seconds / 0.02)):
            rig.now += 0.02
            if speaks:
                rig.hear(SONAR, sonar(2.0))
                rig.hear(ODOM, odometry(place))
            before = len(rig.wire.sent)
            rig.robot.guard.check()
            check(before)

    def check(before: int) -> None:
        if len(rig.wire.sent) > before and rig.sent != STOP:
            assert rig.robot.armed
            assert rig.now - acted <= 0.22 + 1e-6
            assert rig.now - rig.robot.senses.latest["sonar_ahead"].at_s <= 0.5 + 1e-6
            assert -1 <= rig.robot.senses.value("x", rig.now) <= 1

    for event in events:
        before = len(rig.wire.sent)
        if event == "act":
            acted = rig.now
            rig.robot.act({"drive": np.ones(1)})
            check(before)
        elif event == "sense":
            rig.read("sonar_ahead")
        elif event in ("wait", "long"):
            go_on(0.1 if event == "wait" else 1.5)
        elif event in ("hear", "mute"):
            speaks = event == "hear"
        elif event in ("out", "in"):
            place = 2.0 if event == "out" else 0.0
        elif event == "disarm":
            rig.robot.disarm()
            assert not rig.wire.sent or rig.sent == STOP
        elif event == "other":
            rig.wire.others.append(OTHER)
        elif event == "alone":
            rig.wire.others.clear()
        elif event == "arm":
            try:
                rig.robot.arm("Ada")
            except ArmingRefused:
                assert not rig.robot.armed
