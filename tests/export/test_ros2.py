"""Exports to ROS 2: the node runs on headers that stand in for those of ROS 2, beside Understudy itself."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import pytest
from tests.export.exports import FIXTURE, open_fixture
from tests.export.recorded_answers import Answer, Ask, hash_text
from tests.export.ros2.packages import (
    SANITIZED,
    STRICT,
    build_node,
    write_headers,
    write_stand_ins,
    write_words,
)
from tests.export.ros2.robots import (
    BOOL,
    NS,
    ODOMETRY,
    ROBOT,
    SCAN,
    ReferenceNode,
    Run,
    Step,
    draw_library,
    draw_scan,
    draw_steps,
    fold_commands,
    list_moves,
    read_run,
    start_node,
    unfold_commands,
    write_robot,
    write_script,
)
from tests.export.test_translation import WANDERING, WRITTEN
from tests.ui.cli.commands import run, run_json

from understudy.addons.export.body_interface import describe_robot
from understudy.addons.export.export_automaton import ExportResult, export_automaton
from understudy.addons.export.target_files import TEMPLATES
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.ros.message_readings import ScanSector
from understudy.errors import FileError, SettingError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.squad import Assignment, Order
from understudy.model.tree import Tree, make_leaf
from understudy.model.value_kinds import Continuous
from understudy.records.messages import decode_message, encode_message, make_message

FORAGER = """
format = "understudy-robot/1"
name = "rover"
world = "forage"
namespace = "rover"
domain = 43

[limits]
speed_m_s = 0.5
turn_rad_s = 1.0

[readings.x]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.position.x"
required = true
rate_hz = 10

[readings.y]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.position.y"

[readings.heading]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.orientation"

[targets.station]
at = [1.5, 0.0]

[targets.nearest_food]
at = [-2.0, 0.0]

[commands]
drive_m_s = 0.25
turn_rad_s = 1.0
"""
"""A robot that goes to food: it sees the places of the forager's targets."""

FENCE = "geofence = [-4, -4, 4, 4]"
ARM = "/rover/goto/arm"


def export(folder: Path, text: str, name: str, **binding: str) -> ExportResult:
    """Export an automaton of the foragers' library for the robot of a file."""
    library, _ = open_fixture()
    path = write_robot(folder / "robot", text)
    interface = describe_robot(load_robot(path), path=path)
    return export_automaton(library, name, folder / "out", to="ros2", body=interface, binding=binding)


PROGRAMS: dict[tuple[Path, str], Path] = {}
"""The built nodes, by the folder of their package and the flags of the compiler."""
KEPT = re.compile(r"published \d+ \S+/(cmd_vel|path) |(?!published)")
"""The lines of a node's output that most tests look at."""


def summarize_output(printed: str) -> str:
    return fold_commands("\n".join(line for line in printed.splitlines() if KEPT.match(line)))


def run_node(
    ask: Ask,
    folder: Path,
    steps: Sequence[Step],
    *arguments: str,
    flags: str = SANITIZED,
    summarize: Callable[[str], str] = summarize_output,
    asks_for: str = "run",
) -> Answer:
    """Run the node of the package in a folder, or look up what it did, which is `asks_for` of this output."""
    script = write_script(steps)

    def build_and_run() -> Answer:
        if (folder, flags) not in PROGRAMS:
            PROGRAMS[folder, flags] = build_node(folder / "out", folder, flags)
            copied = shutil.copy(PROGRAMS[folder, flags], folder.with_name(f"{folder.name}-node"))
            shutil.rmtree(folder / "build")
            PROGRAMS[folder, flags] = Path(copied)
        done = start_node(PROGRAMS[folder, flags], script, *arguments)
        assert not done.stderr, done.stderr
        return Answer(done.returncode == 0, summarize(done.stdout))

    return ask.by("ros2-node", folder, flags, script, *arguments, asks_for, question=build_and_run)


