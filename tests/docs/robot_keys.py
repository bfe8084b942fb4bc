"""The keys of robot files and team files, for the reference: meanings here, types and defaults from the schema.

After a key changed, bring the page up to date with: python -m tests.docs.robot_keys
"""

from __future__ import annotations

from tests.docs.pages import ROOT
from tests.docs.renew import replace_between
from tests.docs.schema_tables import Parts, format_tables

from understudy.addons.robots.camera.color import Color
from understudy.addons.robots.camera.config import CameraSpec
from understudy.addons.robots.robot_file import (
    CommandSpec,
    DiagnosticsSpec,
    FrameSpec,
    MotionLimits,
    ReadingSpec,
    RobotFile,
    SafetySpec,
    TargetPlaceSpec,
    TeamFile,
)
from understudy.addons.robots.skill_file import SkillSpec
from understudy.addons.robots.team_settings import AgentSettings, NetworkSpec, TeamSettings

PAGE = ROOT / "docs" / "reference" / "robot-files.md"
KEYS = (
    "<!-- keys: python -m tests.docs.robot_keys puts here what the schema says -->\n",
    "<!-- end of keys -->",
)

_TOPIC = "topic; within the namespace unless it begins with `/`"
_RATE = "expected rate of messages, 1/s, above 0 and at most 10 000; `understudy robots check` reports slower ones"
_STALE = (
    "age of the last message, s, after which the value is absent: at most 60, and longer than 1 / `rate_hz`"
)

