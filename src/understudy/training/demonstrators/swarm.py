"""How a person teaches robots to pull crates and containers home together, or by themselves.

Whoever is ordered about while it pulls what moves brings that home first, and lets go of what does not move.
"""

from __future__ import annotations

from math import isnan, pi, tau

from understudy.model.kinds import YES
from understudy.training.demonstrators.patrol import after, raised
from understudy.training.demonstrators.person import KEEP, Seen, Wish
from understudy.training.demonstrators.teacher import Case, Push, Topic
from understudy.training.design import new_lesson
from understudy.training.screen import Screen

SELDOM, OFTEN = 0.06, 0.3
"""Chances drawn each second: below the first it turns from time to time, from the second on it drives on."""
THERE_M, NOT_THERE_M, PAST_M = 0.4, 0.6, 0.25
ASTRAY, FACING = 0.65, 0.4  # it turns on while the hand moves
AT_M = 1.0
WAITS_S, AWAY_S, GIVES_UP_S, SLACK_S = 40.0, 15.0, 60.0, 3.0


def yes(screen: Screen, feature: str) -> bool:
    """Whether a feature reads yes."""
    return screen.features.get(feature) == YES


def there(screen: Screen, target: str) -> bool:
    """Whether a target is sensed."""
    return not isnan(screen.features[f"distance_to({target})"])


def in_state(state: str, seconds: float = 0.0) -> Seen:
    """So far shown."""
    return lambda screen: screen.state == state and screen.time_s >= seconds


# Wander: drive on, turn from time to time and at walls.


def show_wander(screen: Screen) -> str | None:
    """Drive; turn where it is stuck, and now and then."""
    chance = screen.features["chance"]
    if screen.state == "left":
        return "forward" if chance > OFTEN else None
    if screen.state == "start":
        return "forward"
    if yes(screen, "stuck") or chance < SELDOM:
        return "left"
    return KEEP if 2 * SELDOM < chance < OFTEN else None


def complain_wander(screen: Screen) -> str | None:
    """Where it stays stuck, or does not begin."""
    if screen.state == "forward":
        return "left" if yes(screen, "stuck") else None
    return "forward" if screen.state == "start" or screen.features["chance"] > 2 * OFTEN else None


WANDER = Topic(
    "wander",
    lambda library: new_lesson(
        library, "wander", states=["forward", "left=rotate_left"], features=["stuck", "chance"]
    ),
    show_wander,
    complain_wander,
    after(60.0),
    cases=(Case("alone", enough=after(50.0)),),
    tries=2,
    limit_s=90.0,
    patience_s=70.0,
)


# Approach(A), and home with what is pulled.


def _off(screen: Screen, target: str) -> float:
    return (screen.features[f"angle_to({target})"] + pi) % tau - pi


def _turned(state: str, off: float, *, astray: float, facing: float) -> str | None:
    toward = "rotate_left" if off > 0 else "rotate_right"
    if state in ("start", "forward"):
        return toward if abs(off) > astray else "forward" if state == "start" else None
    ahead = off if state == "rotate_left" else -off
    return "forward" if -pi / 2 < ahead < facing else None


def show_approach(screen: Screen) -> str | None:
    """Turn to A, drive to it, say done; failed where there is none."""
    if screen.flag:
        return None
    if not there(screen, "A"):
        return "failed"
    if screen.features["distance_to(A)"] < THERE_M:
        return "done"
    return _turned(screen.state, _off(screen, "A"), astray=ASTRAY, facing=FACING)


def complain_approach(screen: Screen) -> str | None:
    """Driving past A, turning past it, saying done too early."""
    distance = screen.features["distance_to(A)"]
    if screen.flag == "done":
        return "forward" if distance > NOT_THERE_M else None
    if screen.flag:
        return "forward" if there(screen, "A") else None
    if isnan(distance):
        return "failed"
    if distance < PAST_M:
        return "done"
    return _turned(screen.state, _off(screen, "A"), astray=1.5 * ASTRAY, facing=-ASTRAY)


def _beside(side: int) -> Seen:
    return lambda screen: 0.8 < side * _off(screen, "A") < 2.6


