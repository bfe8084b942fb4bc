"""Outcomes at the desk: what a lesson promises from here on, and what it promises no longer."""

from __future__ import annotations

from understudy.analysis import expectations
from understudy.errors import SessionError
from understudy.model.expectation import Outcome
from understudy.ui.controller.status import Said
from understudy.ui.controller.trainer import Desk


def promise(desk: Desk, flag: str, within_s: float) -> None:
    """Let the lesson promise that from here on, started afresh, the automaton raises a flag in time."""
    outcome = expectations.promise(desk.session, flag=flag, within_s=within_s)
    desk.said = Said(f"Promised from here: {outcome}; undo takes it back")
    desk.changed()


def withdraw(desk: Desk, number: int) -> None:
    """Let the lesson no longer promise its outcome of this number, from 0."""
    outcome = promised(desk, number)
    kept = desk.session.lesson.outcomes
    desk.session.choose(outcomes=(*kept[:number], *kept[number + 1 :]))
    desk.said = Said(f"No longer promised: {outcome}; undo takes that back")
    desk.changed()


def promised(desk: Desk, number: int) -> Outcome:
    """The outcome of this number; SessionError where there is none."""
    kept = desk.session.lesson.outcomes
    if not 0 <= number < len(kept):
        raise SessionError(f"{desk.name} has no outcome {number + 1}: it promises {len(kept)}")
    return kept[number]
