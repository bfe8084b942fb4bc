"""Fit transition functions to a lesson, and predict next states with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from understudy.learning.csv_table import QueryRow
from understudy.learning.pruning import prune_tree
from understudy.learning.sklearn_adapter import fit_classifier
from understudy.learning.training_set import (
    TrainingSet,
    group_examples_by_state,
    make_training_set,
    select_teaching_examples,
)
from understudy.learning.tree_growth import grow_tree
from understudy.model.automaton import Automaton, Transition
from understudy.model.lesson import Example, Lesson, SklearnOptions
from understudy.model.tree import STAY


def learn(lesson: Lesson) -> Mapping[str, Transition]:
    """The transition function of every state that was pressed in; the same whatever the examples' order.

    In stateless mode one function, the very same object, for every state that raises no flag.
    """
    taught = group_examples_by_state(lesson)
    if lesson.automaton.stateless:
        shared = {name: learn_state(lesson, name, examples) for name, examples in list(taught.items())[:1]}
        return MappingProxyType({name: function for function in shared.values() for name in taught})
    return MappingProxyType({name: learn_state(lesson, name, examples) for name, examples in taught.items()})


def learn_automaton(lesson: Lesson) -> Automaton:
    """The lesson's automaton with the transition functions learned from it."""
    return replace(lesson.automaton, transitions=learn(lesson))


def learn_state(lesson: Lesson, state: str, examples: tuple[Example, ...]) -> Transition:
    """The transition function of one state from the examples that teach it."""
    return make_fitter(lesson)(make_training_set(lesson, examples, state))


def make_fitter(lesson: Lesson) -> Callable[[TrainingSet], Transition]:
    """What makes a transition function of arrays of a lesson's examples, in the way that the lesson chose."""
    automaton, learner = lesson.automaton, lesson.options.learner
    kinds = [bound.kind for bound in automaton.features]
    if isinstance(learner, SklearnOptions):
        return lambda shown: fit_classifier(learner, shown, kinds)
    midpoints = automaton.stateless or learner.boundary == "midpoint" or _watches(lesson)

    def grown(shown: TrainingSet) -> Transition:
        tree = grow_tree(
            shown.values,
            shown.outcomes,
            shown.groups,
            kinds,
            states=len(automaton.states),
            current=shown.current,
            midpoints=midpoints,
        )
        return prune_tree(tree, shown, learner.pruning) if learner.pruning else tree

    return grown


def _watches(lesson: Lesson) -> bool:
    return lesson.options.watched or any(
        not example.is_from_press for example in select_teaching_examples(lesson)
    )


def predict_next_states(
    transitions: Mapping[str, Transition], state_names: Sequence[str], rows: Iterable[QueryRow]
) -> list[str]:
    """The next state of each row; a state without a transition function keeps itself."""
    found = []
    for row in rows:
        function = transitions.get(row.state)
        outcome = STAY if function is None else function.decide(row.values)
        found.append(row.state if outcome == STAY else state_names[outcome])
    return found
