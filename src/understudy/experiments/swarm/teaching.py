"""One teaching of the whole swarm: first its robots, then the coordinators, from the bottom up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from understudy.experiments.swarm.practice import known, robots_world, troops
from understudy.model.library import Library
from understudy.training.demonstrators import swarm, swarm_squads
from understudy.training.demonstrators.teacher import Progress, Teacher, Teaching
from understudy.worlds.kits import kit_of
from understudy.worlds.swarm import PLATOON, SQUAD, SWARM, scenario
from understudy.worlds.teams import Libraries

TOPICS = {SQUAD: swarm_squads.SQUAD, PLATOON: swarm_squads.PLATOON, SWARM: swarm_squads.SWARM}


class Taught(NamedTuple):
    """What the robots and what each sort of coordinators were taught."""

    robots: Teaching
    squads: Mapping[str, Teaching]

    @property
    def libraries(self) -> Libraries:
        """What everybody knows."""
        return known(self.robots.library, {name: each.library for name, each in self.squads.items()})

    @property
    def teachings(self) -> tuple[Teaching, ...]:
        """Of robots and all coordinators."""
        return (self.robots, *self.squads.values())


def teach(seed: int, *, progress: Progress = lambda name, what, account: None) -> Taught:
    """Teach everything from nothing; the same seed, the same lessons."""
    library = Library(kit_of(scenario()))
    robots = Teacher(library, robots_world, seed, options={}, progress=progress).teach(*swarm.TOPICS)
    taught = Taught(robots, {})
    for sort, topic in TOPICS.items():
        libraries = taught.libraries
        teacher = Teacher(libraries[sort], troops(sort, libraries), seed, options={}, progress=progress)
        taught = Taught(robots, {**taught.squads, sort: teacher.teach(topic)})
    return taught
