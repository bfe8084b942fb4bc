"""The requests of the page that reviews a recording."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from msgspec import Meta, Struct

from understudy.ui.web.messages.base import Index, NameField, NameListField


class ReviewRequest(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A request about a drive under review; the answer is the review as it stands then."""


class SetLabel(ReviewRequest, frozen=True, kw_only=True, tag="label"):
    """Set the label of the ticks from `first` to before `end` by hand."""

    first: Index
    end: Index
    label: NameField


class UndoLabel(ReviewRequest, frozen=True, kw_only=True, tag="undo"):
    """Take the last change back."""


class DefineBehavior(ReviewRequest, frozen=True, kw_only=True, tag="define"):
    """Add a behavior with a constant command, by channel, and find the labels again."""

    name: NameField
    command: Annotated[dict[NameField, Annotated[float, Meta(ge=-1e9, le=1e9)]], Meta(max_length=100)]


class SplitLabel(ReviewRequest, frozen=True, kw_only=True, tag="split"):
    """Give a state of its own to where a state follows certain others."""

    state: NameField
    entered_from: NameListField


class SettleContradiction(ReviewRequest, frozen=True, kw_only=True, tag="settle"):
    """Settle a contradiction, by its index among those learned: the driver who is trusted is right there."""

    contradiction: Index
    trust: NameField


class TrustDriver(ReviewRequest, frozen=True, kw_only=True, tag="trust"):
    """Trust a driver wherever contradictions are not settled one by one; null: no driver."""

    driver: NameField | None


class LearnFromLabels(ReviewRequest, frozen=True, kw_only=True, tag="learn"):
    """Learn an automaton from the labels, and run it over the recording."""


class SaveLearned(ReviewRequest, frozen=True, kw_only=True, tag="save"):
    """Save what was learned in the library under a name."""

    name: NameField


AnyReviewRequest: TypeAlias = (
    SetLabel
    | UndoLabel
    | DefineBehavior
    | SplitLabel
    | SettleContradiction
    | TrustDriver
    | LearnFromLabels
    | SaveLearned
)
REVIEW_REQUESTS = (
    SetLabel,
    UndoLabel,
    DefineBehavior,
    SplitLabel,
    SettleContradiction,
    TrustDriver,
    LearnFromLabels,
    SaveLearned,
)
