"""What a page may say to look back: why, what lessons promise and whether they keep it, versions, simplifying."""

from __future__ import annotations

from typing import Annotated, ClassVar, TypeAlias

from msgspec import Meta

from understudy.model.expectation import LONGEST_S
from understudy.ui.web.messages.base import Index, Message, NameField

Seconds: TypeAlias = Annotated[float, Meta(gt=0, le=LONGEST_S)]
Pruning: TypeAlias = Annotated[float, Meta(ge=0, le=1e6)]
"""How many examples each leaf of a question must set right for the question to stay."""


class RequestExplanation(Message, frozen=True, kw_only=True, tag="why"):
    """Explain the decisions of now, on all levels, and the last switch."""

    by_anyone: ClassVar[bool] = True


class AddExpectation(Message, frozen=True, kw_only=True, tag="promise"):
    """From here on, the automaton will raise a flag in time."""

    flag: NameField
    within_s: Seconds


class RemoveExpectation(Message, frozen=True, kw_only=True, tag="withdraw"):
    """Promise an outcome no longer; it is counted as in the lesson."""

    outcome: Index


class GoToExpectation(Message, frozen=True, kw_only=True, tag="visit"):
    """Go to where an outcome was promised."""

    outcome: Index


class TestLesson(Message, frozen=True, kw_only=True, tag="test"):
    """Test an automaton on its lesson, as all is now: what is trained counts as it stands."""

    by_anyone: ClassVar[bool] = True
    name: NameField


class SaveAutomaton(Message, frozen=True, kw_only=True, tag="save"):
    """Save the automaton; a name saves a copy under it. What no longer works is said first, unless it is to be saved
    `anyway`.
    """

    name: NameField | None = None
    anyway: bool = False


class PreviewSimplify(Message, frozen=True, kw_only=True, tag="simplify"):
    """Show what the automaton would be with fewer questions, as many as is best where it is not said."""

    by_anyone: ClassVar[bool] = True
    pruning: Pruning | None = None


class ApplyPruning(Message, frozen=True, kw_only=True, tag="prune"):
    """Learn with fewer questions from now on; 0 takes that back."""

    pruning: Pruning


class ListVersions(Message, frozen=True, kw_only=True, tag="versions"):
    """List the former versions of a trained behavior."""

    by_anyone: ClassVar[bool] = True
    name: NameField


class DiffVersions(Message, frozen=True, kw_only=True, tag="changes"):
    """Tell what changed from a former version to another, or to the present one."""

    by_anyone: ClassVar[bool] = True
    name: NameField
    version: Index
    to: Index | None = None