def _behind(side: int) -> Seen:
    return lambda screen: 1.7 < side * _off(screen, "A") < 2.8


APPROACH = Topic(
    "approach",
    lambda library: new_lesson(
        library,
        "approach",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done", "failed"],
        features=["distance_to(A)", "angle_to(A)"],
    ),
    show_approach,
    complain_approach,
    raised,
    cases=(
        Case("alone", {"A": "home"}, _beside(1), push=Push("forward", "rotate_right", 0.8)),
        Case("alone", {"A": "home"}, _beside(-1), push=Push("forward", "rotate_left", 0.8)),
        Case("a crate", {"A": "crate"}, _beside(1)),
        Case("a crate", {"A": "crate"}, _beside(-1)),
        Case("alone", {"A": "caller"}),
        Case("a help that stops", {"A": "caller"}),
        Case("a help that stops soon", {"A": "caller"}, _behind(1)),
        Case("a help that stops soon", {"A": "caller"}, _behind(-1)),
    ),
    tries=8,
    limit_s=60.0,
)


def _steer(facing: float, astray: float) -> Wish:
    return lambda screen: _turned(screen.state, _off(screen, "home"), astray=astray, facing=facing)


STEER = Topic(
    "steer",
    lambda library: new_lesson(
        library,
        "steer",
        states=["forward=pull_forward", "rotate_left=pull_left", "rotate_right=pull_right"],
        features=["angle_to(home)"],
    ),
    _steer(FACING, ASTRAY),
    _steer(-ASTRAY, 2 * ASTRAY),
    after(15.0),
    cases=(
        Case(
            "alone",
            suits=lambda screen: _off(screen, "home") > 0.8,
            enough=after(8.0),
            push=Push("forward", "rotate_right", 0.8),
        ),
        Case(
            "alone",
            suits=lambda screen: _off(screen, "home") < -0.8,
            enough=after(8.0),
            push=Push("forward", "rotate_left", 0.8),
        ),
    ),
    tries=4,
    limit_s=40.0,
)


def show_haul(screen: Screen) -> str | None:
    """Home with what moves; what does not, it lets go."""
    if screen.flag:
        return None
    if yes(screen, "enough"):
        return "steer"
    return "drop" if yes(screen, "holding") else "done"


HAUL = Topic(
    "haul",
    lambda library: new_lesson(
        library,
        "haul",
        states=["steer", "drop=let_go"],
        flags=["done"],
        features=["enough", "holding"],
    ),
    show_haul,
    show_haul,
    raised,
    cases=(Case("holding a crate"), Case("holding in vain"), Case("losing hands"), Case("alone")),
    tries=4,
    limit_s=90.0,
    patience_s=70.0,
)


# Search: find what nobody pulls.


def _begun(screen: Screen, then: str) -> str:
    if yes(screen, "enough") and screen.state == "start":
        return "haul"
    return "drop" if yes(screen, "holding") else then


def show_search(screen: Screen) -> str | None:
    """Bring home what moves, let go of the rest; wander, and go to what nobody pulls."""
    if screen.flag:
        return None
    found = (
        "container" if there(screen, "free_container") else "crate" if there(screen, "free_crate") else None
    )
    if screen.state in ("start", "drop"):
        return _begun(screen, found or "wander")
    if screen.state == "wander":
        return found
    if yes(screen, "done"):
        return "wander" if screen.state == "haul" else "done"
    return "wander" if yes(screen, "failed") else None


SEARCH = Topic(
    "search",
    lambda library: new_lesson(
        library,
        "search",
        states=[
            "wander",
            "crate=approach(free_crate)",
            "container=approach(free_container)",
            "haul",
            "drop=let_go",
        ],
        flags=["done"],
        features=[
            "done",
            "failed",
            "holding",
            "enough",
            "distance_to(free_crate)",
            "distance_to(free_container)",
        ],
    ),
    show_search,
    show_search,
    lambda screen: raised(screen) or screen.time_s > 90.0,
    cases=(
        Case("a field"),
        Case("a crate"),
        Case("a container"),
        Case("holding in vain", enough=in_state("wander")),
        Case("holding a crate", enough=in_state("wander", 5.0)),
        Case("a crate that others take", enough=in_state("wander", 3.0)),
    ),
    tries=6,
    limit_s=120.0,
    patience_s=70.0,
)


