"""Options and arguments that several commands share, and functions that resolve them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from understudy.errors import SettingError, join_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from understudy.adapters.body_maker import BodyMaker
    from understudy.model.automaton import Transition
    from understudy.model.lesson import Lesson
    from understudy.model.library import Kit
    from understudy.model.library import Library as Taught
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries
    from understudy.storage.document import Learn
    from understudy.storage.library_folder import LoadedLibrary

LibraryOption: TypeAlias = Annotated[Path, typer.Option("--library", "-l", help="Folder of the library.")]
ScenarioName: TypeAlias = Annotated[
    str | None,
    typer.Argument(
        metavar="[SCENARIO]",
        help="Scenario: a name (see understudy worlds) or a file; or MODULE:NAME of a function that makes a scenario, "
        "a body or a Gymnasium environment; forage if left out.",
        show_default=False,
    ),
]
WorldOption: TypeAlias = Annotated[
    str,
    typer.Option("--world", "-w", metavar="SCENARIO", help="Scenario that defines the kit."),
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
    str | None, typer.Option("--world", "-w", metavar="SCENARIO", help="Scenario, as an option.")
]
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
AutomatonNames: TypeAlias = Annotated[
    list[str] | None, typer.Argument(metavar="[NAME]...", help="Names of automata; all if left out.")
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

LIBRARY = Path("library")
FAILURES = Path("failures")
"""The folder in which `understudy falsify` keeps failing worlds."""
WORLD = "forage"
MAIN = "forage"
ALONE = "robot"
"""Name of the sort of robots that have no scenario."""
KIT_REMEDY = "name a Kit as MODULE:NAME, such as mylab.robots:kit, that Python finds from this folder"


def open_scenario(name: str) -> Scenario:
    """Return the scenario of this name, or load it from a file or from a function MODULE:NAME."""
    from understudy.sim.catalog import find_scenario as find

    return find(name)


def open_world(name: str) -> Scenario | BodyMaker:
    """Return what `open_scenario` returns, or the function MODULE:NAME if it makes a body or an environment."""
    from understudy.adapters.body_maker import find_world

    return find_world(name)


def find_optional_scenario(name: str | None) -> Scenario | None:
    """Return the scenario of this name; None if there is no name, or if it is a function that makes a body."""
    from understudy.sim.scenario.schema import Scenario

    found = None if name is None else open_world(name)
    return found if isinstance(found, Scenario) else None


def choose_scenario_name(argument: str | None, option: str | None) -> str:
    """Return the scenario given as argument or as option, or the default if neither was given.

    Raises SettingError if both were given and differ.
    """
    if argument is not None and option is not None and argument != option:
        raise SettingError(
            where="--world",
            setting=repr(option),
            problem=f"is another scenario than {argument!r}",
            remedy="name one of them",
        )
    return argument or option or WORLD


def find_kit(named: str | None, world: str) -> Kit:
    """Return the kit named as MODULE:NAME or by its entry point, or that of the world if `named` is None."""
    from understudy.entry_points import KITS, load_instance
    from understudy.model.library import Kit

    if named is None:
        return make_world_kit(open_world(world))
    return load_instance(named, KITS, Kit, where="--kit", remedy=KIT_REMEDY)


def make_world_kit(world: Scenario | BodyMaker) -> Kit:
    """Return the kit of a scenario, or that of the body that a function makes; SettingError if the body has none."""
    from understudy.sim.kit import make_scenario_kit
    from understudy.sim.scenario.schema import Scenario

    return make_scenario_kit(world) if isinstance(world, Scenario) else world.find_kit()


def find_optional_kit(named: str | None, world: str | None) -> Kit | None:
    """Return the kit if a kit or a world is named; otherwise None, and the documents define the features."""
    return None if named is None and world is None else find_kit(named, world or WORLD)


def open_library_with_notes(library: Path, kit: Kit) -> LoadedLibrary:
    """Open a library, and report on stderr which transition functions were learned again."""
    from understudy.storage.library_folder import open_library

    found = open_library(library, kit, import_learner())
    for name, reason in found.rebuilt.items():
        if "classifier" not in reason:
            typer.echo(f"Note: {name} was learned again from its examples: {reason}.", err=True)
    return found


def open_behavior_library(behavior: str | None, folder: Path, kit: Kit) -> Taught:
    """Open the library in a folder; without the folder, return an empty one with the kit's basic behaviors.

    Raises UnknownName if there is no folder and `behavior` is not a basic one.
    """
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
    """Open the libraries of all sorts of agents in a scenario.

    Squads, and robot types that differ, have subfolders of their names in `folder`.
    """
    from understudy.model.library import Library
    from understudy.sim.team.libraries import collect_libraries, load_type_libraries

    def look(where: Path, kit: Kit) -> Taught:
        return open_library_with_notes(where, kit).library if where.is_dir() else Library(kit)

    if not folder.exists():
        open_behavior_library(behavior, folder, kit)
    robots = load_type_libraries(scenario, folder, kit, look)
    return collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))


def choose_behavior(library: Taught, named: str | None, folder: Path) -> str:
    """Return the behavior that was named, or else the only automaton that no other automaton uses.

    If there are several such automata, `forage` is chosen if it is among them. Otherwise SettingError lists them.
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
    """Behavior to run, the sort of agents it belongs to, all libraries, and what each sort runs (`roots`)."""

    libraries: Libraries
    sort: str
    behavior: str
    binding: dict[str, str]
    roots: dict[str, tuple[str, dict[str, str]]]

    @property
    def flags(self) -> set[str]:
        """Names of the behavior's states that raise a flag and so end it."""
        from understudy.model.automaton import Automaton

        root = self.libraries[self.sort].behavior(self.behavior)
        states = root.states if isinstance(root, Automaton) else ()
        return {state.name for state in states if state.flag is not None}


def assign_run(
    world: Scenario | BodyMaker,
    behavior: str | None,
    folder: Path,
    kit: Kit,
    bind: list[str] | None,
    *,
    bound_for_others: bool = False,
) -> RunAssignment:
    """Find the behavior that the options name and the agents that run it.

    With `bound_for_others`, bindings of parameters that it does not have are meant for another behavior. Mistakes are
    reported here, before anything is compiled or moves. Raises the errors of `open_team_libraries`, `choose_behavior`
    and `link`.
    """
    from understudy.runtime.program import link
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import find_behavior_sort, list_running_sorts

    bound = parse_bindings(bind)
    if isinstance(world, Scenario):
        known = open_team_libraries(world, behavior, folder, kit)
    else:
        known = {ALONE: open_behavior_library(behavior, folder, kit)}
    sort = find_behavior_sort(known, behavior)
    found = choose_behavior(known[sort], behavior and behavior.removeprefix(f"{sort}/"), folder)
    if bound_for_others:
        parameters = known[sort].parameters(found)
        bound = {name: target for name, target in bound.items() if name in parameters}
    link(known[sort], found, bound)
    return RunAssignment(
        known, sort, found, bound, dict.fromkeys(list_running_sorts(known, sort, found), (found, bound))
    )


def import_learner() -> Learn:
    """Return the function that learns transition functions from a lesson, imported on its first call."""

    def learn(lesson: Lesson) -> Mapping[str, Transition]:
        from understudy.learning.fit import learn

        return learn(lesson)

    return learn


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
