"""Our own case: worlds of a scenario with robots that run a library, through the public interface."""

from __future__ import annotations

from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World


class UnderstudyCase:
    """Parallel worlds, with recording off."""

    def __init__(
        self, scenario: Scenario, library: Library, behavior: str, *, worlds: int = 1, threads: int = 1
    ) -> None:
        self.seeds, self.threads = range(worlds), threads
        self.world = World(scenario, self.seeds)
        self.robots = self.world.agents
        self.engine = Engine.from_program(self.world, link(library, behavior))

    def reset(self) -> None:
        """Restore the start of robots and automata."""
        self.world.reset(self.seeds)
        self.engine.restart()

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        self.engine.run(ticks, threads=self.threads)
