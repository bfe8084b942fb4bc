"""The watchdog: what it does for what it hears; and as a process of its own, started, answering, missed."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from threading import Thread
from time import sleep

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.domains import new_namespace, own_domain
from tests.robots.rovers import ROVER, Wire
from tests.simulated_clock import SimulatedClock
from tests.waiting import wait_until

from understudy.addons.robots.robot_file import RobotFile, parse_robot
from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety import watchdog as watchdog_process
from understudy.addons.robots.safety.stop_log import read_stops
from understudy.addons.robots.safety.watchdog import (
    BYE,
    DISCOVERY_S,
    MOVING,
    READY,
    RESTING,
    SETTLING_S,
    STOPPED,
    TAKEN_OVER,
    WELL,
    WatchdogConfig,
    watch_heartbeats,
)
from understudy.addons.robots.safety.watchdog_client import ANSWER_S, WatchdogClient, WatchdogFailed

DEADLINE_S = 0.12
GONE = b""


class Scene:
    """Words at moments; time passes only while it waits. What it does, with the moment in hundredths of a second."""

    def __init__(self, words: Sequence[tuple[float, bytes]]) -> None:
        self.clock, self.words = SimulatedClock(0.0), list(words)
        self.stopped: list[float] = []
        self.answers: list[bytes] = []
        self.logged: list[str] = []

    def hear(self, wait_s: float | None) -> bytes | None:
        at_s, words = self.words[0]
        if wait_s is not None and at_s > self.clock() + wait_s:
            self.clock.sleep(wait_s)
            return None
        self.clock.sleep(at_s - self.clock())
        del self.words[0]
        return words

    def play(self) -> Scene:
        watch_heartbeats(
            self.hear,
            self.answers.append,
            lambda: self.stopped.append(round(self.clock(), 2)),
            self.logged.append,
            deadline_s=DEADLINE_S,
            clock=self.clock,
        )
        return self


def beats(since_s: float, until_s: float, word: bytes = MOVING) -> list[tuple[float, bytes]]:
    return [(since_s + 0.02 * number, word) for number in range(round((until_s - since_s) / 0.02))]


QUIET = [  # words after which it does nothing
    [(0.0, GONE)],
    [(0.0, BYE)],
    [(60.0, RESTING), (120.0, GONE)],
    [(0.0, TAKEN_OVER), *beats(0.02, 2.0), (2.0, BYE)],
    [(0.0, TAKEN_OVER), (0.1, MOVING), (0.2, RESTING), (60.0, RESTING), (61.0, GONE)],
    [(0.0, TAKEN_OVER), (0.1, MOVING + MOVING + BYE)],
]


@pytest.mark.parametrize("words", QUIET)
def test_it_does_nothing_while_all_is_well(words: list[tuple[float, bytes]]) -> None:
    scene = Scene(words).play()
    assert (scene.stopped, scene.logged) == ([], [])
    assert set(scene.answers) <= {WELL}


def test_of_a_program_that_is_gone_it_stops_the_robot_for_a_second() -> None:
    scene = Scene([(0.0, TAKEN_OVER), (0.1, MOVING), (0.15, GONE)]).play()
    assert scene.stopped[0] == 0.15
    assert len(scene.stopped) == 51
    assert scene.stopped[-1] == pytest.approx(1.13, abs=0.021)
    assert scene.logged == ["the program that decides ended without a word"]


def test_of_a_frozen_program_it_stops_the_robot_for_as_long_and_a_second_more() -> None:
    words = [(0.0, TAKEN_OVER), (0.1, MOVING), *beats(5.1, 10.0), (10.0, BYE)]
    scene = Scene(words).play()
    assert scene.stopped[0] == 0.22
    assert scene.stopped[-1] == pytest.approx(6.1, abs=0.021)
    assert len(scene.stopped) >= 50 * (scene.stopped[-1] - scene.stopped[0])
    assert scene.answers.count(STOPPED) == 1
    assert scene.logged == ["no sign for 0.12 s of the program that decides"]


def test_a_robot_that_may_move_anew_is_left_alone_at_once() -> None:
    words = [(0.0, TAKEN_OVER), (1.0, MOVING), (1.1, TAKEN_OVER), *beats(1.12, 3.0), (3.0, BYE)]
    scene = Scene(words).play()
    assert scene.stopped[-1] < 1.1


def watch(wire: Wire, peers: Sequence[Publisher], folder: Path, clock: SimulatedClock) -> list[bytes]:
    """The answers of a watchdog that says goodbye as soon as it is ready."""
    answers: list[bytes] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(watchdog_process, "_answer", answers.append)
        patch.setattr(watchdog_process, "_hear", lambda wait_s: BYE)
        orders = WatchdogConfig(file=parse_robot(ROVER), log=str(folder / "log"), peers=tuple(peers))
        watchdog_process._watch(orders, wire, clock)
    return answers


SENSOR = Publisher("/rover/odom", "nav_msgs/msg/Odometry")


def test_it_is_ready_once_it_found_the_robot(tmp_path: Path) -> None:
    """And was found itself; it sends one stop then, so that the first that counts is not the first."""
    wire, clock = Wire([SENSOR]), SimulatedClock(0.0)
    assert watch(wire, [SENSOR], tmp_path, clock) == [READY + b"\n", WELL]
    assert clock() == SETTLING_S
    assert [topic for topic, _ in wire.sent] == ["/rover/cmd_vel"]


def test_it_is_not_ready_for_a_robot_that_it_does_not_find(tmp_path: Path) -> None:
    wire, clock = Wire(), SimulatedClock(0.0)
    assert watch(wire, [SENSOR], tmp_path, clock) == [b"it does not find who publishes on /rover/odom\n"]
    assert clock() == pytest.approx(DISCOVERY_S, abs=0.021)
    assert wire.sent == []


class SteadyClock:
    """Real waits that count as hardly any time, so that a busy computer misses no watchdog, or as much longer."""

    now_s, factor = 0.0, 0.001

    def __call__(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.now_s += self.factor * seconds
        sleep(seconds)

    def wait(self, *_: object) -> bool:
        raise NotImplementedError


@pytest.fixture
def file() -> RobotFile:
    """A robot that nobody publishes for."""
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    return parse_robot(
        ROVER.replace("/rover", new_namespace("dog")).replace("domain = 43", f"domain = {own_domain()}")
    )


@pytest.fixture
def clock() -> SteadyClock:
    return SteadyClock()


@pytest.fixture
def watchdog(
    file: RobotFile, tmp_path: Path, clock: SteadyClock, monkeypatch: pytest.MonkeyPatch
) -> Iterator[WatchdogClient]:
    """A watchdog that has a minute to start and to end, on computers that are busy."""
    monkeypatch.setattr("understudy.addons.robots.safety.watchdog_client.STARTING_S", 60.0)
    monkeypatch.setattr("understudy.addons.robots.safety.watchdog_client.LEAVING_S", 60.0)
    made = WatchdogClient(file, log=tmp_path / "log", clock=clock)
    yield made
    made.shut_down()


@pytest.mark.timed
def test_it_starts_answers_and_leaves(
    watchdog: WatchdogClient, clock: SteadyClock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder whose files go by the names of modules, and from which a relative PYTHONPATH leads nowhere."""
    (tmp_path / "select.py").write_text("raise ImportError")
    monkeypatch.syspath_prepend(Path("src").absolute())
    monkeypatch.setenv("PYTHONPATH", "src")
    monkeypatch.chdir(tmp_path)
    assert watchdog.problem() == "there is no watchdog"
    watchdog.start([])
    pid = watchdog.pid
    assert os.getsid(pid) != os.getsid(0)  # no Ctrl-C of ours reaches it
    clock.now_s += ANSWER_S
    watchdog.send(RESTING)
    assert watchdog.problem() == ""
    watchdog.start([])  # which waits for an answer
    assert watchdog.pid == pid
    clock.now_s += ANSWER_S
    assert watchdog.problem() == ""
    assert not watchdog.poll_intervention()
    watchdog.shut_down()
    assert (watchdog.pid, watchdog.alive) == (0, False)
    assert read_stops(tmp_path / "log") == ()


