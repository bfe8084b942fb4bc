"""The watchdog: what it does for what it hears; and as a process of its own, started, answering, missed."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from pathlib import Path
from threading import Thread

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER

from understudy.robots.robot_file import RobotFile, parse_robot
from understudy.robots.ros.transport import Publisher
from understudy.robots.safety.stop_log import read_stops
from understudy.robots.safety.watchdog import (
    BYE,
    MOVING,
    RESTING,
    STOPPED,
    TAKEN_OVER,
    WELL,
    watch_heartbeats,
)
from understudy.robots.safety.watchdog_client import WatchdogClient, WatchdogFailed

NUMBERS = count()
DEADLINE_S = 0.12
GONE = b""


class Scene:
    """Words at moments; time passes only while it waits. What it does, with the moment in hundredths of a second."""

    def __init__(self, words: Sequence[tuple[float, bytes]]) -> None:
        self.now, self.words = 0.0, list(words)
        self.stopped: list[float] = []
        self.answers: list[bytes] = []
        self.logged: list[str] = []

    def sleep(self, seconds: float) -> None:
        self.now += seconds

    def hear(self, wait_s: float | None) -> bytes | None:
        at_s, words = self.words[0]
        if wait_s is not None and at_s > self.now + wait_s:
            self.now += wait_s
            return None
        self.now = max(self.now, at_s)
        del self.words[0]
        return words

    def play(self) -> Scene:
        watch_heartbeats(
            self.hear,
            self.answers.append,
            lambda: self.stopped.append(round(self.now, 2)),
            self.logged.append,
            deadline_s=DEADLINE_S,
            clock=lambda: self.now,
            sleep=self.sleep,
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


@pytest.fixture
def file() -> RobotFile:
    """A robot that nobody publishes for."""
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    return parse_robot(ROVER.replace("/rover", f"/dog_{os.getpid()}_{next(NUMBERS)}"))


@pytest.fixture
def watchdog(file: RobotFile, tmp_path: Path) -> Iterator[WatchdogClient]:
    made = WatchdogClient(file, log=tmp_path / "log")
    yield made
    made.shut_down()


def keep_on(watchdog: WatchdogClient, until: Callable[[], object], seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < end, "it never came"
        watchdog.send(MOVING)
        time.sleep(0.02)


def test_it_starts_answers_and_leaves(watchdog: WatchdogClient, tmp_path: Path) -> None:
    assert watchdog.problem() == "there is no watchdog"
    watchdog.start([])
    pid = watchdog.pid
    assert os.getsid(pid) != os.getsid(0)  # no Ctrl-C of ours reaches it
    watchdog.send(RESTING)
    time.sleep(0.3)
    assert watchdog.problem() == ""
    watchdog.start([])
    assert watchdog.pid == pid
    watchdog.shut_down()
    assert (watchdog.pid, watchdog.alive) == (0, False)
    assert read_stops(tmp_path / "log") == ()


def test_it_starts_in_any_folder(
    watchdog: WatchdogClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even in one whose files go by the names of modules, and from which a relative PYTHONPATH leads nowhere."""
    (tmp_path / "select.py").write_text("raise ImportError")
    monkeypatch.syspath_prepend(Path("src").absolute())
    monkeypatch.setenv("PYTHONPATH", "src")
    monkeypatch.chdir(tmp_path)
    watchdog.start([])
    assert watchdog.alive


@pytest.mark.parametrize(
    ("number", "said"),
    [(signal.SIGKILL, "the watchdog died"), (signal.SIGSTOP, "the watchdog does not answer")],
)
def test_it_is_missed(watchdog: WatchdogClient, number: int, said: str) -> None:
    watchdog.start([])
    keep_on(watchdog, lambda: watchdog.problem() == "")
    os.kill(watchdog.pid, number)
    problems: list[str] = []

    def missed() -> str:
        problems.append(watchdog.problem())
        return problems[-1]

    keep_on(watchdog, missed)
    assert problems[-1] == said
    os.kill(watchdog.pid, signal.SIGKILL)


def test_a_program_that_cannot_be_started_is_told(
    watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with pytest.raises(WatchdogFailed, match="No such file"):
        watchdog.start([])


def test_dropped_it_stops_the_robot(watchdog: WatchdogClient, tmp_path: Path) -> None:
    watchdog.start([])
    watchdog.send(TAKEN_OVER)
    watchdog.close_without_goodbye()
    assert (watchdog.alive, watchdog.count) == (False, 1)  # who dropped it goes on while it stops the robot
    watchdog.shut_down()
    assert watchdog.count == 0
    assert [stop.by for stop in read_stops(tmp_path / "log")] == ["watchdog"]


def test_dropped_at_the_end_of_a_program_it_stops_the_robot_too(
    watchdog: WatchdogClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When no thread can be started any more."""

    def refuse(thread: Thread) -> None:
        raise RuntimeError("can't create new thread at interpreter shutdown")

    watchdog.start([])
    watchdog.send(TAKEN_OVER)
    with monkeypatch.context() as ending:
        ending.setattr(Thread, "start", refuse)
        watchdog.close_without_goodbye()
    watchdog.shut_down()
    assert [stop.by for stop in read_stops(tmp_path / "log")] == ["watchdog"]


def test_one_that_is_frozen_is_replaced(watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.robots.safety.watchdog_client.LEAVING_S", 0.1)
    watchdog.start([])
    pid = watchdog.pid
    os.kill(pid, signal.SIGSTOP)
    keep_on(watchdog, watchdog.problem)
    watchdog.start([])
    assert watchdog.pid != pid
    keep_on(watchdog, lambda: watchdog.problem() == "")


def test_it_is_not_ready_for_a_robot_that_it_does_not_find(
    watchdog: WatchdogClient, file: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("understudy.robots.safety.watchdog_client.STARTING_S", 1.5)
    with pytest.raises(WatchdogFailed, match="took too long"):
        watchdog.start([Publisher(file.topic("odom"), "nav_msgs/msg/Odometry")])
    assert not watchdog.alive


def test_what_it_says_of_itself_is_told(watchdog: WatchdogClient, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere = '<Interfaces><NetworkInterface name="nowhere"/></Interfaces>'
    uri = f"<CycloneDDS><Domain><General>{nowhere}</General></Domain></CycloneDDS>"
    monkeypatch.setenv("CYCLONEDDS_URI", uri)
    with pytest.raises(WatchdogFailed, match="domain 43 of DDS cannot be joined"):
        watchdog.start([])
