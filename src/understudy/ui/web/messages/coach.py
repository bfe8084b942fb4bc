"""The requests of the page to the coach."""

from __future__ import annotations

from typing import Annotated, ClassVar, TypeAlias

from msgspec import Meta

from understudy.coaching.queries import QueryPolicy
from understudy.ui.web.messages.base import Call, Index, Message

Sentence: TypeAlias = Annotated[str, Meta(min_length=1, max_length=10_000)]


class RequestAdvice(Message, frozen=True, kw_only=True, tag="request_advice"):
    """List what the lesson lacks, and estimate how late presses come."""

    by_anyone: ClassVar[bool] = True


class SetUpSituation(Message, frozen=True, kw_only=True, tag="set_up"):
    """Put the robot into the situation that this piece of advice or finding is about."""

    sentence: Sentence


class GoToNextSituation(Message, frozen=True, kw_only=True, tag="next_situation"):
    """Go to the situation of further worlds in which an answer would change most, and pause there with the question."""


class SetQueryPolicy(Message, frozen=True, kw_only=True, tag="set_query_policy"):
    """Set what the robot does in testing where it is uncertain."""

    policy: QueryPolicy


class GoToUncertain(Message, frozen=True, kw_only=True, tag="go_to_mark"):
    """Go back to a moment at which the robot was uncertain and continued."""

    number: Index


class SetReactionTime(Message, frozen=True, kw_only=True, tag="set_reaction_time"):
    """Set the reaction time of the demonstrator, s."""

    reaction_s: float


class CorrectSlip(Message, frozen=True, kw_only=True, tag="correct_slip"):
    """Correct the press of an example: the demonstrator hit the wrong button."""

    number: Index
    next: Call


class ConfirmPress(Message, frozen=True, kw_only=True, tag="confirm_press"):
    """Confirm that the press of an example was intended."""

    number: Index
