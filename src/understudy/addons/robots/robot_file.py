"""Robot files (TOML): which topics give a robot's readings, and how its channels become speeds.

Lengths are in m, times in s, speeds in m/s and rad/s. Keys of angles in degrees end in `_deg`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Literal, Protocol

from msgspec import field

from understudy.addons.robots.camera.config import CameraSpec
from understudy.addons.robots.ros.state_topic import TOPIC as STATE_TOPIC
from understudy.addons.robots.ros.transport import BUILTIN_TRANSPORTS, list_transports
from understudy.addons.robots.skill_file import SkillSpec, find_skill_problems
from understudy.addons.robots.team_settings import TeamSettings
from understudy.errors import FileError
from understudy.sim.scenario.scenario_errors import suggest_name
from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.scenario.toml_decode import DecodeProblem, Described, decode_toml_values, parse_toml
from understudy.sim.sensing.sensor_table import BLOBS, LOCATIONS


class FrameSpec(StrictStruct, frozen=True, kw_only=True):
    """The frames (REP 105) between which the robot's pose is read: the readings `x`, `y` and `heading`.

    They are the place and direction of the frame `robot` in the frame `fixed`. Transforms come on `topic`, and those
    that never change on `static`. The pose is as old as the oldest transform between the two frames, except for those
    on `static`. If older than `stale_s` it is absent; the robot then stops if it is `required`.
    """

    fixed: str = "map"
    robot: str = "base_link"
    topic: str = "/tf"
    static: str = "/tf_static"
    rate_hz: float | None = None
    stale_s: float = 0.5
    required: bool = False


class DiagnosticsSpec(StrictStruct, frozen=True, kw_only=True):
    """The robot's diagnostics (REP 107).

    With `publish`, the robot's state in Understudy is published there once a second. `unfit` and `stop` list names of
    statuses. While one of them has the level ERROR or STALE, the robot is not counted as a member of its squad; one of
    `stop` also stops it.
    """

    topic: str = "/diagnostics"
    publish: bool = False
    unfit: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()


FORMAT = "understudy-robot/1"
TEAM = "understudy-robots/1"
OTHER = {
    FORMAT: "is the format of one robot's file; give it to understudy robots run, or in a team's file",
    TEAM: "is the format of a team's file; give it to understudy robots run, or name one of the files in it",
}
"""The problem and remedy, separated by "; ", if a file of this format is given where the other one is expected."""

DOMAINS = range(233)
"""The domain ids of ROS 2 that have network ports on every system."""
TOPIC = re.compile(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)
TYPE = re.compile(r"[a-z]\w*/msg/[A-Z]\w*", re.ASCII)
ROUTER = re.compile(r"(tcp|udp|tls|quic|ws)/\S+:\d+|unixsock-stream/\S+")
READING = re.compile(r"[A-Za-z_]\w*", re.ASCII)
POSE = ("x", "y", "heading")
"""The readings that say where the robot is."""
LONGEST_TOPIC = 247
"""The largest number of characters of a full topic name in ROS 2 (RMW_TOPIC_MAX_NAME_LENGTH of rmw)."""
FASTEST_TICK_S, SLOWEST_TICK_S = 0.005, 1.0
SHORTEST_DEADLINE_S = 0.04
"""The shortest deadline, in s: two check periods of the guard. A shorter one would stop the robot without need."""
FASTEST_M_S, FASTEST_RAD_S = 5.0, 10.0
"""The highest limits of speed (m/s) and turning (rad/s) that are accepted; higher ones must be in wrong units."""


class MotionLimits(StrictStruct, frozen=True, kw_only=True):
    """The limits that every command is clipped to.

    `geofence` (x0, y0, x1, y1), in m, is the rectangle in which the readings `x` and `y` must stay.
    """

    speed_m_s: float
    turn_rad_s: float
    acceleration_m_s2: float | None = None
    turn_acceleration_rad_s2: float | None = None
    geofence: tuple[float, float, float, float] | None = None


class ReadingSpec(StrictStruct, frozen=True, kw_only=True):
    """The source of a reading: a `field` of the messages on a topic.

    `field` is a path of names with dots; that of an orientation gives the heading. It may be left out for a Range.
    For a LaserScan, `sector_deg` is (from, to), counter-clockwise from straight ahead, both equal for a single beam.
    Without a field, the reading is then the distance of the nearest return in the sector; with `bearing` it is the
    direction of that return, and with `width` the width of the widest opening in which nothing is nearer than
    `clear_m` (default 1 m). `offset_m`, the distance from the sensor to the robot's rim, is subtracted from ranges. A
    value older than `stale_s` is absent; the robot then stops if the reading is `required`.
    """

    topic: str
    type: str
    field: str | None = None
    sector_deg: tuple[float, float] | None = None
    offset_m: float = 0.0
    clear_m: float | None = None
    unit: str = ""
    rate_hz: float | None = None
    stale_s: float = 0.5
    required: bool = False
    doc: str = ""


class CommandSpec(StrictStruct, frozen=True, kw_only=True):
    """The topic for commands, and the speeds that `drive = 1` (m/s) and `turn = 1` (rad/s) stand for."""

    topic: str = "cmd_vel"
    type: Literal["geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"] = "geometry_msgs/msg/Twist"
    drive_m_s: float
    turn_rad_s: float
    frame: str = "base_link"


class TargetPlaceSpec(StrictStruct, frozen=True, kw_only=True):
    """The place of a target, from which its readings `range` and `bearing` are computed.

    It is a fixed place `at` (x, y), in m, or comes from a topic, whose `field` is the path of a point or position.
    Both are in the frame of the readings `x`, `y` and `heading`; if `relative`, x is ahead of the robot and y to its
    left.
    """

    at: tuple[float, float] | None = None
    topic: str | None = None
    type: str = "geometry_msgs/msg/PoseStamped"
    field: str = "pose.position"
    relative: bool = False
    rate_hz: float | None = None
    stale_s: float = 1.0
    required: bool = False


class SafetySpec(StrictStruct, frozen=True, kw_only=True):
    """The conditions under which the robot stops.

    A tick that is late by more than `deadline_s`, or a program that is silent for that long, stops it. If
    `hold_to_run`, it moves only while a person holds a key. Stops are logged to the file `log` in the folder of the
    robot file; by default its name ends in .stops.jsonl.
    """

    deadline_s: float = 0.12
    hold_to_run: bool = False
    log: str | None = None


class RobotFile(StrictStruct, frozen=True, kw_only=True):
    """The content of a robot file: everything that is needed to connect to a robot.

    `world` is the scenario, by name or path, whose lessons the robot runs, and `kind` its type of robot there, which
    may be left out if there is only one; they define the features, behaviors and targets. `transport` is one of
    `list_transports`. `router` is the address of Zenoh's router, such as tcp/192.168.0.5:7447, or an address for the
    transport of another package. `definitions` is the folder, relative to this file, with the .action, .srv and .msg
    files of the types of `skills`. With `use_sim_time`, ticks follow the clock of a simulation on /clock.
    """

    format: Literal["understudy-robot/1"]
    name: str
    about: str = ""
    world: str | None = None
    kind: str | None = None
    transport: str = "dds"
    router: str | None = None
    domain: int = 0
    namespace: str = ""
    tick_s: float = 0.1
    use_sim_time: bool = False
    limits: MotionLimits
    safety: SafetySpec = SafetySpec()
    readings: Mapping[str, ReadingSpec] = field(default_factory=dict)
    camera: CameraSpec | None = None
    targets: Mapping[str, TargetPlaceSpec] = field(default_factory=dict)
    definitions: str | None = None
    skills: Mapping[str, SkillSpec] = field(default_factory=dict)
    frames: FrameSpec | None = None
    diagnostics: DiagnosticsSpec | None = None
    commands: CommandSpec

    def topic(self, name: str) -> str:
        """Return the full name of a topic.

        Parameters
        ----------
        name
            Name of the topic, which is in the robot's namespace unless it begins with a slash.

        Returns
        -------
        str
            The name with the namespace before it.
        """
        if name.startswith("/"):
            return name
        namespace = self.namespace.strip("/")
        return f"/{namespace}/{name}" if namespace else f"/{name}"


class TeamFile(StrictStruct, frozen=True, kw_only=True):
    """The content of a team's file: several robots, each by the path of its robot file relative to this file.

    `agents` says how they run if each decides for itself, in a process of its own.
    """

    format: Literal["understudy-robots/1"]
    name: str
    about: str = ""
    robots: tuple[str, ...]
    agents: TeamSettings = field(default_factory=TeamSettings)


def is_team_file(path: Path | str) -> bool:
    """Return whether a file has the format of a team's file; other errors in it are left to `load_team`."""
    try:
        return tomllib.loads(_read(path)).get("format") == TEAM
    except (ValueError, RecursionError):
        return False


