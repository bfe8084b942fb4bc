"""Explain the present decisions of all levels, as data for the page."""

from __future__ import annotations

from typing import Any

from understudy.analysis.explain_run import DecisionReason, LevelExplanation
from understudy.analysis.explanation_text import (
    MOST_EXAMPLES,
    DecisionData,
    describe_decision,
    describe_rest,
    describe_switch,
)
from understudy.model.lesson import ExampleKind
from understudy.training.trainee import Mode
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.messages.base import Data
from understudy.ui.web.messages.review import RequestExplanation
from understudy.ui.web.session_host import SessionHost
from understudy.ui.web.views.session import ExampleKindName


class ResponsibleData(Data, frozen=True, kw_only=True):
    """An example that is responsible for a decision."""

    number: int
    kind: ExampleKindName
    correction: bool
    time_s: float | None


class BehindData(Data, frozen=True, kw_only=True):
    """The readings on which a decision is based, and the responsible examples."""

    automaton: str
    says: str
    read: str
    """The readings in words."""
    by_hand: bool
    here: bool
    """Whether the examples belong to the open lesson."""
    examples: list[ResponsibleData]
    more: int
    """The number of further examples, which are not listed."""


class LevelData(BehindData, frozen=True, kw_only=True):
    """The present decision of the automaton on one level."""

    state: str
    since_s: float
    yours: bool
    """Whether this level is in training, where the demonstrator decides."""


class SwitchedData(BehindData, frozen=True, kw_only=True):
    """The last switch of any level."""

    time_s: float


class ReasonsReply(Data, frozen=True, kw_only=True):
    """The present decision of every level, topmost first, and the last switch of any level."""

    levels: list[LevelData]
    last: SwitchedData | None


def handle_explain(host: SessionHost, _: RequestExplanation) -> ReasonsReply:
    """Explain the present decision of every level, with the responsible examples, and the last switch of any level."""
    trainer = host.active_trainer
    levels = trainer.explainer.explain_levels()
    return ReasonsReply(
        levels=[_level(trainer, level, first=level is levels[0]) for level in levels], last=_last(trainer)
    )


def _level(trainer: Trainer, level: LevelExplanation, *, first: bool) -> LevelData:
    decision = level.decision
    return LevelData(
        automaton=level.automaton,
        state=level.state,
        since_s=level.since_s,
        says=describe_rest(level) if decision is None else f"It {describe_decision(decision.explanation)}.",
        yours=first and trainer.session_view.mode is Mode.TRAINING,
        **_behind(trainer, decision),
    )


def _last(trainer: Trainer) -> SwitchedData | None:
    last = trainer.explainer.explain_last_switch()
    if last is None:
        return None
    switch, reason = last
    says = f"It {describe_switch(switch.before, switch.after, reason.explanation)}."
    return SwitchedData(automaton=switch.call, time_s=switch.time_s, says=says, **_behind(trainer, reason))


def _behind(trainer: Trainer, reason: DecisionReason | None) -> dict[str, Any]:
    """Return the fields of `BehindData` other than `automaton` and `says`."""
    if reason is None:
        return {"read": "", "by_hand": False, "here": False, "examples": [], "more": 0}
    data = DecisionData.from_reason(reason)
    return {
        "read": data.read,
        "by_hand": data.by_hand,
        "here": reason.taught.automaton.name == trainer.name,
        "examples": _examples(data)[:MOST_EXAMPLES],
        "more": max(0, len(data.examples) - MOST_EXAMPLES),
    }


def _examples(data: DecisionData) -> list[ResponsibleData]:
    """Return the examples responsible for a decision, those recorded from silence last."""
    return [
        ResponsibleData(
            number=each.number, kind=each.kind.value, correction=each.correction, time_s=each.shown_s
        )
        for each in sorted(data.examples, key=lambda each: each.kind is ExampleKind.WATCHED)
    ]
