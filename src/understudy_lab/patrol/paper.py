"""The patrol taught with nothing but the features and behaviors that the paper lists (section 5.1).

No robot there knows that it searches in vain or gets nowhere, and no coordinator that an intruder has long been gone.
"""

from __future__ import annotations

from dataclasses import replace

from understudy.training.lesson_design import new_lesson
from understudy_lab.tasks import patrol_squad_teacher, patrol_teacher, patrol_wander_teacher
from understudy_lab.teachers.teacher import Case

SERVO = replace(
    patrol_teacher.SERVO,
    choose=lambda library: new_lesson(
        library,
        "servo",
        parameters=["A"],
        states=["left", "right", "forward_left=forwards", "forward_right=forwards"],
        features=["blob_x(A)"],
    ),
)

ATTACK = replace(
    patrol_teacher.ATTACK,
    choose=lambda library: new_lesson(
        library,
        "attack",
        parameters=["A"],
        states=["servo(A)"],
        flags=["done"],
        features=["blob_size(A)"],
    ),
    cases=tuple(each for each in patrol_teacher.ATTACK.cases if each.practice in ("alone", "an intruder")),
)

COLLECTIVE_PATROL = replace(
    patrol_squad_teacher.COLLECTIVE_PATROL,
    choose=lambda library: new_lesson(
        library,
        "collective_patrol",
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)"],
    ),
    cases=(Case("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),),
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
