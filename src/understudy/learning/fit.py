"""Learning of transition functions from a lesson, and prediction of next states with them."""

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
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY


def learn(lesson: Lesson) -> Mapping[str, Transition]:
    """Learn a transition function for every state of a lesson that has press-made examples.

    The order of the examples makes no difference.

    Parameters
    ----------
    lesson
        The lesson.

    Returns
    -------
    Mapping[str, Transition]
        Transition function by state name: decision trees, or classifiers if the lesson's options say so. In a
        stateless lesson all states that raise no flag share one object.

    Raises
    ------
    DefinitionError
        If an example does not fit the automaton's features, or the classifier cannot be fitted.
    UnknownName
        If an example is of a state that the automaton does not have.
    SklearnMissing
        If the lesson needs scikit-learn, which is not installed.
    """
    taught = group_examples_by_state(lesson)
    if lesson.automaton.stateless:
        shared = {name: learn_state(lesson, name, examples) for name, examples in list(taught.items())[:1]}
        return MappingProxyType({name: function for function in shared.values() for name in taught})
    return MappingProxyType({name: learn_state(lesson, name, examples) for name, examples in taught.items()})


def learn_automaton(lesson: Lesson) -> Automaton:
    """Learn a lesson's automaton: the one of the lesson, with transition functions.

    Parameters
    ----------
    lesson
        The lesson.

    Returns
    -------
    Automaton
        The automaton; the lesson stays unchanged.

    Raises
    ------
    DefinitionError
        If an example does not fit the automaton's features, or the classifier cannot be fitted.
    UnknownName
        If an example is of a state that the automaton does not have.
    SklearnMissing
        If the lesson needs scikit-learn, which is not installed.
    """
    return replace(lesson.automaton, transitions=learn(lesson))


def learn_state(lesson: Lesson, state: str, examples: tuple[Example, ...]) -> Transition:
    """Learn the transition function of one state from the given examples."""
    return make_fitter(lesson)(make_training_set(lesson, examples, state))


def make_fitter(lesson: Lesson) -> Callable[[TrainingSet], Transition]:
    """Make the function that learns a transition function from a training set, with the lesson's options."""
    automaton, learner = lesson.automaton, lesson.options.learner
    kinds = [bound.kind for bound in automaton.features]
    if isinstance(learner, SklearnOptions):
        return lambda training_set: fit_classifier(learner, training_set, kinds)
    flags = [index for index, state in enumerate(automaton.states) if state.flag is not None]
    midpoints = automaton.stateless or learner.boundary == "midpoint" or _watches(lesson)

    def grown(training_set: TrainingSet) -> Transition:
        tree = grow_tree(
            training_set.values,
            training_set.outcomes,
            training_set.groups,
            kinds,
            states=len(automaton.states),
            current=training_set.current,
            midpoints=midpoints,
            flags=flags if learner.order == "flags first" else (),
            silence=learner.order == "flags first",
        )
        return prune_tree(tree, training_set, learner.pruning) if learner.pruning else tree

    return grown


def _watches(lesson: Lesson) -> bool:
    return lesson.options.watched or any(
        not example.is_from_press for example in select_teaching_examples(lesson)
    )


def predict_next_states(
    transitions: Mapping[str, Transition], state_names: Sequence[str], rows: Iterable[QueryRow]
) -> list[str]:
    """Predict the next state of each row; a state without a transition function is kept."""
    states = []
    for row in rows:
        function = transitions.get(row.state)
        outcome = STAY if function is None else function.decide(row.values)
        states.append(row.state if outcome == STAY else state_names[outcome])
    return states
