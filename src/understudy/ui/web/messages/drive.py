"""The requests of the pages on which a person drives a robot, and reviews what was driven."""

from __future__ import annotations

from typing import Annotated, TypeAlias, get_args

from msgspec import Meta, Struct

from understudy.ui.web.messages.base import Index, NameField, NameListField, Seed

Lean: TypeAlias = Annotated[float, Meta(ge=-1, le=1)]
"""How far a stick leans to one side."""
HeldIndices: TypeAlias = Annotated[list[Index], Meta(max_length=100)]
"""The indices of the behaviors whose buttons are held."""


class DriveRequest(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="do"):
    """A request about the drive under way."""


class SteerRobot(DriveRequest, frozen=True, kw_only=True, tag="steer"):
    """Where the stick is: sent whenever it moves, and again and again while the robot is driven."""

    right: Lean = 0.0
    up: Lean = 0.0
    held: HeldIndices = []


class BeginDriving(DriveRequest, frozen=True, kw_only=True, tag="drive"):
    """Drive, or go on."""


class LetAutomatonDrive(DriveRequest, frozen=True, kw_only=True, tag="let_drive"):
    """Let the automaton that was learned drive, until it is paused or the stick is moved."""


class PauseDriving(DriveRequest, frozen=True, kw_only=True, tag="pause_drive"):
    """Pause, so that the labels can be reviewed."""


class BeginWorld(DriveRequest, frozen=True, kw_only=True, tag="new_world"):
    """Begin another world, as another episode of the drive; by default that of the next seed."""

    seed: Seed | None = None


AnyDriveRequest: TypeAlias = SteerRobot | BeginDriving | LetAutomatonDrive | PauseDriving | BeginWorld
DRIVE_REQUESTS = get_args(AnyDriveRequest)
"""All requests of the page on which a person drives."""


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
REVIEW_REQUESTS = get_args(AnyReviewRequest)
