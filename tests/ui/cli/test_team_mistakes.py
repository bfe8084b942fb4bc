"""Mistakes with the agents of a team on the command line: one sentence each."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.robots.test_load_plan import write_team
from tests.ui.cli.commands import run

pytest.importorskip("zenoh", reason="needs the extra ros2")

MISTAKES = [  # arguments besides the team's file, what the error says
    (
        ["team", "stop", "--name", "patrol_0"],
        "team patrol has no robot 'patrol_0'",
    ),  # a squad: nothing to stop
    (["team", "stop", "--name", "nobody"], "team patrol has no robot 'nobody'"),
    (["team", "logs", "--name", "nobody"], "team patrol has no agent 'nobody'"),
    (["team", "arm"], "is not a terminal"),
    (["agent", "--name", "nobody"], "team patrol has no agent 'nobody'"),
    (["agent", "--name", "patrol_0", "--library", "nowhere"], "there is no such folder"),
]


@pytest.mark.parametrize(("arguments", "says"), MISTAKES)
def test_mistakes(tmp_path: Path, arguments: list[str], says: str) -> None:
    file = write_team(tmp_path, "[agents.network]\nmulticast = false\n")
    result = run(*arguments, str(file))
    assert result.exit_code == 2
    assert says in " ".join(result.stderr.split())


def test_robots_can_be_stopped_whatever_is_wrong_with_the_library(tmp_path: Path) -> None:
    file = write_team(tmp_path, "[agents.network]\nmulticast = false\n")
    library = tmp_path / "library"
    library.mkdir(exist_ok=True)
    (library / "broken.json").write_text("{")
    result = run("team", "stop", str(file))
    assert result.exit_code == 1  # nobody is there
    assert "did not answer: look whether it stands" in result.stdout


NOBODY = (
    "No agent of team patrol is there; start them with understudy team agent, or correct [agents.network]."
)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["status"], NOBODY), (["logs"], NOBODY), (["logs", "--name", "pioneer_1"], "pioneer_1 is not there.")],
)
def test_a_team_that_nobody_started(tmp_path: Path, arguments: list[str], says: str) -> None:
    file = write_team(tmp_path, "[agents.network]\nmulticast = false\n")
    result = run("team", *arguments, str(file))
    assert result.exit_code == 1
    assert " ".join((result.stdout + result.stderr).split()) == says


def test_a_team_that_nobody_started_as_json(tmp_path: Path) -> None:
    file = write_team(tmp_path, "[agents.network]\nmulticast = false\n")
    status, logs = (run("team", command, str(file), "--json") for command in ("status", "logs"))
    assert (status.exit_code, logs.exit_code) == (1, 1)
    assert json.loads(status.stdout)["missing"] == ["pioneer_1", "pioneer_2", "pioneer_3", "patrol_0"]
    assert json.loads(logs.stdout) == {"logs": {}}
