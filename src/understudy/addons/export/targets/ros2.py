"""Target ros2: a package for ROS 2 with a C++ node around the code of target c99, for the robot of a robot's file."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from xml.sax.saxutils import escape

from understudy.addons.export.body_interface import RobotInterface
from understudy.addons.export.target_files import ExportJob, TargetFiles, fill_template, fill_templates
from understudy.addons.export.targets.c99 import make_c99_files
from understudy.addons.export.targets.c99_source import quote_for_c, write_comment
from understudy.addons.export.targets.cpp_names import CNames, name_for_c
from understudy.addons.export.targets.ros2_readings import STEP, NodeReadings, write_cpp_type
from understudy.errors import SettingError, join_names

HEADERS = ("message_values.hpp", "derived_readings.hpp", "motion_guard.hpp")
ALWAYS = ("diagnostic_msgs", "rcl_interfaces", "rclcpp", "std_msgs", "std_srvs")
"""The packages that every node needs."""
TEXT, TRUTH = "std_msgs/msg/String", "std_msgs/msg/Bool"
SPEEDS = ("drive", "turn")
"""The channels that a robot obeys."""
NO_LIMIT = "INFINITE"
KEY = "constexpr double KEY_S = 0.4;         // how long a message says that the key is held\n"


def make_ros2_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to ROS 2; SettingError if no robot was given or it cannot run there."""
    if job.hierarchy.is_coordinator:
        raise SettingError(
            where="target ros2",
            setting="behavior",
            problem=f"{job.hierarchy.name!r} orders a squad, and the node drives one robot",
            remedy="export a behavior of the members, or this one to another target",
        )
    if job.robot is None:
        raise SettingError(
            where="target ros2",
            setting="robot's file",
            problem="is missing: it says what the node subscribes to",
            remedy="give it with --robot rover.toml",
        )
    names = name_for_c(job.hierarchy)
    return _PackageFiles(job, names, job.robot).make()


