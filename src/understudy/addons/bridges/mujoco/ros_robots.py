"""Run simulated robots as ROS 2 robots that publish their readings and obey Twist, each in its own namespace."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import cos, inf, isfinite, isnan, sin
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.robot_files import (
    IMAGE,
    ODOMETRY,
    PLACE,
    list_located_targets,
    list_robot_names,
    list_robot_types,
    list_sensor_topics,
)
from understudy.addons.bridges.mujoco.robot_model import find_camera, scale_to_commands
from understudy.addons.robots.camera.blobs import Image
from understudy.addons.robots.ros.frame_tree import TRANSFORMS, make_transform
from understudy.addons.robots.ros.transport import Publish, Transport
from understudy.clock import REAL_TIME, Clock
from understudy.model.features import ReadingKey
from understudy.records.messages import (
    TWIST,
    MessageRefused,
    decode_message,
    encode_message,
    list_message_fields,
    make_message,
)
from understudy.sim.scenario.schema import ElapsedSensor, RobotType, Scenario

DEADLINE_S = 0.15
"""The age of its last command (s) above which a robot stops: its own protection against lost control."""
POINT, TURNED = "geometry_msgs/msg/Point", "geometry_msgs/msg/Quaternion"


@dataclass
class LastCommand:
    """The last command of a robot (m/s and rad/s), and the time of its arrival (s, `time.monotonic`)."""

    speed_m_s: float = 0.0
    turn_rad_s: float = 0.0
    at_s: float = -inf


@dataclass
class RosRobot:
    """One robot of a simulated body, controlled and observed through its ROS 2 topics."""

    body: MujocoBody
    number: int
    transport: Transport
    last_command: LastCommand = field(default_factory=LastCommand)

    def __post_init__(self) -> None:
        scenario = self.body.scenario
        self.name = list_robot_names(scenario)[self.number]
        self.kind: RobotType = scenario.types[list_robot_types(scenario)[self.number]]
        self._sensors = list_sensor_topics(self.kind)
        self._targets = list_located_targets(scenario, self.kind)
        self._camera = find_camera(self.kind)
        types = {topic.type for topic in self._sensors}
        self._with_header = {type for type in types if "header" in list_message_fields(type)}
        topics = {topic.name: topic.type for topic in self._sensors} | {"odom": ODOMETRY}
        topics |= {"/tf": TRANSFORMS}
        topics |= {f"targets/{target}": PLACE for target in self._targets}
        topics |= {"image_raw": IMAGE} if self._camera else {}
        self._publish: Mapping[str, Publish] = {
            topic: self.transport.publisher(topic if topic[0] == "/" else f"/{self.name}/{topic}", type)
            for topic, type in topics.items()
        }
        self.transport.subscribe(f"/{self.name}/cmd_vel", TWIST, self._obey)

    @property
    def keys(self) -> tuple[ReadingKey, ...]:
        """The readings of the body that the robot publishes."""
        own = dict.fromkeys(name for topic in self._sensors for name in topic.readings)
        located = [(reading, target) for target in self._targets for reading in ("range", "bearing")]
        return (*((name, None) for name in own), *located)

    def _obey(self, data: bytes, at_s: float) -> None:
        try:
            message = decode_message(TWIST, data)
        except MessageRefused:
            return
        speed, turn = float(message.linear.x), float(message.angular.z)
        if isfinite(speed) and isfinite(turn):
            self.last_command = LastCommand(speed, turn, at_s)

    def command(self, now_s: float, *, deadline_s: float = DEADLINE_S) -> tuple[float, float]:
        """Return drive and turn as shares of the robot's greatest speeds; zero if the last command is too old."""
        latest = self.last_command
        if now_s - latest.at_s > deadline_s:
            return 0.0, 0.0
        return scale_to_commands(self.kind, latest.speed_m_s, latest.turn_rad_s)

    def publish(self, percept: Mapping[ReadingKey, Any], time_s: float) -> None:
        """Publish the robot's readings; `percept` has the columns of all robots, `time_s` is seconds since 1970."""
        header = make_message_header(time_s, self.name)
        for topic in self._sensors:
            values = {name: float(percept[name, None][self.number]) for name in topic.readings}
            fields = dict(topic.make_fields(values))
            if topic.type in self._with_header:
                fields["header"] = header
            self._publish[topic.name](encode_message(topic.type, make_message(topic.type, **fields)))
        odometry = self._odometry(make_message_header(time_s, f"{self.name}/odom"))
        self._publish["odom"](encode_message(ODOMETRY, odometry))
        self._publish["/tf"](encode_message(TRANSFORMS, make_odometry_transform(odometry)))
        for target in self._targets:
            away, bearing = (float(percept[each, target][self.number]) for each in ("range", "bearing"))
            if not (isnan(away) or isnan(bearing)):
                at = make_point_message(away * cos(bearing), away * sin(bearing))
                pose = make_message(
                    "geometry_msgs/msg/Pose", position=at, orientation=make_message(TURNED, w=1.0)
                )
                self._publish[f"targets/{target}"](
                    encode_message(PLACE, make_message(PLACE, header=header, pose=pose))
                )
        if self._camera is not None and (image := self.body.image(self.number)) is not None:
            self._publish["image_raw"](encode_image_message(image, header))

    def _odometry(self, header: Any) -> Any:
        pose = self.body.arenas[0].pose(self.number)
        turned = make_message(TURNED, z=sin(pose.heading / 2), w=cos(pose.heading / 2))
        place = make_message(
            "geometry_msgs/msg/Pose", position=make_point_message(pose.x, pose.y), orientation=turned
        )
        vector = "geometry_msgs/msg/Vector3"
        moved = make_message(
            TWIST, linear=make_message(vector, x=pose.speed), angular=make_message(vector, z=pose.turning)
        )
        return make_message(
            ODOMETRY,
            header=header,
            child_frame_id=f"{self.name}/base_link",
            pose=make_message("geometry_msgs/msg/PoseWithCovariance", pose=place),
            twist=make_message("geometry_msgs/msg/TwistWithCovariance", twist=moved),
        )


