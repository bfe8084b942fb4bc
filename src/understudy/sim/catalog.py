"""Find scenarios by name (built-in ones) or path, and compile the kernels for a scenario in advance."""

from __future__ import annotations

from pathlib import Path

from understudy.errors import UnknownName
from understudy.jit.settings import pause_garbage_collection
from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import IDLE_PROGRAM
from understudy.runtime.team.team import Team
from understudy.sim.kit import make_scenario_kit, make_type_kits
from understudy.sim.scenario.files import SUFFIX, add_markers, list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import collect_libraries, make_scenario_team
from understudy.sim.world import World


def find_scenario(name: str | Path) -> Scenario:
    """Load a built-in scenario by name, or a scenario file by path, and add a class of markers to it.

    UnknownName for a text that is neither a name nor like a path; FileError for a file that is not a scenario.
    """
    path = Path(name)
    known = list_builtin_scenarios()
    if isinstance(name, str) and name not in known and path.suffix != SUFFIX and len(path.parts) < 2:
        where = f"Understudy, which takes a path ending in {SUFFIX} too,"
        raise UnknownName(what="world", name=name, where=where, known=known)
    return add_markers(load_scenario(name))


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