class _PackageFiles:
    def __init__(self, job: ExportJob, names: CNames, robot: RobotInterface) -> None:
        self.job, self.names, self.hierarchy = job, names, job.hierarchy
        self.robot, self.file = robot, robot.file
        self.readings = NodeReadings(robot, job.hierarchy, names)
        self.node = re.sub("_+", "_", names.prefix).strip("_")
        self.package = f"{self.node}_behavior"

    def make(self) -> TargetFiles:
        p, values = self.names.prefix, self.values()
        c99 = make_c99_files(self.job)
        files = {
            f"src/{p}.h": c99.files[f"{p}.h"],
            f"src/{p}.c": c99.files[f"{p}.c"],
            f"src/{self.node}_node.cpp": fill_template("ros2/node.cpp", values),
            "test/conformance.c": c99.files["conformance.c"],
            f"launch/{self.node}.launch.py": fill_template("ros2/launch.py.in", values),
            f"config/{self.node}.yaml": self.write_parameters().encode(),
        }
        files |= {f"src/{name}": fill_template(f"ros2/{name}", {}) for name in HEADERS}
        files |= fill_templates("ros2", values, "package.xml", "CMakeLists.txt", "Makefile", "README.md")
        by_hand = {f"src/{name}": replace(file, copies=()) for name, file in c99.by_hand.items()}
        return TargetFiles(
            files,
            c99.names,
            ("conformance",),
            facts=self.describe(),
            notes=tuple(self.list_notes()),
            by_hand=by_hand,
        )

    def describe(self) -> dict[str, object]:
        """Describe for the manifest what the node subscribes to, publishes and lacks."""
        sources = [each.source for each in self.readings.sources]
        return {
            "robot": {
                "name": self.file.name,
                "package": self.package,
                "subscriptions": [
                    {
                        "source": each.name, "topic": self.file.topic(each.topic), "type": each.type,
                        "stale_s": each.stale_s, "required": each.required,
                    }
                    for each in sources
                ],
                "commands": {
                    "topic": self.file.topic(self.file.commands.topic), "type": self.file.commands.type,
                },
                "absent_readings": list(self.readings.absent),
                "ignored_channels": self.list_ignored(),
            }
        }  # fmt: skip

    def list_ignored(self) -> list[str]:
        """List the channels that the behavior commands and the robot does not have."""
        used = {
            channel
            for basic in self.hierarchy.basics
            for channel in (*basic.command, *basic.computed)
            if channel not in SPEEDS
        }
        return [each.name for each in self.hierarchy.channels if each.name in used]

    def list_notes(self) -> Iterator[str]:
        """Yield what a person should know before the robot runs."""
        if self.readings.absent:
            absent = join_names(self.readings.absent)
            yield f"{self.file.name} does not read {absent}, so they are always absent"
        if ignored := self.list_ignored():
            yield f"{self.file.name} ignores {join_names(ignored)}: it only drives and turns"
        if not any(each.source.required for each in self.readings.sources):
            yield (
                f"no reading of {self.file.name} is required, so it does not stop when its sensors fall silent; "
                "set required = true in its file for those without which it must not move"
            )
        if self.readings.uses_random:
            yield "random readings are drawn by another generator than in Understudy"

    def values(self) -> dict[str, str]:
        """Make the values of the templates."""
        file, limits, commands = self.file, self.file.limits, self.file.commands
        namespace = file.namespace.strip("/")
        stamped = commands.type.endswith("TwistStamped")
        twist = "message.twist" if stamped else "message"
        fill = [f"{twist}.linear.x = speeds.drive;", f"{twist}.angular.z = speeds.turn;"]
        if stamped:
            frame = f'message.header.frame_id = "{quote_for_c(commands.frame)}";'
            fill = ["message.header.stamp = now();", frame, *fill]
        types = [*self.readings.message_types, commands.type, TEXT]
        if file.safety.hold_to_run:
            types.append(TRUTH)
        packages = sorted({*ALWAYS, *(each.split("/")[0] for each in types)})
        messages = [each for each in packages if each != "rclcpp"]
        notes = list(self.list_notes())
        notes += [
            f"write {each.name} yourself, in src/{self.names.prefix}_functions.h, which later exports keep: "
            f"{each.problem}"
            for each in self.hierarchy.functions_to_write
        ]
        return {
            "title": write_comment(self.hierarchy.name),
            "name": self.names.prefix,
            "NAME": self.names.prefix.upper(),
            "node": self.node,
            "package": self.package,
            "robot": write_comment(file.name),
            "robot_xml": escape(write_comment(file.name)),
            "title_xml": escape(write_comment(self.hierarchy.name)),
            "robot_text": f'"{quote_for_c(file.name)}"',
            "tick_s": repr(float(self.hierarchy.tick_s)),
            "includes": "\n".join(f'#include "{find_header(each)}"' for each in dict.fromkeys(sorted(types))),
            "states": "\n".join(self.write_states()),
            "root": str(self.hierarchy.root.index),
            "source_numbers": "\n".join(f"{STEP}{each.identifier}," for each in self.readings.sources),
            "speed_m_s": repr(float(limits.speed_m_s)),
            "turn_rad_s": repr(float(limits.turn_rad_s)),
            "acceleration": _limit(limits.acceleration_m_s2),
            "turn_acceleration": _limit(limits.turn_acceleration_rad_s2),
            "drive_m_s": repr(float(commands.drive_m_s)),
            "turn_full_rad_s": repr(float(commands.turn_rad_s)),
            "deadline_s": repr(float(file.safety.deadline_s)),
            "hold_to_run": "true" if file.safety.hold_to_run else "false",
            "key_constant": KEY if file.safety.hold_to_run else "",
            "hold_subscription": _indent(self.write_hold(), 2),
            "commands_topic": commands.topic,
            "command_type": write_cpp_type(commands.type),
            "fill_command": _indent(fill, 2),
            "drive": self.names.channels[SPEEDS[0]],
            "turn": self.names.channels[SPEEDS[1]],
            "parameters": _indent(self.readings.write_parameters(), 2),
            "subscriptions": _indent(self.readings.write_subscriptions(), 2),
            "readings": _indent(self.readings.write_readings(), 2),
            "members": _indent(self.readings.write_members(), 1),
            "fence": _indent(self.readings.write_fence(), 2),
            "depends": "\n".join(f"  <depend>{each}</depend>" for each in packages),
            "find_packages": "\n".join(f"find_package({each} REQUIRED)" for each in packages),
            "targets": "\n".join(f"  ${{{each}_TARGETS}}" for each in messages),
            "namespace": namespace,
            "namespace_path": f"{namespace}/" if namespace else "",
            "command_ros": commands.type,
            "domain": "" if file.domain == 0 else self.write_domain(),
            "topics": "\n".join(self.write_topics()),
            "required": join_names(
                [each.source.name for each in self.readings.sources if each.source.required] or ["none"]
            ),
            "zenoh": (
                "\nThe robot's file uses Zenoh: set `RMW_IMPLEMENTATION=rmw_zenoh_cpp` for the node, too.\n"
                if file.transport == "zenoh"
                else ""
            ),
            "hold_note": (
                "\nThe robot's file has `hold_to_run`: the robot moves only while `~/hold` (std_msgs/Bool) says true, "
                "again every 0.4 s at least.\n"
                if file.safety.hold_to_run
                else ""
            ),
            "notes": "".join(f"\n- {note}." for note in notes),
        }

    def write_domain(self) -> str:
        """Write the action of the launch file that sets the robot's domain."""
        return f'        SetEnvironmentVariable("ROS_DOMAIN_ID", "{self.file.domain}"),\n'

    def write_hold(self) -> Sequence[str]:
        """Write the subscription to the key that is held, if the robot's file asks for one."""
        if not self.file.safety.hold_to_run:
            return ()
        return (
            "subscribe<std_msgs::msg::Bool>(",
            f'{STEP}"~/hold", [this](const std_msgs::msg::Bool & message, double now) {{',
            f"{STEP * 2}guard_->hold(message.data ? now + KEY_S : -INFINITE);",
            f"{STEP}}});",
        )

    def write_states(self) -> Iterator[str]:
        """Write the tables of the states' names."""
        for index, automaton in enumerate(self.hierarchy.automata):
            states = ", ".join(
                f'{{"{quote_for_c(state.name)}", {state.child.index if state.child.is_automaton else -1}}}'
                for state in automaton.states
            )
            yield f"const StateName STATES_{index}[] = {{{states}}};"
        tables = ", ".join(f"STATES_{index}" for index in range(len(self.hierarchy.automata)))
        yield f"const StateName * const AUTOMATA[] = {{{tables}}};"

    def write_parameters(self) -> str:
        """Write the file of parameters with their defaults."""
        limits, commands = self.file.limits, self.file.commands
        parameters: list[tuple[str, object]] = [
            ("armed", False),
            ("resume", False),
            ("limits.speed_m_s", limits.speed_m_s),
            ("limits.turn_rad_s", limits.turn_rad_s),
            ("commands.drive_m_s", commands.drive_m_s),
            ("commands.turn_rad_s", commands.turn_rad_s),
            *self.readings.list_parameters(),
        ]
        lines = [f"    {name}: {_write_yaml(value)}" for name, value in parameters]
        return "\n".join(["/**:", "  ros__parameters:", *lines]) + "\n"

    def write_topics(self) -> Iterator[str]:
        """Write the rows of the README's table of topics."""
        for each in self.readings.sources:
            of = each.source
            required = ", required" if of.required else ""
            yield f"| `{of.topic}` | {of.type} | reads {of.name}: absent after {of.stale_s:g} s{required} |"


def find_header(type: str) -> str:
    """Return the header of a type of messages: sensor_msgs/msg/laser_scan.hpp."""
    package, sort, name = type.split("/")
    for pattern in ("(.)([A-Z][a-z]+)", "([a-z0-9])([A-Z])"):  # as rosidl spells file names
        name = re.sub(pattern, r"\1_\2", name)
    return f"{package}/{sort}/{name.lower()}.hpp"


def _limit(value: float | None) -> str:
    return NO_LIMIT if value is None else repr(float(value))


def _indent(lines: Sequence[str] | Iterator[str], steps: int) -> str:
    return "\n".join(f"{STEP * steps}{line}" if line else "" for line in lines)


def _write_yaml(value: object) -> str:
    return json.dumps(value) if isinstance(value, bool | int) else repr(float(str(value)))
