"""Agents in processes of their own: trained over the network, left by their coordinator, recorded, and explained."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("mujoco", reason="needs the extra mujoco")

from tests.robots.agent_processes import SQUAD, AgentProcesses, run_patrol, wait_until
from tests.ui.cli.commands import run, run_json

from understudy.addons.robots.team_network.agent_questions import AgentStatus
from understudy.addons.robots.team_network.load_plan import load_team_plan
from understudy.addons.robots.team_network.remote_robot import drive_robots
from understudy.addons.robots.twin import DigitalTwin
from understudy.clock import PROMPT_S
from understudy.judging.rerun import Rerun
from understudy.records.merge import read_team_clock
from understudy.records.team_reader import TeamRecording, read_team_recording
from understudy.runtime.agents.leadership import is_term_of
from understudy.runtime.agents.messages import OrderId
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.team import Team
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli.commands.studio import watch_team

ROBOTS = ("pioneer_1", "pioneer_2")
TRAINED = "pioneer_2"
TICK_S, LOOKS_AFTER = 0.05, 5
"""The time between ticks of a training, s, and after how many its robots are asked."""
GOES_ON = 20
"""The number of ticks after which a robot counts as one that goes on."""


def find_statuses(agents: AgentProcesses) -> dict[str, AgentStatus]:
    answers = agents.ask("status")
    return {name: answer.status for name, answer in answers.items() if answer.status is not None}


def find_trained(agents: AgentProcesses) -> list[str] | None:
    """The robots that a person's computer drives; None if one of them does not say."""
    found = find_statuses(agents)
    if not found.keys() >= {*ROBOTS}:
        return None
    return [name for name in ROBOTS if found[name].trainer == "laptop"]


def train(session: Session, press: str, seen: Callable[[], bool]) -> None:
    """Press a state, and tick until something is seen."""
    session.train()
    session.direct(press)

    def is_seen() -> bool:
        for _ in range(LOOKS_AFTER):
            session.tick()
            time.sleep(TICK_S)
        return seen()

    wait_until(is_seen, "it was never so")


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
    train(session, "disperse", lambda: find_trained(agents) == [*ROBOTS])
    assert session.examples[0].next == "disperse"
    assert {path[0] for path in team.paths} == {"disperse"}
    drive_robots(twin.fleet, [])
    wait_until(lambda: find_trained(agents) == [], "the robots were not left alone")


def is_by(leader: str | None, order: OrderId | None) -> bool:
    """Whether an order was decided on by this leader, not by a former one."""
    return leader is not None and order is not None and is_term_of(order[0], leader, (SQUAD, *ROBOTS))


def wait_ordered(agents: AgentProcesses, leaders: Callable[[list[str]], bool]) -> str:
    """Wait until one agent leads, and all robots are armed and have gone on for a while by its own orders."""
    since: dict[str, int] = {}
    leading: list[str] = []

    def have_gone_on() -> bool:
        found = find_statuses(agents)
        leading[:] = [name for name, status in found.items() if SQUAD in status.leads]
        robots = [found[name] for name in ROBOTS if name in found]
        if (
            not agents.are_armed()
            or len(leading) != 1
            or not leaders(leading)
            or any(each.leader not in leading or not is_by(each.leader, each.order) for each in robots)
        ):
            since.clear()
            return False
        for each in robots:
            since.setdefault(each.name, each.ticks)
        return len(robots) == len(ROBOTS) and all(each.ticks > since[each.name] + GOES_ON for each in robots)

    wait_until(have_gone_on, "the robots were not ordered")
    return leading[0]


def run_recorded(folder: Path) -> str:
    """Run a patrol, train it, kill its coordinator; return the robot that leads since."""
    with run_patrol(1000, robots=len(ROBOTS), trainer="laptop", record=folder) as agents:
        shutil.copytree(agents.file.parent, folder / "files")
        shutil.copytree(agents.file.parent.parent / "library", folder / "library")
        with watch_team(agents.file) as (_, twin):
            train_both(agents, twin, folder / "library")
        wait_ordered(agents, lambda leading: leading == [SQUAD])
        agents.processes[SQUAD].kill()
        agents.processes[SQUAD].wait()
        return wait_ordered(agents, lambda leading: leading != [SQUAD])


