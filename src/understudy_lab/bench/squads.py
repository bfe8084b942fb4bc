"""How fast robots in three levels of squads run, that pull boxes together: two hundred, and ten thousand.

What robots and coordinators do is written by hand, in the shape of what is taught in `understudy demo swarm`.
"""

from __future__ import annotations

import os
from functools import partial

from understudy.sim.team.libraries import team_of
from understudy_lab.bench.harness import Case, Goal, Row, measure, result, speed
from understudy_lab.tasks.swarm import EACH, SWARM, of_platoons
from understudy_lab.tasks.swarm_expert import hand_coded

TASK, PLATOONS, LARGE, SQUAD_ROUNDS = "three levels of squads", 8, 400, 5
AT_WORK = 150
HERTZ, TIMES = 10, 10
"""How many ticks a second has, and how many times as fast as that it should go."""


class Swarm:
    """So many platoons, under their coordinators."""

    def __init__(self, platoons: int) -> None:
        self.robots = EACH * platoons
        self._world = of_platoons(platoons)
        self.reset()

    def reset(self) -> None:
        """Back to where all are at work, past the ten seconds in which they spread out."""
        self.team = team_of(self._world, [0], hand_coded(), {SWARM: ("swarm_work", {})})
        self.team.run(AT_WORK)

    def run(self, ticks: int) -> None:
        """Run for so many ticks."""
        self.team.run(ticks)


def make_squad_cases() -> list[Case]:
    """The swarm that ships, and ten thousand robots."""
    return [
        Case(TASK, partial(Swarm, PLATOONS), 1, 1_000),
        Case(TASK, partial(Swarm, LARGE), os.cpu_count() or 1, 200),
    ]


SQUAD_GOALS = (
    Goal(
        f"{EACH * LARGE} robots: times real time, at {HERTZ} Hz",
        lambda rows: speed(rows, TASK, EACH * LARGE) / (EACH * LARGE) / HERTZ,
        least=TIMES,
    ),
)


def run_squads(*, rounds: int = SQUAD_ROUNDS) -> Row:
    """Both, and whether they are fast enough."""
    return result(measure(make_squad_cases(), rounds=rounds), SQUAD_GOALS)
