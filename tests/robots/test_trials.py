"""Stopping, with real processes over DDS: each of `tests.robots.trials` once, and all ways for a program to end."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER
from tests.robots.trials import TRIALS, Process, can_cut, scene
from tests.ui.cli.commands import run

from understudy.robots.safety.stop_log import read_stops

GENEROUS_S = 2.0
"""How long a robot may go on here, where many tests may run at once; what is promised is measured by the trials."""


@pytest.mark.parametrize("name", ["killed", "frozen", "deaf", "killed, Zenoh"])
def test_it_stops(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if "Zenoh" in name:
        pytest.importorskip("zenoh", reason="needs the extra ros2")
    monkeypatch.setattr("tests.robots.trials.STOP_S", GENEROUS_S)
    monkeypatch.setattr("tests.robots.trials.SENSOR_S", GENEROUS_S)
    if name != "frozen":  # which has to last until it is disarmed
        monkeypatch.setattr("tests.robots.trials.AFTER_S", 0.8)  # longer than a reading may be old
    trial, _ = TRIALS[name]
    assert [outcome.problem for outcome in trial(1)] == [""]


@pytest.mark.skipif(not can_cut(), reason="needs root and ip, for a network of its own")
def test_it_stops_where_the_link_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.robots.trials.STOP_S", GENEROUS_S)
    monkeypatch.setattr("tests.robots.trials.AFTER_S", 0.8)
    assert [outcome.problem for outcome in TRIALS["cut"][0](1)] == [""]


def tell(line: str) -> Callable[[Process], object]:
    def write(decider: Process) -> None:
        assert decider.process.stdin is not None
        decider.process.stdin.write(f"{line}\n")
        decider.process.stdin.flush()

    return write


ENDS: list[tuple[str, Callable[[Process], object], str, str]] = [  # how it ends, the cause, who logs it
    ("exit", tell("exit"), "its program left", "program"),
    ("error", tell("fail"), "its program failed: ValueError", "program"),
    ("no close", tell("leave"), "its program left", "program"),
    (
        "Ctrl-C",
        lambda decider: decider.send(signal.SIGINT),
        "its program was interrupted",
        "program",
    ),
    ("SIGTERM", lambda decider: decider.send(signal.SIGTERM), "ended without a word", "watchdog"),
    ("SIGHUP", lambda decider: decider.send(signal.SIGHUP), "ended without a word", "watchdog"),
]


@pytest.mark.parametrize(("how", "ends", "cause", "by"), ENDS, ids=[row[0] for row in ENDS])
def test_it_stops_however_its_program_ends(
    how: str, ends: Callable[[Process], object], cause: str, by: str
) -> None:
    with scene() as (here, _):
        assert here.drive() == ""
        ends(here.decider)
        assert here.robot.line().split()[::2] == ["stops", "command"]
        here.decider.process.wait(10.0)
        assert here.robot.line(0.3) == ""
        stops = read_stops(here.log)
        assert [stop.by for stop in stops] == [by]
        assert cause in stops[0].cause


def test_a_late_tick_stops_it_until_the_next() -> None:
    with scene() as (here, _):
        assert here.drive() == ""
        assert here.decider.ask("late") == "late"
        assert [here.robot.line().split()[0] for _ in range(2)] == ["stops", "moves"]
        assert here.decider.ask("state") == "armed"
        assert "no command came" in read_stops(here.log)[0].cause


def test_it_is_stopped_from_another_terminal() -> None:
    with scene() as (here, _):
        assert here.drive() == ""
        result = run("robots", "stop", here.log.with_name("rover.toml"))
        assert result.exit_code == 0, result.output
        assert here.decider.ask("state").startswith("disarmed somebody else publishes")
        lines = [here.robot.line()]
        while line := here.robot.line(0.5):
            lines.append(line)
        assert lines[-1].startswith("stops")
        assert "robots stop" in {stop.by for stop in read_stops(here.log)}


def test_a_robot_that_is_not_heard_may_not_have_heard_it(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text(ROVER.replace("/rover", f"/nobody_{os.getpid()}"))
    result = run("robots", "stop", file)
    assert result.exit_code == 1
    assert "look whether it stands" in result.stdout
