"""Worlds by name: the built-in scenarios, and any file of a scenario by its path."""

from __future__ import annotations

from pathlib import Path

from understudy.errors import UnknownName
from understudy.kernel_cache import pause_garbage_collection
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import IDLE_PROGRAM
from understudy.sim.scenario.files import SUFFIX, add_markers, list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World


def find_scenario(name: str | Path) -> Scenario:
    """The built-in scenario of this name, or that of a file, with room for markers.

    UnknownName for what is neither a name nor looks like a path; FileError for a file that is no scenario.
    """
    path = Path(name)
    known = list_builtin_scenarios()
    if isinstance(name, str) and name not in known and path.suffix != SUFFIX and len(path.parts) < 2:
        where = f"Understudy, which takes a path ending in {SUFFIX} too,"
        raise UnknownName(what="world", name=name, where=where, known=known)
    return add_markers(load_scenario(name))


def compile_world_kernels(scenario: Scenario) -> None:
    """Have the kernels compiled or loaded, so that no later call waits (a minute, once per installation)."""
    with pause_garbage_collection():
        engine = Engine.from_program(World(scenario), IDLE_PROGRAM)
        engine.run(1)
        engine.tick()
