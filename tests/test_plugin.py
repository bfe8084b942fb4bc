"""A package of another author: what it offers at every extension point passes its check, and works in the commands."""

from __future__ import annotations

import ast
import json
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from tests.export.exports import FIXTURE, open_fixture
from tests.make.packages import PLUGIN, install_entry_points, install_project
from tests.robots.rovers import ROVER
from tests.ui.cli.commands import run, run_json

from understudy import Forage, Library, evaluate, read_recorded_drive, testing
from understudy.addons.robots.robot_file import parse_robot
from understudy.errors import SettingError
from understudy.sim.catalog import find_scenario
from understudy.spi import EXTENSION_POINTS, ExtensionPoint

POINTS = pytest.mark.parametrize("point", EXTENSION_POINTS, ids=lambda point: point.group)
MODULES = sorted((PLUGIN / "orchard").glob("*.py"))
LOG = "".join(f"{tick / 10} drive={(tick // 20) % 2 * 0.5} mowed={tick / 40}\n" for tick in range(200))


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the package, and work in a folder of its own."""
    install_project(PLUGIN, tmp_path / "site", monkeypatch)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def list_entries(group: str) -> dict[str, str]:
    """List the entry points of the package in a group."""
    project = tomllib.loads((PLUGIN / "pyproject.toml").read_text("utf-8"))["project"]
    entries: dict[str, str] = project["entry-points"][group]
    return entries


def load_entry(group: str) -> Any:
    """Load the only entry point of the package in a group."""
    ((_, place),) = list_entries(group).items()
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


# What it is made of.


@POINTS
def test_it_uses_every_extension_point_by_one_module(point: ExtensionPoint) -> None:
    assert len(list_entries(point.group)) == 1


def test_each_module_is_short() -> None:
    assert len(MODULES) == len(EXTENSION_POINTS) + 1
    assert all(len(path.read_text("utf-8").splitlines()) < 70 for path in MODULES)


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_it_imports_nothing_of_understudy_but_the_public_modules(path: Path) -> None:
    nodes = [*ast.walk(ast.parse(path.read_text("utf-8")))]
    names = {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    names |= {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    ours = {name for name in names if name is not None and name.startswith("understudy")}
    assert ours <= {"understudy", "understudy.spi"}


# The checks that its author calls.


def write_log(folder: Path) -> Path:
    path = folder / "lawn.mow"
    path.write_text(LOG)
    return path


@POINTS
def test_it_passes_the_check(point: ExtensionPoint, plugin: Path) -> None:
    offered, check = load_entry(point.group), getattr(testing, point.check)
    match point.check:
        case "check_body":
            check(offered(3))
        case "check_kit":
            check(offered, Forage([1, 2]))
        case "check_scenario_worlds":
            check(offered, ticks=10)
        case "check_export_target":
            check(offered, open_fixture()[0], "goto", binding={"A": "station"})
        case "check_reader":
            check(offered, write_log(plugin))
        case "check_transport":
            check(offered, parse_robot(ROVER))
        case "check_command":
            check(offered, "--hours", "2", "--json")
        case "check_study":
            check(offered)
        case "check_baseline":
            check(offered, find_scenario("orchard"), ticks=10)
        case _:
            raise AssertionError(point.check)


# The commands.


def test_a_body_is_run(plugin: Path) -> None:
    """From 3 m, at 0.5 m/s for 4 s."""
    found = run_json("run", "--world", "lawn", "--behavior", "mow", "--seed", 3, "--seconds", 4)
    assert (found["world"], found["readings"]) == ("lawn", {"mowed": [pytest.approx(5.0)]})
    assert run_json("worlds", "lawn")["behaviors"] == ["mow"]
    assert "understudy worlds lawn" in run("worlds").stdout
    assert "lawn" not in [row["name"] for row in run_json("worlds")["worlds"]]


def test_a_body_is_no_scenario(plugin: Path) -> None:
    """It is not made either, which may connect to a robot."""
    with pytest.raises(SettingError, match="'lawn' is a body; name a function without parameters"):
        find_scenario("lawn")


def test_a_kit_is_run(plugin: Path) -> None:
    options = ("--kit", "orchard", "--behavior", "creep", "--seconds", 1)
    assert run_json("run", "--world", "orchard", *options)["behavior"] == "creep"
    listed = run("list", "--library", FIXTURE, "--kit", "orchard")
    assert "the kit has no feature 'food_left'; its features are room_left" in " ".join(listed.output.split())


def test_a_scenario_is_listed_and_run(plugin: Path) -> None:
    (row,) = [row for row in run_json("worlds")["worlds"] if row["name"] == "orchard"]
    assert row["about"] == "Bring apples from under the trees to the barn."
    assert (
        run_json("run", "--world", "orchard", "--behavior", "forward", "--seconds", 1)["world"] == "orchard"
    )


def test_an_automaton_is_exported(plugin: Path) -> None:
    options = ("--bind", "A=station", "--library", FIXTURE, "--out", plugin / "out")
    found = run_json("export", "goto", "--to", "outline", *options)
    assert (found["target"], list(found["files"])) == (
        "outline",
        ["conformance.csv", "manifest.json", "outline.txt"],
    )
    text = (plugin / "out" / "outline.txt").read_text()
    assert text == "goto(station): start, forward, rotate_left, rotate_right, done\n"
    assert "ros2 or outline" in " ".join(run("export", "automaton", "--help").stdout.split())


def test_a_recording_is_learned(plugin: Path) -> None:
    options = ("--define", "mow: drive 0.5", "--define", "rest: drive 0", "--features", "mowed")
    found = run_json("learn", "--recording", write_log(plugin), *options)
    assert set(found["states"]) == {"start", "mow", "rest"}
    assert read_recorded_drive(plugin / "lawn.mow").ticks == 200


def test_a_robot_is_reached(plugin: Path) -> None:
    """Its own loop carries nothing that the robot would have to say."""
    (plugin / "rover.toml").write_text(ROVER.replace("tick_s", 'transport = "loopback"\ntick_s', 1))
    result = run("robots", "check", "rover.toml", "--seconds", 0.1, "--json")
    found = json.loads(result.stdout)
    assert (found["name"], result.exit_code) == ("rover", 1)
    assert any("sonar_ahead" in problem for problem in found["problems"])


def test_a_command_is_called_and_listed(plugin: Path) -> None:
    assert run_json("graze", "--hours", 2) == {"eaten_kg": 12.0}
    assert "Say how much grass a cow eats" in run("--help").stdout


def test_a_study_is_run(plugin: Path) -> None:
    found = run_json("experiment", "grazing", "--quick", "--jobs", 1, "--out", plugin / "grazing")
    assert found["result"]["findings"]["numbers"] == {"least_kg": 3.0}
    assert (plugin / "grazing" / "figure.svg").is_file()


def test_a_baseline_is_found(plugin: Path) -> None:
    """It drives ahead, as the behavior does, and neither brings apples home."""
    found = evaluate(Library(load_entry("understudy.kits")), "creep", "orchard", range(2))
    assert found.expert is not None
    assert (found.expert.success, found.success) == (0.0, 0.0)


# What cannot be used.

BROKEN = "raise RuntimeError('no harvest this year')"
USES = {  # how an entry point of a group is used, by its name
    "understudy.bodies": ("run", "--world", "{}", "--behavior", "mow"),
    "understudy.kits": ("run", "forage", "--kit", "{}", "--behavior", "creep"),
    "understudy.worlds": ("run", "--world", "{}", "--behavior", "forward"),
    "understudy.export_targets": (
        *("export", "goto", "--to", "{}", "--library", str(FIXTURE)),
        *("--out", "out", "--bind", "A=station"),
    ),
    "understudy.readers": ("learn", "--recording", "lawn.{}", "--define", "mow: drive 0.5"),
    "understudy.transports": ("robots", "check", "{}.toml"),
    "understudy.commands": ("{}",),
    "understudy.studies": ("experiment", "{}"),
    "understudy.baselines": ("eval", "--world", "arena", "--behavior", "forward"),
}


@pytest.fixture(params=["broken", "seven"])
def defect(request: pytest.FixtureRequest) -> str:
    defect: str = request.param
    return defect


@POINTS
def test_what_cannot_be_used_is_one_sentence(
    point: ExtensionPoint,
    defect: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "broken_of_tests.py").write_text(BROKEN)
    (tmp_path / "seven_of_tests.py").write_text("seven = 7")
    groups = {point.group: {defect: f"{defect}_of_tests:seven"}}
    install_entry_points("bad", groups, tmp_path, monkeypatch)
    monkeypatch.chdir(tmp_path)
    (tmp_path / f"lawn.{defect}").write_text(LOG)
    (tmp_path / f"{defect}.toml").write_text(ROVER.replace("tick_s", f'transport = "{defect}"\ntick_s', 1))
    result = run(*(word.format(defect) for word in USES[point.group]))
    message = " ".join((result.stderr + capsys.readouterr().err).split())
    assert result.exit_code == 2
    assert "Traceback" not in message
    problem = "cannot be imported: RuntimeError: no harvest this year" if defect == "broken" else "is a int"
    assert f"{defect!r} {problem}; " in message


def test_help_says_which_command_cannot_be_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken_of_tests.py").write_text(BROKEN)
    entries = {"understudy.commands": {"mow": "broken_of_tests:command"}}
    install_entry_points("bad", entries, tmp_path, monkeypatch)
    result = run("--help")
    assert result.exit_code == 0
    assert "command: 'mow' cannot be imported: RuntimeError: no harvest this year; let" in (
        result.stderr + capsys.readouterr().err
    )
    assert "studio" in result.stdout
