"""Change a lesson outside of presses: quarantine examples, simplify trees, add and remove properties."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.errors import SessionError, join_names
from understudy.judging.properties import stored_moments
from understudy.judging.simplify_preview import (
    SimplifyPreview,
    get_simplifiable_lesson,
    preview_simplification,
)
from understudy.learning.pruning_suggestions import replace_pruning
from understudy.model.property import Property
from understudy.ui.controller.status import StatusMessage, keep_status
from understudy.ui.controller.trainer import Trainer

BY_HAND = "Put into quarantine by hand."


@keep_status
def quarantine_examples(trainer: Trainer, numbers: Sequence[int]) -> StatusMessage:
    """Put examples into quarantine, with the evidence against them, or as a person's choice."""
    judgement = trainer.session.correction_diagnosis
    reasons = {} if judgement is None else judgement.reasons
    trainer.session.quarantine({number: reasons.get(number, BY_HAND) for number in numbers})
    trainer.note_lesson_change()
    return StatusMessage(f"{_examples(numbers)} in quarantine; undo reverts this")


@keep_status
def release_examples(trainer: Trainer, numbers: Sequence[int]) -> StatusMessage:
    """Take examples out of quarantine."""
    trainer.session.quarantine(dict.fromkeys(numbers, ""))
    trainer.note_lesson_change()
    return StatusMessage(f"{_examples(numbers)} out of quarantine; undo reverts this")


def _examples(numbers: Sequence[int]) -> str:
    """Name examples with a verb: "Example 3 is", "Examples 3 and 5 are"."""
    return (
        f"Example {numbers[0]} is" if len(numbers) == 1 else f"Examples {join_names(map(str, numbers))} are"
    )


@keep_status
def add_property_here(trainer: Trainer, flag: str, within_s: float) -> StatusMessage:
    """Add a property: restarted at this moment, the automaton raises a flag in time."""
    added = stored_moments.add_moment_property(trainer.session, flag=flag, within_s=within_s)
    trainer.refresh_view()
    return StatusMessage(f"Property from here: {added}; undo reverts this")


@keep_status
def remove_property(trainer: Trainer, number: int) -> StatusMessage:
    """Remove the property with this number, from 0."""
    removed = find_property(trainer, number)
    properties = trainer.session.lesson.properties
    trainer.session.change_design(properties=(*properties[:number], *properties[number + 1 :]))
    trainer.refresh_view()
    return StatusMessage(f"Property removed: {removed}; undo reverts this")


def find_property(trainer: Trainer, number: int) -> Property:
    """Find the property with this number; SessionError if there is none."""
    properties = trainer.session.lesson.properties
    if not 0 <= number < len(properties):
        raise SessionError(f"{trainer.name} has no property {number + 1}: it has {len(properties)}")
    return properties[number]


@keep_status
def choose_goal(trainer: Trainer, name: str | None) -> StatusMessage:
    """Choose what success means among the offered goals by its name; None: nothing is chosen."""
    goal = None if name is None else trainer.score.find_offer(name)
    trainer.session.change_design(goal=goal)
    trainer.note_lesson_change()
    chosen = trainer.score.goal or "not chosen"
    return StatusMessage(f"Success: {chosen}; undo reverts this")


@keep_status
def choose_next_goal(trainer: Trainer) -> StatusMessage:
    """Choose the offered goal after the present one; after the last one, none."""
    names = [each.name for each in trainer.score.offers]
    if not names:
        raise SessionError(f"success is already clear: {trainer.score.goal or 'there is no simulated world'}")
    now = trainer.session.lesson.goal
    following = names[names.index(now.name) + 1 :] if now is not None and now.name in names else names
    if now is not None and now.name not in names:
        following = []
    return choose_goal(trainer, following[0] if following else None)


def preview_pruning(trainer: Trainer, pruning: float | None = None) -> SimplifyPreview:
    """Preview the effect of pruning the current lesson; nothing is changed."""
    return preview_simplification(trainer.session.make_trained_automaton(), pruning)


@keep_status
def change_pruning(trainer: Trainer, pruning: float) -> StatusMessage:
    """Learn the lesson with a pruning from now on; 0 turns pruning off."""
    lesson = get_simplifiable_lesson(trainer.session.make_trained_automaton())
    trainer.session.change_design(options=replace_pruning(lesson, pruning).options)
    trainer.note_lesson_change()
    return StatusMessage("Simplified as shown; undo reverts this" if pruning else "Pruning is off")
