"""Write robot files of simulated robots: their ROS 2 topics, and the readings of a scenario that these carry."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from math import radians
from typing import Any

from understudy.addons.bridges.mujoco.materials import derive_camera_color
from understudy.addons.bridges.mujoco.robot_model import find_camera
from understudy.addons.robots.camera.blobs import LEAST_PX
from understudy.addons.robots.camera.color import Color
from understudy.addons.robots.camera.config import HEADING, format_color_line
from understudy.addons.robots.robot_file import FORMAT, TEAM
from understudy.errors import SettingError
from understudy.records.messages import TWIST
from understudy.sim.params import count_robots
from understudy.sim.scenario.files import TARGET as MARKER
from understudy.sim.scenario.schema import RobotType, Scenario, TargetLocator
from understudy.sim.sensing.sensor_row import SensorTopic, find_target_color
from understudy.sim.sensing.sensor_table import find_sensor_row

ODOMETRY, IMAGE, PLACE = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Image", "geometry_msgs/msg/PoseStamped"
STALE_S = 0.5
"""The age (s) from which a reading counts as absent: ten messages were lost, or the simulation has ended."""
POSE: Mapping[str, tuple[str, str]] = {
    "x": ("pose.pose.position.x", "m"),
    "y": ("pose.pose.position.y", "m"),
    "heading": ("pose.pose.orientation", "rad"),
    "speed": ("twist.twist.linear.x", "m/s"),
    "turning": ("twist.twist.angular.z", "rad/s"),
}


ROS_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def check_ros(scenario: Scenario) -> None:
    """Raise SettingError if a scenario has no robots, skills, or names that ROS 2 topics cannot have."""
    where, remedy = (
        f"scenario {scenario.name!r}",
        "begin with a letter, and give letters from a to z, digits and _",
    )
    if not list_robot_names(scenario):
        raise SettingError(where=where, setting="robots", problem="are none", remedy="give one at least")
    for name in list_robot_types(scenario):
        if scenario.types[name].skills:
            raise SettingError(
                where=where,
                setting=f"types.{name}.skills",
                problem="has no action or service on a simulated robot",
                remedy="leave it out, or run the behavior in the scenario itself",
            )
    names = [(f"types.{name}", name) for name in list_robot_types(scenario)]
    names += [
        (f"reading {name}", name)
        for kind in scenario.types.values()
        for name in list_published_readings(kind)
    ]
    names += [(f"targets.{name}", name) for name in scenario.targets if name != MARKER]
    for setting, name in names:
        if not ROS_NAME.fullmatch(name):
            raise SettingError(
                where=where, setting=setting, problem="is not a valid name in ROS 2", remedy=remedy
            )


def list_robot_names(scenario: Scenario) -> tuple[str, ...]:
    """Return the names of all robots by number: the type, such as humanoid, or pioneer_1 and pioneer_2 if several."""
    types = [group.type for group in scenario.robots for _ in range(count_robots(group.count, group.at))]
    counts: dict[str, int] = {}
    names = []
    for each in types:
        counts[each] = counts.get(each, 0) + 1
        names.append(f"{each}_{counts[each]}" if types.count(each) > 1 else each)
    return tuple(names)


def list_robot_types(scenario: Scenario) -> tuple[str, ...]:
    """Return the name of the type of each robot, by number."""
    return tuple(group.type for group in scenario.robots for _ in range(count_robots(group.count, group.at)))


def calibrate_camera_colors(scenario: Scenario, type_name: str) -> Mapping[str, Color]:
    """Return the range of pixel colors of each target with a color, as the camera of a type renders it in physics."""
    films = {thing.color for thing in scenario.objects if thing.aloft and thing.color is not None}
    colors = {target: find_target_color(scenario, of, type_name) for target, of in scenario.targets.items()}
    return {
        target: derive_camera_color(color, film=color in films, films=films)
        for target, color in colors.items()
        if color is not None
    }


def format_robot_file(
    scenario: Scenario, number: int, *, world: str, domain: int, rate_hz: float, router: str | None = None
) -> str:
    """Return the text (TOML) of the robot file of a simulated robot.

    `number` is the robot's number in the scenario, and `world` the scenario's name or path. With a `router` the robot
    uses Zenoh as its transport.
    """
    name, type_name = list_robot_names(scenario)[number], list_robot_types(scenario)[number]
    kind = scenario.types[type_name]
    lines = [
        f'format = "{FORMAT}"',
        f'name = "{name}"',
        'about = "Simulated: understudy robots simulate."',
        f"world = {json.dumps(world, ensure_ascii=False)}",  # a path may have any characters
        f'kind = "{type_name}"',
        *([] if router is None else ['transport = "zenoh"', f'router = "{router}"']),
        f"domain = {domain}",
        f'namespace = "/{name}"',
        f"tick_s = {scenario.tick_s:g}",
        "",
        "[limits]",
        f"speed_m_s = {kind.speed:g}",
        f"turn_rad_s = {radians(kind.turning_deg):g}",
        f"geofence = [0, 0, {scenario.size[0]:g}, {scenario.size[1]:g}]",
        "",
        "[commands]",
        'topic = "cmd_vel"',
        f'type = "{TWIST}"',
        f"drive_m_s = {kind.speed:g}",
        f"turn_rad_s = {radians(kind.turning_deg):g}",
    ]
    for reading, (topic, type, settings) in list_published_readings(kind).items():
        lines += ["", f"[readings.{reading}]", f'topic = "{topic}"', f'type = "{type}"']
        lines += [f"{key} = {json.dumps(value)}" for key, value in settings.items()]
        lines += [f"rate_hz = {rate_hz:g}", f"stale_s = {STALE_S:g}", "required = true"]
    lines += _camera_lines(scenario, type_name, rate_hz)
    for target in list_located_targets(scenario, kind):
        lines += ["", f"[targets.{target}]", f'topic = "targets/{target}"', "relative = true"]
        lines += [f"stale_s = {STALE_S:g}"]
    return "\n".join(lines) + "\n"


def format_team_file(scenario: Scenario) -> str:
    """Return the text (TOML) of the file of all robots of a scenario, which refers to their robot files beside it."""
    files = ", ".join(f'"{name}.toml"' for name in list_robot_names(scenario))
    return f'format = "{TEAM}"\nname = "{scenario.name}"\nrobots = [{files}]\n'


def list_sensor_topics(robot_type: RobotType) -> tuple[SensorTopic, ...]:
    """Return the ROS 2 topics on which a type of robots publishes its sensors' readings."""
    return tuple(
        topic for sensor in robot_type.sensors for topic in find_sensor_row(sensor).topics(sensor, robot_type)
    )


