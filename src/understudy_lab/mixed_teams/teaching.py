"""One teaching of the whole team: scouts, carriers, then their coordinator."""

from __future__ import annotations

from typing import NamedTuple

from understudy.model.lesson import Options
from understudy.model.library import Library
from understudy.sim.team.libraries import Libraries
from understudy_lab.mixed_teams.practice import CARRIER, SCOUT, kits, robots_world, squads_library, troops
from understudy_lab.tasks import salvage_carrier_teacher, salvage_crew, salvage_scout_teacher
from understudy_lab.teachers.teacher import Progress, Teacher, Teaching

TOPICS = {SCOUT: salvage_scout_teacher.SCOUTS, CARRIER: salvage_carrier_teacher.CARRIERS}
OPTIONS = {"goto": Options(watched=True, reaction_s=0.2)}
"""Of lessons about motion: silence is consent, and presses come late."""


class Taught(NamedTuple):
    """What each type of robots and what the coordinator was taught."""

    robots: dict[str, Teaching]
    coordinator: Teaching

    @property
    def libraries(self) -> Libraries:
        """What each type knows."""
        return {kind: teaching.library for kind, teaching in self.robots.items()}


def teach(seed: int, *, progress: Progress = lambda name, what, account: None) -> Taught:
    """Teach everything from nothing; the same seed, the same lessons."""
    robots = {
        kind: Teacher(Library(kits()[kind]), robots_world, seed, options=OPTIONS, progress=progress).teach(
            *topics
        )
        for kind, topics in TOPICS.items()
    }
    known = {kind: teaching.library for kind, teaching in robots.items()}
    teacher = Teacher(squads_library(known), troops(known), seed, options={}, progress=progress)
    return Taught(robots, teacher.teach(*salvage_crew.TOPICS))
