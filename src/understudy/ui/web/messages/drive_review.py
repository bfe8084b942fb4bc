"""The requests of the page that reviews a recording."""

from __future__ import annotations

from typing import TypeAlias

from msgspec import Struct

from understudy.ui.web.messages.base import Index, NameField


class ReviewRequest(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A request about a drive under review; the answer is the review as it stands then."""


class SetLabel(ReviewRequest, frozen=True, kw_only=True, tag="label"):
    """Set the label of the ticks from `first` to before `end` by hand."""

    first: Index
    end: Index
    label: NameField


class UndoLabel(ReviewRequest, frozen=True, kw_only=True, tag="undo"):
    """Take the last change of a label back."""


class LearnFromLabels(ReviewRequest, frozen=True, kw_only=True, tag="learn"):
    """Learn an automaton from the labels, and run it over the recording."""


class SaveLearned(ReviewRequest, frozen=True, kw_only=True, tag="save"):
    """Save what was learned in the library under a name."""

    name: NameField


AnyReviewRequest: TypeAlias = SetLabel | UndoLabel | LearnFromLabels | SaveLearned
REVIEW_REQUESTS = (SetLabel, UndoLabel, LearnFromLabels, SaveLearned)
