"""The messages of an agent to computers that watch the team: its status, and all readings of its robot."""

from __future__ import annotations

from secrets import randbits

import msgspec

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import POSE
from understudy.runtime.agents.messages import compute_layout
from understudy.runtime.agents.network import Network
from understudy.runtime.agents.training_link import MemberView, view_key
from understudy.runtime.body import list_reading_keys

VIEWER = "viewer:"
"""The prefix of the names that watching computers have in the network."""
STATUS = "status"
"""The first part of the keys of what agents say of themselves."""
STATUS_S = 0.2
"""The time between two such messages, s."""


def is_watched(network: Network) -> bool:
    """Return whether any computer watches the team."""
    return any(name.startswith(VIEWER) for name in network.present)


class RobotViews:
    """The messages with all readings of one robot.

    Parameters
    ----------
    robot
        The robot.
    network
        Its agent's access to the network.
    """

    def __init__(self, robot: Robot, network: Network) -> None:
        self._robot, self._network = robot, network
        self._keys = list_reading_keys(robot)
        self._layout = compute_layout(self._keys)
        self._start, self._sequence = randbits(53), 0

    def publish(self) -> None:
        """Publish the readings of this tick; call it after the robot has sensed, and before it acts."""
        robot, now = self._robot, self._robot.now_s
        percept = robot.sense(self._keys)
        self._sequence += 1
        view = MemberView(
            member=robot.file.name,
            start=self._start,
            sequence=self._sequence,
            layout=self._layout,
            readings=[float(percept[key][0]) for key in self._keys],
            pose=[robot.senses.value(name, now) for name in POSE],
            places={
                name: place
                for name in robot.file.targets
                if (place := robot.senses.locate(name, now)) is not None
            },
        )
        self._network.publish(view_key(robot.file.name), msgspec.msgpack.encode(view))
