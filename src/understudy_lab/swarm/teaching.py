"""One teaching of the whole swarm: first its robots, then the coordinators, from the bottom up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from understudy.model.library import Library
from understudy.sim.kit import kit_of
from understudy.sim.team.libraries import Libraries
from understudy_lab.swarm.practice import known, robots_world, troops
from understudy_lab.tasks import swarm_squad_teacher, swarm_teacher
from understudy_lab.tasks.swarm import PLATOON, SQUAD, SWARM, scenario
from understudy_lab.teachers.teacher import Progress, Teacher, Teaching

TOPICS = {
    SQUAD: swarm_squad_teacher.SQUAD,
    PLATOON: swarm_squad_teacher.PLATOON,
    SWARM: swarm_squad_teacher.SWARM,
}


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
    robots = Teacher(library, robots_world, seed, options={}, progress=progress).teach(*swarm_teacher.TOPICS)
    taught = Taught(robots, {})
    for sort, topic in TOPICS.items():
        libraries = taught.libraries
        teacher = Teacher(libraries[sort], troops(sort, libraries), seed, options={}, progress=progress)
        taught = Taught(robots, {**taught.squads, sort: teacher.teach(topic)})
    return taught