def list_published_readings(robot_type: RobotType) -> Mapping[str, tuple[str, str, Mapping[str, Any]]]:
    """Return the published readings: the topic, its message type, and other settings for a robot file."""
    sources: dict[str, tuple[str, str, Mapping[str, Any]]] = {}
    for topic in list_sensor_topics(robot_type):
        for reading, settings in topic.readings.items():
            sources.setdefault(reading, (topic.name, topic.type, settings))
    odometry = {name: ("odom", ODOMETRY, {"field": of, "unit": unit}) for name, (of, unit) in POSE.items()}
    return sources | odometry


def list_located_targets(scenario: Scenario, robot_type: RobotType) -> tuple[str, ...]:
    """Return the targets whose places a robot of a type receives: all if it has a locator, else none."""
    there = any(isinstance(each, TargetLocator) for each in robot_type.sensors)
    return tuple(target for target in scenario.targets if target != MARKER) if there else ()


def _camera_lines(scenario: Scenario, type_name: str, rate_hz: float) -> list[str]:
    camera = find_camera(scenario.types[type_name])
    if camera is None:
        return []
    return [
        "",
        "[camera]",
        'topic = "image_raw"',
        f'type = "{IMAGE}"',
        f"view_deg = {camera.view_deg:g}",
        f"least_px = {max(LEAST_PX, camera.least_px):g}",
        f"rate_hz = {rate_hz:g}",
        f"stale_s = {STALE_S:g}",
        "required = true",
        "",
        HEADING,
        *(
            format_color_line(target, color)
            for target, color in calibrate_camera_colors(scenario, type_name).items()
            if target != MARKER
        ),
    ]
