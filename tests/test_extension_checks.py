"""The checks of extension points pass what is built in, and catch what breaks a contract: a liar per law."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
import typer
from matplotlib.figure import Figure
from tests.export.exports import open_fixture
from tests.robots.rovers import ROVER

from understudy import BOOLEAN, Behavior, Command, Feature, Forage, Kit, Target, load_scenario
from understudy.addons.export.targets.target_table import TARGETS
from understudy.addons.recordings.mapping_file import CommandColumn, RecordingMap
from understudy.addons.recordings.table_readers import read_csv, read_json_lines
from understudy.addons.robots.robot_file import parse_robot
from understudy.errors import FileError
from understudy.sim.forage import FORAGE_KIT
from understudy.spi import (
    Baseline,
    CommandEntry,
    ExportJob,
    ExportTarget,
    RecordedTable,
    Scenario,
    Study,
    StudyFindings,
    TargetFiles,
    Task,
)
from understudy.testing import (
    LawBroken,
    check_baseline,
    check_command,
    check_export_target,
    check_kit,
    check_reader,
    check_scenario_worlds,
    check_study,
    check_transport,
)

CALLS = count()
FORAGE = load_scenario("forage")


def refuse(law: str) -> Any:
    return pytest.raises(LawBroken, match=law)


# Kits.

BAD_KITS: list[tuple[Any, str]] = [
    (7, "it is a Kit; it is a int"),
    (Kit.from_parts(Target("lamp")), r"its targets are targets of the body; it has \['lamp'\]"),
    (Kit.from_parts(Feature("sonar", BOOLEAN, "sonar")), "a feature reads what the body offers"),
    (Kit.from_parts(Behavior("fly", Command(fly=1.0))), "commands channels of the body"),
]


def test_a_good_kit() -> None:
    check_kit(FORAGE_KIT, Forage([1, 2]), ticks=3)


@pytest.mark.parametrize(("kit", "law"), BAD_KITS)
def test_a_bad_kit(kit: Any, law: str) -> None:
    with refuse(law):
        check_kit(kit, Forage([1, 2]), ticks=3)


# Scenarios.


def make_another_each_time() -> Scenario:
    return msgspec.structs.replace(FORAGE, about=f"Call {next(CALLS)}")


def make_nothing() -> Any:
    return 7


BAD_SCENARIOS: list[tuple[Any, str]] = [
    (make_nothing, "it is a Scenario; it is a int"),
    (make_another_each_time, "makes the same scenario each time"),
    (lambda seed: FORAGE, "takes no parameters and returns a Scenario; it raised TypeError"),
    (msgspec.structs.replace(FORAGE, robots=()), "a World can be made of it; it raised SettingError"),
]


def test_a_good_scenario() -> None:
    check_scenario_worlds(FORAGE, seeds=[0], ticks=3)


@pytest.mark.parametrize(("scenario", "law"), BAD_SCENARIOS)
def test_a_bad_scenario(scenario: Any, law: str) -> None:
    with refuse(law):
        check_scenario_worlds(scenario, seeds=[0], ticks=3)


# Targets of exports.


@pytest.mark.parametrize("name", [name for name in TARGETS if name != "ros2"])  # which needs a robot
def test_a_good_target(name: str) -> None:
    library, _ = open_fixture()
    check_export_target(TARGETS[name], library, "goto", binding={"A": "station"})


def write(name: str, content: Any = b"x", **others: Any) -> Callable[[ExportJob], TargetFiles]:
    return lambda job: TargetFiles({name: content}, **others)


BAD_TARGETS: list[tuple[Callable[[ExportJob], Any], str]] = [
    (lambda job: 7, "it returns TargetFiles; it returned 7"),
    (lambda job: 1 / 0, "it makes files of every job; it raised ZeroDivisionError"),
    (lambda job: TargetFiles({}), "it makes a file at least"),
    (lambda job: write(f"{next(CALLS)}.c")(job), "the same job gives the same files"),
    (write("/etc/passwd"), "files have paths within the folder"),
    (write("../up.c"), "files have paths within the folder"),
    (write("manifest.json"), "it makes no file that the export adds"),
    (write("a.c", "text"), "the content of a file is bytes; that of 'a.c' is str"),
    (write("a.c", makes=("a.c",)), "what its tests make is none of its files"),
    (write("a.c", notes=(7,)), "its notes are sentences"),
    (write("a.c", names={"colors": {}}), "its identifiers are of readings"),
    (write("a.c", names={"basics": {"fly": "fly"}}), "identifiers belong to names of the hierarchy"),
    (write("a.c", names={"channels": {"drive": "x", "turn": "x"}}), "no two names have the same identifier"),
]


@pytest.mark.parametrize(("function", "law"), BAD_TARGETS)
def test_a_bad_target(function: Callable[[ExportJob], Any], law: str) -> None:
    library, _ = open_fixture()
    with refuse(law):
        check_export_target(ExportTarget(function), library, "goto", binding={"A": "station"})


# Readers of recordings.

ROWS: list[list[Any]] = [[f"{tick / 10}", tick % 3, 2.0 - tick / 10] for tick in range(20)]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "drive.rec"
    path.write_text("time_s,command.drive,range(ball)\n" + "".join(f"{a},{b},{c}\n" for a, b, c in ROWS))
    return path


def test_a_good_reader(log: Path) -> None:
    check_reader(read_csv, log)
    lines = [msgspec.json.encode({"time_s": float(a), "command.drive": b}) for a, b, _ in ROWS]
    (log.parent / "drive.jsonl").write_bytes(b"\n".join(lines))
    check_reader(read_json_lines, log.parent / "drive.jsonl")


def change_rows(**fields: Any) -> Callable[[Path, object], Any]:
    """Make a reader whose table differs from a good one."""
    return lambda path, _: read_csv(path)._replace(**fields)


def change_file(path: Path, _: object) -> Any:
    table = read_csv(path)
    path.write_text(path.read_text() + "2.0,0,0\n")
    return table


def fail_on_half(path: Path, _: object) -> Any:
    table = read_csv(path)
    return table if len(table.cells) == len(ROWS) else [][1]


def read_what_is_missing(path: Path, _: object) -> Any:
    return read_csv(path) if path.exists() else RecordedTable(path, ("time_s",), [], [], [])


def stop_moving(path: Path, _: object) -> Any:
    table = read_csv(path)
    return table._replace(cells=[[row[0], "0", row[2]] for row in table.cells])


def name_no_file(path: Path, _: object) -> Any:
    if path.exists():
        return read_csv(path)
    raise FileError(path="", place="", problem="it is not there", remedy="look for it")


STAMPED = RecordingMap(
    format="understudy-recording-map/1", time="stamp", commands=(CommandColumn(column="command.drive"),)
)
BAD_READERS: list[tuple[Callable[[Path, object], Any], str]] = [
    (lambda path, _: 7, "it returns a RecordedTable; it returned 7"),
    (lambda path, _: path.stop(), "it reads the recording; it raised AttributeError"),  # type: ignore[attr-defined]
    (change_rows(header=("time_s", "x", "x")), "columns have names, each once"),
    (change_rows(header=("time_s", "x")), "a row has a cell for each column"),
    (change_rows(lines=[3]), "a row has a number in the file, which rises; 20 rows have 1"),
    (change_rows(lines=[7] * 20), "a row has a number in the file, which rises"),
    (change_rows(cells=[[0.0, 1.0, b"2"]] * 20), "a cell is a number, a text, or None .* is bytes"),
    (change_rows(omissions=[7]), "omissions are sentences"),
    (change_rows(mapping=STAMPED), "its mapping names its columns"),
    (stop_moving, "its table becomes a drive; it raised FileError: .*no motion"),
    (lambda path, _: read_csv(path)._replace(counted=f"{next(CALLS)}"), "the same file gives the same table"),
    (change_file, "it leaves the file as it is|the same file gives the same table"),
    (fail_on_half, "a damaged file is read in part, or refused .*raised"),
    (read_what_is_missing, "a missing file is refused"),
    (name_no_file, "a missing file is refused with an UnderstudyError that names it"),
]


@pytest.mark.parametrize(("reader", "law"), BAD_READERS)
def test_a_bad_reader(reader: Any, law: str, log: Path) -> None:
    with refuse(law):
        check_reader(reader, log)


# Commands.


def greet(fail: bool = False) -> None:
    """Greet."""
    typer.echo("Hello.")
    raise typer.Exit(int(fail))


def say_nothing() -> None:
    pass


GREET = CommandEntry("greet", greet, "Run")
BAD_COMMANDS: list[tuple[Any, tuple[str, ...], str]] = [
    (greet, (), "it is a CommandEntry; it is a function"),
    (replace(GREET, name="Greet!"), (), "its name is words"),
    (replace(GREET, name="run"), (), "no built-in command has its name"),
    (replace(GREET, panel="Greetings"), (), "its panel is one of"),
    (replace(GREET, run="no_such_module:greet"), (), "can be imported; it raised ModuleNotFoundError"),
    (replace(GREET, run=say_nothing), (), "it has a docstring or a help text"),
    (GREET, ("--fail",), "it succeeds with --fail; it ended with 1"),
    (replace(GREET, run=lambda as_json=False: greet()), ("--as-json",), "it has a docstring"),
]


def test_a_good_command() -> None:
    check_command(GREET, "--no-fail")


@pytest.mark.parametrize(("entry", "arguments", "law"), BAD_COMMANDS)
def test_a_bad_command(entry: Any, arguments: tuple[str, ...], law: str) -> None:
    with refuse(law):
        check_command(entry, *arguments)


# Studies.


def list_tasks(plan: Any) -> list[Task]:
    return [{"seed": seed} for seed in plan.seeds]


STUDY = Study(
    "squares",
    range(4),
    2,
    list_tasks,
    lambda task: {"square": task["seed"] ** 2},
    lambda rows: StudyFindings(f"{len(rows)} squares"),
    lambda rows: Figure(),
    question="What are the squares?",
)


def clear(rows: Any) -> StudyFindings:
    rows[0].clear()
    return StudyFindings("None")


NONE: Any = None
BAD_STUDIES: list[tuple[Any, str]] = [
    (7, "it is a Study; it is a int"),
    (replace(STUDY, question=""), "it says which question it answers"),
    (replace(STUDY, quick=5), "its quick version has some of its seeds; it has 5 of 4"),
    (replace(STUDY, tasks=lambda plan: []), "the tasks of a plan are all different"),
    (replace(STUDY, tasks=lambda plan: [{"seed": 0}] * 2), "the tasks of a plan are all different"),
    (replace(STUDY, tasks=lambda plan: [{"n": len(plan.seeds)}]), "the quick tasks are among those"),
    (replace(STUDY, work=lambda task: {"x": object()}), "are JSON data; it raised TypeError"),
    (replace(STUDY, work=lambda task: {"x": next(CALLS)}), "a task gives the same row again"),
    (replace(STUDY, conclude=lambda rows: NONE), "it concludes StudyFindings"),
    (replace(STUDY, conclude=clear), "it leaves the rows as they are"),
    (replace(STUDY, draw=lambda rows: NONE), "it draws a figure of Matplotlib"),
]


def test_a_good_study() -> None:
    check_study(STUDY)
    check_study(replace(STUDY, work=lambda task: {"ms": next(CALLS)}, varies=("ms",)))


@pytest.mark.parametrize(("study", "law"), BAD_STUDIES)
def test_a_bad_study(study: Any, law: str) -> None:
    with refuse(law):
        check_study(study)


# Baselines.


def drive(command: Any = 0.5, *, channel: str = "drive", limit_s: Any = 5.0, key: str = "food_left") -> Any:
    """Make the function of a baseline that drives ahead."""

    def decide(percept: Any) -> Any:
        return {channel: np.full(len(percept[key, None]), command)}

    controller = SimpleNamespace(keys=((key, None),), decide=decide)
    return lambda scenario: Baseline(scenario, lambda _: controller, lambda world: np.full(3, limit_s))


BAD_BASELINES: list[tuple[Any, str]] = [
    (lambda scenario: None, "it returns a Baseline for 'forage'; it returned None"),
    (lambda scenario: {}[scenario.name], "it takes every scenario; it raised KeyError"),
    (drive(limit_s=math.inf), "finite"),
    (drive(limit_s=0.0), "time limits are above 0"),
    (drive(limit_s=5), "one column of floats"),
    (drive(key="sonar"), "its controller reads what the world has"),
    (drive(channel="fly"), r"it commands channels of the world; it commands \['fly'\]"),
    (drive(math.nan), "commands are finite"),
]


def test_a_good_baseline() -> None:
    check_baseline(drive(), FORAGE, ticks=3)


@pytest.mark.parametrize(("find", "law"), BAD_BASELINES)
def test_a_bad_baseline(find: Any, law: str) -> None:
    with refuse(law):
        check_baseline(find, FORAGE, ticks=3)


# Transports.

RADIO = parse_robot(ROVER)


@pytest.fixture
def loopback(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.syspath_prepend(Path(__file__).parent / "fixtures" / "plugin")
    module: Any = import_module("orchard.loopback")
    yield module
    assert module.OPEN == []  # the check has closed what it opened


def test_a_good_transport(loopback: Any) -> None:
    check_transport(loopback.open_loopback, RADIO)


class Immediate:
    """Receives in the thread of the sender, before ends that were opened later."""

    def __init__(self, end: Any) -> None:
        self.end, self.put = end, self.deliver
        self.get = lambda: None  # which ends the thread of the end

    def deliver(self, arrival: tuple[str, bytes, float] | None) -> None:
        for topic, received in self.end.listeners:
            if arrival is not None and topic == arrival[0]:
                received(*arrival[1:])


def stay_open(end: Any) -> None:
    end.arrivals = Immediate(end)


LONG_S = 30.0
"""A time that is over only where nothing arrives, s."""
BAD_TRANSPORTS = [  # a method of an end, what it does instead, the longest time to wait (s), and the law
    ("close", stay_open, LONG_S, "nothing is received after closing"),
    ("subscribe", lambda end, *_, **__: None, 0.1, "a message of one end reaches the others"),
    ("find_service_problem", lambda end, *_: None, LONG_S, "it says why a service is not reached"),
    ("call", lambda end, *_, **__: None, 4.0, "answered once by None; there was no answer"),
    ("call", lambda end, *given, **_: given[3](b""), LONG_S, "answered once by None; the answer was b''"),
    ("peers", lambda end: ["robot"], LONG_S, "peers are Publishers"),
]


@pytest.mark.parametrize(("method", "function", "timeout_s", "law"), BAD_TRANSPORTS)
def test_a_bad_transport(
    loopback: Any,
    method: str,
    function: Callable[..., Any],
    timeout_s: float,
    law: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(loopback.Loopback, method, function)
        with refuse(law):
            check_transport(loopback.open_loopback, RADIO, timeout_s=timeout_s)
    for end in [*loopback.OPEN]:
        end.close()


def test_what_is_no_transport() -> None:
    with refuse("it has the methods of a Transport; SimpleNamespace has not all of them"):
        check_transport(lambda file: SimpleNamespace(close=lambda: None), RADIO)
