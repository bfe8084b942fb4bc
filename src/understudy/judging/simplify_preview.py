"""Comparison of an automaton with a simplified version that has smaller trees, before either is kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from understudy.errors import SettingError
from understudy.judging.lesson_replay import LessonReplay, replay_lesson
from understudy.learning.fit import learn_automaton
from understudy.learning.pruning_suggestions import PruningSuggestion, replace_pruning, suggest_pruning
from understudy.model.automaton import Automaton
from understudy.model.describe import describe_transitions
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import TestKind, Tree

T = TypeVar("T")
UNTOLD = 1.0
"""The pruning to preview if none can be suggested: it removes tests that only one example supports."""


@dataclass(frozen=True, slots=True)
class BeforeAfter(Generic[T]):
    """A value before and after simplification."""

    before: T
    after: T


@dataclass(frozen=True, slots=True)
class ChangedDecision:
    """An example that the simplified automaton decides otherwise.

    `shown` is the next state of the example; `before` and `after` are those decided. `before` is None if the former
    version cannot decide there.
    """

    number: int
    kind: str
    state: str
    shown: str
    before: str | None
    after: str


@dataclass(frozen=True, slots=True)
class ChangedMoments:
    """A number of recorded moments in a state at which the simplified automaton chooses `after` instead of `before`."""

    state: str
    before: str
    after: str
    moments: int


@dataclass(frozen=True, slots=True)
class SimplifyPreview:
    """A simplified version of an automaton, compared with the current one.

    `pruning` is the strength used. `suggested` is None if there are too few examples for a suggestion. `replayed` has
    the decisions of both at the recorded moments of the lesson.
    """

    pruning: float
    suggested: PruningSuggestion | None
    before: TrainedAutomaton
    after: TrainedAutomaton
    replayed: LessonReplay

    @property
    def leaves(self) -> BeforeAfter[int]:
        """The number of leaves of all trees, before and after."""
        return BeforeAfter(count_leaves(self.before.automaton), count_leaves(self.after.automaton))

    @property
    def conditions(self) -> dict[str, BeforeAfter[list[str]]]:
        """The descriptions of the transitions of each state whose description changes, before and after."""
        was, now = (describe_transitions(each.automaton, each.lesson) for each in (self.before, self.after))
        both = {state: (was.get(state, []), now.get(state, [])) for state in dict.fromkeys([*was, *now])}
        return {state: BeforeAfter(old, new) for state, (old, new) in both.items() if old != new}

    @property
    def decisions(self) -> tuple[ChangedDecision, ...]:
        """The examples that the two versions decide differently."""
        return tuple(
            ChangedDecision(each.number, each.kind, each.state, each.shown, each.formerly, each.now)
            for each in self.replayed.different
            if each.formerly != each.now
        )

    @property
    def changes_before_presses(self) -> tuple[ChangedMoments, ...]:
        """The changed decisions at moments in the second before presses."""
        return tuple(
            ChangedMoments(each.state, each.formerly, each.now, each.moments)
            for each in self.replayed.changes
        )


def preview_simplification(taught: TrainedAutomaton, pruning: float | None = None) -> SimplifyPreview:
    """Prune an automaton's trees and compare the result; refuse an automaton that was not learned as trees.

    Without `pruning`, the suggested strength is used, or UNTOLD if there is none.
    """
    lesson = get_simplifiable_lesson(taught)
    suggestion = suggest_pruning(lesson)
    strength = pruning if pruning is not None else UNTOLD if suggestion is None else suggestion.pruning
    pruned = replace_pruning(lesson, strength)
    after = TrainedAutomaton(learn_automaton(pruned), pruned)
    return SimplifyPreview(strength, suggestion, taught, after, replay_lesson(after, taught))


def get_simplifiable_lesson(taught: TrainedAutomaton) -> Lesson:
    """Return the lesson of an automaton that was learned as trees; raise SettingError for any other automaton."""
    if taught.lesson is None:
        raise make_simplify_error(taught.automaton.name, "was written by hand", "name one that was taught")
    if not isinstance(taught.lesson.options.learner, TreeOptions):
        problem, remedy = "is decided by a classifier, which has no questions", "learn it with trees first"
        raise make_simplify_error(taught.automaton.name, problem, remedy)
    return taught.lesson


def make_simplify_error(name: str, problem: str, remedy: str) -> SettingError:
    """Make the error that an automaton cannot be simplified."""
    return SettingError(where="simplify", setting=f"automaton {name!r}", problem=problem, remedy=remedy)


def count_leaves(automaton: Automaton) -> int:
    """Count the leaves of all trees of an automaton."""
    trees = [tree for tree in automaton.transitions.values() if isinstance(tree, Tree)]
    return sum(node.test == TestKind.LEAF for tree in trees for node in tree.nodes)
