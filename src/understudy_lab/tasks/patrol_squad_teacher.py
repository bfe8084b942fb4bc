"""How a person teaches those who coordinate a patrol: CollectivePatrol and CollectivePatrolAndDefer (section 5.1)."""

from __future__ import annotations

from understudy.model.kinds import NO, YES
from understudy.training.lesson_design import new_lesson
from understudy.training.session_view import Screen
from understudy_lab.teachers.person import KEEP, after
from understudy_lab.teachers.teacher import Case, Topic


def show_collective_patrol(screen: Screen) -> str | None:
    """All attack when one sees an intruder, go home when one has it, disperse when all are home.

    Where nobody has seen it for a while, it is gone: disperse. Before that, and before all are home: keep on.
    """
    seen = screen.features
    if screen.state == "start":
        return "disperse"
    if screen.state == "disperse":
        return "attack" if seen["someone_sees(intruder)"] == YES else None
    if screen.state == "attack":
        if seen["someone_done"] == YES:
            return "home"
        if seen.get("seen_lately(intruder)") == NO:
            return "disperse"
        return KEEP if seen["someone_sees(intruder)"] == NO else None
    if seen["all_done"] == YES:
        return "disperse"
    return KEEP if seen["someone_done"] == YES and seen.get("seen_lately(intruder)") != YES else None


def complain_collective_patrol(screen: Screen) -> str | None:
    """As shown."""
    wished = show_collective_patrol(screen)
    return None if wished == KEEP else wished


def _sees_intruder(screen: Screen) -> bool:
    return screen.features["someone_sees(intruder)"] == YES


def _has_given_up(screen: Screen) -> bool:
    return screen.state == "disperse" and screen.time_s > 10.0


COLLECTIVE_PATROL = Topic(
    "collective_patrol",
    lambda library: new_lesson(
        library,
        "collective_patrol",
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)", "seen_lately(intruder)"],
    ),
    show_collective_patrol,
    complain_collective_patrol,
    after(200.0),
    cases=(
        Case("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),
        Case("an intruder that leaves", suits=_sees_intruder, enough=_has_given_up),
    ),
    tries=3,
    limit_s=240.0,
    patience_s=1000.0,
)


def show_defer(screen: Screen) -> str | None:
    """Run away from the boss; go on with the patrol when nobody has seen him for a while."""
    return "run_away" if screen.features["seen_lately(boss)"] == YES else "patrol"


DEFER = Topic(
    "collective_patrol_and_defer",
    lambda library: new_lesson(
        library,
        "collective_patrol_and_defer",
        states=["patrol=collective_patrol", "run_away"],
        features=["seen_lately(boss)"],
    ),
    show_defer,
    show_defer,
    after(150.0),
    cases=(Case("the boss comes", enough=lambda screen: screen.state == "patrol" and screen.time_s > 60.0),),
    tries=2,
    limit_s=200.0,
    patience_s=1000.0,
)

SQUAD_TOPICS = (COLLECTIVE_PATROL, DEFER)
