"""Teaching of the whole patrol: first its robots, then their coordinator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy_lab.patrol.practice import robots_world, scenario, squads_library, troops
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher, patrol_wander_teacher
from understudy_lab.teachers.live_teacher import choose_teacher
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Progress, Situation, TeachingResult


class PatrolTeaching(NamedTuple):
    """The results of teaching the robots and their coordinator."""

    robots: TeachingResult
    coordinators: TeachingResult


def teach(
    seed: int,
    topics: Sequence[LessonPlan] = patrol_teacher.TOPICS,
    squads: Sequence[LessonPlan] = patrol_squad_teacher.SQUAD_TOPICS,
    *,
    method: str = "watched",
    progress: Progress = lambda name, what, account: None,
) -> PatrolTeaching:
    """Teach robots and coordinator from empty libraries, live or as in the paper; a seed gives the same lessons."""
    make_teacher = choose_teacher(method)
    kit = make_scenario_kit(scenario())
    robots = make_teacher(Library(kit), robots_world, seed, options={}, progress=progress).teach(*topics)
    library = robots.library
    teacher = make_teacher(squads_library(library), troops(library), seed, options={}, progress=progress)
    return PatrolTeaching(robots, teacher.teach(*squads))


SERVO = replace(
    patrol_teacher.SERVO,
    design=LessonDesign(
        parameters=["A"],
        states=["left", "right", "forward_left=forwards", "forward_right=forwards"],
        features=["blob_x(A)"],
    ),
)

ATTACK = replace(
    patrol_teacher.ATTACK,
    design=LessonDesign(parameters=["A"], states=["servo(A)"], flags=["done"], features=["blob_size(A)"]),
    cases=tuple(each for each in patrol_teacher.ATTACK.cases if each.practice in ("alone", "an intruder")),
)

COLLECTIVE_PATROL = replace(
    patrol_squad_teacher.COLLECTIVE_PATROL,
    design=LessonDesign(
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)"],
    ),
    cases=(
        Situation("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),
    ),
)

ROBOTS = (
    patrol_wander_teacher.DISPERSE,
    SERVO,
    ATTACK,
    patrol_teacher.SCATTER,
    patrol_teacher.RUN_AWAY,
    patrol_teacher.PATROL,
)
SQUADS = (COLLECTIVE_PATROL, patrol_squad_teacher.DEFER)