PARTS: Parts = {
    RobotFile: (
        "Robot file",
        {
            "format": "format and version of the file",
            "name": "name of the robot",
            "about": "a sentence about it",
            "world": "scenario, by name or path, that defines the robot's features, behaviors and targets",
            "kind": "type of robot in that scenario; needed if there are several",
            "transport": "how ROS 2 messages travel: `dds`, `zenoh`, or as an installed package offers",
            "router": "address of Zenoh's router, such as `tcp/192.168.0.5:7447`; not with `dds`",
            "domain": "`ROS_DOMAIN_ID`, 0 to 232",
            "namespace": "put before each topic that does not begin with `/`",
            "tick_s": "length of a tick, s, above 0.005 and at most 1",
            "use_sim_time": "whether ticks follow the clock of a simulation, on `/clock`",
            "limits": "limits on motion, which hold after every behavior",
            "safety": "when the robot stops by itself",
            "readings": "readings, by the names that the scenario gives them",
            "camera": "the camera; none if left out",
            "targets": "where targets are, by their names",
            "definitions": "folder, beside this file, with the `.action`, `.srv` and `.msg` files of the skills' "
            "types, as `PACKAGE/action/NAME.action`",
            "skills": "actions and services of the robot that become basic behaviors, by the names of these",
            "frames": "the frames between which the robot's pose is read; none if left out",
            "diagnostics": "the robot's diagnostics, read and written; none if left out",
            "commands": "where commands go",
        },
    ),
    MotionLimits: (
        "Limits",
        {
            "speed_m_s": "largest speed, m/s, above 0 and at most 5",
            "turn_rad_s": "largest angular speed, rad/s, above 0 and at most 10",
            "acceleration_m_s2": "largest change of speed, m/s²; not limited if left out",
            "turn_acceleration_rad_s2": "largest change of angular speed, rad/s²; not limited if left out",
            "geofence": "x0, y0, x1, y1, m: rectangle in which the readings `x` and `y` must stay",
        },
    ),
    SafetySpec: (
        "Safety",
        {
            "deadline_s": "longest delay of a tick, and longest silence of the program, s: above 0.04, at most 1",
            "hold_to_run": "whether the robot moves only while a person holds a key",
            "log": "path of the log of stops, beside this file; the file's name with `.stops.jsonl` if left out",
        },
    ),
    ReadingSpec: (
        "Reading",
        {
            "topic": _TOPIC,
            "type": "type of its messages, such as `sensor_msgs/msg/Range`",
            "field": "field of the message, with dots between nested ones; may be left out for a Range; for a scan "
            "`bearing` or `width`, or left out for the distance",
            "sector_deg": "from and to, degrees counter-clockwise from ahead: part of a LaserScan; equal for one beam",
            "offset_m": "distance from the sensor to the robot's rim, m, which is subtracted from a range",
            "clear_m": "distance, m, that beams must reach to count as an opening, for `width`; 1 if left out",
            "unit": "unit of the reading",
            "rate_hz": _RATE,
            "stale_s": _STALE,
            "required": "whether the robot stops while the reading is absent",
            "doc": "a sentence about it",
        },
    ),
    TargetPlaceSpec: (
        "Target",
        {
            "at": "x and y of a fixed place, m, in the frame of the readings `x`, `y` and `heading`; or `topic`",
            "topic": f"{_TOPIC}; or `at`",
            "type": "type of its messages",
            "field": "path of a point or a position in the message",
            "relative": "whether the message says how far ahead and to the left the target is, instead of x and y",
            "rate_hz": _RATE,
            "stale_s": _STALE,
            "required": "whether the robot stops while the place is unknown",
        },
    ),
    SkillSpec: (
        "Skill",
        {
            "action": "name of the action; within the namespace unless it begins with `/`; or `service`",
            "service": "name of the service; within the namespace unless it begins with `/`; or `action`",
            "type": "its type, such as `nav2_msgs/action/NavigateToPose`",
            "goal": "fields of the goal or request, with dots between nested ones: constants, or `A.x` and `A.y`, the "
            "place of the target of parameter A; others are 0, empty or false",
            "feedback": "fields of the feedback that become readings",
            "timeout_s": "longest time for it, s, above 0 and at most 3600; then it is cancelled",
            "moves": "whether the robot drives by itself meanwhile, so that no speeds are sent to it",
            "doc": "a sentence about it",
        },
    ),
    FrameSpec: (
        "Frames",
        {
            "fixed": "frame in which the readings `x`, `y` and `heading` are, such as `map` or `odom`",
            "robot": "frame of the robot",
            "topic": _TOPIC,
            "static": "topic of transforms that never change; within the namespace unless it begins with `/`",
            "rate_hz": _RATE,
            "stale_s": "age of the oldest transform between the two frames, s, after which the pose is absent: at most "
            "60, and longer than 1 / `rate_hz`",
            "required": "whether the robot stops while the pose is absent",
        },
    ),
    DiagnosticsSpec: (
        "Diagnostics",
        {
            "topic": _TOPIC,
            "publish": "whether the robot's state in Understudy is published there, once a second and when it stops",
            "unfit": "names of statuses whose levels ERROR and STALE exclude the robot from its squad",
            "stop": "names of statuses whose levels ERROR and STALE stop the robot, too",
        },
    ),
    CommandSpec: (
        "Commands",
        {
            "topic": _TOPIC,
            "type": "type of its messages",
            "drive_m_s": "speed that the command drive = 1 means, m/s; at most `limits.speed_m_s`",
            "turn_rad_s": "angular speed that the command turn = 1 means, rad/s; at most `limits.turn_rad_s`",
            "frame": "frame id in the header of a TwistStamped",
        },
    ),
    CameraSpec: (
        "Camera",
        {
            "topic": _TOPIC,
            "type": "type of its messages",
            "view_deg": "horizontal angle of view, degrees; 60 if left out",
            "least_px": "size of the smallest blob that counts, pixels of a frame of 160 × 120",
            "rate_hz": _RATE,
            "stale_s": _STALE,
            "required": "whether the robot stops while no image comes",
            "colors": "color of each target that the camera detects, by the target's name",
        },
    ),
    Color: (
        "Color",
        {
            "hue_deg": "smallest and largest hue, degrees; from 350 to 10 crosses red",
            "saturation": "smallest and largest saturation, 0 to 1",
            "value": "smallest and largest value (brightness), 0 to 1",
        },
    ),
    TeamFile: (
        "Team file",
        {
            "format": "format and version of the file",
            "name": "name of the team",
            "about": "a sentence about it",
            "robots": "paths of the robots' files, relative to this file; at least one",
            "agents": "how the robots run if each decides for itself (`understudy team agent`)",
        },
    ),
    TeamSettings: (
        "Agents",
        {
            "library": "folder of the team's automata, relative to this file",
            "runs": "behavior that agents run without an order, by their sort: a type of robots or a kind of squads",
            "bind": "target of each parameter of these behaviors, by the sort",
            "deputies": "agents that may lead a squad besides the one of its own name, the first choice first, by the "
            "squad's name; its members if left out, of more than four the first two",
            "lease_s": "time for which an order holds after it was received, s; from three ticks to 60",
            "same_library": "whether agents with another library are neither counted nor obeyed",
            "trainer": "name of the computer from which a person may train robots",
            "network": "how agents reach each other",
            "each": "what differs for single agents, by their names",
        },
    ),
    NetworkSpec: (
        "Network",
        {
            "connect": "addresses of agents or routers to connect to, such as `udp/10.0.0.1:7447`",
            "listen": "addresses at which agents can be reached; any free port if left out",
            "multicast": "whether agents find each other by multicast",
            "config": "further keys of Zenoh's configuration, such as `transport/link/tls/...`",
        },
    ),
    AgentSettings: (
        "Agent",
        {
            "library": "folder of its automata, instead of the team's",
            "connect": "further addresses to connect to",
            "listen": "addresses at which it can be reached, instead of the team's",
            "config": "keys of Zenoh's configuration, in addition to the team's or instead of them",
        },
    ),
}


def make_tables() -> str:
    """Return the part of the page with all keys. TOML has no null: such keys are left out."""
    return format_tables(PARTS).replace(" or null |", " |")


if __name__ == "__main__":
    replace_between(PAGE, KEYS, make_tables())
