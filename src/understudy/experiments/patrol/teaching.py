"""One teaching of the whole patrol: first its robots, then their coordinator."""

from __future__ import annotations

from typing import NamedTuple

from understudy.experiments.patrol.practice import robots_world, scenario, squads_library, troops
from understudy.model.library import Library
from understudy.training.demonstrators import patrol, patrol_squad
from understudy.training.demonstrators.teacher import Teacher, Teaching
from understudy.worlds.kits import kit_of


class Taught(NamedTuple):
    """What the robots and what their coordinator were taught."""

    robots: Teaching
    coordinators: Teaching


def teach(seed: int) -> Taught:
    """Teach everything from nothing; the same seed, the same lessons."""
    robots = Teacher(Library(kit_of(scenario())), robots_world, seed, options={}).teach(*patrol.TOPICS)
    library = robots.library
    teacher = Teacher(squads_library(library), troops(library), seed, options={})
    return Taught(robots, teacher.teach(*patrol_squad.TOPICS))
