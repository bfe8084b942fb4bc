"""One teaching of the whole patrol: first its robots, then their coordinator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from understudy.model.library import Library
from understudy.sim.kit import kit_of
from understudy_lab.patrol.practice import robots_world, scenario, squads_library, troops
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher
from understudy_lab.teachers.teacher import Progress, Teacher, Teaching, Topic


class Taught(NamedTuple):
    """What the robots and what their coordinator were taught."""

    robots: Teaching
    coordinators: Teaching


def teach(
    seed: int,
    topics: Sequence[Topic] = patrol_teacher.TOPICS,
    squads: Sequence[Topic] = patrol_squad_teacher.SQUAD_TOPICS,
    *,
    progress: Progress = lambda name, what, account: None,
) -> Taught:
    """Teach everything from nothing; the same seed, the same lessons."""
    kit = kit_of(scenario())
    robots = Teacher(Library(kit), robots_world, seed, options={}, progress=progress).teach(*topics)
    library = robots.library
    teacher = Teacher(squads_library(library), troops(library), seed, options={}, progress=progress)
    return Taught(robots, teacher.teach(*squads))
