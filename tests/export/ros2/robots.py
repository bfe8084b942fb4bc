"""Robots for exported nodes, what happens to them, and what Understudy does with the same messages."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from math import cos, inf, isnan, nan, sin
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from tests.export.exports import keep_arcs_on_circles
from tests.export.ros2.packages import write_words
from tests.robots.rovers import Wire
from tests.runtime.random_libraries import draw_library as draw_random_library
from tests.simulated_clock import ReadOnlyClock

from understudy.addons.export.body_interface import RobotInterface
from understudy.addons.export.conformance import ReferenceRun
from understudy.addons.export.export_automaton import link_ground
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target
from understudy.model.features import Feature, FlagFeature, TimeInState
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy.records.messages import decode_message, encode_message, make_message

SCENARIO = """
understudy = "scenario"
version = 1
name = "yard"
size = [8, 8]
tick_s = 0.1
limit_s = 60

[[objects]]
name = "ball"

[[objects]]
name = "goal"

[types.rover]
radius = 0.2
speed = 0.5
turning_deg = 70

[[types.rover.sensors]]
kind = "pose"

[[types.rover.sensors]]
kind = "locator"

[[types.rover.sensors]]
kind = "bumper"

[[types.rover.sensors]]
kind = "stuck"
after_s = 0.5

[[types.rover.sensors]]
kind = "since"
name = "unseen"
of = "range"

[[types.rover.sensors]]
kind = "since"
name = "untouched"
of = "bumper"

[types.rover.behaviors]
forward = { drive = 1 }

[[robots]]
type = "rover"

[targets]
ball = { object = "ball" }
goal = { object = "goal" }
"""

ROBOT = """
format = "understudy-robot/1"
name = "rover \\"one\\""
world = "yard.toml"
namespace = "/rover"
domain = 7
tick_s = 0.1

[limits]
speed_m_s = 0.5
turn_rad_s = 1.0
acceleration_m_s2 = 1.5
geofence = [-4, -4, 4, 4]

[readings.x]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.position.x"
unit = "m"
required = true

[readings.y]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.position.y"
unit = "m"

[readings.heading]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.orientation"
unit = "rad"

[readings.sonar]
topic = "/shared/sonar"
type = "sensor_msgs/msg/Range"
offset_m = 0.1
stale_s = 0.3

[readings.front]
topic = "scan"
type = "sensor_msgs/msg/LaserScan"
sector_deg = [-45, 45]
offset_m = 0.1

[readings.front_bearing]
topic = "scan"
type = "sensor_msgs/msg/LaserScan"
field = "bearing"
sector_deg = [-90, 90]

[readings.gap]
topic = "scan"
type = "sensor_msgs/msg/LaserScan"
field = "width"
sector_deg = [-180, 180]

[readings.bumper]
topic = "bumper"
type = "std_msgs/msg/Bool"
field = "data"

[targets.ball]
topic = "ball"
stale_s = 0.4

[targets.goal]
at = [1.5, 0.5]

[commands]
type = "geometry_msgs/msg/TwistStamped"
drive_m_s = 0.4
turn_rad_s = 0.9
"""

KIT = Kit.from_parts(
    *(Feature(name, Continuous(), name) for name in ("x", "sonar", "front", "gap", "untouched")),
    *(Feature(name, Toroidal(), name) for name in ("heading", "front_bearing")),
    *(Feature(name, BOOLEAN, name) for name in ("bumper", "stuck")),
    *(Feature(name, Continuous(), name, of="A") for name in ("range", "unseen")),
    Feature("bearing", Toroidal(), "bearing", of="A"),
    FlagFeature("done"),
    FlagFeature("failed"),
    TimeInState(),
    Behavior("forward", Command(drive=1.0)),
    Behavior("left", Command(turn=1.0)),
    Behavior("veer", Command(drive=0.7, turn=-2.0)),
    Target("ball"),
    Target("goal"),
)
NS = 1_000_000_000
TICK_NS, CHECK_NS, MESSAGES_NS = NS // 10, NS // 50, NS // 25
COMMAND = re.compile(r"published (\d+) (/rover/cmd_vel .*)")
FOLDED = re.compile(r"published ([\d+*]+) (/rover/cmd_vel .*)")
ODOMETRY, POSE, RANGE, SCAN, BOOL = (
    "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan",
    "std_msgs/msg/Bool",
)  # fmt: skip


def write_robot(folder: Path, text: str = ROBOT) -> Path:
    """Write a robot's file with its scenario beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "yard.toml").write_text(SCENARIO)
    (folder / "rover.toml").write_text(text)
    return folder / "rover.toml"


