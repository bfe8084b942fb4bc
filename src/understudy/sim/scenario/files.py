"""Scenarios as TOML files: read, checked, written; the built-in ones by name."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

import msgspec
from msgspec.structs import replace

from understudy.errors import FileError, SettingError, join_names
from understudy.sim.params import collect_names
from understudy.sim.scenario.scenario_errors import suggest_name
from understudy.sim.scenario.schema import VERSION, ObjectClass, Scenario, TargetSpec
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values
from understudy.sim.scenario.toml_writer import format_toml
from understudy.sim.scenario.validate_names import NAME
from understudy.sim.scenario.validation import check_scenario

FORMAT = "scenario"
HEAD = f'understudy = "{FORMAT}"\nversion = {VERSION}\n'
SUFFIX = ".toml"

ScenarioDocument = dict[str, Any]
MIGRATIONS: Mapping[int, Callable[[ScenarioDocument], ScenarioDocument]] = MappingProxyType({})
"""From a version of the format to the next: a step each."""


def load_scenario(source: Path | str) -> Scenario:
    """The built-in scenario of this name, or that of a file; FileError where it cannot be read or cannot be."""
    return parse_scenario(*_content(source))


def read_scenario_text(source: Path | str) -> str:
    """The file of a scenario as it is, with its comments; FileError where it cannot be read."""
    content, path = _content(source)
    return _decoded(content, path)


def _content(source: Path | str) -> tuple[bytes, Path | str]:
    """What a scenario's file holds, and how to call it."""
    names = list_builtin_scenarios()
    if isinstance(source, str) and source in names:
        return _folder().joinpath(source + SUFFIX).read_bytes(), f"{source}{SUFFIX}"
    path = Path(source)
    try:
        return path.read_bytes(), path
    except FileNotFoundError:
        remedy = f"give a file, or a built-in scenario: {suggest_name(str(source), names, what='scenario')}"
        raise FileError(path=path, place="", problem="there is no such file", remedy=remedy) from None
    except (OSError, ValueError) as error:
        raise FileError(
            path=path, place="", problem=f"cannot be read ({error})", remedy="give a file"
        ) from None


def list_builtin_scenarios() -> tuple[str, ...]:
    """The names of the built-in scenarios."""
    return tuple(
        sorted(file.name.removesuffix(SUFFIX) for file in _folder().iterdir() if file.name.endswith(SUFFIX))
    )


def parse_scenario(content: str | bytes, path: Path | str = "scenario.toml") -> Scenario:
    """The scenario that the content of a file describes; FileError, naming the key, where it is none or cannot be."""
    document = _migrated(_head(_table(content, path), path))
    if "name" not in document and NAME.fullmatch(Path(path).stem):
        document["name"] = Path(path).stem
    scenario = decode_toml_values(document, Scenario)
    if isinstance(scenario, DecodeProblem):
        raise FileError(path=path, place=scenario.key, problem=scenario.problem, remedy=scenario.remedy)
    try:
        check_scenario(scenario)
    except SettingError as error:
        raise FileError(path=path, place=error.setting, problem=error.problem, remedy=error.remedy) from None
    return scenario


def format_scenario(scenario: Scenario) -> str:
    """The file of a scenario: parsed, it gives the same."""
    document = msgspec.to_builtins(scenario)
    return HEAD + "\n" + format_toml({"name": scenario.name, **document})


def _folder() -> Any:
    return resources.files("understudy.sim").joinpath("scenarios")


def _decoded(content: bytes, path: Path | str) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise FileError(
            path=path,
            place=f"line {line}",
            problem="is not UTF-8 text",
            remedy="save it as UTF-8, or give another file",
        ) from None


def _table(content: str | bytes, path: Path | str) -> ScenarioDocument:
    if isinstance(content, bytes):
        content = _decoded(content, path)
    try:
        return tomllib.loads(content.replace("\r\n", "\n"))
    except RecursionError:
        raise FileError(
            path=path, place="", problem="is nested too deeply", remedy="give tables of tables"
        ) from None
    except ValueError as error:
        problem, _, place = str(error).partition(" (at ")
        if not place.startswith("line"):  # it ends too early, or holds a number with thousands of digits
            lines = content.splitlines() or [""]
            place = f"line {len(lines)}, column {len(lines[-1]) + 1}"
        raise FileError(
            path=path, place=place.rstrip(")"), problem=f"is not TOML: {problem}", remedy="correct it there"
        ) from None


def _head(document: ScenarioDocument, path: Path | str) -> ScenarioDocument:
    """What follows the head of a scenario's file, with the version under its key."""
    begin = "let the file begin with " + join_names(repr(line) for line in HEAD.splitlines())
    if document.get("understudy") != FORMAT:
        given = document.get("understudy")
        problem = "is missing" if given is None else f"is {given!r:.60}: this is not a scenario file"
        raise FileError(path=path, place="understudy", problem=problem, remedy=begin)
    version = document.get("version")
    if type(version) is not int or version < 1:
        problem = "is missing" if version is None else f"is {version!r:.60}"
        raise FileError(path=path, place="version", problem=problem, remedy=begin)
    if version > VERSION:
        problem = f"is {version}, and this Understudy reads scenarios up to version {VERSION}"
        raise FileError(path=path, place="version", problem=problem, remedy="use a newer Understudy")
    return document


def _migrated(document: ScenarioDocument) -> ScenarioDocument:
    """The fields of a scenario, brought up to the present version."""
    for version in range(document["version"], VERSION):
        document = MIGRATIONS[version](document)
    return {key: value for key, value in document.items() if key not in ("understudy", "version")}


MARKER = "marker"
TARGET = "nearest_marker"
COLORS = ("magenta", "orange", "cyan", "purple", "yellow", "white")
"""What cameras know it by: the first that nothing else in the world has."""
RADIUS = 0.15


def add_markers(scenario: Scenario) -> Scenario:
    """The scenario with a class of markers and the target of that name, as far as it has none of its own."""
    objects, targets = scenario.objects, dict(scenario.targets)
    if MARKER not in (thing.name for thing in objects):
        taken = collect_names(scenario).colors
        color = next((color for color in COLORS if color not in taken), None)
        objects = (*objects, ObjectClass(name=MARKER, count=0, radius=RADIUS, color=color))
    targets.setdefault(
        TARGET, TargetSpec(nearest=MARKER, doc="The nearest of the markers that somebody placed.")
    )
    return replace(scenario, objects=objects, targets=targets)


def remove_markers(scenario: Scenario) -> Scenario:
    """The scenario as it was `add_markers`; as it is where its markers are its own."""
    objects = tuple(thing for thing in scenario.objects if thing.name != MARKER)
    targets = {name: target for name, target in scenario.targets.items() if name != TARGET}
    stripped = replace(scenario, objects=objects, targets=targets)
    return stripped if add_markers(stripped) == scenario else scenario
