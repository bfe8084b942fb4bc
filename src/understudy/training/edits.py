"""Edits: changes that a demonstrator makes to a lesson by hand. Each takes a lesson and returns another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypedDict, Unpack

from understudy.errors import SessionError, UnknownName
from understudy.learning.mislabels import list_press_examples
from understudy.model.automaton import State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.training.lesson_design import (
    check_binding_names,
    parse_feature,
    parse_state,
    refuse_single_texts,
)


class DesignChange(TypedDict, total=False):
    """The parts of a lesson's design that can change, as for `new_lesson`; `names` has new names of states."""

    states: Sequence[str | State]
    flags: Sequence[str]
    features: Sequence[str | BoundFeature]
    parameters: Sequence[str]
    stateless: bool
    options: LearnerOptions
    properties: Sequence[Property]
    goal: Property | None
    names: Mapping[str, str]


class ExampleChange(TypedDict, total=False):
    """The parts of an example that can be edited; values are given by feature label."""

    state: str | None
    next: str | None
    values: Mapping[str, float] | None


def describe_edit(what: str, examples: int) -> str:
    """Name an edit for undo, with the number of examples that it changes."""
    return f"{what} {examples} example{'s' * (examples != 1)}"


def delete_examples(lesson: Lesson, numbers: Sequence[int]) -> Lesson:
    """Return the lesson without these examples; SessionError if one does not exist."""
    for number in numbers:
        find_example(lesson, number)
    return replace(
        lesson, examples=tuple(example for example in lesson.examples if example.number not in numbers)
    )


def set_quarantine(lesson: Lesson, reasons: Mapping[int, str]) -> Lesson:
    """Return the lesson with these examples in quarantine, by number with the reason; "" takes one out.

    The same object is returned if nothing changes.
    """
    if all(find_example(lesson, number).quarantined == reason for number, reason in reasons.items()):
        return lesson
    return replace(
        lesson,
        examples=tuple(
            replace(example, quarantined=reasons[example.number]) if example.number in reasons else example
            for example in lesson.examples
        ),
    )


def edit_example(lesson: Lesson, number: int, **change: Unpack[ExampleChange]) -> Lesson:
    """Return the lesson with the state, next state or values (by feature label) of one example changed."""
    example, automaton = find_example(lesson, number), lesson.automaton
    state, following = change.get("state") or example.state, change.get("next") or example.next
    values = change.get("values") or {}
    automaton.index(following)
    if automaton.state(state).flag is not None:
        raise SessionError(f"a flag state is never left, so no example can begin in {state!r}")
    new_values = list(example.values)
    labels = [str(bound) for bound in automaton.features]
    for label, value in values.items():
        if label not in labels:
            raise UnknownName(what="feature", name=label, where=f"automaton {automaton.name!r}", known=labels)
        index = labels.index(label)
        new_values[index] = automaton.features[index].kind.check(value, where=f"example {number}, {label}")
    changed = replace(
        example,
        state=state,
        next=following,
        kind=_kind(example, state, following),
        values=tuple(new_values),
        edited=example.edited or bool(values),
    )
    examples = tuple(changed if other.number == number else other for other in lesson.examples)
    return replace(lesson, examples=examples)


def correct_press(lesson: Lesson, number: int, next: str) -> Lesson:
    """Return the lesson with a press changed to the intended one, and its former default in quarantine."""
    beside = list_press_examples(lesson, number)[1:]
    lesson = edit_example(lesson, number, next=next)
    return set_quarantine(lesson, dict.fromkeys(beside, f"Example {number} was a slip."))


def change_design(
    lesson: Lesson, library: Library, choice: DesignChange, targets: Mapping[str, str]
) -> Lesson:
    """Return the lesson with other states, flags, features, parameters or options, but with its former values.

    A new parameter gets its target in all examples.
    """
    old = lesson.automaton
    lists = ("states", "features", "flags", "parameters")
    refuse_single_texts(old.name, {what: choices for what, choices in choice.items() if what in lists})
    states = [state for state in old.states[1:] if state.flag is None]
    flags = [state for state in old.states[1:] if state.flag is not None]
    if "states" in choice:
        states = [parse_state(library, state) for state in choice["states"]]
    if "flags" in choice:
        flags = [State(flag, flag=flag) for flag in choice["flags"]]
    features = old.features
    if "features" in choice:
        features = tuple(parse_feature(library, feature) for feature in choice["features"])
    automaton = replace(
        old,
        states=(old.states[0], *states, *flags),
        features=features,
        parameters=tuple(choice.get("parameters", old.parameters)),
        stateless=choice.get("stateless", old.stateless),
    )
    check_binding_names(library, automaton)
    names = {state.name: state for state in automaton.states}
    bound = {name: target for name, target in targets.items() if name in automaton.parameters}
    examples = tuple(
        replace(example, binding=Binding({**bound, **example.binding}))
        for example in _renamed(lesson.examples, choice.get("names", {}))
        if example.state in names and example.next in names and names[example.state].flag is None
    )
    return replace(
        lesson,
        automaton=automaton,
        examples=examples,
        options=choice.get("options", lesson.options),
        properties=tuple(choice.get("properties", lesson.properties)),
        goal=choice.get("goal", lesson.goal),
    )


def find_example(lesson: Lesson, number: int) -> Example:
    """Find the example with this number; SessionError if there is none."""
    for example in lesson.examples:
        if example.number == number:
            return example
    raise SessionError(f"lesson {lesson.name!r} has no example {number}")


def _renamed(examples: Sequence[Example], names: Mapping[str, str]) -> Sequence[Example]:
    """Return examples with new names of states, without those of states whose name was given to another."""
    if not names:
        return examples
    gone = set(names.values()) - set(names)
    return [
        replace(
            example,
            state=names.get(example.state, example.state),
            next=names.get(example.next, example.next),
        )
        for example in examples
        if not {example.state, example.next} & gone
    ]


def _kind(example: Example, state: str, following: str) -> ExampleKind:
    if example.kind is ExampleKind.WATCHED or (state, following) == (example.state, example.next):
        return example.kind
    return ExampleKind.CONFIRMATION if state == following else ExampleKind.DIRECTIVE
