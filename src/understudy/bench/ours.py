"""Our side of the measurements: worlds of a scenario and robots that run a library, through the public names."""

from __future__ import annotations

from importlib import import_module

from understudy.model.library import Library
from understudy.runtime.program import link
from understudy.worlds.scenario import Scenario


class Ours:
    """Worlds side by side, with recording off."""

    def __init__(
        self, scenario: Scenario, library: Library, behavior: str, *, worlds: int = 1, threads: int = 1
    ) -> None:
        self.worlds, self.threads = worlds, threads
        self.robots = worlds * sum(
            robots.count for robots in scenario.robots if isinstance(robots.count, int)
        )
        self.world = import_module("understudy.worlds.world").World(scenario, seeds=range(worlds))
        engine = import_module("understudy.runtime.engine").Engine
        self.engine = engine.of(self.world, link(library, behavior))

    def reset(self) -> None:
        """Back to the start, robots and automata."""
        self.world.reset()
        self.engine.reset()

    def run(self, ticks: int) -> None:
        """Run for so many ticks."""
        self.engine.run(ticks, threads=self.threads)
