"""Robots in processes of their own agree on where all are, and on what the referee says there is."""

from __future__ import annotations

from collections.abc import Callable
from math import nan

import numpy as np
import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from msgspec.structs import replace
from tests.robots.rovers import Wire
from tests.sim_mujoco.drawing import draws
from tests.simulated_clock import SimulatedClock

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.processes import OBJECTS, ObjectServer, RobotProcess
from understudy.addons.bridges.mujoco.robot_files import ODOMETRY
from understudy.addons.bridges.mujoco.ros_robots import (
    drop_derived_readings,
    make_point_message,
    tick_in_real_time,
)
from understudy.addons.bridges.mujoco.world import BodyPose
from understudy.addons.robots.ros.transport import Publish
from understudy.records.messages import TWIST, encode_message, encode_twist, make_message
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import AppearanceSchedule, Scenario


class Hub(Wire):
    """What is published comes to all who subscribed, at once."""

    def publisher(self, topic: str, type: str) -> Publish:
        def publish(data: bytes) -> None:
            if topic in self._received:
                self.deliver(topic, data, 0.0)

        return publish


def crew() -> Scenario:
    """The patrol, whose intruder comes after 0.2 s, for a second, and cannot be captured."""
    scenario = drop_derived_readings(replace(load_scenario("patrol"), tick_s=0.05))
    comes = AppearanceSchedule(away_s=(60, 60), first_s=(0.2, 0.2), stays_s=(1, 1))
    objects = (
        replace(each, presence=comes, capture=None) if each.name == "intruder" else each
        for each in scenario.objects
    )
    return replace(scenario, objects=tuple(objects))


@draws
def test_all_processes_have_all_robots_where_each_one_is() -> None:
    """The first drives, the second turns; after a second, everybody and the referee know it, to a tick's way."""
    hub, scenario = Hub(), crew()
    alone = [RobotProcess(MujocoBody(scenario, [3]), number, hub) for number in range(4)]
    referee = ObjectServer(scenario, 3, hub)
    for _ in range(20):
        hub.deliver("/pioneer_1/cmd_vel", encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=0.0), 0.0)
        hub.deliver("/pioneer_2/cmd_vel", encode_twist(TWIST, speed_m_s=0.0, turn_rad_s=-1.0), 0.0)
        for each in alone:
            each.tick(0.0)
        referee.tick()
    own = [each.body.arenas[0].pose(number) for number, each in enumerate(alone)]
    assert own[0].speed == pytest.approx(0.4, abs=0.05)
    assert own[1].turning == pytest.approx(-1.0, abs=0.15)
    for bodies in (*(each.body.world for each in alone), referee.world):
        robots = bodies.view().robots
        for number, pose in enumerate(own):
            assert np.hypot(robots.x[number] - pose.x, robots.y[number] - pose.y) < 0.05
            assert abs(np.angle(np.exp(1j * (robots.heading[number] - pose.heading)))) < 0.12


def test_who_is_followed_is_put_there_at_its_speeds() -> None:
    body = MujocoBody(crew(), [3])
    told = BodyPose(6.0, 2.0, 1.0, 0.3, -0.5)
    drive, turn = body.follow_pose(1, told)
    assert [drive, turn] == pytest.approx([0.75, -0.5])
    assert list(body.arenas[0].pose(1)) == pytest.approx(list(told))
    assert float(body.view().robots.x[1]) == 6.0


@draws
def test_objects_are_where_the_referee_has_them() -> None:
    """It comes after 0.2 s, for a second: so the referee says, and each robot's process has it then, and then only."""
    hub, scenario = Hub(), crew()
    robot, referee = RobotProcess(MujocoBody(scenario, [3]), 0, hub), ObjectServer(scenario, 3, hub)
    there = []
    for _ in range(40):
        referee.tick()
        robot.tick(0.0)
        views = [world.view().objects for world in (referee.world, robot.body.world)]
        (slots, x), others = ((view.slot.tolist(), view.x.tolist()) for view in views)
        assert (slots, x) == others
        there.append(len(views[0].x))
    assert there[0] == there[-1] == min(there)
    assert 18 <= sum(count > min(there) for count in there) <= 22


@draws
@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00" + bytes(40)])
def test_what_makes_no_sense_changes_nothing(data: bytes) -> None:
    hub = Hub()
    robot = RobotProcess(MujocoBody(crew(), [3]), 0, hub)
    before = robot.body.view().robots.x.copy()
    for topic in ("/pioneer_2/odom", OBJECTS):
        hub.deliver(topic, data, 0.0)
    robot.tick(0.0)
    assert np.abs(robot.body.view().robots.x - before).max() < 0.01


def odometry(x: float, speed: float, turning: float) -> bytes:
    vector = "geometry_msgs/msg/Vector3"
    turned = make_message("geometry_msgs/msg/Quaternion", w=1.0)
    pose = make_message("geometry_msgs/msg/Pose", position=make_point_message(x, 5.0), orientation=turned)
    moved = make_message(TWIST, linear=make_message(vector, x=speed), angular=make_message(vector, z=turning))
    posed, going = (f"geometry_msgs/msg/{name}WithCovariance" for name in ("Pose", "Twist"))
    return encode_message(
        ODOMETRY,
        make_message(ODOMETRY, pose=make_message(posed, pose=pose), twist=make_message(going, twist=moved)),
    )


@draws
@pytest.mark.parametrize(
    ("said", "taken"),
    [
        ((5.0, 0.3, 0.0), True),
        ((5.0, 19.0, 19.0), True),
        ((5.0, nan, 0.0), False),
        ((1e12, 0.0, 0.0), False),
        ((5.0, 1e6, 0.0), False),
        ((5.0, 0.0, -1e9), False),
    ],
)
def test_odometry_that_cannot_be_moves_nobody(said: tuple[float, float, float], taken: bool) -> None:
    """And does not have physics begin anew, with the robot that listens back at its start."""
    hub = Hub()
    robot = RobotProcess(MujocoBody(crew(), [3]), 0, hub)
    robot.body.place(0, 9.0, 9.0, 0.0)
    before = robot.body.arenas[0].pose(1)
    hub.deliver("/pioneer_2/odom", odometry(*said), 0.0)
    robot.tick(0.0)
    mine, other = (robot.body.arenas[0].pose(number) for number in (0, 1))
    assert np.hypot(mine.x - 9.0, mine.y - 9.0) < 0.01
    assert (abs(other.x - before.x) > 0.1) == taken


def test_time_is_kept_and_late_ticks_are_counted() -> None:
    """Ten ticks in a second of 0.1 s each; one that takes three periods makes itself and none other late."""
    ticks, clock = list[float](), SimulatedClock(0.0)

    def slow_once(number: int, seconds: float) -> Callable[[float], None]:
        def tick(now_s: float) -> None:
            ticks.append(now_s)
            if len(ticks) == number:
                clock.sleep(seconds)

        return tick

    late = tick_in_real_time(
        slow_once(3, 0.07), 0.02, seconds=0.3, stopped=lambda: len(ticks) >= 8, clock=clock
    )
    assert (len(ticks), late) == (8, 1)
    assert ticks == [0.0, 0.02, 0.04, 0.11, 0.13, 0.15, 0.17, 0.19]
    ticks.clear()
    assert tick_in_real_time(slow_once(0, 0.0), 0.1, seconds=1.0, stopped=lambda: False, clock=clock) == 0
    assert len(ticks) == 10
