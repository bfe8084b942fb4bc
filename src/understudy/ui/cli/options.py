"""What several commands are told: which library, which kit, which world; and how those are found."""

from __future__ import annotations

import importlib
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from understudy.errors import SettingError, UnderstudyError, join_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from understudy.model.automaton import Transition
    from understudy.model.lesson import Lesson
    from understudy.model.library import Kit
    from understudy.model.library import Library as Taught
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries
    from understudy.storage.document import Learn
    from understudy.storage.library_folder import LoadedLibrary

LibraryOption: TypeAlias = Annotated[
    Path, typer.Option("--library", "-l", help="The folder the automata are in.")
]
ScenarioName: TypeAlias = Annotated[
    str | None,
    typer.Argument(
        metavar="[SCENARIO]",
        help="A built-in scenario (understudy worlds lists them), or a file of one; forage if left out.",
        show_default=False,
    ),
]
WorldOption: TypeAlias = Annotated[
    str,
    typer.Option("--world", "-w", metavar="SCENARIO", help="The scenario, and the kit that goes with it."),
]
SomeWorld: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--world",
        "-w",
        metavar="SCENARIO",
        help="Look features up in this scenario's kit, not in the documents.",
    ),
]
FoundWorld: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--world",
        "-w",
        metavar="SCENARIO",
        help="What it was taught in; found out among the built-in scenarios if left out.",
        show_default=False,
    ),
]
SameWorld: TypeAlias = Annotated[
    str | None, typer.Option("--world", "-w", metavar="SCENARIO", help="The scenario, as an option.")
]
KitName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--kit", metavar="MODULE:NAME", help="Features, behaviors and targets of your own, from Python."
    ),
]
BehaviorName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--behavior",
        metavar="NAME",
        help="A behavior; if left out, the automaton of the library that no other uses.",
        show_default=False,
    ),
]
AutomatonNames: TypeAlias = Annotated[
    list[str] | None, typer.Argument(metavar="[NAME]...", help="Which automata; all if none is named.")
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")]
Bind: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--bind", "-b", metavar="PARAMETER=TARGET", help="What a parameter of the behavior stands for."
    ),
]

LIBRARY = Path("library")
WORLD = "forage"
MAIN = "forage"


def open_scenario(name: str) -> Scenario:
    """The built-in scenario of this name, or that of a file."""
    from understudy.sim.catalog import find_scenario as find

    return find(name)


def choose_scenario_name(argument: str | None, option: str | None) -> str:
    """The scenario that was named, as an argument or as an option."""
    if argument is not None and option is not None and argument != option:
        raise SettingError(
            where="--world",
            setting=repr(option),
            problem=f"is another scenario than {argument!r}",
            remedy="name one of them",
        )
    return argument or option or WORLD


def find_kit(named: str | None, world: str) -> Kit:
    """The kit named as MODULE:NAME, otherwise the scenario's."""
    from understudy.model.library import Kit

    if named is None:
        from understudy.sim.kit import make_scenario_kit

        return make_scenario_kit(open_scenario(world))
    module, _, name = named.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        found = getattr(importlib.import_module(module), name)
    except UnderstudyError:
        raise
    except Exception as error:  # whatever a module of the user's own does when it is imported
        raise _no_kit(named, f"cannot be had: {type(error).__name__}: {error}") from error
    if not isinstance(found, Kit):
        raise _no_kit(named, f"is a {type(found).__name__}")
    return found


def find_optional_kit(named: str | None, world: str | None) -> Kit | None:
    """The kit where one is named or a world is, otherwise None: features are as the documents say."""
    return None if named is None and world is None else find_kit(named, world or WORLD)


def _no_kit(named: str, problem: str) -> SettingError:
    remedy = "name a Kit as MODULE:NAME, such as mylab.robots:kit, that Python finds from this folder"
    return SettingError(where="--kit", setting=repr(named), problem=problem, remedy=remedy)


def open_library_with_notes(library: Path, kit: Kit) -> LoadedLibrary:
    """A library; transition functions that were built anew are reported on stderr."""
    from understudy.storage.library_folder import open_library

    found = open_library(library, kit, import_learner())
    for name, reason in found.rebuilt.items():
        if "classifier" not in reason:
            typer.echo(f"Note: {name} was learned again from its examples: {reason}.", err=True)
    return found


