"""Teaching of the whole patrol: first its robots, then their coordinator."""

from __future__ import annotations

from dataclasses import replace

from understudy_lab.patrol.practice import ROBOT, SQUAD, robots_world, scenario, squad_practices
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher, patrol_wander_teacher
from understudy_lab.teachers.teacher import LessonDesign, Situation
from understudy_lab.teams import TeamCourse

COURSE = TeamCourse(
    scenario,
    {ROBOT: patrol_teacher.TOPICS, SQUAD: patrol_squad_teacher.SQUAD_TOPICS},
    robots_world,
    squad_practices,
)
teach = COURSE.teach
"""Teach the robots of a patrol and their coordinator."""


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

PAPERS_TOPICS = {
    ROBOT: (
        patrol_wander_teacher.DISPERSE,
        SERVO,
        ATTACK,
        patrol_teacher.SCATTER,
        patrol_teacher.RUN_AWAY,
        patrol_teacher.PATROL,
    ),
    SQUAD: (COLLECTIVE_PATROL, patrol_squad_teacher.DEFER),
}
"""The lessons with the features of the paper."""
