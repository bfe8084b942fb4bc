"""The simulated teacher of robots that pull crates and containers home, with others or alone, and of coordinators.

A robot that gets a new command while it pulls an object first brings it home if it moves, and lets go of it otherwise.
"""

from __future__ import annotations

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.swarm_motion_teacher import APPROACH, HAUL, STEER, WANDER, there, yes
from understudy_lab.teachers.person import KEEP, Seen, Wish, after, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

AT_M = 1.0
WAITS_S, AWAY_S, GIVES_UP_S, SLACK_S = 40.0, 15.0, 60.0, 3.0


def in_state(state: str, seconds: float = 0.0) -> Seen:
    """Return a predicate: the automaton is in `state` and at least `seconds` have passed since the practice began."""
    return lambda screen: screen.state == state and screen.time_s >= seconds


# Search: find objects that no robot pulls.


def _begun(screen: SessionView, then: str) -> str:
    if yes(screen, "enough") and screen.state == "start":
        return "haul"
    return "drop" if yes(screen, "holding") else then


def show_find(screen: SessionView) -> str | None:
    """Return the next state of Find, or None: wander until a crate or container is visible that no robot pulls."""
    if screen.flag:
        return None
    if there(screen, "free_container"):
        return "container_seen"
    if there(screen, "free_crate"):
        return "crate_seen"
    return "wander" if screen.state == "start" else None


def _sees(*things: str) -> Seen:
    return lambda screen: all(there(screen, f"free_{thing}") for thing in things)


def _nothing(screen: SessionView) -> bool:
    return not there(screen, "free_crate") and not there(screen, "free_container")


FIND = LessonPlan(
    "find",
    LessonDesign(
        states=["wander"],
        flags=["crate_seen", "container_seen"],
        features=["distance_to(free_crate)", "distance_to(free_container)"],
    ),
    show_find,
    show_find,
    lambda screen: has_raised_flag(screen) or screen.time_s > 60.0,
    cases=(
        Situation("crates nobody is at", suits=_nothing),
        Situation("containers nobody is at", suits=_nothing),
        Situation("crates nobody is at", suits=_sees("crate")),
        Situation("containers nobody is at", suits=_sees("container")),
        Situation("a field", suits=_sees("crate", "container")),
    ),
    tries=5,
    limit_s=120.0,
    patience_s=90.0,
)


def show_search(screen: SessionView) -> str | None:
    """Return the next state of Search, or None.

    The robot brings home what moves and lets go of what does not, then finds an object that no robot pulls and goes to
    it.
    """
    if screen.flag:
        return None
    if screen.state in ("start", "drop"):
        return _begun(screen, "find")
    if screen.state == "find":
        return next((thing for thing in ("container", "crate") if yes(screen, f"{thing}_seen")), None)
    if yes(screen, "done"):
        return "find" if screen.state == "haul" else "done"
    return "find" if yes(screen, "failed") else None


SEARCH = LessonPlan(
    "search",
    LessonDesign(
        states=[
            "find",
            "crate=approach(free_crate)",
            "container=approach(free_container)",
            "haul",
            "drop=let_go",
        ],
        flags=["done"],
        features=["done", "failed", "crate_seen", "container_seen", "holding", "enough"],
    ),
    show_search,
    show_search,
    lambda screen: has_raised_flag(screen) or screen.time_s > 90.0,
    cases=(
        Situation("crates nobody is at"),
        Situation("containers nobody is at"),
        Situation("holding in vain", enough=in_state("find")),
        Situation("holding a crate", enough=in_state("find", 5.0)),
        Situation("a crate that others take", enough=in_state("find", 1.5)),
        Situation("a container that others take", enough=in_state("find", 1.5)),
    ),
    tries=6,
    limit_s=120.0,
    patience_s=90.0,
)


# Help, muster: go to the robot that calls, hold its object, pull it home.


