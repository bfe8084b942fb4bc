"""A robot over a wire in memory, by a clock that tests set."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from tests.robots.rovers import ROVER, Wire, odometry, sonar
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.records.messages import decode_message

SONAR, ODOM, CMD = "/rover/sonar", "/rover/odom", "/rover/cmd_vel"
STOP = (0.0, 0.0)
FENCED = ROVER.replace("turn_rad_s = 1.0\n\n", "turn_rad_s = 1.0\ngeofence = [-1, -1, 1, 1]\n\n", 1).replace(
    "[commands]",
    '[readings.y]\ntopic = "odom"\ntype = "nav_msgs/msg/Odometry"\nfield = "pose.pose.position.y"\n[commands]',
)
HELD = ROVER.replace("[commands]", "[safety]\nhold_to_run = true\n[commands]")
PERIOD_S = 0.02


@dataclass
class Timed:
    """Something in simulated time."""

    clock: SimulatedClock = field(default_factory=SimulatedClock, kw_only=True)

    @property
    def now(self) -> float:
        """The time, s; setting it on is a time in which no thread runs."""
        return self.clock()

    @now.setter
    def now(self, now_s: float) -> None:
        self.clock.jump(now_s - self.clock())


@dataclass
class Rig(Timed):
    """A robot, and everything around it."""

    text: str = ROVER
    wire: Wire = field(default_factory=Wire)

    def __post_init__(self) -> None:
        self.robot = Robot(parse_robot(self.text), self.wire, clock=self.clock)

    def hear(self, topic: str, data: bytes) -> None:
        self.wire.deliver(topic, data, self.now)

    def read(self, name: str) -> float:
        column = self.robot.sense([(name, None)])[name, None]
        assert column.shape == (1,)
        return float(column[0])

    def move(self, drive: float, turn: float = 0.0) -> tuple[float, float]:
        """What was sent for a command."""
        self.robot.act({"drive": np.array([drive]), "turn": np.array([turn])})
        return self.sent

    @property
    def sent(self) -> tuple[float, float]:
        topic, data = self.wire.sent[-1]
        assert topic == CMD
        twist = decode_message(self.robot.file.commands.type, data)
        twist = getattr(twist, "twist", twist)
        return twist.linear.x, twist.angular.z

    def ready(self) -> Rig:
        """Armed, all its readings there."""
        self.hear(SONAR, sonar(2.0))
        self.hear(ODOM, odometry(0.0))
        self.robot.arm("Ada")
        return self

    def wait(self, seconds: float, *, deaf: bool = False) -> None:
        """Let time pass, its guard looking all the while, its sensors speaking unless it is deaf."""
        for _ in range(round(seconds / PERIOD_S)):
            self.now += PERIOD_S
            if not deaf:
                self.hear(SONAR, sonar(2.0))
                self.hear(ODOM, odometry(0.0))
            self.robot.guard.check()