def load_team(path: Path | str) -> tuple[TeamFile, Sequence[Path]]:
    """Load a team's file, and return it with the paths of its robot files; refuse an invalid file with a FileError."""
    team = _described(_read(path), path, TEAM, TeamFile, "teams of robots")
    if not team.robots:
        raise FileError(path=path, place="robots", problem="are none", remedy="give the path of one at least")
    return team, [Path(path).parent / each for each in team.robots]


def list_robot_files(path: Path | str) -> Sequence[Path]:
    """List the robot files of a team's file; a robot file itself is listed alone."""
    return load_team(path)[1] if is_team_file(path) else [Path(path)]


def load_robot(path: Path | str) -> RobotFile:
    """Load a robot file; refuse an invalid one with a FileError that names the key."""
    return parse_robot(_read(path), path)


def parse_robot(content: str, path: Path | str = "robot.toml") -> RobotFile:
    """Parse the content of a robot file; refuse invalid content with a FileError that names the key."""
    robot = _described(content, path, FORMAT, RobotFile, "robots")
    if (wrong := next(_wrong(robot), None)) is not None:
        raise FileError(path=path, place=wrong.key, problem=wrong.problem, remedy=wrong.remedy)
    return robot


def _read(path: Path | str) -> str:
    try:
        return Path(path).read_text("utf-8-sig")
    except (OSError, ValueError) as error:
        problem = (
            "there is no such file" if isinstance(error, FileNotFoundError) else f"cannot be read ({error})"
        )
        raise FileError(path=path, place="", problem=problem, remedy="give a robot's file") from None


