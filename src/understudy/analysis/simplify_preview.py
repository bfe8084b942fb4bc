"""An automaton with fewer questions beside the one there is: shown before anybody decides to keep it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from understudy.analysis.lesson_replay import LessonReplay, replay_lesson
from understudy.errors import SettingError
from understudy.learning.fit import learn_automaton
from understudy.learning.pruning_suggestions import PruningSuggestion, replace_pruning, suggest_pruning
from understudy.model.automaton import Automaton
from understudy.model.describe import describe_transitions
from understudy.model.lesson import Lesson, TreeOptions
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import TestKind, Tree

T = TypeVar("T")
UNTOLD = 1.0
"""The pruning to show where nothing can be suggested: what one example alone holds up goes."""


@dataclass(frozen=True, slots=True)
class BeforeAfter(Generic[T]):
    """The same of two versions of an automaton."""

    before: T
    after: T


@dataclass(frozen=True, slots=True)
class ChangedDecision:
    """An example, what it showed, and the next states that are decided (None: it cannot be asked)."""

    number: int
    kind: str
    state: str
    shown: str
    before: str | None
    after: str


@dataclass(frozen=True, slots=True)
class ChangedMoments:
    """How many moments of a state are decided otherwise, and how."""

    state: str
    before: str
    after: str
    moments: int


@dataclass(frozen=True, slots=True)
class SimplifyPreview:
    """A lesson pruned: what is learned then, and how that decides its moments beside what `before` does; `suggested` is
    None where there are too few examples to tell.
    """

    pruning: float
    suggested: PruningSuggestion | None
    before: TrainedAutomaton
    after: TrainedAutomaton
    replayed: LessonReplay

    @property
    def leaves(self) -> BeforeAfter[int]:
        """How many answers all trees have."""
        return BeforeAfter(count_leaves(self.before.automaton), count_leaves(self.after.automaton))

    @property
    def conditions(self) -> dict[str, BeforeAfter[list[str]]]:
        """By state, in words, when it switches: of states where that would change."""
        was, now = (describe_transitions(each.automaton, each.lesson) for each in (self.before, self.after))
        both = {state: (was.get(state, []), now.get(state, [])) for state in dict.fromkeys([*was, *now])}
        return {state: BeforeAfter(old, new) for state, (old, new) in both.items() if old != new}

    @property
    def decisions(self) -> tuple[ChangedDecision, ...]:
        """The examples that would be decided otherwise than they are."""
        return tuple(
            ChangedDecision(each.number, each.kind, each.state, each.shown, each.formerly, each.now)
            for each in self.replayed.different
            if each.formerly != each.now
        )

    @property
    def changes_before_presses(self) -> tuple[ChangedMoments, ...]:
        """What would be decided otherwise at moments of the second before presses."""
        return tuple(
            ChangedMoments(each.state, each.formerly, each.now, each.moments)
            for each in self.replayed.changes
        )


def preview_simplification(taught: TrainedAutomaton, pruning: float | None = None) -> SimplifyPreview:
    """An automaton pruned, as much as is suggested where it is not said how much.

    SettingError where it was not taught with trees.
    """
    lesson = get_simplifiable_lesson(taught)
    found = suggest_pruning(lesson)
    asked = pruning if pruning is not None else UNTOLD if found is None else found.pruning
    pruned = replace_pruning(lesson, asked)
    after = TrainedAutomaton(learn_automaton(pruned), pruned)
    return SimplifyPreview(asked, found, taught, after, replay_lesson(after, taught))


def get_simplifiable_lesson(taught: TrainedAutomaton) -> Lesson:
    """The lesson of an automaton that was taught with trees; SettingError of another."""
    if taught.lesson is None:
        raise make_simplify_error(taught.automaton.name, "was written by hand", "name one that was taught")
    if not isinstance(taught.lesson.options.learner, TreeOptions):
        problem, remedy = "is decided by a classifier, which has no questions", "learn it with trees first"
        raise make_simplify_error(taught.automaton.name, problem, remedy)
    return taught.lesson


def make_simplify_error(name: str, problem: str, remedy: str) -> SettingError:
    """That an automaton cannot be simplified."""
    return SettingError(where="simplify", setting=f"automaton {name!r}", problem=problem, remedy=remedy)


def count_leaves(automaton: Automaton) -> int:
    """How many answers all its trees have."""
    trees = [tree for tree in automaton.transitions.values() if isinstance(tree, Tree)]
    return sum(node.test == TestKind.LEAF for tree in trees for node in tree.nodes)
