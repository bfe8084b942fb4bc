"""The world while nothing is trained: its robots idle, and time stands still until somebody lets it go."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.robots.twin import Ground, Twin
from understudy.ui.controller.clock import Pace, Wall


class Idling:
    """A world in real time, without a desk."""

    def __init__(self, world: Ground, wall: Wall) -> None:
        self._world, self.pace = world, Pace(wall, tick_s=world.tick_s, live=isinstance(world, Twin))
        self.paused = True

    def pause(self, paused: bool) -> None:
        """Let time stand still, or go on."""
        self.paused = paused
        (self.pace.stop if paused else self.pace.go)()

    def ticks(self) -> Iterator[None]:
        """Take the ticks that are due, one after the other."""
        for _ in self.pace.ticks():
            self._world.act({})
            yield

    def step(self) -> None:
        """One tick, then time stands still."""
        self.pause(True)
        self._world.act({})
