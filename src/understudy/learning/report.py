"""Reports on learning a lesson: conditions, sizes, contradictions and disagreements of each state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from types import MappingProxyType

from understudy.learning.fit import learn_state
from understudy.learning.training_set import (
    group_by_feature_vector,
    group_examples_by_state,
    select_teaching_examples,
)
from understudy.learning.tree_growth import compile_tree_kernels
from understudy.model.automaton import Transition, name_next_state
from understudy.model.describe import list_shown_vectors
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.tree import Tree
from understudy.model.tree_text import describe_exits


@dataclass(frozen=True, slots=True)
class StateReport:
    """The result of learning one state.

    `conditions` describe in words when it is left. `nodes` and `depth` are the size of its tree, 0 for a
    classifier. `contradictions` counts groups of examples that contradict each other, `disagreements` examples
    that are decided otherwise than shown, and `overruled` those of the `watched` examples in which the robot would now
    do otherwise. `fit_ms` is the time to learn it, in ms.
    """

    conditions: tuple[str, ...]
    nodes: int
    depth: int
    contradictions: int
    disagreements: int
    watched: int
    overruled: int
    fit_ms: float


@dataclass(frozen=True, slots=True)
class ContradictedExample:
    """An example that is decided otherwise than shown.

    `place` says where it is from: a line of a table, a recording, or its number in the lesson. In `state` it shows
    `next`, and what was learned decides `decided`.
    """

    place: str
    state: str
    next: str
    decided: str
    kind: ExampleKind

    def __str__(self) -> str:
        """Format as a sentence: "example 3: forward goes to back, and was shown to stay"."""
        does = f"{self.state} stays" if self.decided == self.state else f"{self.state} goes to {self.decided}"
        should = "stay" if self.next == self.state else f"go to {self.next}"
        return f"{self.place}: {does}, and was shown to {should}"


@dataclass(frozen=True, slots=True)
class Report:
    """The result of learning a lesson: by state name, the transition functions and the reports.

    `repeated` of `examples` that were learned from are decided as shown; `contradicted` are the others.
    """

    transitions: Mapping[str, Transition]
    states: Mapping[str, StateReport]
    repeated: int
    examples: int
    contradicted: tuple[ContradictedExample, ...]


def learn_and_report(lesson: Lesson, *, lines: Mapping[int, str] = MappingProxyType({})) -> Report:
    """Learn a lesson, and report on each state that has a transition function.

    `lines` are the places of examples in the table that they are from, by their numbers.

    In a stateless lesson all states share one function and its `fit_ms`, which is the time from Example objects
    to a finished function, without compiling the kernel.
    """
    if isinstance(lesson.options.learner, TreeOptions):
        compile_tree_kernels()
    transitions: dict[str, Transition] = {}
    states: dict[str, StateReport] = {}
    shared: tuple[Transition, float] | None = None
    contradicted: list[ContradictedExample] = []
    for name, examples in group_examples_by_state(lesson).items():
        if shared is None or not lesson.automaton.stateless:
            began = perf_counter()
            function = learn_state(lesson, name, examples)
            shared = function, (perf_counter() - began) * 1e3
        function, fit_ms = shared
        transitions[name] = function
        against, overruled = (find(lesson, name, function) for find in (find_disagreements, find_overruled))
        contradicted += [
            _describe_contradicted(lesson, each, function, lines) for each in (*against, *overruled)
        ]
        states[name] = StateReport(
            conditions=_sentences(lesson, name, function),
            nodes=len(function.nodes) if isinstance(function, Tree) else 0,
            depth=function.depth if isinstance(function, Tree) else 0,
            contradictions=len(find_contradictions(lesson, name)),
            disagreements=len(against),
            watched=len(_list_watched(lesson, name)),
            overruled=len(overruled),
            fit_ms=fit_ms,
        )
    count = len(select_teaching_examples(lesson))
    return Report(transitions, states, count - len(contradicted), count, tuple(contradicted))


def _describe_contradicted(
    lesson: Lesson, example: Example, function: Transition, lines: Mapping[int, str]
) -> ContradictedExample:
    decided = name_next_state(lesson.automaton, example.state, function.decide(example.values))
    place = f"example {example.number}" if example.source is None else str(example.source)
    if example.number in lines:
        place = f"{lines[example.number]} ({place})"
    return ContradictedExample(place, example.state, example.next, decided, example.kind)


def _sentences(lesson: Lesson, state: str, function: Transition) -> tuple[str, ...]:
    automaton = lesson.automaton
    if not isinstance(function, Tree):
        return (f"decided by {type(getattr(function, 'classifier', function)).__name__} of scikit-learn",)
    return describe_exits(
        function, automaton.features, automaton.state_names, state, list_shown_vectors(lesson, state)
    )


def find_contradictions(lesson: Lesson, state: str) -> tuple[tuple[Example, ...], ...]:
    """Find directives and confirmations of a state that have equal feature vectors but different next states."""
    shown_examples = [
        example for example in group_examples_by_state(lesson).get(state, ()) if example.is_shown
    ]
    return tuple(
        tuple(group)
        for group in group_by_feature_vector(shown_examples).values()
        if len({example.next for example in group}) > 1
    )


def list_contradicting_numbers(lesson: Lesson) -> set[int]:
    """List the numbers of all directives and confirmations of a lesson that contradict others."""
    groups = (group for state in lesson.automaton.state_names for group in find_contradictions(lesson, state))
    return {example.number for group in groups for example in group}


def find_disagreements(lesson: Lesson, state: str, function: Transition) -> tuple[Example, ...]:
    """Find the press-made examples of a state whose next state is not what its transition function decides."""
    pressed = [
        example
        for example in select_teaching_examples(lesson)
        if example.state == state and example.is_from_press
    ]
    return _list_otherwise(lesson, pressed, function)


def find_overruled(lesson: Lesson, state: str, function: Transition) -> tuple[Example, ...]:
    """Find the watched examples of a state in which its transition function decides something else."""
    return _list_otherwise(lesson, _list_watched(lesson, state), function)


def _list_watched(lesson: Lesson, state: str) -> list[Example]:
    return [
        example
        for example in select_teaching_examples(lesson)
        if example.state == state and example.kind is ExampleKind.WATCHED
    ]


def _list_otherwise(lesson: Lesson, examples: Sequence[Example], function: Transition) -> tuple[Example, ...]:
    return tuple(
        each
        for each in examples
        if name_next_state(lesson.automaton, each.state, function.decide(each.values)) != each.next
    )