@dataclass
class Forager:
    """The behavior goto to the nearest food: its package with its stand-ins, what runs it, and what the export said."""

    ask: Ask
    folder: Path
    result: ExportResult

    @property
    def package(self) -> Path:
        return self.folder / "out"

    def run(self, *steps: Step, arguments: tuple[str, ...] = ()) -> Run:
        answer = run_node(self.ask, self.folder, steps, *arguments)
        assert answer.succeeded, answer.said
        return read_run(unfold_commands(answer.said))


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ExportResult]:
    folder = tmp_path_factory.mktemp("forager")
    result = export(folder, FORAGER, "goto", A="nearest_food")
    write_stand_ins(folder / "out", folder)
    return folder, result


@pytest.fixture
def forager(exported: tuple[Path, ExportResult], ask: Ask) -> Forager:
    return Forager(ask, *exported)


def sense(until_s: float, *, since_s: float = 0.0, x: float = 0.0) -> list[Step]:
    """Ten odometries a second, of a robot that stands still, until a time."""
    message = make_message(ODOMETRY)
    message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
    steps = []
    for tenth in range(round(since_s * 10), round(until_s * 10)):
        steps.append(Step("message", 0, "/rover/odom", ODOMETRY, message))
        steps.append(Step("advance", (tenth + 1) * NS // 10))
    return steps


def summarize_run(run: Run, count: int) -> dict[str, str]:
    """Summarize what a node did: hashes of answers, paths and its first commands; what it commanded after those."""
    commands = [(ns, float(speed) + 0.0, float(turning) + 0.0) for ns, speed, turning in run.commands]
    return {
        "answers": hash_text(repr(run.answers).encode()),
        "paths": hash_text(repr(run.paths).encode()),
        "commands": hash_text(repr(commands[:count]).encode()),
        "later": repr(sorted({each[1:] for each in commands[count:]} - {(0.0, 0.0)})),
        "moves": str(len(list(list_moves(run)))),
        "different paths": str(len({path for _, path in run.paths})),
    }


@pytest.mark.parametrize("seed", [3, 8])
def test_the_node_does_what_understudy_does(seed: int, ask: Ask, tmp_path: Path) -> None:
    """Commands at every moment, stops, paths and refusals, while sensors fall silent, lie, and the node freezes."""
    path, library = write_robot(tmp_path), draw_library(seed)
    interface = describe_robot(load_robot(path), path=path)
    export_automaton(library, "a2", tmp_path / "out", to="ros2", body=interface)
    write_stand_ins(tmp_path / "out", tmp_path)
    steps = draw_steps(seed, 200, node="a2")
    expected = ReferenceNode(path, library, "a2", interface).follow(steps)
    count = len(expected.commands)
    answer = run_node(
        ask, tmp_path, steps, flags=SANITIZED if seed == 3 else STRICT, asks_for=f"summary of {count} commands",
        summarize=lambda printed: json.dumps(summarize_run(read_run(printed), count)),
    )  # fmt: skip
    assert answer.succeeded
    found, summary = json.loads(answer.said), summarize_run(expected, count)
    assert found["answers"] == summary["answers"]
    assert found["paths"] == summary["paths"]
    assert found["commands"] == summary["commands"]
    assert found["later"] == "[]"  # but stops
    assert int(found["moves"]) > 1000
    assert int(found["different paths"]) > 3


def test_folded_commands_are_all_there() -> None:
    printed = "\n".join((
        "publisher /rover/cmd_vel reliable volatile 1",
        *(f"published {ns} /rover/cmd_vel 0 0 0 0 0 {turning}" for turning in (0, 1) for ns in (3, 5, 7, 7, 8)),
        "log info goto rover is armed",
        "published 9 /rover/cmd_vel 0 0 0 0 0 1",
    ))  # fmt: skip
    folded = fold_commands(printed)
    assert "published 3+2*2+1*0+1*1 /rover/cmd_vel 0 0 0 0 0 0" in folded.splitlines()
    assert len(folded.splitlines()) == 5
    assert unfold_commands(folded) == printed


def test_nothing_is_sent_before_it_is_armed(forager: Forager) -> None:
    found = forager.run(*sense(2.0))
    assert found.commands == []
    assert found.paths  # it decides
    assert not any("publisher /rover/cmd_vel" in line for line in found.others)


def test_it_stops_when_its_readings_are_stale(forager: Forager) -> None:
    """A required reading is older than 0.5 s at 1.5 s: one more stop per check for five seconds, then nothing."""
    found = forager.run(*sense(0.5), Step("call", 1, ARM), *sense(1.0, since_s=0.5), Step("advance", 9 * NS))
    last = max(ns for ns, *_ in list_moves(found))
    assert NS < last <= 1.42 * NS  # the last message came at 0.9 s
    stops = [ns for ns, *_ in found.commands if ns > last]
    assert stops[0] - last <= NS // 50
    assert 6.3 * NS < stops[-1] < 6.5 * NS
    assert "log warn goto disarmed: x is absent" in found.others


def test_it_goes_on_by_itself_only_when_told_to(forager: Forager) -> None:
    steps = (
        *sense(0.5),
        Step("call", 1, ARM),
        *sense(1.0, since_s=0.5),
        Step("advance", 3 * NS),
        *sense(5.0, since_s=3.0),
    )
    assert max(ns for ns, *_ in list_moves(forager.run(*steps))) < 2 * NS
    found = forager.run(*steps, arguments=("resume:=true",))
    assert max(ns for ns, *_ in list_moves(found)) > 4 * NS
    assert (0.0, 0.0) in {each[1:] for each in found.commands if 2 * NS < each[0] < 3 * NS}


def test_it_can_be_armed_from_the_start(forager: Forager) -> None:
    found = forager.run(Step("advance", NS), *sense(2.0, since_s=1.0), arguments=("armed:=true",))
    assert NS <= found.commands[0][0] <= 1.2 * NS  # as soon as its readings are there
    assert list(list_moves(found))


def test_arming_is_refused_with_the_reason(forager: Forager) -> None:
    others = Step("others", 1, "/rover/cmd_vel")
    found = forager.run(Step("call", 1, ARM), *sense(0.2), others, Step("call", 1, ARM))
    assert [answer for _, answer in found.answers] == [
        "x is absent",
        "somebody else publishes on /rover/cmd_vel",
    ]
    assert found.commands == []


def test_it_is_stopped_when_the_node_ends(forager: Forager) -> None:
    found = forager.run(*sense(0.5), Step("call", 1, ARM), *sense(1.0, since_s=0.5))
    assert [each[1:] for each in found.commands[-4:]] == [(0.0, 0.0)] * 4
    assert found.commands[-5][1:] != (0.0, 0.0)
    assert "log warn goto disarmed: the node was shut down" in found.others


def test_parameters_lower_limits_and_never_raise_them(forager: Forager) -> None:
    steps = (*sense(0.5), Step("call", 1, ARM), *sense(6.0, since_s=0.5, x=0.0))
    slow = forager.run(*steps, arguments=("limits.speed_m_s:=0.1", "limits.turn_rad_s:=0.2"))
    assert max(abs(speed) for _, speed, _ in slow.commands) <= 0.1
    assert max(abs(turning) for *_, turning in slow.commands) == 0.2
    for argument in (
        "limits.speed_m_s:=0.6",
        "limits.speed_m_s:=nan",
        "stale_s.x:=0",
        "targets.nearest_food.x:=inf",
    ):
        answer = run_node(forager.ask, forager.folder, (), argument)
        assert not answer.succeeded
        assert f"log fatal goto parameter {argument.partition(':')[0]} is " in answer.said


def test_places_of_targets_are_parameters(forager: Forager) -> None:
    steps = (*sense(0.5), Step("call", 1, ARM), *sense(3.0, since_s=0.5))
    place = ("targets.nearest_food.x:=2.0", "targets.nearest_food.y:=0.01")
    ahead, behind = forager.run(*steps, arguments=place), forager.run(*steps)
    assert 0.25 in {speed for _, speed, _ in list_moves(ahead)}
    assert 0.25 not in {speed for _, speed, _ in list_moves(behind)}  # it turns around


def test_quality_of_service_is_that_of_understudy(forager: Forager) -> None:
    found = forager.run(*sense(0.5), Step("call", 1, ARM))
    assert "subscription /rover/odom best_effort volatile 4" in found.others
    assert "publisher /rover/cmd_vel reliable volatile 1" in found.others
    assert "publisher /rover/goto/path reliable transient_local 1" in found.others


def test_diagnostics_say_what_is_wrong(forager: Forager) -> None:
    steps = (*sense(1.0), Step("advance", 4 * NS))
    answer = run_node(
        forager.ask, forager.folder, steps, summarize=summarize_diagnostics, asks_for="diagnostics"
    )
    texts = answer.said.splitlines()
    assert len(texts) == 4
    assert "goto: behavior|disarmed: not armed|rover|" in texts[0]
    assert "goto: x|fresh|rover|" in texts[0]
    assert "topic|odom|messages|10|rate_hz|10|" in texts[0]
    assert "goto: x|it fell silent|rover|" in texts[-1]


def summarize_diagnostics(printed: str) -> str:
    lines = [line for line in printed.splitlines() if re.match(r"published \d+ /diagnostics ", line)]
    return "\n".join(re.sub(r" s([0-9a-f]+)", _decode, line) for line in lines)


def _decode(found: re.Match[str]) -> str:
    return bytes.fromhex(found[1]).decode() + "|"


def test_a_held_key_lets_it_move(ask: Ask, tmp_path: Path) -> None:
    export(tmp_path, FORAGER + "\n[safety]\nhold_to_run = true\n", "goto", A="nearest_food")
    write_stand_ins(tmp_path / "out", tmp_path)
    held = Step("message", 0, "/rover/goto/hold", BOOL, make_message(BOOL, data=True))
    steps = [*sense(0.5), Step("call", 1, ARM), *sense(1.0, since_s=0.5), held, *sense(2.0, since_s=1.0)]
    found = read_run(unfold_commands(run_node(ask, tmp_path, steps, flags=STRICT).said))
    moves = [ns for ns, *_ in list_moves(found)]
    assert NS <= min(moves) <= 1.12 * NS
    assert max(moves) <= 1.42 * NS
    assert found.commands[-10][1:] == (0.0, 0.0)
    assert not any("disarmed: nobody" in line for line in found.others)


def test_the_package_is_complete(forager: Forager) -> None:
    """What is included is depended on and found by CMake, and the launch file names what there is."""
    code = next((forager.package / "src").glob("*_node.cpp")).read_text()
    used = set(re.findall(r'#include "(\w+)/(?:msg|srv|rclcpp)', code)) | {"rclcpp"}
    package = ElementTree.parse(forager.package / "package.xml").getroot()
    assert package.findtext("name") == "goto_behavior"
    assert {each.text for each in package.findall("depend")} == used
    cmake = (forager.package / "CMakeLists.txt").read_text()
    assert set(re.findall(r"find_package\((\w+) REQUIRED\)", cmake)) == used | {"ament_cmake"}
    parameters = (forager.package / "config" / "goto.yaml").read_text()
    declared = re.findall(r'(?:read_number|read_place|declare_parameter<\w+>)\(\s*"([\w.]+)"', code)
    assert re.findall(r"^    ([\w.]+): ", parameters, re.MULTILINE) == [
        name for name in ("armed", "resume") if name in declared
    ] + [name for name in declared if name not in ("armed", "resume")]


def test_the_launch_file_launches_the_node(forager: Forager, monkeypatch: pytest.MonkeyPatch) -> None:
    """On modules that stand in for those of launch: each action is what it was made of."""

    def action(name: str) -> Any:
        return lambda *arguments, **named: (name, arguments, named)

    for module, names in {
        "ament_index_python": (), "launch": ("LaunchDescription",), "launch_ros": (),
        "ament_index_python.packages": (), "launch.substitutions": ("LaunchConfiguration",),
        "launch.actions": ("DeclareLaunchArgument", "SetEnvironmentVariable"), "launch_ros.actions": ("Node",),
        "launch_ros.parameter_descriptions": ("ParameterValue",),
    }.items():  # fmt: skip
        made: Any = ModuleType(module)
        for name in names:
            setattr(made, name, action(name))
        made.get_package_share_directory = lambda package: f"/share/{package}"
        monkeypatch.setitem(sys.modules, module, made)
    space: dict[str, Any] = {}
    exec((forager.package / "launch" / "goto.launch.py").read_text(), space)
    _, (actions,), _ = space["generate_launch_description"]()
    assert ("SetEnvironmentVariable", ("ROS_DOMAIN_ID", "43"), {}) in actions
    defaults = {
        arguments[0]: named["default_value"]
        for sort, arguments, named in actions
        if sort.startswith("Declare")
    }
    assert defaults == {
        "namespace": "rover", "armed": "false", "parameters": "/share/goto_behavior/config/goto.yaml",
    }  # fmt: skip
    (node,) = [named for sort, _, named in actions if sort == "Node"]
    assert (node["package"], node["executable"], node["name"]) == ("goto_behavior", "goto_node", "goto")


def test_make_test_says_that_the_node_was_not_built(forager: Forager) -> None:
    command = ("env", "-u", "AMENT_PREFIX_PATH", "make", "test", "CC=gcc")
    finds = r"\d+ ticks, \d+ mismatches|The node was not built: .*"
    said = forager.ask("gcc", forager.package, command=command, finds=finds).said.splitlines()
    assert f"{forager.result.ticks} ticks, 0 mismatches" in said
    assert any(line.startswith("The node was not built: ROS 2 and colcon are not at hand.") for line in said)


def test_the_export_says_what_the_robot_lacks(tmp_path: Path) -> None:
    absent, ignored = export(tmp_path, FORAGER, "forage").notes
    assert absent == (
        "rover does not read food_left, food_stored, food_here and station_here, so they are always absent"
    )
    assert ignored == "rover ignores load and unload: it only drives and turns"
    readme = (tmp_path / "out" / "README.md").read_text()
    assert f"- {absent}." in readme


def test_a_function_written_by_hand_is_kept(ask: Ask, tmp_path: Path) -> None:
    path = write_robot(tmp_path / "robot", FORAGER)
    interface = describe_robot(load_robot(path), path=path)
    out = tmp_path / "out"
    export_automaton(WANDERING, "a", out, to="ros2", body=interface)
    assert not ask("gcc", out, "conformance", "CC=gcc", finds="#error").succeeded
    name, stub, _ = WRITTEN["c99"]
    file = out / "src" / name
    written = re.sub(
        stub, "    (void)r;\n    commands->drive = 0.0;  /* the robot has no speed */", file.read_text()
    )
    file.write_text(written)
    for _ in range(2):
        assert ask("gcc", out, "conformance", "CC=gcc", finds="").succeeded
        export_automaton(WANDERING, "a", out, to="ros2", body=interface)
        assert file.read_text() == written


CAMERA = """
[camera]
view_deg = 70

[camera.colors]
ball = { hue_deg = [0, 30], saturation = [0.5, 1], value = [0.1, 1] }
"""


def test_what_comes_from_images_is_refused_by_name(tmp_path: Path) -> None:
    path = write_robot(
        tmp_path, ROBOT.replace('world = "yard.toml"', 'world = "soccer"').replace(FENCE, "") + CAMERA
    )
    # Its names are those of another scenario, and their kinds fit.
    interface = describe_robot(load_robot(path), path=path)
    size = Feature("size", Continuous(), "blob_size", of="A")
    kit = Kit.from_parts(size, Behavior("forward", Command(drive=1.0)), Target("ball"))
    automaton = Automaton(
        "chase", (START, State("forward", "forward")), (BoundFeature(size, Binding({"A": "ball"})),), (), False,
        {"start": Tree((make_leaf(1),))},
    )  # fmt: skip
    library = Library.from_automata(kit, automaton)
    with pytest.raises(
        SettingError, match=r"blob_size\(ball\) comes from images, which the exported node cannot read"
    ):
        export_automaton(library, "chase", tmp_path / "out", to="ros2", body=interface)
    assert not (tmp_path / "out").exists()


def test_a_squad_has_no_node(tmp_path: Path) -> None:
    path = write_robot(tmp_path)
    kit = Kit.from_parts(Behavior("patrol", order=Order((Assignment("walk", Binding()),))))
    automaton = Automaton(
        "lead", (START, State("patrol", "patrol")), (), (), False, {"start": Tree((make_leaf(1),))}
    )  # fmt: skip
    interface = describe_robot(load_robot(path), path=path)
    with pytest.raises(SettingError, match="'lead' orders a squad, and the node drives one robot"):
        export_automaton(
            Library.from_automata(kit, automaton), "lead", tmp_path / "out", to="ros2", body=interface
        )
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_wrong_is_refused(tmp_path: Path) -> None:
    path = write_robot(tmp_path, ROBOT.replace("pose.pose.orientation", "pose.pose.direction"))
    with pytest.raises(FileError, match="there is no 'direction'"):
        describe_robot(load_robot(path), path=path)


def test_the_command_takes_a_robot(tmp_path: Path) -> None:
    library = FIXTURE
    path = write_robot(tmp_path, FORAGER.replace("domain = 43", "tick_s = 0.05"))
    found = run_json(
        "export", "forage", "--library", library, "--to", "ros2", "--robot", path, "--out", tmp_path / "a"
    )
    assert "src/forage_node.cpp" in found["files"]
    assert len(found["notes"]) == 2
    run_json(
        "export", "forage", "--library", library, "--to", "python", "--robot", path, "--out", tmp_path / "b"
    )
    assert '"tick_s": 0.05' in (tmp_path / "b" / "manifest.json").read_text()
    mistakes: list[tuple[list[Any], str]] = [
        (["--to", "ros2"], "robot's file is missing"),
        (["--to", "ros2", "--robot", tmp_path / "none.toml"], "there is no such file"),
        (["--to", "ros2", "--robot", path, "--world", "soccer"], "its world is named by its file"),
        (["--to", "ros2", "--robot", path, "--float32"], "single precision is not offered"),
    ]
    for arguments, problem in mistakes:
        result = run("export", "forage", "--library", library, *arguments, "--out", tmp_path / "c")
        assert (result.exit_code, problem in result.stderr) == (2, True), result.stderr
        assert not (tmp_path / "c").exists()


MEASURE = """
#include <cmath>
#include <cstdio>
#include <iostream>
#include "sensor_msgs/msg/laser_scan.hpp"
#include "message_values.hpp"
static double drop_sign_of_nan(double x) { return x != x ? std::nan("") : x; }
int main()
{
  double from, to, offset, clear;
  while (std::cin >> from >> to >> offset >> clear) {
    sensor_msgs::msg::LaserScan scan;
    scan.read_from(std::cin);
    const understudy::ScanSector sector(from, to);
    for (double x : {sector.find_nearest(scan, offset), sector.find_bearing(scan),
                     sector.measure_opening(scan, offset, clear)})
      std::printf("%.17g\\n", drop_sign_of_nan(x));
  }
}
"""


def test_scans_are_measured_as_by_understudy(ask: Ask, tmp_path: Path) -> None:
    """Sectors of every width and scans of every sort, also invalid ones: to the last bit."""
    write_headers(tmp_path, [SCAN])
    (tmp_path / "main.cpp").write_text(MEASURE)
    shutil.copy(TEMPLATES / "ros2" / "message_values.hpp", tmp_path)
    strict = "-std=c++17 -Wall -Wextra -Werror -Wconversion"
    command = f"g++ {strict} -I. main.cpp -o main && ./main > found.txt"
    random, lines, expected = Random(5), [], []
    for _ in range(3000):
        edges = random.choice(
            [(-pi, pi), (0.0, 0.0), (-pi / 4, pi / 4), (random.uniform(-4, 4), random.uniform(-4, 4))]
        )
        offset, clear = random.choice((0.0, 0.1, 0.5)), random.choice((0.4, 1.0, 1.9))
        scan = decode_message(SCAN, encode_message(SCAN, draw_scan(random)))
        lines.append(f"{edges[0]!r} {edges[1]!r} {offset} {clear} {write_words(SCAN, scan)}")
        sector = ScanSector(*edges)
        values = (
            sector.find_nearest(scan, offset),
            sector.find_bearing(scan),
            sector.measure_opening(scan, offset, clear),
        )
        expected.append([f"{value:.17g}" for value in values])
    given = "\n".join(lines)
    answer = ask("g++", tmp_path, command=("sh", "-c", command), given=given, hashes="found.txt")
    text = "".join(f"{value}\n" for values in expected for value in values)
    assert answer.said == hash_text(text.encode())
    assert sum("nan" not in each for each in expected) > 300
