"""Reasons: why what is trained does what it does, on all levels, as plain data."""

from __future__ import annotations

from understudy.analysis.explain_run import Level, Reason
from understudy.analysis.explanation_text import (
    MOST_EXAMPLES,
    DecisionData,
    describe_decision,
    describe_rest,
    describe_switch,
)
from understudy.model.lesson import ExampleKind
from understudy.training.trainee import Mode
from understudy.ui.controller.trainer import Desk
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views.scene import Plain


def told(stage: Stage) -> Plain:
    """What every level decides now, what held and who showed it; and the last switch of any of them."""
    desk = stage.trained
    levels = desk.why.levels()
    return {
        "levels": [_level(desk, level, first=level is levels[0]) for level in levels],
        "last": _last(desk),
    }


def _level(desk: Desk, level: Level, *, first: bool) -> Plain:
    decision = level.decision
    return {
        "automaton": level.automaton,
        "state": level.state,
        "since_s": level.since_s,
        "says": describe_rest(level)
        if decision is None
        else f"It {describe_decision(decision.explanation)}.",
        "yours": first and desk.screen.mode is Mode.TRAINING,
        **_behind(desk, decision),
    }


def _last(desk: Desk) -> Plain | None:
    last = desk.why.last()
    if last is None:
        return None
    switch, reason = last
    says = describe_switch(switch.before, switch.after, reason.explanation)
    return {
        "automaton": switch.call,
        "time_s": switch.time_s,
        "says": f"It {says}.",
        **_behind(desk, reason),
    }


def _behind(desk: Desk, reason: Reason | None) -> Plain:
    """What a decision read, and the examples responsible: `here` are those of the lesson that is open."""
    if reason is None:
        return {"read": "", "by_hand": False, "here": False, "examples": [], "more": 0}
    data = DecisionData.of(reason)
    return {
        "read": data.read,
        "by_hand": data.by_hand,
        "here": reason.taught.automaton.name == desk.name,
        "examples": _examples(data)[:MOST_EXAMPLES],
        "more": max(0, len(data.examples) - MOST_EXAMPLES),
    }


def _examples(data: DecisionData) -> list[Plain]:
    """Those that were said first, then what was recorded by itself, what was watched last."""
    return [
        {"number": each.number, "kind": each.kind, "correction": each.correction, "time_s": each.shown_s}
        for each in sorted(data.examples, key=lambda each: each.kind is ExampleKind.WATCHED)
    ]
