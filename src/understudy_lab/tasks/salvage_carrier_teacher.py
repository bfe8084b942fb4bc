"""The simulated teacher of carriers, which bring home the contents of wrecks, alone or guided by a scout."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.patrol_wander_teacher import make_timed_sequence
from understudy_lab.tasks.salvage_scout_teacher import (
    goto,
    is_done,
    raised_or_after,
    roam,
    sees_wreck,
)
from understudy_lab.teachers.person import KEEP, Wish, after, find_bearing, has_raised_flag, never_confirm
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

CAPACITY = 4
"""Largest number of units that a carrier can carry."""
BEHIND = 0.2  # rad: as good as having it behind
LOOKED_S = 45.0  # the time for which a carrier looks around for itself where its scout has found nothing


# What carriers do: Take what is in a wreck; Search one by themselves, or Fetch where a scout is; Deposit; and Gather or
# Haul, which is both in turn.


def _taking(back: str) -> Wish:
    """Return the rule of a state that takes from a wreck: `done` when finished, `back` when the wreck has disappeared.

    KEEP confirms the state while the carrier loads, because loading is no reason to leave it.
    """

    def wished(screen: SessionView) -> str | None:
        if is_done(screen):
            return "done"
        return back if not sees_wreck(screen) else KEEP if "load" in screen.path else None

    return wished


def show_take(screen: SessionView) -> str | None:
    """Return the next state of Take, or None: go to a wreck and load until full, or go to another when it is empty."""
    if screen.state in ("start", "done"):
        return None if screen.state == "done" else "goto"
    if screen.state == "goto":
        return "load" if is_done(screen) else None
    return (
        "done"
        if screen.features["stored"] >= CAPACITY
        else None
        if screen.features["salvage_here"] > 0
        else "goto"
    )


def show_search(screen: SessionView) -> str | None:
    """Return the next state of Search: roam until a wreck is visible, take its contents, roam again when it is gone."""
    if screen.state == "done":
        return None
    if screen.state == "take":
        return _taking("roam")(screen)
    return "take" if sees_wreck(screen) else "roam"


def show_fetch(screen: SessionView) -> str | None:
    """Return the next state of Fetch: go to a scout and take from the wreck there; roam where there is no wreck."""
    if screen.state == "done":
        return None
    if screen.state == "take":
        return _taking("follow")(screen)
    if sees_wreck(screen):
        return "take"
    if screen.state != "start" and not is_done(screen):
        return None
    return "look" if screen.state == "follow" else "follow"


def show_deposit(screen: SessionView) -> str | None:
    """Return the next state of Deposit, or None: go to the harbor and unload; done when nothing is left to unload."""
    if screen.state == "done":
        return None
    if screen.features["stored"] == 0:
        return "done"
    if screen.state == "goto":
        return "unload" if is_done(screen) else None
    return "goto" if screen.state == "start" or screen.features["at_harbor"] != YES else None


def _in_turn(bring: str) -> Wish:
    """Return a rule that alternates between `bring` and `deposit`; a loaded robot starts with `deposit`."""

    def wished(screen: SessionView) -> str | None:
        if screen.state == "start":
            return "deposit" if screen.features["stored"] > 0 else bring
        if not is_done(screen):
            return None
        return "deposit" if screen.state == bring else bring

    return wished


def show_return(screen: SessionView) -> str | None:
    """Return the next state of Return: as Gather, but turn around at the harbor, to leave toward the last wreck."""
    if screen.state == "turn":
        return "search" if abs(find_bearing(screen, "harbor")) > pi - BEHIND else None
    wished = _in_turn("search")(screen)
    return "turn" if screen.state == "deposit" and wished == "search" else wished


TAKE = LessonPlan(
    "take",
    LessonDesign(states=["goto(wreck)", "load"], flags=["done"], features=["done", "stored", "salvage_here"]),
    show_take,
    show_take,
    has_raised_flag,
    cases=(Situation("a carrier at a wreck"), Situation("a carrier at wrecks with little in them")),
    tries=4,
    limit_s=90.0,
)

SEARCH = LessonPlan(
    "search",
    LessonDesign(states=["roam", "take"], flags=["done"], features=["done", "distance_to(wreck)"]),
    show_search,
    never_confirm(show_search),
    raised_or_after(90.0),
    cases=(Situation("a carrier, wrecks about"), Situation("a carrier, wrecks that others empty")),
    tries=4,
    limit_s=120.0,
    patience_s=60.0,
)

LOOK = make_timed_sequence("look", [("walk", "roam", LOOKED_S)], "done", "a carrier alone")

FETCH = LessonPlan(
    "fetch",
    LessonDesign(
        states=["follow=goto(scout)", "take", "look"], flags=["done"], features=["done", "distance_to(wreck)"]
    ),
    show_fetch,
    never_confirm(show_fetch),
    raised_or_after(120.0),
    cases=(
        Situation("a carrier, a scout at a wreck"),
        Situation("a carrier, a scout somewhere else", enough=after(90.0)),
        Situation("a carrier, a scout at a wreck that others empty"),
    ),
    tries=4,
    limit_s=150.0,
    patience_s=60.0,
)

DEPOSIT = LessonPlan(
    "deposit",
    LessonDesign(states=["goto(harbor)", "unload"], flags=["done"], features=["done", "stored", "at_harbor"]),
    show_deposit,
    show_deposit,
    has_raised_flag,
    cases=(
        Situation("a carrier with one unit"),
        Situation(
            "a carrier with a load",
            push=PushAway("unload", "forward", 6.0),
            enough=lambda screen: screen.state == "goto",
        ),
    ),
    tries=3,
    limit_s=120.0,
)


def _both(name: str, bring: str, practice: str) -> LessonPlan:
    """Return the plan of a lesson that alternates between the behavior `bring` and `deposit`."""
    return LessonPlan(
        name,
        LessonDesign(states=[bring, "deposit"], features=["done", "stored"]),
        _in_turn(bring),
        _in_turn(bring),
        after(240.0),
        cases=(
            Situation(practice, enough=after(160.0)),
            Situation(f"{practice}, with a load", enough=after(5.0)),
        ),
        tries=2,
        limit_s=300.0,
        patience_s=60.0,
    )


GATHER = _both("gather", "search", "a carrier, wrecks about")
HAUL = _both("haul", "fetch", "a carrier, a scout at a wreck")

RETURN = replace(
    _both("return", "search", "a carrier, wrecks about"),
    design=LessonDesign(
        states=["search", "deposit", "turn=rotate_left"], features=["done", "stored", "angle_to(harbor)"]
    ),
    show=show_return,
    complain=show_return,
)

CARRIERS = (
    roam("carrier", near_m=0.9, clear_m=1.7, bump_m=0.5, wide_m=2.1),
    goto("carrier", ["harbor", "scout"], far_m=8.0, there_m=0.7, beyond_m=0.95, past_m=0.35),
    TAKE,
    SEARCH,
    LOOK,
    FETCH,
    DEPOSIT,
    GATHER,
    RETURN,
    HAUL,
)


def show_lead(screen: SessionView) -> str | None:
    """Return a leader's command: `work` when all scouts have found a wreck, `share` when some have, else `seek`.

    All robots seek in `seek`; two thirds of the carriers haul in `share`; in `work` all carriers haul and scouts stay
    where they are.
    """
    if screen.features["all_found(wreck)"] == YES:
        return "work"
    return "share" if screen.features["some_found(wreck)"] == YES else "seek"


LEAD = LessonPlan(
    "lead",
    LessonDesign(states=["seek", "share", "work"], features=["some_found(wreck)", "all_found(wreck)"]),
    show_lead,
    show_lead,
    after(200.0),
    cases=(Situation("wrecks with little in them", enough=after(200.0)),),
    tries=3,
    limit_s=240.0,
    patience_s=1000.0,
)

TOPICS = (LEAD,)
