"""Arming over the network: an order that a stop has overtaken, or that comes late, arms nothing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.memory_network import MemoryTeam
from tests.robots.test_load_plan import write_team

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.team_network.agent_process import ANSWER_S
from understudy.addons.robots.team_network.agent_questions import (
    READY_S,
    AgentQuestion,
    ask,
    ask_to_arm,
    ask_to_prepare,
    ask_to_stop,
)
from understudy.addons.robots.team_network.arming_permits import PERMIT_S, ArmingPermits
from understudy.addons.robots.team_network.load_plan import load_team_plan

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
def waiting_agent(tmp_path: Path) -> Iterator[Visited]:
    """An agent that does not tick yet."""
    team = Visited(load_team_plan(write_team(tmp_path)))
    team.make(NAME)
    assert NAME in team.visitor.present
    yield team
    team.close()


def test_a_robot_is_armed(waiting_agent: Visited) -> None:
    with waiting_agent.run_agents():
        assert {
            name: answer.problem for name, answer in ask_to_arm(waiting_agent.visitor, "Ada").items()
        } == {NAME: ""}
        assert waiting_agent.robot.armed
        ask_to_stop(waiting_agent.visitor, "Ada")
        assert not waiting_agent.robot.armed


def test_a_robot_is_armed_whose_watchdog_takes_long_to_start(
    waiting_agent: Visited, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Longer than a person's order waits: it is prepared before that."""
    start = waiting_agent.robot.prepare
    takes_s = [READY_S + 1.0]

    def start_slowly() -> None:
        waiting_agent.clock.sleep(takes_s.pop() if takes_s else 0.0)
        start()

    monkeypatch.setattr(waiting_agent.robot, "prepare", start_slowly)
    with waiting_agent.run_agents():
        assert ask_to_prepare(waiting_agent.visitor, "Ada")[NAME].problem == ""
        assert not waiting_agent.robot.armed
        assert ask_to_arm(waiting_agent.visitor, "Ada")[NAME].problem == ""
        assert waiting_agent.robot.armed


def test_a_stop_since_the_permit_holds(waiting_agent: Visited) -> None:
    """Also where it stops a robot that was not armed yet."""
    with waiting_agent.run_agents():
        permits = waiting_agent.ask_for_permits()
        ask_to_stop(waiting_agent.visitor, "Bob")
        assert "it was stopped meanwhile" in waiting_agent.arm(permits)
        assert not waiting_agent.robot.armed
        assert waiting_agent.arm(waiting_agent.ask_for_permits()) == ""


def test_a_permit_that_is_too_old_arms_nothing(waiting_agent: Visited) -> None:
    with waiting_agent.run_agents():
        permits = waiting_agent.ask_for_permits()
        waiting_agent.clock.advance(PERMIT_S + 0.1)
        assert waiting_agent.arm(permits) == "was told to arm too late: arm it again"
        assert not waiting_agent.robot.armed


@pytest.mark.parametrize("permits", [{}, {NAME: ""}, {NAME: "0" * 16}])
def test_without_a_permit_nothing_is_armed(waiting_agent: Visited, permits: dict[str, str]) -> None:
    with waiting_agent.run_agents():
        assert waiting_agent.arm(permits) == "was told to arm too late: arm it again"
        assert not waiting_agent.robot.armed


def test_who_was_told_that_it_did_not_answer_finds_it_disarmed_later(waiting_agent: Visited) -> None:
    permits, asked_s = waiting_agent.ask_for_permits(), waiting_agent.clock()
    assert waiting_agent.arm(permits) == "did not answer in time"  # it does not tick
    assert waiting_agent.clock() == asked_s + ANSWER_S
    waiting_agent.agents[NAME].tick()
    assert not waiting_agent.robot.armed


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
