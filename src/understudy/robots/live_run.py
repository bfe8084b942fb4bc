"""A run on real robots: everybody senses, decides and acts, tick by tick as time passes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TypeAlias

from understudy.robots.twin import DigitalTwin
from understudy.runtime.team.team import Team
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries

Clock: TypeAlias = Callable[[], float]


class LiveRun:
    """A team on the robots of a twin, in real time. A late tick is not made up for.

    `libraries` has what each sort of agents knows, `roots` what those in no squad run, as for a team in a world.
    """

    def __init__(
        self,
        twin: DigitalTwin,
        libraries: Libraries,
        roots: Mapping[str, tuple[str, Mapping[str, str]]],
        *,
        clock: Clock = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.twin = twin
        radio = twin.scenario.radio
        self.team = Team(
            twin,
            assign_team_members(twin.scenario),
            libraries,
            roots,
            delay_s=radio.delay_s,
            loss=radio.loss,
            seeds=(0,),
        )
        self._clock, self._sleep = clock, sleep
        self._due = clock()
        self.ticks = self.late = 0

    def tick(self) -> None:
        """Wait until the next tick is due, and take it."""
        now = self._clock()
        if now < self._due:
            self._sleep(self._due - now)
        elif self.ticks and now > self._due + self.twin.tick_s:
            self.late += 1
            self._due = now
        self.team.tick()
        self.ticks += 1
        self._due += self.twin.tick_s

    def restart(self) -> None:
        """Let everybody begin anew, such as when robots were armed."""
        self.team.clear()
        self._due = self._clock()
        self.ticks = self.late = 0
