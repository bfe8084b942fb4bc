"""Find scenarios by name (built-in ones) or path, and compile the kernels for a scenario in advance."""

from __future__ import annotations

from pathlib import Path

from understudy.errors import UnknownName
from understudy.jit.settings import pause_garbage_collection
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import IDLE_PROGRAM
from understudy.sim.scenario.files import SUFFIX, add_markers, list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import Scenario
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
