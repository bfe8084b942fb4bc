"""Read, check and write scenarios as TOML files, and find the built-in ones by name."""

from __future__ import annotations

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
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values, parse_toml
from understudy.sim.scenario.toml_writer import format_toml
from understudy.sim.scenario.validate_names import NAME
from understudy.sim.scenario.validation import check_scenario

FORMAT = "scenario"
HEAD = f'understudy = "{FORMAT}"\nversion = {VERSION}\n'
SUFFIX = ".toml"

ScenarioDocument = dict[str, Any]
MIGRATIONS: Mapping[int, Callable[[ScenarioDocument], ScenarioDocument]] = MappingProxyType({})
"""The function that converts a document of each version of the format to the next version."""


def load_scenario(source: Path | str) -> Scenario:
    """Load a built-in scenario by its name, or any scenario from a TOML file.

    Parameters
    ----------
    source
        The name of a built-in scenario, such as "forage", or the path of a file.

    Returns
    -------
    Scenario
        The scenario, checked.

    Raises
    ------
    FileError
        If the file cannot be read, is not a scenario, or describes one that is not possible. It names the key.

    Examples
    --------
    >>> load_scenario("forage").name
    'forage'
    """
    return parse_scenario(*_content(source))


def read_scenario_text(source: Path | str) -> str:
    """Return the text of a scenario's file, with its comments; raise FileError if it cannot be read."""
    content, path = _content(source)
    return _decoded(content, path)


def _content(source: Path | str) -> tuple[bytes, Path | str]:
    """Return the bytes of a scenario's file, and its path or name for error messages."""
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
    """Return the names of the built-in scenarios, sorted."""
    return tuple(
        sorted(file.name.removesuffix(SUFFIX) for file in _folder().iterdir() if file.name.endswith(SUFFIX))
    )


def parse_scenario(content: str | bytes, path: Path | str = "scenario.toml") -> Scenario:
    """Parse and check the content of a scenario file; raise FileError, naming the key, if it is not valid.

    A scenario without a name is named after the file `path`, which errors name too.
    """
    if isinstance(content, bytes):
        content = _decoded(content, path)
    document = _migrated(_head(parse_toml(content, path), path))
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
    """Return the text of a file that describes a scenario; `parse_scenario` returns an equal scenario from it."""
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


def _head(document: ScenarioDocument, path: Path | str) -> ScenarioDocument:
    """Check a document's format and version, and return it; raise FileError if it cannot be read here."""
    begin = "let the file begin with " + join_names(repr(line) for line in HEAD.splitlines())
    if document.get("understudy") != FORMAT:
        mark = document.get("understudy")
        problem = "is missing" if mark is None else f"is {mark!r:.60}: this is not a scenario file"
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
    """Return the fields of a scenario document converted to the present version, without format and version."""
    for version in range(document["version"], VERSION):
        document = MIGRATIONS[version](document)
    return {key: value for key, value in document.items() if key not in ("understudy", "version")}


MARKER = "marker"
TARGET = "nearest_marker"
COLORS = ("magenta", "orange", "cyan", "purple", "yellow", "white")
"""The possible colors of markers; cameras detect them by the first one that nothing else in the world has."""
RADIUS = 0.15


def add_markers(scenario: Scenario) -> Scenario:
    """Return a scenario with a class `marker` of objects and a target `nearest_marker`, unless it has its own."""
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
    """Return a scenario without what `add_markers` added; unchanged if it declared its markers itself."""
    objects = tuple(thing for thing in scenario.objects if thing.name != MARKER)
    targets = {name: target for name, target in scenario.targets.items() if name != TARGET}
    stripped = replace(scenario, objects=objects, targets=targets)
    return stripped if add_markers(stripped) == scenario else scenario
