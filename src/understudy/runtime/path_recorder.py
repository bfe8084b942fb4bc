"""Record where the agents of a run are and what they do, to draw their paths."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from understudy.errors import SettingError
from understudy.runtime.body import Viewable
from understudy.runtime.thinning_buffer import ThinningBuffer

if TYPE_CHECKING:
    from understudy.runtime.run_loop import Run

MOST_MOMENTS, LEAST_MOMENTS, MOST_PLACES = 4_000, 300, 400_000
"""The largest number of recorded moments, its least value with many robots, and the largest number of places."""


class RecordedMoment(NamedTuple):
    """One moment of a run: a view of its world, and the outermost state of each robot in it."""

    view: Any
    doing: tuple[str, ...]


class PathRecorder:
    """A recorder of one world of a run; of long runs it keeps every second, fourth … moment.

    SettingError if the body cannot be drawn, or has no such world.
    """

    def __init__(self, run: Run, world: int = 0) -> None:
        body = run.body
        if not isinstance(body, Viewable):
            raise SettingError(
                where="run",
                setting="body",
                problem=f"is a {type(body).__name__}, which does not say where its agents are",
                remedy="give it a method view that returns a WorldView, as that of World does",
            )
        worlds = getattr(body, "worlds", 1)
        if not 0 <= world < worlds:
            problem, remedy = f"is {world} of {worlds}", "count from 0"
            raise SettingError(where="run", setting="world", problem=problem, remedy=remedy)
        self._body, self._world, self._robots = body, world, run.body.agents // worlds
        fitting = max(LEAST_MOMENTS, MOST_PLACES // max(1, self._robots))
        self._kept: ThinningBuffer[RecordedMoment] = ThinningBuffer(min(MOST_MOMENTS, fitting))

    def add(self, run: Run) -> None:
        """Record the present moment."""
        first = self._world * self._robots
        doing = tuple((*run.path(agent), "")[0] for agent in range(first, first + self._robots))
        self._kept.append(RecordedMoment(self._body.view(self._world), doing))

    @property
    def moments(self) -> list[RecordedMoment]:
        """The moments kept, with the first and the last one."""
        return self._kept.items
