"""A session with a robot whose agent runs elsewhere, over a network within this process."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, TWIST, Wire, odometry, sonar
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.team_network.agent_views import RobotViews
from understudy.addons.robots.team_network.remote_robot import RemoteRobot, drive_robots
from understudy.addons.robots.team_network.team_watch import TeamWatch
from understudy.errors import SettingError
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding
from understudy.model.features import Feature
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Continuous
from understudy.records.messages import decode_message
from understudy.runtime.agents.agent import Agent, AgentSpec
from understudy.runtime.agents.network import LocalNetwork
from understudy.runtime.team.team_programs import make_finder
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

KIT = Kit.from_parts(
    Feature("sonar_ahead", Continuous(), reading="sonar_ahead", unit="m"),
    Behavior("forward", Command(drive=1.0)),
    Behavior("backward", Command(drive=-1.0)),
)
FILE = parse_robot(ROVER.replace("required = true\n", ""))


class Rig:
    """A robot with its agent, and a laptop on which it is a body; both have the clock of the test."""

    def __init__(self, trainer: str | None = "laptop") -> None:
        self.clock = SimulatedClock()
        self.network, self.wire = LocalNetwork(), Wire()
        self.robot = Robot(FILE, self.wire, clock=self.clock)
        node = self.network.join("rover")
        find = make_finder(Library(KIT), "rover")
        spec = AgentSpec("rover", find, [], find("backward", Binding({})), trainer=trainer)
        self.agent, self.views = Agent(spec, self.robot, node), RobotViews(self.robot, node)
        team: Any = SimpleNamespace(settings=SimpleNamespace(trainer=trainer), agents=("rover",), name="team")
        laptop: Any = self.network.join("laptop")
        self.watch = TeamWatch(team, laptop, clock=self.clock)
        self.remote = RemoteRobot(FILE, Path("rover.toml"), self.watch)
        self.fleet = Fleet([self.remote])
        self.robot.arm("a test")

    def tick(self) -> float:
        """Let the robot's agent decide once, and return the speed that the robot was sent, m/s."""
        self.clock.advance(0.1)
        self.wire.deliver("/rover/sonar", sonar(2.0), self.clock())
        self.wire.deliver("/rover/odom", odometry(3.0), self.clock())
        self.agent.sense()
        self.views.publish()
        self.agent.obey()
        self.agent.act()
        return float(decode_message(TWIST, self.wire.sent[-1][1]).linear.x)


@pytest.fixture
def rig() -> Iterator[Rig]:
    made = Rig()
    yield made
    made.robot.close()


def test_a_press_moves_a_robot_elsewhere_until_the_laptop_dies(rig: Rig) -> None:
    """The lesson stays with the session; the robot goes by its own guard, and alone half a second after the end."""
    assert rig.tick() < 0.0
    lesson = new_lesson(Library(KIT), "taught", states=["forward"], features=["sonar_ahead"], live=False)
    session = Session(rig.remote, Library(KIT), lesson)
    session.train()
    drive_robots(rig.fleet, [0])
    session.direct("forward")
    speeds = []
    for _ in range(10):
        session.tick()
        speeds.append(rig.tick())
    assert speeds == sorted(speeds)  # the guard lets it speed up as far as the file allows
    assert speeds[-1] == pytest.approx(0.4)
    assert [(each.state, each.next) for each in session.examples] == [
        ("start", "forward"),
        ("forward", "forward"),
    ]
    assert session.examples[0].values == (2.0,)
    assert rig.remote.senses.value("x", rig.clock()) == 3.0
    assert rig.agent.is_driven
    after = [rig.tick() for _ in range(12)]  # the laptop has died
    assert after[3] == pytest.approx(0.4)
    assert after[-1] < 0.0
    assert not rig.agent.is_driven


def test_a_robot_that_is_not_trained_is_left_to_its_agent(rig: Rig) -> None:
    for _ in range(5):
        rig.fleet.act({"drive": np.array([1.0]), "turn": np.array([0.0])})
        assert rig.tick() < 0.0


def test_readings_of_a_silent_agent_are_absent(rig: Rig) -> None:
    """Of the robot, and of the fleet that the studio shows."""
    key = "sonar_ahead", None
    rig.tick()
    assert rig.fleet.sense([key])[key][0] == 2.0
    assert rig.remote.senses.value("x", rig.clock()) == 3.0
    assert rig.remote.sense([key])[key][0] == 2.0
    rig.clock.advance(0.6)
    assert np.isnan(rig.fleet.sense([key])[key][0])
    assert np.isnan(rig.remote.sense([key])[key][0])
    assert (rig.remote.armed, rig.remote.stop_cause) == (False, "its agent is not there")


def test_a_team_without_a_trainer_is_not_trained() -> None:
    rig = Rig(trainer=None)
    drive_robots(rig.fleet, [0])
    with pytest.raises(SettingError, match=r"agents\.trainer is missing; add trainer ="):
        rig.fleet.act({"drive": np.array([1.0]), "turn": np.array([0.0])})
    rig.robot.close()
