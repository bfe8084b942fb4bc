"""Explain the present decisions of all levels, as data for the page."""

from __future__ import annotations

from typing import Any

from msgspec import field

from understudy.judging.explain_run import DecisionReason, LevelExplanation
from understudy.judging.explanation_text import (
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


class ResponsibleExampleData(Data, frozen=True, kw_only=True):
    """An example that is responsible for a decision."""

    number: int
    kind: ExampleKind
    correction: bool
    shown_s: float | None = field(name="time_s")


class DecisionBasisData(Data, frozen=True, kw_only=True):
    """The readings on which a decision is based, and the responsible examples."""

    automaton: str
    decision: str
    readings: str
    """The readings in words."""
    by_hand: bool
    in_lesson: bool
    """Whether the examples belong to the open lesson."""
    examples: list[ResponsibleExampleData]
    omitted: int
    """The number of further examples, which are not listed."""


class LevelData(DecisionBasisData, frozen=True, kw_only=True):
    """The present decision of the automaton on one level."""

    state: str
    since_s: float
    in_training: bool
    """Whether this level is in training, where the demonstrator decides."""


class LastSwitchData(DecisionBasisData, frozen=True, kw_only=True):
    """The last switch of any level."""

    time_s: float


class ReasonsReply(Data, frozen=True, kw_only=True):
    """The present decision of every level, topmost first, and the last switch of any level."""

    levels: list[LevelData]
    last: LastSwitchData | None


def handle_explain(host: SessionHost, _: RequestExplanation) -> ReasonsReply:
    """Explain the present decision of every level, with the responsible examples, and the last switch of any level."""
    trainer = host.active_trainer
    levels = trainer.explainer.explain_levels()
    return ReasonsReply(
        levels=[_level(trainer, level, first=level is levels[0]) for level in levels], last=_last(trainer)
    )


def _level(trainer: Trainer, level: LevelExplanation, *, first: bool) -> LevelData:
    decision = level.decision
    sentence = describe_rest(level) if decision is None else f"It {describe_decision(decision.explanation)}."
    return LevelData.of(
        level,
        decision=sentence,
        in_training=first and trainer.session_view.mode is Mode.TRAINING,
        **_describe_basis(trainer, decision),
    )


def _last(trainer: Trainer) -> LastSwitchData | None:
    last = trainer.explainer.explain_last_switch()
    if last is None:
        return None
    switch, reason = last
    decision = f"It {describe_switch(switch.before, switch.after, reason.explanation)}."
    return LastSwitchData.of(
        switch, automaton=switch.call, decision=decision, **_describe_basis(trainer, reason)
    )


def _describe_basis(trainer: Trainer, reason: DecisionReason | None) -> dict[str, Any]:
    """Return the fields of `DecisionBasisData` other than `automaton` and `decision`."""
    if reason is None:
        return {"readings": "", "by_hand": False, "in_lesson": False, "examples": [], "omitted": 0}
    data = DecisionData.from_reason(reason)
    watched_last = sorted(data.examples, key=lambda each: each.kind is ExampleKind.WATCHED)
    return {
        "readings": data.read,
        "by_hand": data.by_hand,
        "in_lesson": reason.taught.automaton.name == trainer.name,
        "examples": watched_last[:MOST_EXAMPLES],
        "omitted": max(0, len(data.examples) - MOST_EXAMPLES),
    }