def make_odometry_transform(odometry: Any) -> Any:
    """Make the transform of an odometry message, from its frame to the robot's base (REP 105)."""
    pose = odometry.pose.pose
    return make_transform(
        odometry.header,
        odometry.child_frame_id,
        x=pose.position.x,
        y=pose.position.y,
        turned=pose.orientation,
    )


def encode_image_message(image: Image, header: Any) -> bytes:
    """Encode pixels [H, W, 3] as a ROS 2 message Image (rgb8)."""
    height, width, _ = image.shape
    message = make_message(
        IMAGE,
        header=header,
        height=height,
        width=width,
        encoding="rgb8",
        step=3 * width,
        data=image.reshape(-1),
    )
    return encode_message(IMAGE, message)


def make_message_header(time_s: float, frame: str) -> Any:
    """Make the header of a message: the time (s since 1970) and the coordinate frame."""
    seconds = int(time_s)
    stamp = make_message("builtin_interfaces/msg/Time", sec=seconds, nanosec=int((time_s - seconds) * 1e9))
    return make_message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def drop_derived_readings(scenario: Scenario) -> Scenario:
    """Return the scenario without readings that robots do not publish, because their controller derives them.

    This avoids rendering images for them.
    """
    types = {
        name: replace(
            kind, sensors=tuple(each for each in kind.sensors if not isinstance(each, ElapsedSensor))
        )
        for name, kind in scenario.types.items()
    }
    return replace(scenario, types=types)


def make_point_message(x: float, y: float, z: float = 0.0) -> Any:
    """Make a ROS 2 message Point (m)."""
    return make_message(POINT, x=float(x), y=float(y), z=z)


def tick_in_real_time(
    tick: Callable[[float], None],
    period_s: float,
    *,
    seconds: float,
    stopped: Callable[[], bool],
    clock: Clock = REAL_TIME,
) -> int:
    """Call `tick` with the time once per period; return how many ticks were late by a period or more.

    Late ticks are not made up for. It ends after `seconds`, or when `stopped` returns true.
    """
    began = due = clock()
    late = 0
    while not stopped() and clock() - began < seconds:
        tick(clock())
        due += period_s
        left = due - clock()
        if left > 0:
            clock.sleep(left)
        elif left < -period_s:
            late, due = late + 1, clock()
    return late


class Simulation:
    """All robots of a scenario with their ROS 2 topics, in real time with one tick of the body per period."""

    def __init__(self, body: MujocoBody, transport: Transport, *, deadline_s: float = DEADLINE_S) -> None:
        self.body, self._deadline_s = body, deadline_s
        self.robots = [RosRobot(body, number, transport) for number in range(body.robots)]
        self._keys = tuple(dict.fromkeys(key for robot in self.robots for key in robot.keys))

    def tick(self, now_s: float) -> None:
        """Publish the readings of all robots, then execute their last commands for one tick."""
        percept = self.body.sense(self._keys)
        for robot in self.robots:
            robot.publish(percept, time.time())
        commands = np.array([robot.command(now_s, deadline_s=self._deadline_s) for robot in self.robots])
        self.body.act({"drive": commands[:, 0], "turn": commands[:, 1]})

    def run(self, *, seconds: float = inf, stopped: Callable[[], bool] = lambda: False) -> int:
        """Run in real time for `seconds` or until `stopped` returns true; return the number of late ticks."""
        return tick_in_real_time(self.tick, self.body.tick_s, seconds=seconds, stopped=stopped)