def _described(content: str, path: Path | str, format: str, whole: type[Described], what: str) -> Described:
    """Decode a document that must have the given format."""
    document = parse_toml(content, path)
    if (mark := document.get("format")) != format:
        if isinstance(mark, str) and mark in OTHER:
            problem, _, remedy = OTHER[mark].partition("; ")
            raise FileError(path=path, place="format", problem=problem, remedy=remedy)
        problem = "is missing" if mark is None else f"is {mark!r:.60}, which is not a known format of {what}"
        raise FileError(path=path, place="format", problem=problem, remedy=f'write format = "{format}"')
    file = decode_toml_values(document, whole)
    if isinstance(file, DecodeProblem):
        raise FileError(path=path, place=file.key, problem=file.problem, remedy=file.remedy)
    return file


def _wrong(robot: RobotFile) -> Iterator[DecodeProblem]:
    """Yield the values that have the right types and still are invalid."""
    limits, commands = robot.limits, robot.commands
    if robot.transport not in BUILTIN_TRANSPORTS and robot.transport not in (names := list_transports()):
        remedy = suggest_name(robot.transport, names, what="word")
        yield DecodeProblem("transport", f"is {robot.transport!r:.60}, which is unknown", remedy)
    if robot.domain not in DOMAINS:
        yield DecodeProblem("domain", f"is {robot.domain}", f"give one from 0 to {DOMAINS[-1]}")
    if robot.namespace and not TOPIC.fullmatch(robot.namespace):
        yield DecodeProblem("namespace", f"is {robot.namespace!r:.60}", "give letters, digits, _ and /")
    room = LONGEST_TOPIC - len("//") - len(STATE_TOPIC)
    if len(robot.namespace.strip("/")) > room:
        problem = f"has {len(robot.namespace)} letters, too many for the topics in it"
        yield DecodeProblem("namespace", problem, f"give one of at most {room}")
    yield from _range("tick_s", robot.tick_s, FASTEST_TICK_S, SLOWEST_TICK_S)
    yield from _range("limits.speed_m_s", limits.speed_m_s, 0.0, FASTEST_M_S)
    yield from _range("limits.turn_rad_s", limits.turn_rad_s, 0.0, FASTEST_RAD_S)
    for key in ("acceleration_m_s2", "turn_acceleration_rad_s2"):
        value = getattr(limits, key)
        if value is not None and not (isfinite(value) and value > 0):
            yield DecodeProblem(f"limits.{key}", f"is {value:g}", "give a positive number, or leave it out")
    yield from _range("commands.drive_m_s", commands.drive_m_s, 0.0, limits.speed_m_s)
    yield from _range("commands.turn_rad_s", commands.turn_rad_s, 0.0, limits.turn_rad_s)
    yield from _wrong_topic(robot, "commands.topic", commands.topic)
    yield from _wrong_fence(robot)
    for name, reading in robot.readings.items():
        yield from _wrong_reading(robot, f"readings.{name}", name, reading)
    yield from _wrong_names(robot)
    yield from _range("safety.deadline_s", robot.safety.deadline_s, SHORTEST_DEADLINE_S, 1.0)
    if robot.router is not None and robot.transport == "dds":
        yield DecodeProblem("router", "is not used with DDS", 'leave it out, or give transport = "zenoh"')
    if robot.router is not None and robot.transport == "zenoh" and not ROUTER.fullmatch(robot.router):
        yield DecodeProblem("router", f"is {robot.router!r:.60}", "give one as tcp/192.168.0.5:7447")
    yield from find_source_problems(robot)
    for name, skill in robot.skills.items():
        yield from find_skill_problems(f"skills.{name}", name, skill)
        yield from _wrong_topic(
            robot, f"skills.{name}.{'action' if skill.action else 'service'}", skill.endpoint
        )
    if robot.diagnostics is not None:
        yield from _wrong_topic(robot, "diagnostics.topic", robot.diagnostics.topic)


