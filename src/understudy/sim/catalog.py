"""Find scenarios by name, path or function, and compile the kernels for a scenario in advance."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from understudy.entry_points import BODIES, WORLDS, list_entry_points, load_object
from understudy.errors import SettingError, UnderstudyError, UnknownName
from understudy.jit.settings import pause_garbage_collection
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import IDLE_PROGRAM
from understudy.runtime.team.team import Team
from understudy.sim.kit import make_scenario_kit, make_type_kits
from understudy.sim.scenario.files import SUFFIX, add_markers, list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import collect_libraries, make_scenario_team
from understudy.sim.world import World

REMEDY = "name a function without parameters that returns a Scenario, as MODULE:NAME"


def list_scenarios() -> list[str]:
    """List the names of scenarios: built-in ones, and those that installed packages offer."""
    return sorted({*list_builtin_scenarios(), *list_entry_points(WORLDS)})


def list_bodies() -> list[str]:
    """List the names of bodies that installed packages offer as worlds."""
    return sorted({*list_entry_points(BODIES)}.difference(list_scenarios()))


def find_scenario(name: str | Path) -> Scenario:
    """Load a scenario, and add a class of markers to it.

    Parameters
    ----------
    name
        A built-in scenario; a scenario that an installed package offers in the entry point group `understudy.worlds`;
        the path of a scenario file; or MODULE:NAME, a function that returns a scenario, or a scenario.

    Returns
    -------
    Scenario
        The scenario.

    Raises
    ------
    UnknownName
        For a text that is none of these.
    FileError
        For a file that is not a scenario.
    SettingError
        For a function that cannot be imported, fails, or returns something else; and for a body of a package.
    """
    path = Path(name)
    names = list_builtin_scenarios()
    if isinstance(name, str) and is_function(name):
        return add_markers(_make_scenario(name))
    if isinstance(name, str) and name not in names and path.suffix != SUFFIX and len(path.parts) < 2:
        names = (*list_scenarios(), *list_bodies())
        where = f"Understudy, which takes a path ending in {SUFFIX} too,"
        raise UnknownName(what="world", name=name, where=where, known=names)
    return add_markers(load_scenario(name))


def is_function(name: str) -> bool:
    """Return whether a scenario's name means a function: that of an installed package, or MODULE:NAME."""
    if name in list_builtin_scenarios():  # before entry points, for which all installed packages are searched
        return False
    is_place = ":" in name and Path(name).suffix != SUFFIX
    return is_place or name in list_entry_points(WORLDS) or name in list_entry_points(BODIES)


def locate_scenario(name: str) -> str:
    """Return the name by which a scenario is found from any working folder: the path of a file is made absolute."""
    return name if name in list_builtin_scenarios() or is_function(name) else str(Path(name).resolve())


def _make_scenario(name: str) -> Scenario:
    if name in list_bodies():
        raise refuse_world(name, "is a body", REMEDY)
    world = load_object(name, WORLDS, where="world", remedy=REMEDY)
    if callable(world):
        world = call_world_function(world, name, remedy=REMEDY)
    if not isinstance(world, Scenario):
        raise refuse_world(name, f"is a {type(world).__name__}", REMEDY)
    return world


def call_world_function(function: Callable[..., Any], name: str, *seeds: int, remedy: str) -> Any:
    """Call a function of the user's own that makes a world; turn any error into a SettingError."""
    try:
        return function(*seeds)
    except UnderstudyError:
        raise
    except Exception as error:  # a user's function can raise any error
        raise refuse_world(name, f"raised {type(error).__name__}: {error}", remedy) from error


def refuse_world(name: str, problem: str, remedy: str) -> SettingError:
    """Make the error about a world that is named by a function."""
    return SettingError(where="world", setting=repr(name), problem=problem, remedy=remedy)


def compile_world_kernels(scenario: Scenario) -> None:
    """Compile or load the kernels that a scenario needs, so that later calls do not wait.

    Compiling takes a minute, once per installation.
    """
    with pause_garbage_collection():
        engine = Engine.from_program(World(scenario), IDLE_PROGRAM)
        engine.run(1)
        engine.tick()
        if scenario.squads:  # other kernels: they also compute what coordinators read
            _make_idle_team(scenario).run(1)


def _make_idle_team(scenario: Scenario) -> Team:
    """Make the team of a scenario, with all coordinators, whose robots and coordinators idle."""
    kits = make_type_kits(scenario, make_scenario_kit(scenario))
    libraries = collect_libraries(scenario, {name: Library(kit) for name, kit in kits.items()})
    *_, highest = libraries
    return make_scenario_team(
        World(scenario), scenario, libraries, {}, seeds=[0], makes=Engine, trained=highest
    )
