"""Reasons: why what is trained does what it does, on all levels, as plain data."""

from __future__ import annotations

from understudy.analysis.explain_run import Level, Reason
from understudy.learning.explain import Explanation
from understudy.training.trainee import Mode
from understudy.ui.controller import formatting
from understudy.ui.controller.explainer import because, decided
from understudy.ui.controller.trainer import Desk
from understudy.ui.web.session_host import Stage
from understudy.ui.web.views.scene import Plain

MOST_EXAMPLES = 6


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
    says = level.rests if decision is None else decided(decision.explanation)
    return {
        "automaton": level.automaton,
        "state": level.state,
        "since_s": level.since_s,
        "says": says if decision is None else f"It {says}.",
        "yours": first and desk.screen.mode is Mode.TRAINING,
        **_behind(desk, decision),
    }


def _last(desk: Desk) -> Plain | None:
    last = desk.why.last()
    if last is None:
        return None
    switch, reason = last
    says = f"It went from {switch.before} to {switch.after}"
    if reason.explanation.next == switch.after:
        says += because(reason.explanation)
    else:  # the lesson changed since
        says += f"; by now it {decided(reason.explanation)}"
    return {"automaton": switch.call, "time_s": switch.time_s, "says": f"{says}.", **_behind(desk, reason)}


def _behind(desk: Desk, reason: Reason | None) -> Plain:
    """What a decision read, and the examples responsible: `here` are those of the lesson that is open."""
    if reason is None:
        return {"read": "", "by_hand": False, "here": False, "examples": [], "more": 0}
    automaton = reason.taught.automaton
    responsible = _examples(reason.explanation, reason)
    return {
        "read": formatting.values(automaton.features, list(reason.values.values())),
        "by_hand": reason.taught.lesson is None,
        "here": automaton.name == desk.name,
        "examples": responsible[:MOST_EXAMPLES],
        "more": max(0, len(responsible) - MOST_EXAMPLES),
    }


def _examples(explanation: Explanation, reason: Reason) -> list[Plain]:
    """Those that were said first, then what was recorded by itself."""
    return [
        {
            "number": each.number,
            "kind": each.kind.value,
            "correction": each.correction,
            "time_s": reason.moments.get(each.number),
        }
        for each in sorted(
            explanation.examples, key=lambda each: (not each.shown, not each.pressed, each.number)
        )
    ]