class SourceFile(Protocol):
    """What of a robot file says where places of targets, poses and images come from."""

    @property
    def targets(self) -> Mapping[str, TargetPlaceSpec]:
        """The places of targets, by name."""
        ...

    @property
    def frames(self) -> FrameSpec | None:
        """The frames between which the robot's pose is read."""
        ...

    @property
    def camera(self) -> CameraSpec | None:
        """The camera and the colors of targets."""
        ...

    def topic(self, name: str) -> str:
        """Return the full name of a topic."""
        ...


def find_source_problems(file: SourceFile) -> Iterator[DecodeProblem]:
    """Yield what is invalid in what a file says of targets, frames and the camera."""
    for name, target in file.targets.items():
        yield from _wrong_target(file, f"targets.{name}", name, target)
    if file.frames is not None:
        yield from _wrong_frames(file, file.frames)
    if file.camera is not None:
        yield from _wrong_topic(file, "camera.topic", file.camera.topic)
        yield from _wrong_times("camera", stale_s=file.camera.stale_s, rate_hz=file.camera.rate_hz)


def _wrong_reading(robot: RobotFile, key: str, name: str, reading: ReadingSpec) -> Iterator[DecodeProblem]:
    if not READING.fullmatch(name):
        yield DecodeProblem(key, "is not a valid name of a reading", "give letters, digits and _")
    yield from _wrong_topic(robot, f"{key}.topic", reading.topic)
    if not TYPE.fullmatch(reading.type):
        problem = f"is {reading.type!r:.60}, which is not a message type"
        yield DecodeProblem(f"{key}.type", problem, "give one as sensor_msgs/msg/Range")
    yield from _wrong_times(key, stale_s=reading.stale_s, rate_hz=reading.rate_hz)
    if not isfinite(reading.offset_m):
        yield DecodeProblem(f"{key}.offset_m", f"is {reading.offset_m:g}", "give a length in m")
    if reading.sector_deg is not None and not all(map(isfinite, reading.sector_deg)):
        yield DecodeProblem(f"{key}.sector_deg", "is not finite", "give two angles in degrees")
    if reading.clear_m is not None:
        yield from _range(f"{key}.clear_m", reading.clear_m, 0.0, 1000.0)


