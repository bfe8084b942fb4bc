"""Robot files of simulated robots: which topics they publish, which readings these are in the scenario's lessons."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from math import radians
from typing import Any

from understudy.errors import SettingError
from understudy.robots.camera.blobs import LEAST_PX
from understudy.robots.camera.color import Color
from understudy.robots.camera.config import HEADING, format_color_line
from understudy.robots.robot_file import FORMAT, TEAM
from understudy.sim.params import count_robots
from understudy.sim.scenario.files import TARGET as MARKER
from understudy.sim.scenario.schema import RobotType, Scenario, TargetLocator
from understudy.sim.sensing.sensor_row import SensorTopic, find_target_color
from understudy.sim.sensing.sensor_table import find_sensor_row
from understudy.sim_mujoco.materials import derive_camera_color
from understudy.sim_mujoco.robot_model import find_camera

ODOMETRY, IMAGE, PLACE = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Image", "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/Twist"
STALE_S = 0.5
"""Readings older than this are absent: ten messages were lost, or the simulation is gone."""
POSE: Mapping[str, tuple[str, str]] = {
    "x": ("pose.pose.position.x", "m"),
    "y": ("pose.pose.position.y", "m"),
    "heading": ("pose.pose.orientation", "rad"),
    "speed": ("twist.twist.linear.x", "m/s"),
    "turning": ("twist.twist.angular.z", "rad/s"),
}


ROS_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def check_ros(scenario: Scenario) -> None:
    """SettingError where a scenario has no robots, or names that topics of ROS 2 cannot have."""
    where, remedy = (
        f"scenario {scenario.name!r}",
        "begin with a letter, and give letters from a to z, digits and _",
    )
    if not list_robot_names(scenario):
        raise SettingError(where=where, setting="robots", problem="are none", remedy="give one at least")
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
    """What robots are called, in the order of their numbers: humanoid; or pioneer_1, pioneer_2 where there are more."""
    types = [group.type for group in scenario.robots for _ in range(count_robots(group.count, group.at))]
    seen: dict[str, int] = {}
    names = []
    for each in types:
        seen[each] = seen.get(each, 0) + 1
        names.append(f"{each}_{seen[each]}" if types.count(each) > 1 else each)
    return tuple(names)


def list_robot_types(scenario: Scenario) -> tuple[str, ...]:
    """The type of each robot, in the order of their numbers."""
    return tuple(group.type for group in scenario.robots for _ in range(count_robots(group.count, group.at)))


def calibrate_camera_colors(scenario: Scenario, type_name: str) -> Mapping[str, Color]:
    """The pixels that a type's camera takes for each target, calibrated to how it is painted in physics."""
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
    """The file of a simulated robot, TOML; `world` is the scenario by name or path. With a router it speaks Zenoh."""
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
    """The file of all of them, TOML: their own lie beside it."""
    files = ", ".join(f'"{name}.toml"' for name in list_robot_names(scenario))
    return f'format = "{TEAM}"\nname = "{scenario.name}"\nrobots = [{files}]\n'


def list_sensor_topics(kind: RobotType) -> tuple[SensorTopic, ...]:
    """What a type of robots publishes of its sensors' readings."""
    return tuple(topic for sensor in kind.sensors for topic in find_sensor_row(sensor).topics(sensor, kind))


def list_published_readings(kind: RobotType) -> Mapping[str, tuple[str, str, Mapping[str, Any]]]:
    """The readings that have a topic: that, its type, and the other settings of a reading in a robot file."""
    found: dict[str, tuple[str, str, Mapping[str, Any]]] = {}
    for topic in list_sensor_topics(kind):
        for reading, settings in topic.readings.items():
            found.setdefault(reading, (topic.name, topic.type, settings))
    odometry = {name: ("odom", ODOMETRY, {"field": of, "unit": unit}) for name, (of, unit) in POSE.items()}
    return found | odometry


def list_located_targets(scenario: Scenario, kind: RobotType) -> tuple[str, ...]:
    """The targets that a robot is told the place of."""
    there = any(isinstance(each, TargetLocator) for each in kind.sensors)
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