def draw_library(seed: int) -> Library:
    """Draw a library whose topmost automaton has no parameter."""
    random = Random(seed)
    while True:
        library = keep_arcs_on_circles(draw_random_library(random, automata=3, depth=4, kit=KIT))
        if not library.parameters("a2"):
            return library


@dataclass(frozen=True)
class Step:
    """What happens next: time passes ("advance", "freeze"), or a message, a call or another publisher comes."""

    sort: str
    ns: int = 0
    topic: str = ""
    type: str = ""
    message: Any = None

    def write(self) -> str:
        if self.sort == "message":
            return f"message {self.topic} {write_words(self.type, self.message)}"
        if self.sort == "call":
            return f"call {self.topic} {self.ns}"
        return f"others {self.topic} {self.ns}" if self.sort == "others" else f"{self.sort} {self.ns}"


def draw_steps(seed: int, seconds: int, *, node: str) -> list[Step]:
    """Draw what happens to a robot: it wanders, its sensors fall silent and lie, somebody arms it again and again."""
    random = Random(seed)
    steps, ns, silent = list[Step](), 0, dict[str, int]()
    x = y = heading = 0.0
    while ns < seconds * NS:
        chance = random.random()
        if chance < 0.008:
            silent[random.choice(("odom", "scan", "sonar", "ball"))] = ns + random.randrange(2 * NS)
        if chance > 0.97:
            steps.append(Step("others", int(random.random() < 0.1), "/rover/cmd_vel"))
        if chance < 0.1:
            steps.append(Step("call", int(random.random() < 0.95), f"/rover/{node}/arm"))
        if 0.5 < chance < 0.502:
            x = random.choice((9.0, nan))
        x = x + random.uniform(-0.1, 0.1) if abs(x) < 4.2 else 0.0
        y, heading = y + random.uniform(-0.05, 0.05), heading + random.uniform(-0.5, 0.5)
        messages = {
            "odom": ("/rover/odom", ODOMETRY, _odometry(random, x, y, heading)),
            "scan": ("/rover/scan", SCAN, draw_scan(random)),
            "sonar": ("/shared/sonar", RANGE, _range(random)),
            "ball": ("/rover/ball", POSE, _pose(random)),
            "bumper": ("/rover/bumper", BOOL, make_message(BOOL, data=random.random() < 0.2)),
        }
        for name, (topic, type, made) in messages.items():
            if silent.get(name, 0) <= ns and random.random() < 0.6:
                # Encoded and decoded, 32-bit floats are what they are on the wire.
                steps.append(
                    Step("message", 0, topic, type, decode_message(type, encode_message(type, made)))
                )
        ns += random.choice((MESSAGES_NS, MESSAGES_NS, MESSAGES_NS + 7_000_001))
        if random.random() < 0.003:
            ns += random.choice((NS // 5, NS // 2, 2 * NS))
            steps.append(Step("freeze", ns))
        else:
            steps.append(Step("advance", ns))
    return steps


def _odometry(random: Random, x: float, y: float, heading: float) -> Any:
    message = make_message(ODOMETRY)
    message.pose.pose.position.x, message.pose.pose.position.y = x, y
    if random.random() < 0.95:
        message.pose.pose.orientation.z = sin(heading / 2)
        message.pose.pose.orientation.w = cos(heading / 2)
    return message


def _pose(random: Random) -> Any:
    message = make_message(POSE)
    message.pose.position.x = random.choice((nan, *(random.uniform(-2, 2) for _ in range(8))))
    message.pose.position.y = random.uniform(-2, 2)
    return message


def _range(random: Random) -> Any:
    low, high = random.choice(((0.1, 3.0), (0.1, 3.0), (0.2, 0.2)))
    value = random.choice((inf, -inf, nan, 0.0, 5.0, *(random.uniform(0.1, 3.0) for _ in range(8))))
    return make_message(RANGE, min_range=low, max_range=high, range=value)


def draw_scan(random: Random) -> Any:
    """Draw a scan of any resolution and reach, with some beams that see nothing, or are invalid."""
    count = random.choice((1, 7, 16, 36, 36, 37, 90))
    step = random.choice((6.283185307179586 / count, 0.1, -0.1, 0.0))
    far = [0.5, 1.0, 1.1, 1.5, 2.0, 2.0, 4.0, inf, -inf, nan, 20.0]
    ranges = [random.choice(far) for _ in range(count)]
    return make_message(
        SCAN, angle_min=random.choice((-3.1415927410125732, 0.0, 1.0, nan)) if random.random() < 0.3 else -3.1415927,
        angle_increment=step, range_min=0.1, range_max=4.0, ranges=np.array(ranges, np.float32),
    )  # fmt: skip


@dataclass
class Run:
    """What was sent (time in ns, speed, turning), every path, and the answers to calls."""

    commands: list[tuple[int, float, float]] = field(default_factory=list)
    paths: list[tuple[int, str]] = field(default_factory=list)
    answers: list[tuple[int, str]] = field(default_factory=list)
    others: list[str] = field(default_factory=list)


def run_node(program: Path, steps: list[Step], *parameters: str) -> Run:
    """Run an exported node on what happens."""
    done = start_node(program, write_script(steps), *parameters)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr
    return read_run(done.stdout)


def write_script(steps: Iterable[Step]) -> str:
    """Write what happens as the stand-in for ROS 2 reads it."""
    return "".join(f"{step.write()}\n" for step in steps) + "shutdown\n"


def start_node(program: Path, script: str, *parameters: str) -> subprocess.CompletedProcess[str]:
    """Run an exported node on a script until it ends."""
    command = [str(program), "--ros-args", "-r", "__ns:=/rover"]
    command += [word for each in parameters for word in ("-p", each)]
    return subprocess.run(command, input=script, capture_output=True, text=True, check=False)


def read_run(printed: str) -> Run:
    """Read what a node printed."""
    run = Run()
    for line in printed.splitlines():
        words = line.split()
        if words[0] == "published" and words[2] == "/rover/cmd_vel":
            run.commands.append((int(words[1]), float(words[-6]), float(words[-1])))
        elif words[0] == "published" and words[2].endswith("/path"):
            run.paths.append((int(words[1]), _text(words[3])))
        elif words[0] == "answered":
            run.answers.append((int(words[1]), _text(words[3])))
        else:
            run.others.append(line)
    return run


def fold_commands(printed: str) -> str:
    """Write commands in a row that are equal as one line: the first time, and how often how much later."""
    lines: list[str] = []
    found = [(COMMAND.fullmatch(line), line) for line in printed.splitlines()]
    for rest, group in groupby(found, key=lambda each: each[0] and each[0][2]):
        if rest is None:
            lines += [line for _, line in group]
        else:
            times = [int(match[1]) for match, _ in group if match]
            later = groupby(after - before for before, after in pairwise(times))
            steps = [f"{len(list(same))}*{step}" for step, same in later]
            lines.append(f"published {'+'.join((str(times[0]), *steps))} {rest}")
    return "\n".join(lines)


def unfold_commands(folded: str) -> str:
    """Write each command on a line of its own again."""
    lines: list[str] = []
    for line in folded.splitlines():
        if (match := FOLDED.fullmatch(line)) is None:
            lines.append(line)
            continue
        begin, *later = match[1].split("+")
        times = [int(begin)]
        for each in later:
            count, _, step = each.partition("*")
            times += [times[-1] + number * int(step) for number in range(1, int(count) + 1)]
        lines += [f"published {ns} {match[2]}" for ns in times]
    return "\n".join(lines)


def _text(word: str) -> str:
    return bytes.fromhex(word[1:]).decode()


class ReferenceNode:
    """Understudy on the same messages, by the same clock, with the guard of `understudy run --robot`."""

    def __init__(self, path: Path, library: Library, name: str, interface: RobotInterface) -> None:
        self.ns, self.wire, self.run = 0, Wire(), Run()
        program, self.hierarchy = link_ground(library, name, {}, interface.body)
        self.reference = ReferenceRun(program, self.hierarchy)
        self.robot = Robot(
            load_robot(path), self.wire, path=path, clock=ReadOnlyClock(lambda: self.ns * 1e-9)
        )
        self.offered = {(each.name, each.of_targets) for each in self.robot.readings}
        self.reference.start(0.0)
        self.due = {self.tick: TICK_NS, self.check: CHECK_NS}
        self.period = dict(self.due)
        self.path = ""

    def follow(self, steps: list[Step]) -> Run:
        for step in steps:
            if step.sort == "advance":
                self._advance(step.ns)
            elif step.sort == "freeze":
                self.ns = step.ns
                for timer, period in self.period.items():
                    while self.due[timer] + period <= self.ns:
                        self.due[timer] += period
            elif step.sort == "message":
                self.wire.deliver(step.topic, encode_message(step.type, step.message), self.ns * 1e-9)
            elif step.sort == "others":
                self.wire.others = [Publisher(step.topic, "")] * step.ns
            else:
                self._call(bool(step.ns))
            self._keep()
        return self.run

    def _call(self, arm: bool) -> None:
        problem = ""
        if not arm:
            self.robot.disarm("a person disarmed it")
        elif not self.robot.armed:
            try:
                self.robot.arm("Ada")
                self.reference.start(self.ns * 1e-9)
            except ArmingRefused as error:
                problem = error.problem
        self.run.answers.append((self.ns, problem))

    def _advance(self, until: int) -> None:
        while min(self.due.values()) <= until:
            timer = min(self.due, key=lambda each: self.due[each])
            self.ns = max(self.ns, self.due[timer])
            self.due[timer] += self.period[timer]
            timer()
            self._keep()
        self.ns = until

    def tick(self) -> None:
        row = []
        for slot in self.hierarchy.readings:
            has = (slot.reading, slot.target is not None) in self.offered
            key = (slot.reading, slot.target)
            row.append(float(self.robot.sense([key])[key][0]) if has else nan)
        if not row:
            self.robot.sense([])
        answer = self.reference.pulse(row, self.robot.time_s)
        names = [
            machine.instance.automaton.states[machine.state].name
            for machine in self.reference.interpreter.active
        ]
        drive, turn = (
            answer.commands[[c.name for c in self.hierarchy.channels].index(n)] for n in ("drive", "turn")
        )
        self.robot.act({"drive": np.array([drive]), "turn": np.array([turn])})
        if "/".join(names) != self.path:
            self.path = "/".join(names)
            self.run.paths.append((self.ns, self.path))

    def check(self) -> None:
        self.robot.guard.check()

    def _keep(self) -> None:
        for _, data in self.wire.sent:
            twist = decode_message("geometry_msgs/msg/TwistStamped", data).twist
            self.run.commands.append((self.ns, twist.linear.x, twist.angular.z))
        self.wire.sent.clear()


def list_moves(run: Run) -> Iterator[tuple[int, float, float]]:
    """Yield the commands that move the robot."""
    return (each for each in run.commands if each[1:] != (0.0, 0.0) and not isnan(each[1]))