def _wrong_names(robot: RobotFile) -> Iterator[DecodeProblem]:
    """Yield readings whose names are taken by readings of targets or of the camera."""
    taken = {
        "targets": [each.name for each in LOCATIONS] if robot.targets else [],
        "the camera": [each.name for each in BLOBS] if robot.camera is not None else [],
        "frames": POSE if robot.frames is not None else [],
    }
    for of, names in taken.items():
        for name in names:
            if name in robot.readings:
                yield DecodeProblem(f"readings.{name}", f"is what {of} give, too", "give it another name")


def _wrong_target(file: SourceFile, key: str, name: str, target: TargetPlaceSpec) -> Iterator[DecodeProblem]:
    if not READING.fullmatch(name):
        yield DecodeProblem(key, "is not a valid name of a target", "give letters, digits and _")
    if (target.at is None) == (target.topic is None):
        yield DecodeProblem(key, "has to have either `at` or `topic`", "give one of the two")
    if target.at is not None and not all(map(isfinite, target.at)):
        yield DecodeProblem(f"{key}.at", f"is {list(target.at)}", "give x and y in m")
    if target.topic is not None:
        yield from _wrong_topic(file, f"{key}.topic", target.topic)
    if not TYPE.fullmatch(target.type):
        problem = f"is {target.type!r:.60}, which is not a message type"
        yield DecodeProblem(f"{key}.type", problem, "give one as geometry_msgs/msg/PoseStamped")
    if target.at is not None and target.relative:
        yield DecodeProblem(f"{key}.relative", "is not used with a fixed place", "leave it out")
    yield from _wrong_times(key, stale_s=target.stale_s, rate_hz=target.rate_hz)


def _wrong_times(key: str, *, stale_s: float, rate_hz: float | None) -> Iterator[DecodeProblem]:
    yield from _range(f"{key}.stale_s", stale_s, 0.0, 60.0)
    if rate_hz is not None:
        yield from _range(f"{key}.rate_hz", rate_hz, 0.0, 10_000.0)
        if rate_hz * stale_s < 1:
            problem = f"is {stale_s:g}, shorter than the time from one message to the next"
            yield DecodeProblem(f"{key}.stale_s", problem, f"give more than {1 / rate_hz:g}")


def _wrong_fence(robot: RobotFile) -> Iterator[DecodeProblem]:
    fence = robot.limits.geofence
    if fence is None:
        return
    x0, y0, x1, y1 = fence
    if not (x0 < x1 and y0 < y1 and all(map(isfinite, fence))):
        yield DecodeProblem(
            "limits.geofence", f"is {list(fence)}", "give x0, y0, x1, y1 with x0 < x1 and y0 < y1"
        )
    for name in ("x", "y"):
        if name not in robot.readings and robot.frames is None:
            yield DecodeProblem(
                f"readings.{name}", "is missing, and the geofence needs it", f"give the reading {name!r}"
            )


def _wrong_frames(file: SourceFile, frames: FrameSpec) -> Iterator[DecodeProblem]:
    yield from _wrong_topic(file, "frames.topic", frames.topic)
    yield from _wrong_topic(file, "frames.static", frames.static)
    yield from _wrong_times("frames", stale_s=frames.stale_s, rate_hz=frames.rate_hz)
    for key, name in (("fixed", frames.fixed), ("robot", frames.robot)):
        if not name.strip("/"):
            yield DecodeProblem(f"frames.{key}", "is empty", "give the name of a frame, such as base_link")
    if frames.fixed.lstrip("/") == frames.robot.lstrip("/"):
        yield DecodeProblem("frames.robot", "is the same frame as fixed", "give the robot's own frame")


def _wrong_topic(file: SourceFile, key: str, topic: str) -> Iterator[DecodeProblem]:
    if len(file.topic(topic)) > LONGEST_TOPIC:
        problem = f"has {len(file.topic(topic))} letters with its namespace"
        yield DecodeProblem(key, problem, f"give a name of a topic of at most {LONGEST_TOPIC}")
    elif not TOPIC.fullmatch(topic):
        yield DecodeProblem(
            key, f"is {topic!r:.60}, which is not a valid topic name", "give letters, digits, _ and /"
        )


def _range(key: str, value: float, low: float, high: float) -> Iterator[DecodeProblem]:
    """Yield a problem unless the value is above `low` and at most `high`; NaN is a problem."""
    if not low < value <= high:
        yield DecodeProblem(key, f"is {value:g}", f"give a number above {low:g}, up to {high:g}")
