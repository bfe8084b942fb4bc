"""What of a lesson is never used: states that are never left or entered, features that decide nothing."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.errors import join_names
from understudy.learning.training_set import select_teaching_examples
from understudy.model.tree import TestKind, Tree


def advise_on_states_never_left(survey: LessonAnalysis) -> Iterator[Advice]:
    """States, other than flag states, that no example leaves; where it begins is the most urgent."""
    automaton, examples = survey.lesson.automaton, select_teaching_examples(survey.lesson)
    if automaton.stateless:
        return
    left = {example.state for example in examples if example.next != example.state}
    entered = {example.next for example in examples}
    for index, state in enumerate(automaton.states):
        if state.flag is not None or state.name in left or (index and state.name not in entered):
            continue
        if index == 0:
            sentence = f"Show me what to do first: nothing leads from {state.name} to any other state."
        else:
            sentence = f"Show me when to leave {state.name}: so far I stay in it for good."
        yield Advice(AdviceKind.NEVER_LEFT, sentence, state.name, 0.9 if index == 0 else 0.6)


def advise_on_states_never_entered(survey: LessonAnalysis) -> Iterator[Advice]:
    """States that no example leads to."""
    automaton = survey.lesson.automaton
    entered = {example.next for example in select_teaching_examples(survey.lesson)}
    for state in automaton.states[1:]:
        if state.name not in entered:
            what = f"say {state.flag}" if state.flag is not None else f"go to {state.name}"
            yield Advice(
                AdviceKind.NEVER_ENTERED,
                f"Show me when to {what}, or leave it out: nothing you showed leads there.",
                state.name,
                0.55 if state.flag is None else 0.8,
            )


def advise_on_unused_features(survey: LessonAnalysis) -> Iterator[Advice]:
    """Features that no tree asks about."""
    trees = [function for function in survey.transitions.values() if isinstance(function, Tree)]
    if survey.scant or not trees or len(trees) < len(survey.transitions):
        return
    used = {node.feature for tree in trees for node in tree.nodes if node.test != TestKind.LEAF}
    names = [str(bound) for index, bound in enumerate(survey.lesson.automaton.features) if index not in used]
    if names:
        many = len(names) > 1
        yield Advice(
            AdviceKind.IDLE,
            f"Leave out {join_names(names)}, or show me where {'they matter' if many else 'it matters'}: so far "
            f"{'they decide' if many else 'it decides'} nothing.",
            "",
            0.2,
        )