def open_behavior_library(behavior: str | None, folder: Path, kit: Kit) -> Taught:
    """The library a behavior is in; a basic one, which the kit has, needs no folder."""
    from understudy.errors import UnknownName
    from understudy.model.library import Library

    if folder.exists():
        return open_library_with_notes(folder, kit).library
    if behavior is not None and behavior not in kit.behaviors:
        where = f"there is no folder {folder} with automata, and the kit"
        raise UnknownName(what="behavior", name=behavior, where=where, known=list(kit.behaviors))
    return Library(kit)


def open_team_libraries(
    scenario: Scenario, behavior: str | None, folder: Path, kit: Kit
) -> Mapping[str, Taught]:
    """What everybody knows: squads, and types of robots that differ, have folders of their names in that of all."""
    from understudy.model.library import Library
    from understudy.sim.team.libraries import collect_libraries, load_type_libraries

    def look(where: Path, kit: Kit) -> Taught:
        return open_library_with_notes(where, kit).library if where.is_dir() else Library(kit)

    if not folder.exists():
        open_behavior_library(behavior, folder, kit)
    robots = load_type_libraries(scenario, folder, kit, look)
    return collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))


def choose_behavior(library: Taught, named: str | None, folder: Path) -> str:
    """The behavior that was named; if none was, the automaton at the top of the library, which no other uses.

    Of several at the top it is `forage`, if that is among them; otherwise SettingError, saying which there are.
    """
    if named is not None:
        return named
    tops = [name for name in library.taught if not library.find_users(name)]
    if len(tops) == 1:
        return tops[0]
    if MAIN in tops:
        return MAIN
    automata = f"the automata of {folder} are {join_names(library.taught)}"
    if not folder.exists():
        automata = f"there is no folder {folder} with automata"
    raise SettingError(
        where="command line",
        setting="--behavior",
        problem="is missing",
        remedy=f"give --behavior NAME: {automata}, and the basic behaviors are {join_names(library.kit.behaviors)}",
    )


@dataclass(frozen=True, slots=True)
class RunAssignment:
    """Which behavior is to run: of which `sort` of agents, what every sort knows, and what each runs (`roots`)."""

    libraries: Libraries
    sort: str
    behavior: str
    binding: dict[str, str]
    roots: dict[str, tuple[str, dict[str, str]]]

    @property
    def flags(self) -> set[str]:
        """The states of the behavior in which it ends."""
        from understudy.model.automaton import Automaton

        root = self.libraries[self.sort].behavior(self.behavior)
        states = root.states if isinstance(root, Automaton) else ()
        return {state.name for state in states if state.flag is not None}


def assign_run(
    scenario: Scenario, behavior: str | None, folder: Path, kit: Kit, bind: list[str] | None
) -> RunAssignment:
    """Find the behavior that options name, and who runs it; mistakes are reported before anything is compiled or moves.

    Raises what `open_team_libraries`, `choose_behavior` and linking raise.
    """
    from understudy.runtime.program import link
    from understudy.sim.team.libraries import find_behavior_sort, list_running_sorts

    bound = parse_bindings(bind)
    known = open_team_libraries(scenario, behavior, folder, kit)
    sort = find_behavior_sort(known, behavior)
    found = choose_behavior(known[sort], behavior and behavior.removeprefix(f"{sort}/"), folder)
    link(known[sort], found, bound)
    return RunAssignment(
        known, sort, found, bound, dict.fromkeys(list_running_sorts(known, sort, found), (found, bound))
    )


def import_learner() -> Learn:
    """What builds transition functions from a lesson; imported only when it is needed."""

    def learn(lesson: Lesson) -> Mapping[str, Transition]:
        from understudy.learning.fit import learn

        return learn(lesson)

    return learn


def parse_bindings(bound: list[str] | None) -> dict[str, str]:
    """What --bind options say."""
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
    """What commas separate, but for those in parentheses; None where nothing was said."""
    if text is None:
        return None
    return [part.strip() for part in re.split(r",(?![^(]*\))", text) if part.strip()]


def parse_targets(text: str | None) -> dict[str, str]:
    """What --targets says."""
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
