"""What learning a lesson came to, state by state: conditions, sizes, contradictions and disagreements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

from understudy.learning.fit import learn_state
from understudy.learning.training_set import (
    group_by_feature_vector,
    group_examples_by_state,
    select_teaching_examples,
)
from understudy.learning.tree_growth import compile_tree_kernels
from understudy.model.automaton import Transition
from understudy.model.describe import list_shown_vectors
from understudy.model.lesson import Example, Lesson, TreeOptions
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import describe_exits


@dataclass(frozen=True, slots=True)
class StateReport:
    """What one state learned. `find_contradictions` and `find_disagreements` are how many there are (see below)."""

    conditions: tuple[str, ...]
    nodes: int
    depth: int
    contradictions: int
    disagreements: int
    fit_ms: float


@dataclass(frozen=True, slots=True)
class Report:
    """What a lesson came to: the transition functions, and a report for each state that has one."""

    transitions: Mapping[str, Transition]
    states: Mapping[str, StateReport]


def learn_and_report(lesson: Lesson) -> Report:
    """Learn a lesson and say what came of it. In stateless mode all states share one function and one fit.

    `fit_ms` is from Example objects to a finished function, without the kernel's compilation.
    """
    if isinstance(lesson.options.learner, TreeOptions):
        compile_tree_kernels()
    transitions: dict[str, Transition] = {}
    states: dict[str, StateReport] = {}
    shared: tuple[Transition, float] | None = None
    for name, examples in group_examples_by_state(lesson).items():
        if shared is None or not lesson.automaton.stateless:
            began = perf_counter()
            function = learn_state(lesson, name, examples)
            shared = function, (perf_counter() - began) * 1e3
        function, fit_ms = shared
        transitions[name] = function
        states[name] = StateReport(
            conditions=_sentences(lesson, name, function),
            nodes=len(function.nodes) if isinstance(function, Tree) else 0,
            depth=function.depth if isinstance(function, Tree) else 0,
            contradictions=len(find_contradictions(lesson, name)),
            disagreements=len(find_disagreements(lesson, name, function)),
            fit_ms=fit_ms,
        )
    return Report(transitions, states)


def _sentences(lesson: Lesson, state: str, function: Transition) -> tuple[str, ...]:
    automaton = lesson.automaton
    if not isinstance(function, Tree):
        return (f"decided by {type(getattr(function, 'classifier', function)).__name__} of scikit-learn",)
    return describe_exits(
        function, automaton.features, automaton.state_names, state, list_shown_vectors(lesson, state)
    )


def find_contradictions(lesson: Lesson, state: str) -> tuple[tuple[Example, ...], ...]:
    """The state's directives and confirmations that contradict each other, grouped by feature vector."""
    told = [example for example in group_examples_by_state(lesson).get(state, ()) if example.is_shown]
    return tuple(
        tuple(group)
        for group in group_by_feature_vector(told).values()
        if len({example.next for example in group}) > 1
    )


def find_disagreements(lesson: Lesson, state: str, function: Transition) -> tuple[Example, ...]:
    """The state's press-made examples that its transition function decides otherwise than shown."""
    names = lesson.automaton.state_names
    found = []
    for example in select_teaching_examples(lesson):
        if example.state == state and example.is_from_press:
            outcome = function.decide(example.values)
            if (state if outcome == STAY else names[outcome]) != example.next:
                found.append(example)
    return tuple(found)