def _joins(name: str, thing: str, caller: str, calls: str) -> LessonPlan:
    free = f"distance_to(free_{thing})"

    def complain(screen: SessionView) -> str | None:
        if screen.state in ("start", "drop"):
            return _begun(screen, "call" if screen.features[free] < AT_M else "come")
        if screen.state == "wait":
            return "come" if there(screen, caller) else None
        if screen.state == "call" and screen.features[free] > AT_M and not yes(screen, "holding"):
            return "come"  # it calls from too far off to hold it
        if screen.state in ("call", "hold"):
            return "haul" if yes(screen, "enough") else None
        if yes(screen, "failed"):
            return "wait"
        return {"come": "hold", "haul": "wait"}.get(screen.state) if yes(screen, "done") else None

    def show(screen: SessionView) -> str | None:
        holds = screen.state in ("call", "hold") and yes(screen, "holding") and not yes(screen, "enough")
        waits = screen.state == "wait" and there(screen, f"free_{thing}") and not there(screen, caller)
        return KEEP if holds or waits else complain(screen)

    return LessonPlan(
        name,
        LessonDesign(
            states=[
                "wait=wander",
                f"come=approach({caller})",
                f"call={calls}",
                "hold",
                "haul",
                "drop=let_go",
            ],
            features=["done", "failed", "holding", "enough", free, f"distance_to({caller})"],
        ),
        show,
        complain,
        after(60.0),
        cases=(
            Situation(f"beside a {thing}", enough=_waits),
            Situation(
                f"someone calls in vain at a {thing}",
                suits=lambda screen: there(screen, caller) and not there(screen, f"free_{thing}"),
                enough=_holds,
            ),
            Situation(
                f"someone calls late at a {thing}",
                suits=lambda screen: not there(screen, f"free_{thing}"),
                enough=_holds,
            ),
            Situation(f"at a {thing}", enough=_waits),
            Situation(f"in vain at a {thing}", enough=after(5.0)),
            Situation(f"a {name} that stops", enough=after(8.0)),
            Situation("holding in vain", enough=after(4.0)),
            Situation("holding in vain what others claim", enough=after(4.0)),
            Situation("holding a crate", enough=_waits),
            Situation("losing hands", enough=after(4.0)),
            Situation(
                f"{thing}s nobody is at",
                suits=lambda screen: (
                    screen.features[free] > AT_M
                ),  # it is seen, and not for this robot to call at
                enough=lambda screen: _waits(screen) and screen.time_s > 8.0,
            ),
        ),
        tries=11,
        limit_s=120.0,
        patience_s=70.0,
        tries_cases=True,
    )


def _waits(screen: SessionView) -> bool:
    return screen.state == "wait"


def _holds(screen: SessionView) -> bool:
    return screen.state == "hold" and yes(screen, "holding")


HELP = _joins("help", "crate", "caller", "hold_and_call")
MUSTER = _joins("muster", "container", "musterer", "hold_and_muster")


# By themselves, without a coordinator.


ANSWERED = (
    Situation(
        "someone calls in vain at a crate",
        enough=lambda screen: screen.state == "search" and screen.time_s > 60.0,
    ),
    Situation(
        "someone calls late at a crate",
        enough=lambda screen: screen.state == "help" and screen.time_s > 8.0,
    ),
)


def _alone(*, answers: bool) -> LessonPlan:
    waiting = {"call": WAITS_S, "help": GIVES_UP_S}

    def wish(slack_s: float) -> Wish:
        def wished(screen: SessionView) -> str | None:
            late = screen.features["time_in_state"] - slack_s
            keep = None if slack_s else KEEP
            then = "help" if answers and there(screen, "caller") else "search"
            if screen.state == "start":
                return then
            if screen.state == "search":
                return (
                    "call"
                    if yes(screen, "done")
                    else then
                    if then == "help"
                    else keep
                    if late > 10.0
                    else None
                )
            if screen.state in waiting:
                if screen.state == "call" and yes(screen, "enough"):
                    return "haul"
                most = waiting[screen.state]
                return "leave" if late > most else keep if late > 0.6 * most else None
            if screen.state == "haul":
                return then if yes(screen, "done") else keep if late > 5.0 else None
            if screen.state == "leave":
                return "away" if not yes(screen, "holding") else None
            return then if late > AWAY_S else keep if late > 0.6 * AWAY_S else None

        return wished

    name = "alone_answering" if answers else "alone"
    return LessonPlan(
        name,
        LessonDesign(
            states=[
                "search",
                "call=hold_and_call",
                "haul",
                *(["help"] if answers else []),
                "leave=let_go",
                "away=wander",
            ],
            features=[
                "done",
                "enough",
                "holding",
                "time_in_state",
                *(["distance_to(caller)"] if answers else []),
            ],
        ),
        wish(0.0),
        wish(SLACK_S),
        after(150.0),
        cases=(
            Situation("a crate", enough=lambda screen: screen.state == "search" and screen.time_s > 25.0),
            Situation("a field", enough=lambda screen: screen.state == "search" and screen.time_s > 25.0),
            Situation("alone", enough=lambda screen: screen.state == "search" and screen.time_s > 11.0),
            Situation(
                "crates in vain", enough=lambda screen: screen.state == "search" and screen.time_s > 50.0
            ),
            *(ANSWERED if answers else ()),
        ),
        tries=3,
        limit_s=200.0,
        patience_s=70.0,
    )


ALONE, ANSWERING = _alone(answers=False), _alone(answers=True)

TOPICS = (WANDER, APPROACH, STEER, HAUL, FIND, SEARCH, HELP, MUSTER, ALONE, ANSWERING)


# Three levels of coordinators: squads, platoons, and the whole swarm.


QUIET_S, HESITATES_S = 3.0, 1.5
"""The time in s until an unheard call ends the joint work, and, taught live, the time in which members that work again
may join again by themselves."""


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