# Help, muster: to who calls, hold what they hold, pull it home.


def _joins(name: str, thing: str, caller: str, calls: str) -> Topic:
    free = f"distance_to(free_{thing})"

    def complain(screen: Screen) -> str | None:
        if screen.state in ("start", "drop"):
            return _begun(screen, "call" if screen.features[free] < AT_M else "come")
        if screen.state == "wait":
            return "come" if there(screen, caller) else None
        if screen.state in ("call", "hold"):
            return "haul" if yes(screen, "enough") else None
        if yes(screen, "failed"):
            return "wait"
        return {"come": "hold", "haul": "wait"}.get(screen.state) if yes(screen, "done") else None

    def show(screen: Screen) -> str | None:
        waits = screen.state in ("call", "hold") and yes(screen, "holding") and not yes(screen, "enough")
        return KEEP if waits else complain(screen)

    return Topic(
        name,
        lambda library: new_lesson(
            library,
            name,
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
            Case(f"beside a {thing}", enough=_waits),
            Case(f"someone calls in vain at a {thing}", enough=after(20.0)),
            Case(f"at a {thing}", enough=_waits),
            Case(f"in vain at a {thing}", enough=after(5.0)),
            Case(f"a {name} that stops", enough=after(8.0)),
            Case("holding in vain", enough=after(4.0)),
            Case("holding in vain what others claim", enough=after(4.0)),
            Case("holding a crate", enough=_waits),
            Case("losing hands", enough=after(4.0)),
        ),
        tries=9,
        limit_s=120.0,
        patience_s=70.0,
    )


def _waits(screen: Screen) -> bool:
    return screen.state == "wait"


HELP = _joins("help", "crate", "caller", "hold_and_call")
MUSTER = _joins("muster", "container", "musterer", "hold_and_muster")


# By themselves, with nobody to coordinate them.


def _alone(*, answers: bool) -> Topic:
    waiting = {"call": WAITS_S, "help": GIVES_UP_S}

    def wish(slack_s: float) -> Wish:
        def wished(screen: Screen) -> str | None:
            late = screen.features["time_in_state"] - slack_s
            keep = None if slack_s else KEEP
            if screen.state in ("start", "search"):
                if screen.state == "search" and yes(screen, "done"):
                    return "call"
                if answers and there(screen, "caller"):
                    return "help"
                return "search" if screen.state == "start" else keep if late > 3.0 else None
            if screen.state in waiting:
                if screen.state == "call" and yes(screen, "enough"):
                    return "haul"
                most = waiting[screen.state]
                return "leave" if late > most else keep if late > 0.6 * most else None
            if screen.state == "haul":
                return "search" if yes(screen, "done") else keep if late > 5.0 else None
            if screen.state == "leave":
                return "away" if not yes(screen, "holding") else None
            return "search" if late > AWAY_S else keep if late > 0.6 * AWAY_S else None

        return wished

    name = "alone_answering" if answers else "alone"
    return Topic(
        name,
        lambda library: new_lesson(
            library,
            name,
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
            Case("a crate", enough=lambda screen: screen.state == "search" and screen.time_s > 25.0),
            Case("a field", enough=lambda screen: screen.state == "search" and screen.time_s > 25.0),
            Case("crates in vain", enough=lambda screen: screen.state == "search" and screen.time_s > 50.0),
            *(
                [
                    Case(
                        "someone calls in vain at a crate",
                        enough=lambda screen: screen.state == "search" and screen.time_s > 60.0,
                    )
                ]
                if answers
                else []
            ),
        ),
        tries=3,
        limit_s=200.0,
        patience_s=70.0,
    )


ALONE, ANSWERING = _alone(answers=False), _alone(answers=True)

TOPICS = (WANDER, APPROACH, STEER, HAUL, SEARCH, HELP, MUSTER, ALONE, ANSWERING)
