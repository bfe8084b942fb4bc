"""The patrol taught with nothing but the features and behaviors that the paper lists (section 5.1).

No robot there knows that it searches in vain or gets nowhere, and no coordinator that an intruder has long been gone.
"""

from __future__ import annotations

from dataclasses import replace

from understudy.training.demonstrators import patrol, patrol_squad, patrol_wandering
from understudy.training.demonstrators.teacher import Case
from understudy.training.design import new_lesson

SERVO = replace(
    patrol.SERVO,
    choose=lambda library: new_lesson(
        library,
        "servo",
        parameters=["A"],
        states=["left", "right", "forward_left=forwards", "forward_right=forwards"],
        features=["blob_x(A)"],
    ),
)

ATTACK = replace(
    patrol.ATTACK,
    choose=lambda library: new_lesson(
        library,
        "attack",
        parameters=["A"],
        states=["servo(A)"],
        flags=["done"],
        features=["blob_size(A)"],
    ),
    cases=tuple(each for each in patrol.ATTACK.cases if each.practice in ("alone", "an intruder")),
)

COLLECTIVE_PATROL = replace(
    patrol_squad.COLLECTIVE_PATROL,
    choose=lambda library: new_lesson(
        library,
        "collective_patrol",
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)"],
    ),
    cases=(Case("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),),
)

ROBOTS = (patrol_wandering.DISPERSE, SERVO, ATTACK, patrol.SCATTER, patrol.RUN_AWAY, patrol.PATROL)
SQUADS = (COLLECTIVE_PATROL, patrol_squad.DEFER)
