"""A robot and a coordinator are trained over the network, and agents in processes of their own record it."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from tests.robots.agent_processes import COMMAND, SQUAD, AgentProcesses, run_patrol, wait_until
from tests.ui.cli.commands import run

from understudy.analysis.rerun import Rerun
from understudy.robots.recording.team_reader import read_team_recording
from understudy.robots.team_network.load_plan import load_team_plan
from understudy.robots.team_network.remote_robot import drive_robots
from understudy.robots.twin import DigitalTwin
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli.running_team import watch_team

pytestmark = [pytest.mark.long, pytest.mark.timed]
TRAINED = "pioneer_3"
ROBOTS = [f"pioneer_{number}" for number in range(1, 5)]


def find_trained(agents: AgentProcesses) -> list[str]:
    """The robots that a person's computer drives."""
    found = {name: answer.status for name, answer in agents.ask("status").items()}
    return [name for name, status in found.items() if status is not None and status.trainer == "laptop"]


def train(session: Session, press: str, seen: Callable[[], bool]) -> None:
    """Press a state, and tick until something is seen."""
    session.train()
    session.direct(press)
    until = time.monotonic() + 30.0
    while not seen():
        assert time.monotonic() < until, "it was never so"
        for _ in range(5):
            session.tick()
            time.sleep(0.05)


def train_both(agents: AgentProcesses, twin: DigitalTwin, library: Path) -> None:
    """Train one robot, then the coordinator of all; the agents decide again after each."""
    libraries = load_team_plan(agents.file, library=library).libraries
    robots, squads = libraries["pioneer"], libraries["patrol"]
    lesson = new_lesson(
        robots, "dash", states=["forwards", "backwards"], features=["sonar_front_left"], live=False
    )
    drive_robots(twin.fleet, [ROBOTS.index(TRAINED)])
    train(
        Session(twin.fleet.robots[ROBOTS.index(TRAINED)], robots, lesson),
        "forwards",
        lambda: find_trained(agents) == [TRAINED],
    )
    drive_robots(twin.fleet, [])
    wait_until(lambda: find_trained(agents) == [], "the robot was not left alone")

    team = Team(twin, agents.team.plan.tree, libraries, {}, trained="patrol")
    lesson = new_lesson(squads, "gather", states=["disperse"], features=["present"], live=False)
    drive_robots(twin.fleet, range(len(ROBOTS)))
    session = Session(CoordinatorBody(team, "patrol"), squads, lesson)
    train(session, "disperse", lambda: find_trained(agents) == ROBOTS)
    assert session.examples[0].next == "disperse"
    assert {path[0] for path in team.paths} == {"disperse"}
    drive_robots(twin.fleet, [])
    wait_until(lambda: find_trained(agents) == [], "the robots were not left alone")
    time.sleep(2.0)


def test_training_over_the_network_is_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each agent's recording decides again as it decided, before, while and after its robot was driven."""

    def start(agents: AgentProcesses, name: str) -> None:
        command = [*COMMAND, "agent", str(agents.file), "--name", name]
        record = ["--record", str(tmp_path / f"{name}.mcap")]
        agents.running[name] = subprocess.Popen([*command, *record], stderr=subprocess.DEVNULL)

    monkeypatch.setattr(AgentProcesses, "start", start)
    with run_patrol(1000, trainer="laptop") as agents:
        subprocess.run(
            ["cp", "-r", agents.file.parent, agents.file.parent.parent / "library", tmp_path], check=True
        )
        with watch_team(agents.file) as (_, twin):
            train_both(agents, twin, tmp_path / "library")
    merged = tmp_path / "team.mcap"
    paths = [tmp_path / f"{name}.mcap" for name in (SQUAD, *ROBOTS)]
    assert run("team", "merge", merged, *paths).exit_code == 0
    team = read_team_recording(merged)
    assert team is not None
    libraries = load_team_plan(tmp_path / "files" / "team.toml", library=tmp_path / "library").libraries
    for part in team.parts:
        recording = team.read_part(part)
        ran = recording.head.ran
        rerun = Rerun(recording, libraries, ran.sorts, ran.behavior, binding=ran.binding)
        found = []
        while not rerun.is_over:
            rerun.tick()
            found.append(rerun.paths[0])
        assert found == list(recording.paths[0]), part
    for name in ROBOTS:
        driven = [duty for duty in team.read_part(name).duties[0] if duty.leader == "laptop"]
        assert len(driven) == (2 if name == TRAINED else 1), name
        assert () in team.read_part(name).paths[0]
