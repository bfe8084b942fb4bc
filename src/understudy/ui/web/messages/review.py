"""The requests of the page about explanations, advice, properties, tests, versions and pruning."""

from __future__ import annotations

from typing import Annotated, ClassVar, TypeAlias

from msgspec import Meta

from understudy.coaching.questions import QueryPolicy
from understudy.model.property import LONGEST_S, PropertyKind
from understudy.ui.web.messages.base import Call, Data, Index, Message, NameField, Seed, Targets

Sentence: TypeAlias = Annotated[str, Meta(min_length=1, max_length=10_000)]
Seconds: TypeAlias = Annotated[float, Meta(gt=0, le=LONGEST_S)]
ConditionField: TypeAlias = Annotated[str, Meta(max_length=1000, pattern=r"^[^\x00-\x1f\x7f]*$")]
Pruning: TypeAlias = Annotated[float, Meta(ge=0, le=1e6)]
"""How many examples each leaf of a question must set right for the question to stay."""


class RequestExplanation(Message, frozen=True, kw_only=True, tag="why"):
    """Explain the current decisions on all levels, and the last switch."""

    by_anyone: ClassVar[bool] = True


class AddProperty(Message, frozen=True, kw_only=True, tag="add_property"):
    """Add the property that the automaton raises a flag in time, from the present moment on."""

    flag: NameField
    within_s: Seconds


class RemoveProperty(Message, frozen=True, kw_only=True, tag="remove_property"):
    """Remove a property, given by its position in the lesson."""

    property: Index


class GoToProperty(Message, frozen=True, kw_only=True, tag="go_to_property"):
    """Go to the moment of a property."""

    property: Index


class PropertyFieldsData(Data, frozen=True, kw_only=True):
    """The fields of a property's form; they are the keys of its table."""

    kind: PropertyKind
    condition: ConditionField
    """The condition that must never hold, hold in time, or not hold for longer; "goal" is the scenario's goal."""
    seconds: float | None
    """The time in s; null for a condition that must never hold."""
    behavior: ConditionField
    targets: Targets
    world: ConditionField
    """A scenario by name, or a file, relative to the library's folder."""
    seeds: ConditionField
    """As in the file: a number of worlds, a list, or { first = 1000, count = 500 }."""
    limit_s: float | None
    at_least: float | None
    """The share of worlds in which it must hold; null for all."""


class SaveProperty(Message, frozen=True, kw_only=True, tag="save_property"):
    """Write a property to the library's file and test it; with `changes`, in place of the one of this name."""

    name: NameField
    fields: PropertyFieldsData
    changes: bool = False


class DeleteProperty(Message, frozen=True, kw_only=True, tag="delete_property"):
    """Remove a property from the library's file."""

    name: NameField


class TestProperties(Message, frozen=True, kw_only=True, tag="test_properties"):
    """Test one property of the library's file with what is in training; all of them without a name."""

    name: NameField | None = None


class ListPropertyChoices(Message, frozen=True, kw_only=True, tag="property_choices"):
    """List the names that a property in a world can use."""

    by_anyone: ClassVar[bool] = True
    world: ConditionField
    behavior: ConditionField


class TestLesson(Message, frozen=True, kw_only=True, tag="test"):
    """Test an automaton on its lesson, with the unsaved state of what is in training."""

    by_anyone: ClassVar[bool] = True
    name: NameField


class EvaluateSession(Message, frozen=True, kw_only=True, tag="evaluate"):
    """Evaluate the automaton in training, as it stands, in 1 to 1000 unseen worlds."""

    count: Index = 100


class RunWorldGrid(Message, frozen=True, kw_only=True, tag="run_world_grid"):
    """Run what is in training in a hundred new worlds, to be looked at side by side."""


class ReadWorldGrid(Message, frozen=True, kw_only=True, tag="read_world_grid"):
    """Read the newest runs in these worlds."""

    by_anyone: ClassVar[bool] = True


class VisitGridWorld(Message, frozen=True, kw_only=True, tag="visit_grid_world"):
    """Go to where it went wrong in one of these worlds, paused, with the targets with which it ran."""

    seed: Seed


class CancelEvaluation(Message, frozen=True, kw_only=True, tag="cancel_evaluation"):
    """Cancel the evaluation in unseen worlds, or drop its result."""


class OpenFailure(Message, frozen=True, kw_only=True, tag="open_failure"):
    """Go to a failing world, shortly before the behavior goes wrong, to correct it there.

    What is in training goes along. If it is unsaved and does not run there, this is refused without `discard`.
    """

    name: NameField
    discard: bool = False


class LeaveFailure(Message, frozen=True, kw_only=True, tag="leave_failure"):
    """Go back from a failing world to the world that was on the page before; what is in training goes along."""


class RerunFailures(Message, frozen=True, kw_only=True, tag="rerun_failures"):
    """Read the folder of failing worlds again, and run all with what is in training."""


class SaveAutomaton(Message, frozen=True, kw_only=True, tag="save"):
    """Save the automaton, or a copy of it if a name is given.

    If something that worked no longer does, or something changed beyond what was pressed since it was last saved, it is
    saved only with `anyway`.
    """

    name: NameField | None = None
    anyway: bool = False


class PreviewSimplify(Message, frozen=True, kw_only=True, tag="simplify"):
    """Preview the automaton with fewer splits; the best number of splits unless one is given."""

    by_anyone: ClassVar[bool] = True
    pruning: Pruning | None = None


class ApplyPruning(Message, frozen=True, kw_only=True, tag="prune"):
    """Learn with fewer splits from now on; 0 turns pruning off."""

    pruning: Pruning


class ListVersions(Message, frozen=True, kw_only=True, tag="list_versions"):
    """List the former versions of a trained behavior."""

    by_anyone: ClassVar[bool] = True
    name: NameField


class DiffVersions(Message, frozen=True, kw_only=True, tag="diff_versions"):
    """Compare a former version with another, or with the present one."""

    by_anyone: ClassVar[bool] = True
    name: NameField
    version: Index
    to: Index | None = None


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
