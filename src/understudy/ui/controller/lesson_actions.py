"""Change a lesson outside of presses: quarantine examples, simplify trees, add and remove expectations."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.analysis import expectations
from understudy.analysis.simplify_preview import (
    SimplifyPreview,
    get_simplifiable_lesson,
    preview_simplification,
)
from understudy.errors import SessionError, join_names
from understudy.learning.pruning_suggestions import replace_pruning
from understudy.model.expectation import Expectation
from understudy.ui.controller.status import StatusMessage, keep_status
from understudy.ui.controller.trainer import Trainer

BY_HAND = "Somebody put it there."


@keep_status
def quarantine_examples(desk: Trainer, numbers: Sequence[int]) -> StatusMessage:
    """Let examples teach nothing for now: for what speaks against them, or because somebody wants it."""
    judgement = desk.session.correction_diagnosis
    reasons = {} if judgement is None else judgement.reasons
    desk.session.quarantine({number: reasons.get(number, BY_HAND) for number in numbers})
    desk.refresh_view()
    return StatusMessage(f"{_examples(numbers)} in quarantine; undo takes that back")


@keep_status
def release_examples(desk: Trainer, numbers: Sequence[int]) -> StatusMessage:
    """Let examples teach again."""
    desk.session.quarantine(dict.fromkeys(numbers, ""))
    desk.refresh_view()
    return StatusMessage(f"{_examples(numbers)} out of quarantine; undo takes that back")


def _examples(numbers: Sequence[int]) -> str:
    """Examples by number, with the verb: "Example 3 is", "Examples 3 and 5 are"."""
    return (
        f"Example {numbers[0]} is" if len(numbers) == 1 else f"Examples {join_names(map(str, numbers))} are"
    )


@keep_status
def add_expectation_here(desk: Trainer, flag: str, within_s: float) -> StatusMessage:
    """Let the lesson promise that from here on, started afresh, the automaton raises a flag in time."""
    outcome = expectations.add_expectation(desk.session, flag=flag, within_s=within_s)
    desk.refresh_view()
    return StatusMessage(f"Promised from here: {outcome}; undo takes it back")


@keep_status
def remove_expectation(desk: Trainer, number: int) -> StatusMessage:
    """Let the lesson no longer promise its outcome of this number, from 0."""
    outcome = find_expectation(desk, number)
    kept = desk.session.lesson.outcomes
    desk.session.change_design(outcomes=(*kept[:number], *kept[number + 1 :]))
    desk.refresh_view()
    return StatusMessage(f"No longer promised: {outcome}; undo takes that back")


def find_expectation(desk: Trainer, number: int) -> Expectation:
    """The outcome of this number; SessionError where there is none."""
    kept = desk.session.lesson.outcomes
    if not 0 <= number < len(kept):
        raise SessionError(f"{desk.name} has no outcome {number + 1}: it promises {len(kept)}")
    return kept[number]


def preview_pruning(desk: Trainer, pruning: float | None = None) -> SimplifyPreview:
    """What pruning the lesson as it stands would come to; nothing is changed."""
    return preview_simplification(desk.session.make_trained_automaton(), pruning)


@keep_status
def change_pruning(desk: Trainer, pruning: float) -> StatusMessage:
    """Learn the lesson with a pruning from now on; 0 takes it back."""
    lesson = get_simplifiable_lesson(desk.session.make_trained_automaton())
    desk.session.change_design(options=replace_pruning(lesson, pruning).options)
    desk.refresh_view()
    return StatusMessage(
        "It is as simple as you saw; undo takes that back" if pruning else "Nothing is pruned now"
    )