@pytest.mark.timed
@pytest.mark.parametrize(
    ("number", "said"),
    [(signal.SIGKILL, "the watchdog died"), (signal.SIGSTOP, "the watchdog does not answer")],
)
def test_it_is_missed_and_replaced(
    watchdog: WatchdogClient, clock: SteadyClock, number: int, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    watchdog.start([])
    pid = watchdog.pid
    watchdog.start([])  # it answers
    assert watchdog.pid == pid
    os.kill(pid, number)
    if number == signal.SIGKILL:
        wait_until(watchdog.problem)
    while watchdog.problem() == "":  # answers from before may be left in the pipe
        watchdog.send(MOVING)
        clock.now_s += ANSWER_S + 0.01
    assert watchdog.problem() == said
    clock.factor = 10.0
    monkeypatch.setattr("understudy.addons.robots.safety.watchdog_client.LEAVING_S", 0.1)
    watchdog.start([])
    monkeypatch.setattr("understudy.addons.robots.safety.watchdog_client.LEAVING_S", 60.0)
    assert watchdog.pid != pid
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    clock.factor = 0.001
    new = watchdog.pid
    watchdog.start([])
    assert watchdog.pid == new


@pytest.mark.timed
@pytest.mark.parametrize("threads", [True, False], ids=["", "at the end of a program"])
def test_dropped_it_stops_the_robot(
    watchdog: WatchdogClient, tmp_path: Path, threads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when no thread can be started any more."""

    def refuse(thread: Thread) -> None:
        raise RuntimeError("can't create new thread at interpreter shutdown")

    watchdog.start([])
    watchdog.send(TAKEN_OVER)
    if threads:
        pid = watchdog.pid
        os.kill(pid, signal.SIGSTOP)
        watchdog.close_without_goodbye()
        assert (watchdog.alive, watchdog.count) == (
            False,
            1,
        )  # who dropped it goes on while it stops the robot
        os.kill(pid, signal.SIGCONT)
    else:
        with monkeypatch.context() as ending:
            ending.setattr(Thread, "start", refuse)
            watchdog.close_without_goodbye()
    watchdog.shut_down()
    assert watchdog.count == 0
    assert [stop.by for stop in read_stops(tmp_path / "log")] == ["watchdog"]


@pytest.mark.timed
def test_what_it_says_of_itself_is_told(watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere = '<Interfaces><NetworkInterface name="nowhere"/></Interfaces>'
    uri = f"<CycloneDDS><Domain><General>{nowhere}</General></Domain></CycloneDDS>"
    monkeypatch.setenv("CYCLONEDDS_URI", uri)
    with pytest.raises(WatchdogFailed, match=f"domain {own_domain()} of DDS cannot be joined"):
        watchdog.start([])


def test_one_that_is_not_ready_in_time_is_ended(
    watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("understudy.addons.robots.safety.watchdog_client.STARTING_S", 0.0)
    with pytest.raises(WatchdogFailed, match="took too long"):
        watchdog.start([])
    assert not watchdog.alive


def test_a_program_that_cannot_be_started_is_told(
    watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with pytest.raises(WatchdogFailed, match="No such file"):
        watchdog.start([])
