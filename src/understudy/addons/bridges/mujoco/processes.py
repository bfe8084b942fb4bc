"""Run each simulated robot in a process of its own, and a further one, the referee, for the objects of the world.

A robot's process contains the whole model, but drives only its own robot. It sets the others to the poses in their
odometry and lets them continue at those speeds until the next message, so robots push each other in both processes.
The referee follows all odometry, too; it decides when objects appear, vanish and are captured, and publishes their
places.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf, tau
from typing import Any, NamedTuple

import numpy as np

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.robot_files import ODOMETRY, list_robot_names
from understudy.addons.bridges.mujoco.ros_robots import (
    DEADLINE_S,
    RosRobot,
    make_message_header,
    make_point_message,
    tick_in_real_time,
)
from understudy.addons.bridges.mujoco.shapes import AWAY_M
from understudy.addons.bridges.mujoco.world import BodyPose
from understudy.addons.robots.ros.message_readings import compute_heading as heading_of
from understudy.addons.robots.ros.transport import Transport
from understudy.records.messages import MessageRefused, decode_message, encode_message, make_message
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

REFEREE = "referee"
OBJECTS, POSES = f"/{REFEREE}/objects", "geometry_msgs/msg/PoseArray"
"""The topic and message type of the places of all objects, in order of slots; absent ones lie below the floor."""

FAR_M, FAST = 1000.0, 20.0
"""Bounds of valid odometry: distance from the arena's corner (m), and speed (m/s and rad/s)."""


class PoseFollower:
    """The latest pose in a robot's odometry; None before the first message."""

    def __init__(self, name: str, transport: Transport) -> None:
        self.pose: BodyPose | None = None
        transport.subscribe(f"/{name}/odom", ODOMETRY, self._heard)

    def _heard(self, data: bytes, _: float) -> None:
        try:
            message = decode_message(ODOMETRY, data)
        except MessageRefused:
            return
        place, moved = message.pose.pose, message.twist.twist
        heading = heading_of(place.orientation)
        pose = BodyPose(place.position.x, place.position.y, heading % tau, moved.linear.x, moved.angular.z)
        # MuJoCo would reset all its state if it were given an impossible one.
        if (
            abs(pose.x) < FAR_M
            and abs(pose.y) < FAR_M
            and abs(pose.speed) < FAST
            and abs(pose.turning) < FAST
        ):
            self.pose = pose


class ObjectPose(NamedTuple):
    """The place of an object (m), and whether it is present."""

    x: float
    y: float
    there: bool


class RobotProcess:
    """One simulated robot with its ROS 2 topics, in a body whose other robots follow their odometry."""

    def __init__(
        self, body: MujocoBody, number: int, transport: Transport, *, deadline_s: float = DEADLINE_S
    ) -> None:
        self.body, self._deadline_s = body, deadline_s
        self.robot = RosRobot(body, number, transport)
        names = list_robot_names(body.scenario)
        self._others = {k: PoseFollower(name, transport) for k, name in enumerate(names) if k != number}
        self._things: list[ObjectPose] = []
        transport.subscribe(OBJECTS, POSES, self._told)

    def _told(self, data: bytes, _: float) -> None:
        try:
            places = [each.position for each in decode_message(POSES, data).poses]
        except MessageRefused:
            return
        if all(abs(each.x) < FAR_M and abs(each.y) < FAR_M for each in places):
            self._things = [ObjectPose(each.x, each.y, each.z > AWAY_M / 2) for each in places]

    def tick(self, now_s: float) -> None:
        """Update other robots and objects, publish this robot's readings, and execute its last command for one tick."""
        drive, turn = (np.zeros(self.body.robots) for _ in range(2))
        for number, other in self._others.items():
            if (pose := other.pose) is not None:
                drive[number], turn[number] = self.body.follow_pose(number, pose)
                other.pose = None
        self.body.place_objects(self._things)
        self.robot.publish(self.body.sense(self.robot.keys), time.time())
        drive[self.robot.number], turn[self.robot.number] = self.robot.command(
            now_s, deadline_s=self._deadline_s
        )
        self.body.act({"drive": drive, "turn": turn})

    def run(self, *, seconds: float = inf, stopped: Callable[[], bool] = lambda: False) -> int:
        """Run in real time for `seconds` or until `stopped` returns true; return the number of late ticks."""
        return tick_in_real_time(self.tick, self.body.tick_s, seconds=seconds, stopped=stopped)


class ObjectServer:
    """The referee process: it simulates the objects of a scenario whose robots run in other processes."""

    def __init__(self, scenario: Scenario, seed: int, transport: Transport) -> None:
        self.world = World(scenario, [seed])
        self._robots = [PoseFollower(name, transport) for name in list_robot_names(scenario)]
        self._publish = transport.publisher(OBJECTS, POSES)

    def tick(self, _: float = 0.0) -> None:
        """Update the robots from their odometry, advance the objects by one tick, and publish their places."""
        state = self.world.state.robots
        width, height = self.world.scenario.size
        for number, robot in enumerate(self._robots):
            if (pose := robot.pose) is not None:
                state["x"][number], state["y"][number] = np.clip(pose.x, 0, width), np.clip(pose.y, 0, height)
                state["heading"][number] = pose.heading
        self.world.act({})
        objects = self.world.state.objects[0]
        poses = [
            make_message(
                "geometry_msgs/msg/Pose", position=make_point_message(x, y, 0.0 if there else AWAY_M)
            )
            for x, y, there in zip(objects["x"], objects["y"], objects["present"], strict=True)
        ]
        message: Any = make_message(POSES, header=make_message_header(time.time(), "map"), poses=poses)
        self._publish(encode_message(POSES, message))

    def run(self, *, seconds: float = inf, stopped: Callable[[], bool] = lambda: False) -> int:
        """Run in real time for `seconds` or until `stopped` returns true; return the number of late ticks."""
        return tick_in_real_time(self.tick, self.world.tick_s, seconds=seconds, stopped=stopped)
