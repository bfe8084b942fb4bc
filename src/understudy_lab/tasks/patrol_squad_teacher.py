"""The simulated teacher of a patrol's coordinators: CollectivePatrol and CollectivePatrolAndDefer (section 5.1)."""

from __future__ import annotations

from understudy.model.value_kinds import NO, YES
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, Wish, after, has_raised_flag, never_confirm
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation


def show_collective_patrol(screen: SessionView) -> str | None:
    """Return the next state while demonstrating CollectivePatrol; None for no change, KEEP to confirm the current.

    All robots attack when one sees an intruder, go home when one has reached it, and disperse when all are home or when
    no robot has seen the intruder for a while.
    """
    seen = screen.features
    if screen.state != "home":
        return _pursue(screen, then="home")
    if seen["all_done"] == YES:
        return "disperse"
    return KEEP if seen["someone_done"] == YES and seen.get("seen_lately(intruder)") != YES else None


def _pursue(screen: SessionView, *, then: str) -> str | None:
    """Return the next state: all attack when one sees an intruder, and do what comes then when one has reached it."""
    seen = screen.features
    if screen.state == "start":
        return "disperse"
    if screen.state == "disperse":
        return "attack" if seen["someone_sees(intruder)"] == YES else None
    if seen["someone_done"] == YES:
        return then
    if seen.get("seen_lately(intruder)") == NO:
        return "disperse"
    return KEEP if seen["someone_sees(intruder)"] == NO else None


def _sees_intruder(screen: SessionView) -> bool:
    return screen.features["someone_sees(intruder)"] == YES


def _has_given_up(screen: SessionView) -> bool:
    return screen.state == "disperse" and screen.time_s > 10.0


COLLECTIVE_PATROL = LessonPlan(
    "collective_patrol",
    LessonDesign(
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["all_done", "someone_done", "someone_sees(intruder)", "seen_lately(intruder)"],
    ),
    show_collective_patrol,
    never_confirm(show_collective_patrol),
    after(200.0),
    cases=(
        Situation("on patrol", enough=lambda screen: screen.state == "disperse" and screen.time_s > 60.0),
        Situation("an intruder that leaves", suits=_sees_intruder, enough=_has_given_up),
    ),
    tries=3,
    limit_s=240.0,
    patience_s=1000.0,
)


def show_defer(screen: SessionView) -> str | None:
    """Return the state of CollectivePatrolAndDefer: run away while the boss was seen lately, otherwise patrol."""
    return "run_away" if screen.features["seen_lately(boss)"] == YES else "patrol"


DEFER = LessonPlan(
    "collective_patrol_and_defer",
    LessonDesign(states=["patrol=collective_patrol", "run_away"], features=["seen_lately(boss)"]),
    show_defer,
    show_defer,
    after(150.0),
    cases=(
        Situation("the boss comes", enough=lambda screen: screen.state == "patrol" and screen.time_s > 60.0),
    ),
    tries=2,
    limit_s=200.0,
    patience_s=1000.0,
    skips_after=0,
)

SQUAD_TOPICS = (COLLECTIVE_PATROL, DEFER)


# Hunt: one patrol looks for an intruder until one of its robots has it.


def show_hunt(screen: SessionView) -> str | None:
    """Return the next state while demonstrating Hunt; None for no change, KEEP to confirm the current state.

    All robots attack when one sees an intruder, are done when one has reached it, and disperse again when none has
    seen it for a while.
    """
    return None if screen.state == "done" else _pursue(screen, then="done")


HUNT = LessonPlan(
    "hunt",
    LessonDesign(
        states=["disperse", "attack=attack(intruder)"],
        flags=["done"],
        features=["someone_done", "someone_sees(intruder)", "seen_lately(intruder)"],
    ),
    show_hunt,
    never_confirm(show_hunt),
    lambda screen: has_raised_flag(screen) or screen.time_s > 200.0,
    cases=(
        Situation("on patrol"),
        Situation("an intruder that leaves", suits=_sees_intruder, enough=_has_given_up),
    ),
    tries=3,
    limit_s=240.0,
    patience_s=1000.0,
    skips_after=0,
)


# Come(A): all go to A; where that takes long, some are in the others' way, and all make room before they go on.

COMES_S, APART_S = 40.0, 6.0


def _come(slack_s: float) -> Wish:
    def wished(screen: SessionView) -> str | None:
        if screen.state == "start":
            return "go"
        limit, following = (COMES_S, "apart") if screen.state == "go" else (APART_S, "go")
        return following if screen.features["time_in_state"] >= limit + slack_s else None

    return wished


COME = LessonPlan(
    "come",
    LessonDesign(parameters=["A"], states=["go=attack(A)", "apart=disperse"], features=["time_in_state"]),
    _come(0.0),
    _come(2.0),
    after(2.0 * COMES_S),
    cases=(Situation("on patrol", {"A": "home"}),),
    tries=1,
    limit_s=240.0,
    patience_s=1000.0,
    skips_after=0,
)


# Gather(A): all come to A, and it is done when all are there.


def show_gather(screen: SessionView) -> str | None:
    """Return the next state of Gather(A): all robots come to A, and `done` is raised when all are there."""
    if screen.state == "start":
        return "come"
    if screen.state == "done":
        return None
    if screen.features["all_done"] == YES:
        return "done"
    return KEEP if screen.features["someone_done"] == YES else None


GATHER = LessonPlan(
    "gather",
    LessonDesign(parameters=["A"], states=["come(A)"], flags=["done"], features=["all_done", "someone_done"]),
    show_gather,
    never_confirm(show_gather),
    has_raised_flag,
    cases=(Situation("on patrol", {"A": "home"}),),
    tries=2,
    limit_s=240.0,
    patience_s=1000.0,
    skips_after=0,
)


# Guard: all patrols hunt together, and gather each at its own home.


def show_guard(screen: SessionView) -> str | None:
    """Return the next state of Guard: hunt until one patrol is done, then gather until all patrols are done."""
    seen = screen.features
    if screen.state == "start":
        return "hunt"
    if screen.state == "hunt":
        return "gather" if seen["someone_done"] == YES else None
    if seen["all_done"] == YES:
        return "hunt"
    return KEEP if seen["someone_done"] == YES else None


GUARD = LessonPlan(
    "guard",
    LessonDesign(states=["hunt", "gather=gather_all"], features=["all_done", "someone_done"]),
    show_guard,
    never_confirm(show_guard),
    after(120.0),
    cases=(Situation("on guard", enough=lambda screen: screen.state == "hunt" and screen.time_s > 60.0),),
    tries=2,
    limit_s=240.0,
    patience_s=1000.0,
    skips_after=0,
)

PATROL_TOPICS = (HUNT, COME, GATHER)
GUARD_TOPICS = (GUARD,)
