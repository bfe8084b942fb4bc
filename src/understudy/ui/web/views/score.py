"""The score of the automaton in training in new worlds, and what success means, as the page shows them."""

from __future__ import annotations

from msgspec import field

from understudy.falsification.lesson_score import Trend
from understudy.ui.controller.keep_going import BetterVersion
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.web.messages.base import Data


class OfferedGoalData(Data, frozen=True, kw_only=True):
    """A goal of which a person can pick one."""

    name: str
    """What it says, shortly."""
    claim: str
    """What is measured, exactly."""


class ScoreData(Data, frozen=True, kw_only=True):
    """The share of new worlds in which the automaton in training works, taken after each press."""

    text: str
    """The score in words, or why there is none; empty before the first press."""
    trend: Trend
    """What changed since the press before, by more than chance."""
    enabled: bool
    """Whether scores are taken."""
    is_running: bool = field(name="running")
    """Whether one is being taken."""
    goal: str
    """What success means, in words; empty if it is not known."""
    is_goal_chosen: bool = field(name="chosen")
    """Whether a person has chosen that."""
    offers: list[OfferedGoalData]
    """Goals of which a person can pick one."""
    worse_since: str
    """What was done since a version that works in more worlds, in words; empty if none is known."""


def describe_score(score: LessonScoreKeeper, better: BetterVersion | None) -> ScoreData:
    """Return the score, what success means, and what made it worse, as the page shows them."""
    return ScoreData.of(score, text=score.describe(), worse_since="" if better is None else better.since)