@pytest.mark.long
@pytest.mark.timed
def test_a_team_is_trained_recorded_merged_and_explained(tmp_path: Path) -> None:
    deputy = run_recorded(tmp_path)
    paths = sorted(tmp_path.glob("*.mcap"))
    assert [path.stem for path in paths] == [SQUAD, *ROBOTS]
    merged = tmp_path / "team.mcap"
    assert run("team", "merge", merged, *paths).exit_code == 0
    clock = read_team_clock(merged)
    assert clock is not None
    assert [each.whole for each in clock.members] == [False, True, True]
    for each in clock.members:  # in truth, all have the clock of this computer
        assert abs(each.ahead_s) <= each.error_s + PROMPT_S
    decide_again(merged, tmp_path / "library", tmp_path / "files" / "team.toml", deputy)
    explain(merged, tmp_path / "library", deputy)


def decide_again(merged: Path, library: Path, file: Path, deputy: str) -> None:
    """Robots and both coordinators decide as they did, on the orders that they had, and around their training."""
    team = read_team_recording(merged)
    assert team is not None
    assert set(team.parts) >= {
        f"{SQUAD}/{SQUAD}",
        f"{SQUAD}/{deputy}",
        *ROBOTS,
    }  # at the beginning, others may lead until the first choice has started
    libraries = load_team_plan(file, library=library).libraries
    for part in team.parts:
        recording = team.read_part(part)
        ran = recording.head.ran
        rerun = Rerun(recording, libraries, ran.sorts, ran.behavior, binding=ran.binding)
        paths = []
        while not rerun.is_over:
            rerun.tick()
            paths.append(rerun.paths[0])
        assert paths == list(recording.records[0].states), part
        assert len(recording.duties[0]) > 0
    for name in ROBOTS:
        recording = team.read_part(name)
        driven = [duty for duty in recording.duties[0] if duty.leader == "laptop"]
        assert driven, name  # how often depends on which messages are late
        assert () in recording.records[0].states


def find_ordered(team: TeamRecording, name: str, leader: str) -> int:
    """Find the last tick (ns) at which a robot executed an order of this leader."""
    recording = team.read_part(name)
    for tick in reversed(range(recording.ticks)):
        now_ns = int(recording.logged_ns[tick])
        order = next((each.order for each in reversed(recording.duties[0]) if each.tick <= tick), None)
        heard = [
            each.orders.leader
            for each in team.orders
            if each.agent == name and each.orders.order == order and each.logged_ns <= now_ns
        ]
        if is_by(leader, order) and heard[-1:] == [leader]:
            return now_ns
    pytest.fail(f"{name} never executed an order of {leader}")


def explain(merged: Path, library: Path, deputy: str) -> None:
    """A robot's order leads to the decision of the coordinator that gave it, on its own computer."""
    team = read_team_recording(merged)
    assert team is not None
    led_s = np.array([*map(team.count_seconds, team.read_part(f"{SQUAD}/{deputy}").logged_ns.tolist())])
    last_ns = 0
    follower = next(each for each in ROBOTS if each != deputy)
    for name in (follower, deputy):
        last_ns = find_ordered(team, name, deputy)
        why = run_json("why", merged, "--agent", name, "--time", team.count_seconds(last_ns), "-l", library)
        robot, coordinator = why["agents"]
        assert (robot["agent"], robot["host"], coordinator["agent"]) == (name, name, SQUAD)
        assert robot["order"]["squad"] == SQUAD
        assert (robot["order"]["leader"], coordinator["host"]) == (deputy, deputy)
        tick = int(np.abs(led_s - coordinator["time_s"]).argmin())
        if tick > 0:  # it decided after the tick before, and sent the order before it was heard
            error_s = coordinator["error_s"] + robot["error_s"]
            assert led_s[tick - 1] <= robot["order"]["heard_s"] + error_s
        (level,) = coordinator["levels"]
        assert level["decision"]["after"] == level["state"]
        assert {each["member"] for each in coordinator["reports"]} == set(ROBOTS)
    shown = run("why", merged, "--agent", SQUAD, "--time", team.count_seconds(last_ns), "-l", library)
    assert shown.exit_code == 0
    assert f"{SQUAD} (led by {deputy}) at" in shown.stdout
    own = read_team_recording(merged.parent / f"{follower}.mcap")
    assert own is not None
    time_s = own.count_seconds(find_ordered(own, follower, deputy))
    alone = run("why", own.path, "--agent", follower, "--time", time_s, "-l", library)
    assert "is not in this file" in alone.stdout, alone.output
    assert run("why", merged, "--agent", "nobody", "--time", 1, "-l", library).exit_code == 2
    assert run("why", merged, "--agent", SQUAD, "--time", 1e6, "-l", library).exit_code == 2
