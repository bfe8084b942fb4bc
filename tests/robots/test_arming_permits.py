"""Arming over the network: an order that a stop has overtaken, or that comes late, arms nothing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from time import sleep

import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")

from tests.robots.rigs import ODOM, SONAR, Rig
from tests.robots.routers import free_port
from tests.robots.rovers import odometry, sonar
from tests.robots.test_load_plan import write_team
from tests.robots.test_zenoh_network import wait_until

from understudy.robots.team_network import agent_questions
from understudy.robots.team_network.agent_process import AgentProcess
from understudy.robots.team_network.agent_questions import (
    AgentQuestion,
    ask,
    ask_to_arm,
    ask_to_prepare,
    ask_to_stop,
)
from understudy.robots.team_network.arming_permits import PERMIT_S, ArmingPermits
from understudy.robots.team_network.load_plan import LoadedTeam, load_team_plan
from understudy.robots.team_network.zenoh_network import ZenohNetwork, ZenohOptions

NAME = "pioneer_1"


class RigAgent(AgentProcess):
    """The agent of a robot over a wire in memory."""

    def __init__(self, team: LoadedTeam, network: ZenohNetwork) -> None:
        self.rig = Rig()
        self.rig.hear(SONAR, sonar(2.0))
        self.rig.hear(ODOM, odometry(0.0))
        super().__init__(NAME, team, network)

    def _connect_robot(self, path: Path) -> None:
        self.robot = self.rig.robot

    @contextmanager
    def running(self) -> Iterator[None]:
        """Tick in a thread."""
        ends = Event()
        thread = Thread(target=self.run, kwargs={"until": ends.is_set})
        thread.start()
        try:
            yield
        finally:
            ends.set()
            thread.join()


@pytest.fixture
def visited(tmp_path: Path) -> Iterator[tuple[RigAgent, ZenohNetwork]]:
    """An agent that does not tick yet, and another computer of its network."""
    team = load_team_plan(write_team(tmp_path))
    address = f"tcp/127.0.0.1:{free_port()}"
    network = ZenohNetwork(team.name, ZenohOptions(listen=[address], multicast=False))
    visitor = ZenohNetwork(team.name, ZenohOptions(connect=[address], multicast=False))
    agent = RigAgent(team, network)
    wait_until(lambda: NAME in visitor.present)
    yield agent, visitor
    visitor.close()
    agent.close()


def ask_for_permits(visitor: ZenohNetwork) -> dict[str, str]:
    return {name: answer.permit for name, answer in ask(visitor, AgentQuestion("ready", "Ada")).items()}


def arm(visitor: ZenohNetwork, permits: dict[str, str]) -> str:
    """Why the robot was not armed."""
    return ask(visitor, AgentQuestion("arm", "Ada", permits=permits))[NAME].problem


def test_a_robot_is_armed(visited: tuple[RigAgent, ZenohNetwork]) -> None:
    agent, visitor = visited
    with agent.running():
        assert {name: answer.problem for name, answer in ask_to_arm(visitor, "Ada").items()} == {NAME: ""}
        assert agent.rig.robot.armed
        ask_to_stop(visitor, "Ada")
        assert not agent.rig.robot.armed


def test_a_robot_is_armed_whose_watchdog_takes_long_to_start(
    visited: tuple[RigAgent, ZenohNetwork], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Longer than a person's order waits: it is prepared before that."""
    agent, visitor = visited
    monkeypatch.setattr(agent_questions, "READY_S", 0.3)
    start = agent.rig.robot.prepare
    takes_s = [1.0]

    def start_slowly() -> None:
        sleep(takes_s.pop() if takes_s else 0.0)
        start()

    monkeypatch.setattr(agent.rig.robot, "prepare", start_slowly)
    with agent.running():
        assert ask_to_prepare(visitor, "Ada")[NAME].problem == ""
        assert not agent.rig.robot.armed
        assert ask_to_arm(visitor, "Ada")[NAME].problem == ""
        assert agent.rig.robot.armed


def test_a_stop_since_the_permit_holds(visited: tuple[RigAgent, ZenohNetwork]) -> None:
    """Also where it stops a robot that was not armed yet."""
    agent, visitor = visited
    with agent.running():
        permits = ask_for_permits(visitor)
        ask_to_stop(visitor, "Bob")
        assert "it was stopped meanwhile" in arm(visitor, permits)
        assert not agent.rig.robot.armed
        assert arm(visitor, ask_for_permits(visitor)) == ""


@pytest.mark.parametrize("permits", [{}, {NAME: ""}, {NAME: "0" * 16}])
def test_without_a_permit_nothing_is_armed(
    visited: tuple[RigAgent, ZenohNetwork], permits: dict[str, str]
) -> None:
    agent, visitor = visited
    with agent.running():
        assert arm(visitor, permits) == "was told to arm too late: arm it again"
        assert not agent.rig.robot.armed


def test_who_was_told_that_it_did_not_answer_finds_it_disarmed_later(
    visited: tuple[RigAgent, ZenohNetwork],
) -> None:
    agent, visitor = visited
    permits = ask_for_permits(visitor)
    assert arm(visitor, permits) == "did not answer in time"  # it does not tick
    agent.tick()
    assert not agent.rig.robot.armed


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
