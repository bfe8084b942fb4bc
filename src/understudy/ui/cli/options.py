"""Options that several commands share, and functions that parse their values.

The options of a command are the fields of a class whose docstring is its help. These modules import nothing of what
commands do, so that help is quick.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar, dataclass_transform

import typer

from understudy.errors import SettingError

LIBRARY = Path("library")
FAILURES = Path("failures")
"""The folder in which `understudy falsify` keeps failing worlds."""
WORLD = "forage"

LibraryOption: TypeAlias = Annotated[
    Path, typer.Option("--library", "-l", help="Folder of the library; can be an argument, too.")
]
ScenarioName: TypeAlias = Annotated[
    str | None,
    typer.Argument(
        metavar="[SCENARIO]",
        help="Scenario: a name (see understudy worlds) or a file; or MODULE:NAME of a function that makes a scenario, "
        "a body or a Gymnasium environment; forage if left out.",
        show_default=False,
    ),
]
SomeWorld: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--world",
        "-w",
        metavar="SCENARIO",
        help="Take features from this scenario's kit instead of the documents.",
    ),
]
FoundWorld: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--world",
        "-w",
        metavar="SCENARIO",
        help="Scenario it was taught in; the first built-in one that fits if left out.",
        show_default=False,
    ),
]
SameWorld: TypeAlias = Annotated[
    str | None,
    typer.Option("--world", "-w", metavar="SCENARIO", help="Scenario, as an option.", hidden=True),
]
"""Old spelling of the argument SCENARIO."""
KitName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--kit", metavar="MODULE:NAME", help="Python object with your own features, behaviors and targets."
    ),
]
BehaviorName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--behavior",
        metavar="NAME",
        help="Behavior; if left out, the automaton that no other in the library uses.",
        show_default=False,
    ),
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Bind: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--bind", "-b", metavar="PARAMETER=TARGET", help="Bind a parameter of the behavior to a target."
    ),
]
FailuresOption: TypeAlias = Annotated[
    Path,
    typer.Option(
        "--failures", metavar="FOLDER", help="Folder of failing worlds, which are listed to be corrected."
    ),
]
SeedOption: TypeAlias = Annotated[int, typer.Option("--seed", min=0, help="Seed of the world.")]
NoRecording: TypeAlias = Annotated[
    bool, typer.Option("--no-record", help="Do not record the messages of real robots.")
]
RobotsFile: TypeAlias = Annotated[
    Path, typer.Argument(metavar="FILE", help="File of a robot or a team.", show_default=False)
]


@dataclass_transform(kw_only_default=True, frozen_default=True)
@dataclass(frozen=True, kw_only=True)
class CommandOptions:
    """Options of every command; classes derived from it are dataclasses, frozen and with fields given by keyword."""

    as_json: Json = False

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)


class ScenarioOptions(CommandOptions):
    """The scenario of a command, as an argument or in an old spelling as an option."""

    scenario: ScenarioName = None
    world: SameWorld = None

    @property
    def world_name(self) -> str:
        """Name of the scenario, or the default if none was given; SettingError if two were given that differ."""
        if self.scenario is not None and self.world is not None and self.scenario != self.world:
            raise SettingError(
                where="--world",
                setting=repr(self.world),
                problem=f"is another scenario than {self.scenario!r}",
                remedy="name one of them",
            )
        return self.scenario or self.world or WORLD


class LibraryOptions(CommandOptions):
    """The library that a command reads, and what defines the features of its automata."""

    library: LibraryOption = LIBRARY
    world: SomeWorld = None
    kit: KitName = None


Options = TypeVar("Options", bound=CommandOptions)


def choose_options(kind: type[Options], given: CommandOptions, **more: Any) -> Options:
    """Make options of a class of those that others have by the same names, and of `more`."""
    names = [each.name for each in fields(kind) if each.name not in more and hasattr(given, each.name)]
    return kind(**{name: getattr(given, name) for name in names}, **more)


def parse_bindings(bound: list[str] | None) -> dict[str, str]:
    """Parse the PARAMETER=TARGET pairs of the `--bind` options."""
    pairs = {}
    for text in bound or []:
        parameter, equals, target = text.partition("=")
        if not (parameter and equals and target):
            raise SettingError(
                where="--bind",
                setting=repr(text),
                problem="is not a binding",
                remedy="write PARAMETER=TARGET: A=station",
            )
        pairs[parameter] = target
    return pairs


def parse_names(text: str | None) -> list[str] | None:
    """Split a text at commas outside parentheses; None stays None."""
    if text is None:
        return None
    return [part.strip() for part in re.split(r",(?![^(]*\))", text) if part.strip()]


def parse_targets(text: str | None) -> dict[str, str]:
    """Parse the comma-separated PARAMETER=TARGET pairs of `--targets`."""
    found = {}
    for pair in parse_names(text) or []:
        parameter, equals, target = (part.strip() for part in pair.partition("="))
        if not (parameter and equals and target):
            remedy = "write PARAMETER=TARGET: A=station"
            raise SettingError(
                where="--targets", setting=repr(pair), problem="is not a binding", remedy=remedy
            )
        found[parameter] = target
    return found
