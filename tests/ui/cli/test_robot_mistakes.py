"""Mistakes about real robots on the command line: one paragraph each, nothing moved, and no recording left behind."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
from tests.ui.cli.commands import run

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import Transport
from understudy.ui.cli.robot_connection import connect_twin

for module in ("cyclonedds", "rosbags", "mcap"):
    pytest.importorskip(module, reason="needs the extra ros2")

ROVER = """
format = "understudy-robot/1"
name = "rover"
world = "arena"
domain = 100
[limits]
speed_m_s = 0.5
turn_rad_s = 1.0
[commands]
drive_m_s = 0.4
turn_rad_s = 1.0
"""
TEAM = """
format = "understudy-robots/1"
name = "pair"
robots = ["rover.toml", "{other}.toml"]
"""
FILES = {
    "rover": ROVER,
    "nowhere": ROVER.replace('world = "arena"', ""),
    "moon": ROVER.replace("arena", "moon"),
    "sub": ROVER.replace('world = "arena"', 'world = "arena"\nkind = "submarine"'),
    "held": ROVER + "[safety]\nhold_to_run = true\n",
    "torn": "x = [",
    "team": TEAM.format(other="second"),
    "second": ROVER.replace("100", "101"),
    "twins": TEAM.format(other="rover"),
    "lone": TEAM.format(other="missing"),
    "mixed": TEAM.format(other="soccer"),
    "soccer": ROVER.replace("arena", "soccer").replace("100", "101"),
}
MISTAKES = [  # arguments, what the error says
    (["run", "--robot", "torn.toml"], "torn.toml at line 1, column 6: is not TOML"),
    (["run", "--robot", "missing.toml"], "missing.toml: there is no such file"),
    (["run", "--robot", "."], "cannot be read"),
    (["run", "--robot", "nowhere.toml"], "rover: world is missing: it defines the features and behaviors"),
    (["teach", "x", "--robot", "moon.toml"], "no world 'moon'; it has arena"),
    (["studio", "--robot", "sub.toml"], "sub.toml at kind: is 'submarine', which arena has not"),
    (["run", "--robot", "team.toml"], "is the format of a team's file; give it to understudy robots run"),
    (["run", "--team", "rover.toml"], "is the format of one robot's file; give it to understudy robots run"),
    (["run", "--team", "lone.toml"], "missing.toml: there is no such file"),
    (["run", "--team", "twins.toml"], "both would get the same commands; give each its own"),
    (["studio", "--team", "mixed.toml"], "'soccer', that of rover is 'arena'; give all the same"),
    (["run", "--robot", "rover.toml", "--team", "team.toml"], "were both given; give one of them"),
    (["run", "soccer", "--robot", "rover.toml"], "is named by its file, and 'soccer' by the command"),
    (["run", "--robot", "rover.toml"], "is not a terminal, so a robot could not be armed or stopped"),
    (["teach", "x", "--robot", "rover.toml"], "is not a terminal"),
    (["teach", "x", "--robot", "held.toml"], "a terminal does not report released keys; teach it in the"),
    (["run", "--robot", "rover.toml", "--seed", "3"], "--seed is not used with real robots"),
    (["run", "--robot", "rover.toml", "--record", "a.gif"], "real robots are not drawn; name a file"),
    (["run", "--robot", "rover.toml", "--record", "a.mcap", "--no-record"], "--no-record were both given"),
    (["run", "--replay", "a.mcap", "--robot", "rover.toml"], "--robot is not used with --replay"),
]


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        (tmp_path / f"{name}.toml").write_text(content)
    return tmp_path


@pytest.mark.parametrize(("arguments", "expected"), MISTAKES, ids=[" ".join(row[0]) for row in MISTAKES])
def test_a_mistake_is_one_paragraph(
    arguments: list[str], expected: str, files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = run(*arguments, monkeypatch=monkeypatch)
    assert result.exit_code == 2, result.output
    assert expected in result.stderr
    assert result.stderr.count("\n") == 1
    assert {path.suffix for path in files.iterdir()} == {".toml"}


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_program_that_the_system_ends_leaves_as_it_should(
    number: signal.Signals, files: Path, request: pytest.FixtureRequest
) -> None:
    """Robots are stopped by their own program, and the recording is whole; for kill -9 there is the watchdog."""
    outside = signal.signal(number, signal.SIG_DFL)  # who runs the tests may ignore hang-ups
    request.addfinalizer(lambda: signal.signal(number, outside))
    left, transports = list[str](), list[Transport]()

    def connect_and_end() -> None:
        with connect_twin(files / "rover.toml", None, record=None, recorded=False) as twin:
            twin.fleet.robots[0].close = left.append  # type: ignore[method-assign, assignment]
            transports.append(twin.fleet.robots[0].transport)
            signal.raise_signal(number)

    with pytest.raises(SystemExit) as error:
        connect_and_end()
    transports[0].close()
    assert (error.value.code, left) == (128 + number, ["its program left"])
    assert signal.getsignal(number) is signal.SIG_DFL


def test_a_team_is_stopped_though_one_of_its_files_is_wrong(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    halted = []

    def heard(robot: RobotFile, **_: object) -> bool:
        halted.append(robot.domain)
        return True

    monkeypatch.setattr("understudy.addons.robots.safety.emergency_stop.send_emergency_stop", heard)
    assert run("robots", "stop", files / "team.toml").exit_code == 0
    assert sorted(halted) == [100, 101]
    told = json.loads(run("robots", "stop", files / "team.toml", "--json").stdout)
    assert [(each["domain"], each["heard"]) for each in told["robots"]] == [(100, True), (101, True)]
    halted.clear()
    result = run("robots", "stop", files / "lone.toml")
    assert (result.exit_code, halted) == (2, [100])
    assert "missing.toml: there is no such file" in result.stderr
