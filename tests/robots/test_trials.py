"""Stopping, with real processes over DDS: each of `tests.robots.trials` once, and all ways for a program to end."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ODOMETRY, ROVER, TOO_BUSY, TWIST, Wire
from tests.robots.trials import PATIENCE_S, TRIALS, Process, can_cut, scene
from tests.simulated_clock import SimulatedClock
from tests.ui.cli.commands import run

from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety import emergency_stop
from understudy.addons.robots.safety.stop_log import read_stops
from understudy.records.messages import encode_twist

cuts = pytest.mark.skipif(not can_cut(), reason="needs root and ip, for a network of its own")


@pytest.mark.timed
@pytest.mark.parametrize(
    "name", ["killed", "frozen", "deaf", pytest.param("cut", marks=cuts), "killed, Zenoh"]
)
def test_it_stops(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long it takes here, where many tests may run at once; what is promised is measured by the trials."""
    if "Zenoh" in name:
        pytest.importorskip("zenoh", reason="needs the extra ros2")
    for limit in ("STOP_S", "SENSOR_S", "TWITCH_S"):
        monkeypatch.setattr(f"tests.robots.trials.{limit}", PATIENCE_S)
    if name != "frozen":  # which has to last until it is disarmed
        monkeypatch.setattr("tests.robots.trials.AFTER_S", 0.8)  # longer than a reading may be old
    trial, _ = TRIALS[name]
    assert [outcome.problem for outcome in trial(1)] == [""]


def tell(line: str) -> Callable[[Process], object]:
    def write(decider: Process) -> None:
        assert decider.process.stdin is not None
        decider.process.stdin.write(f"{line}\n")
        decider.process.stdin.flush()

    return write


def read_last(robot: Process, line: str) -> str:
    """Read a robot's lines after this one until it stands and says no more for a while; return the last."""
    while later := robot.line(0.5 if line.startswith("stops") else PATIENCE_S):
        line = later
    return line


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


@pytest.mark.timed
@pytest.mark.parametrize(("how", "ends", "cause", "by"), ENDS, ids=[row[0] for row in ENDS])
def test_it_stops_however_its_program_ends(
    how: str, ends: Callable[[Process], object], cause: str, by: str
) -> None:
    """It may have stopped before, on a busy computer; then it has to be driving at the end of another program."""
    for _ in range(20):
        with scene() as (here, _):
            assert here.drive() == ""
            ends(here.decider)
            first = here.robot.line()
            here.decider.process.wait(PATIENCE_S)
            assert read_last(here.robot, first).split()[::2] == ["stops", "command"]
            stop = read_stops(here.log)[-1]
            if stop.by == by and cause in stop.cause:
                return
            assert any(words in stop.cause for words in TOO_BUSY), stop
    pytest.fail("this computer is too busy")


@pytest.mark.timed
def test_it_is_stopped_by_a_late_tick_until_the_next_and_from_another_terminal_for_good() -> None:
    with scene() as (here, _):
        assert here.drive() == ""
        assert here.decider.ask("late") == "late"
        lines = [here.robot.line() for _ in range(2)]
        assert [line.split()[0] for line in lines] == ["stops", "moves"]
        assert "no command came" in read_stops(here.log)[0].cause
        assert here.decider.ask("state").startswith("armed") or here.drive() == ""  # on a busy computer
        result = run("robots", "stop", here.log.with_name("rover.toml"))
        assert result.exit_code == 0, result.output
        assert read_last(here.robot, here.robot.line()).startswith("stops")
        assert here.decider.ask("state").startswith("disarmed")
        stops = read_stops(here.log)
        assert "robots stop" in {stop.by for stop in stops}
        assert any("somebody else publishes" in stop.cause for stop in stops) or any(
            words in stops[-1].cause for words in TOO_BUSY
        )


@pytest.mark.parametrize(
    ("heard", "said"), [(True, ""), (False, "look whether it stands")], ids=["heard", "not heard"]
)
def test_stops_are_sent_for_two_seconds(
    heard: bool, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot that is not heard may not have heard them."""
    file, wire = tmp_path / "rover.toml", Wire([Publisher("/rover/odom", ODOMETRY)] if heard else [])
    file.write_text(ROVER)
    clocks, send = list[SimulatedClock](), emergency_stop.send_emergency_stop

    def send_in_memory(*arguments: Any, **options: Any) -> bool:
        clocks.append(SimulatedClock(0.0))  # of the thread that stops this robot
        return send(*arguments, clock=clocks[-1], **options)

    monkeypatch.setattr(emergency_stop, "open_transport", lambda file: wire)
    monkeypatch.setattr(emergency_stop, "send_emergency_stop", send_in_memory)
    result = run("robots", "stop", file)
    assert result.exit_code == int(not heard)
    assert said in result.stdout
    assert [clock() for clock in clocks] == [2.0]
    still = encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=0.0)
    assert wire.sent == [("/rover/cmd_vel", still)] * 101
    assert [stop.by for stop in read_stops(file.with_suffix(".stops.jsonl"))] == ["robots stop"]
    assert wire.closed
