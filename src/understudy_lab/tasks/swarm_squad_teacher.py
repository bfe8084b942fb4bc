"""The simulated teacher of the three levels of coordinators of a swarm: squads, platoons, and the whole swarm."""

from __future__ import annotations

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, Wish, after
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

QUIET_S, SLACK_S, HESITATES_S = 3.0, 3.0, 1.5
"""The time in s until an unheard call ends the joint work, the extra time before the teacher corrects, and, taught
live, the time in which members that work again may join again by themselves."""


def _joint(
    name: str, works: str, joins: str, found: str, call: str, most_s: float, practices: str
) -> LessonPlan:
    """Return the plan of a coordinator whose members work until one finds something, and then all join it.

    They work again when no robot calls any more or after `most_s` seconds.
    """

    def wish(slack_s: float) -> Wish:
        def wished(screen: SessionView) -> str | None:
            seen = screen.features
            if screen.state == "start":
                return "work"
            if screen.state == "work":
                idle = not slack_s and seen["time_in_state"] > 0.8
                return "join" if seen[found] == YES else KEEP if idle else None
            late = seen["time_in_state"] - slack_s
            if late > most_s or (late > QUIET_S and seen[call] == YES):
                return "work"
            return KEEP if not slack_s and late > 0.6 * most_s else None

        return wished

    def wish_live(screen: SessionView) -> str | None:
        seen = screen.features
        called = seen[found] != YES and seen[call] != YES and seen["time_in_state"] > QUIET_S
        if screen.state == "join" and called:  # joint work goes on although nothing is found any more
            return wish(SLACK_S)(screen) or KEEP
        if screen.state != "work":
            return wish(SLACK_S)(screen)
        return wish(0.0)(screen) if seen["time_in_state"] > HESITATES_S else None

    def accept(screen: SessionView, proposed: str) -> bool:
        gives_up = screen.state == "join" and screen.features["time_in_state"] > 0.7 * most_s
        return gives_up and proposed == "work"

    return LessonPlan(
        name,
        LessonDesign(states=[f"work={works}", f"join={joins}"], features=[found, call, "time_in_state"]),
        wish(0.0),
        wish(SLACK_S),
        after(150.0),
        cases=(
            Situation(f"{practices} at work", enough=_works_again),
            Situation(f"{practices} in vain", enough=_works_again),
        ),
        tries=2,
        limit_s=300.0,
        patience_s=130.0,
        complain_live=wish_live,
        accepts=accept,
    )


def _works_again(screen: SessionView) -> bool:
    return screen.state == "work" and screen.time_s - screen.features["time_in_state"] > 2.0


SQUAD = _joint("squad_work", "search", "help", "someone_at(free_crate)", "unheard(caller)", 60.0, "squad")
PLATOON = _joint(
    "platoon_work", "squad_work", "muster", "found(free_container)", "unheard(musterer)", 120.0, "platoon"
)

SPREAD_S = 10.0


def _spread(slack_s: float) -> Wish:
    def wished(screen: SessionView) -> str | None:
        if screen.state == "start":
            return "spread"
        late = screen.features["time_in_state"] - slack_s > SPREAD_S
        return "work" if screen.state == "spread" and late else None

    return wished


SWARM = LessonPlan(
    "swarm_work",
    LessonDesign(states=["spread=forward", "work=platoon_work"], features=["time_in_state"]),
    _spread(0.0),
    _spread(SLACK_S),
    after(20.0),
    cases=(Situation("all"),),
    tries=1,
    limit_s=40.0,
    patience_s=100.0,
)
