"""Arming over the network: an order that a stop has overtaken, or that comes late, arms nothing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.memory_network import MemoryTeam
from tests.robots.test_load_plan import write_team

from understudy.robots.robot import Robot
from understudy.robots.team_network.agent_process import ANSWER_S
from understudy.robots.team_network.agent_questions import (
    READY_S,
    AgentQuestion,
    ask,
    ask_to_arm,
    ask_to_prepare,
    ask_to_stop,
)
from understudy.robots.team_network.arming_permits import PERMIT_S, ArmingPermits
from understudy.robots.team_network.load_plan import load_team_plan

NAME = "pioneer_1"


class Visited(MemoryTeam):
    """A team with one agent, and another computer of its network."""

    @property
    def robot(self) -> Robot:
        robot = self.agents[NAME].robot
        assert robot is not None
        return robot

    def ask_for_permits(self) -> dict[str, str]:
        return {
            name: answer.permit for name, answer in ask(self.visitor, AgentQuestion("ready", "Ada")).items()
        }

    def arm(self, permits: dict[str, str]) -> str:
        """Why the robot was not armed."""
        return ask(self.visitor, AgentQuestion("arm", "Ada", permits=permits))[NAME].problem


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[Visited]:
    """An agent that does not tick yet."""
    team = Visited(load_team_plan(write_team(tmp_path)))
    team.make(NAME)
    assert NAME in team.visitor.present
    yield team
    team.close()


def test_a_robot_is_armed(visited: Visited) -> None:
    with visited.running():
        assert {name: answer.problem for name, answer in ask_to_arm(visited.visitor, "Ada").items()} == {
            NAME: ""
        }
        assert visited.robot.armed
        ask_to_stop(visited.visitor, "Ada")
        assert not visited.robot.armed


def test_a_robot_is_armed_whose_watchdog_takes_long_to_start(
    visited: Visited, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Longer than a person's order waits: it is prepared before that."""
    start = visited.robot.prepare
    takes_s = [READY_S + 1.0]

    def start_slowly() -> None:
        visited.clock.sleep(takes_s.pop() if takes_s else 0.0)
        start()

    monkeypatch.setattr(visited.robot, "prepare", start_slowly)
    with visited.running():
        assert ask_to_prepare(visited.visitor, "Ada")[NAME].problem == ""
        assert not visited.robot.armed
        assert ask_to_arm(visited.visitor, "Ada")[NAME].problem == ""
        assert visited.robot.armed


def test_a_stop_since_the_permit_holds(visited: Visited) -> None:
    """Also where it stops a robot that was not armed yet."""
    with visited.running():
        permits = visited.ask_for_permits()
        ask_to_stop(visited.visitor, "Bob")
        assert "it was stopped meanwhile" in visited.arm(permits)
        assert not visited.robot.armed
        assert visited.arm(visited.ask_for_permits()) == ""


def test_a_permit_that_is_too_old_arms_nothing(visited: Visited) -> None:
    with visited.running():
        permits = visited.ask_for_permits()
        visited.clock.advance(PERMIT_S + 0.1)
        assert visited.arm(permits) == "was told to arm too late: arm it again"
        assert not visited.robot.armed


@pytest.mark.parametrize("permits", [{}, {NAME: ""}, {NAME: "0" * 16}])
def test_without_a_permit_nothing_is_armed(visited: Visited, permits: dict[str, str]) -> None:
    with visited.running():
        assert visited.arm(permits) == "was told to arm too late: arm it again"
        assert not visited.robot.armed


def test_who_was_told_that_it_did_not_answer_finds_it_disarmed_later(visited: Visited) -> None:
    permits, asked_s = visited.ask_for_permits(), visited.clock()
    assert visited.arm(permits) == "did not answer in time"  # it does not tick
    assert visited.clock() == asked_s + ANSWER_S
    visited.agents[NAME].tick()
    assert not visited.robot.armed


def test_a_permit_is_for_one_use_and_a_short_while() -> None:
    now = 0.0
    permits = ArmingPermits(lambda: now)
    first, second, third = (permits.give(stop_count) for stop_count in (4, 5, 6))
    assert permits.use(first) == 4
    assert permits.use(first) is None
    now = PERMIT_S
    assert permits.use(second) == 5
    now = PERMIT_S + 0.1
    assert permits.use(third) is None
    assert permits.use("") is None
