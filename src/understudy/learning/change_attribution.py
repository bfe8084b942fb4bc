"""Attribution of changes: the examples that caused a condition of an automaton to move, appear or vanish.

Between two versions of a lesson, examples are new, gone, edited, put in quarantine or let out of it; in a lesson that
was started again, a number may belong to another press. Such a changed example is a cause if it fulfills a condition
that changed, if it shows another next state there, or if it is next to a threshold that the other version does not
have. If there is no such example, the causes are those changed examples without which, one at a time, the change
would not have happened.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from understudy.learning.explain import find_rows_by_node
from understudy.learning.fit import learn_state
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Transition, query_next_state
from understudy.model.describe import list_shown_vectors, name_examples
from understudy.model.lesson import Example, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree
from understudy.model.tree_regions import Box
from understudy.model.tree_text import describe_boxes, simplify_outcome_boxes
from understudy.model.value_kinds import Toroidal

Lines: TypeAlias = Mapping[str, Mapping[str, Box]]
"""The conditions for each next state, each with its box of feature vectors."""
Numbered: TypeAlias = Mapping[int, Example]
"""Examples by number."""
MOST_NAMED = 6
"""The largest number of examples that a sentence names."""
MOST_TRIED = 20
"""The largest number of changed examples for which it is tried whether one of them caused a change elsewhere."""
SHOWN_ANEW = "shown anew"
"""The text for an example whose number now belongs to another press."""
SIGNIFICANT = 1e-9
"""The distance below which values count as equal; a threshold may be the next float after an example's value."""


@dataclass(frozen=True, slots=True)
class ExampleAttribution:
    """An example that caused a change: what `happened` to it, and `how` it is connected with the change.

    `happened` is "new", "gone", "edited", "in quarantine", "let out", "read anew" if the lesson's features or
    reaction time changed, or "shown anew" if its number now belongs to another press, as in a lesson that was started
    again.
    """

    number: int
    happened: str
    how: str


HowMoved: TypeAlias = Literal["moved", "appeared", "vanished"]
"""The kind of a change: conditions for a next state were replaced, were added to none, or were all removed."""


@dataclass(frozen=True, slots=True)
class ConditionChange:
    """A change of the conditions for one next state: those that are gone, those that are new, and its causes.

    `said` is a sentence: "goto → done moved: examples 3 (gone, showed it) and 7 (new, shows it)".
    """

    state: str
    next: str
    what: HowMoved
    gone: tuple[str, ...]
    new: tuple[str, ...]
    said: str
    examples: tuple[ExampleAttribution, ...]


def attribute_condition_changes(
    before: TrainedAutomaton, after: TrainedAutomaton
) -> tuple[ConditionChange, ...]:
    """List every change of conditions between two versions of an automaton, with the examples that caused it.

    The result is empty if one version has no lesson. Only decision trees have conditions.
    """
    if before.lesson is None or after.lesson is None:
        return ()
    changes = []
    for state in dict.fromkeys([*before.automaton.transitions, *after.automaton.transitions]):
        pair = _StateDiff(state, before, after, before.lesson, after.lesson)
        changes += list(pair.list_condition_changes())
    return tuple(changes)


class _StateDiff:
    """Two versions of one state: its examples and its transition functions."""

    def __init__(
        self,
        state: str,
        before: TrainedAutomaton,
        after: TrainedAutomaton,
        old_lesson: Lesson,
        new_lesson: Lesson,
    ) -> None:
        self.state, self.before, self.after = state, before, after
        self.old_lesson, self.new_lesson = old_lesson, new_lesson
        self.old = {each.number: each for each in group_examples_by_state(old_lesson).get(state, ())}
        self.new = {each.number: each for each in group_examples_by_state(new_lesson).get(state, ())}
        self.happened = dict(self._happened())
        self.alike = before.automaton.features == after.automaton.features

    def _happened(self) -> Iterator[tuple[int, str]]:
        """Yield the number of each example that differs between the versions, and what happened to it."""
        was = {each.number: each for each in self.old_lesson.examples}
        now = {each.number: each for each in self.new_lesson.examples}
        for number in sorted({*self.old, *self.new}):
            old, new = self.old.get(number), self.new.get(number)
            if number in was and number in now and self._is_another(was[number], now[number]):
                yield number, SHOWN_ANEW
            elif old is None:
                yield number, _into(was.get(number))
            elif new is None:
                yield number, _out(now.get(number))
            elif (old.next, old.kind) != (new.next, new.kind) or (old.edited, new.edited) == (False, True):
                yield number, "edited"
            elif not _same(old.values, new.values):
                yield number, "edited" if new.edited else "read anew"

    def _is_another(self, old: Example, new: Example) -> bool:
        """Return whether two examples with the same number come from different presses, as in a lesson started again.

        Their moments differ then: in time, or in a reading that both lessons recorded. Examples from tables have no
        moment.
        """
        if old.moment is None or new.moment is None:
            return False
        was, now = self.old_lesson.record, self.new_lesson.record
        shared = [key for key in was.keys if key in now.keys]
        first, second = (
            (record.seconds[at], *(record.values[at, record.keys.index(key)] for key in shared))
            for record, at in ((was, old.moment), (now, new.moment))
        )
        return not _same(first, second)

    def list_condition_changes(self) -> Iterator[ConditionChange]:
        """Yield the change of conditions for each next state that has one."""
        old, new = self._lines(self.before, self.old_lesson), self._lines(self.after, self.new_lesson)
        for following in dict.fromkeys([*old, *new]):
            was, now = old.get(following, {}), new.get(following, {})
            gone = {line: box for line, box in was.items() if line not in now}
            come = {line: box for line, box in now.items() if line not in was}
            if gone or come:
                what: HowMoved = "moved" if was and now else "appeared" if now else "vanished"
                examples = self._responsible(following, gone, come)
                sentence = f"{self.state} → {following} {what}: {_name_examples(examples)}"
                yield ConditionChange(
                    self.state, following, what, tuple(gone), tuple(come), sentence, examples
                )

    def _lines(self, taught: TrainedAutomaton, lesson: Lesson) -> Lines:
        automaton = taught.automaton
        tree = automaton.transitions.get(self.state)
        if not isinstance(tree, Tree):
            return {}
        names, vectors = automaton.state_names, list_shown_vectors(lesson, self.state)
        return {
            names[outcome]: dict(
                zip(describe_boxes(tree, automaton.features, boxes, vectors), boxes, strict=True)
            )
            for outcome, boxes in simplify_outcome_boxes(tree, automaton.features).items()
            if names[outcome] != self.state
        }

    def _responsible(
        self, following: str, gone: Mapping[str, Box], come: Mapping[str, Box]
    ) -> tuple[ExampleAttribution, ...]:
        causes: dict[int, str] = {}
        for boxes, lost in ((come, False), (gone, True)):
            for box in boxes.values():
                for number, how in self._reaching(following, box, lost=lost):
                    causes.setdefault(number, how)
        for boxes, taught, mine in ((come, self.after, self.new), (gone, self.before, self.old)):
            for number in self._bounding(boxes, taught, mine):
                if number in self.happened:
                    causes.setdefault(number, "bounds it" if mine is self.new else "bounded it")
        if not causes:
            needed = self._needed(following)
            causes = dict.fromkeys(needed, "elsewhere, without it this would not be")
        if not causes:
            causes = dict.fromkeys(self.happened, "elsewhere, with the others")
        return tuple(
            ExampleAttribution(number, self.happened[number], causes[number]) for number in sorted(causes)
        )

    def _reaching(self, following: str, box: Box, *, lost: bool) -> Iterator[tuple[int, str]]:
        """Yield the changed examples that fulfill a condition, and how each causes the change.

        The condition is new or, if `lost`, was removed.
        """
        for number in self.happened:
            old, new = self.old.get(number), self.new.get(number)
            mine, other = (old, new) if lost else (new, old)
            if mine is not None and mine.next == following and _inside(mine, box):
                yield number, "showed it" if lost else "shows it"
            elif other is not None and other.next != following and self._heard_in(box, other, lost=lost):
                yield number, "contradicts it there" if lost else "contradicted it there"

    def _heard_in(self, box: Box, example: Example, *, lost: bool) -> bool:
        """Return whether an example lies in this box and the other version decided it as it shows."""
        if not (self.alike and _inside(example, box)):
            return False
        automaton = (self.after if lost else self.before).automaton
        return example.next == query_next_state(automaton, self.state, example.values)

    def _bounding(self, boxes: Mapping[str, Box], taught: TrainedAutomaton, mine: Numbered) -> Iterator[int]:
        """Yield the numbers of the examples next to new thresholds at the ends of the conditions `boxes`.

        A threshold is new if the tree of the other version does not have it. `mine` are this version's examples by
        number.
        """
        features, tree = taught.automaton.features, taught.automaton.transitions.get(self.state)
        if not (isinstance(tree, Tree) and boxes):
            return
        cuts = self._cuts(self.before if taught is self.after else self.after)
        examples = list(mine.values())
        vectors = np.array([each.values for each in examples]).reshape(len(examples), len(features))
        reach = find_rows_by_node(tree, vectors)
        for node, rows in zip(tree.nodes, reach, strict=True):
            for cut in _ends(node):
                ends = {end for box in boxes.values() for part in box[node.feature].parts for end in part}
                if cut in ends and (str(features[node.feature]), cut) not in cuts:
                    kind = features[node.feature].kind
                    period = kind.period if isinstance(kind, Toroidal) else None
                    yield from _nearest([examples[row] for row in rows.tolist()], node.feature, cut, period)

    def _cuts(self, taught: TrainedAutomaton) -> set[tuple[str, float]]:
        tree = taught.automaton.transitions.get(self.state)
        nodes = tree.nodes if isinstance(tree, Tree) else ()
        return {(str(taught.automaton.features[node.feature]), cut) for node in nodes for cut in _ends(node)}

    def _needed(self, following: str) -> list[int]:
        """List the changed examples each of which, if it had not changed, would lead to other conditions."""
        now = set(self._lines(self.after, self.new_lesson).get(following, {}))
        return [number for number, lines in self._without.items() if set(lines.get(following, {})) != now]

    @cached_property
    def _without(self) -> Mapping[int, Lines]:
        """The conditions that would be learned if one changed example had not changed, by the number of that example.

        Empty if more than MOST_TRIED examples changed or the features differ; classifiers have no conditions.
        """
        lines_without = {}
        for number in self.happened if self.alike and len(self.happened) <= MOST_TRIED else ():
            examples = {**self.new, number: self.old.get(number)}
            lines = self._lines_of(tuple(each for each in examples.values() if each is not None))
            if lines is not None:
                lines_without[number] = lines
        return lines_without

    def _lines_of(self, examples: tuple[Example, ...]) -> Lines | None:
        if not any(example.is_from_press for example in examples):
            return {}
        lesson = replace(self.new_lesson, examples=examples)
        function: Transition = learn_state(lesson, self.state, examples)
        automaton = replace(self.after.automaton, transitions={self.state: function})
        return (
            self._lines(TrainedAutomaton(automaton, lesson), lesson) if isinstance(function, Tree) else None
        )


def _name_examples(examples: Sequence[ExampleAttribution]) -> str:
    """List the examples that caused a change, such as "examples 3 (new, bounds it) and 2 more"."""
    if not examples:
        return "it is learned otherwise"
    return name_examples([f"{who.number} ({who.happened}, {who.how})" for who in examples], most=MOST_NAMED)


def _into(former: Example | None) -> str:
    """Say why an example is used for a state that was not used for it before."""
    if former is None:
        return "new"
    return "let out" if former.quarantined else "edited"


def _out(now: Example | None) -> str:
    """Say why an example is no longer used for a state."""
    if now is None:
        return "gone"
    return "in quarantine" if now.quarantined else "edited"


def _same(first: Sequence[float], second: Sequence[float]) -> bool:
    """Return whether two vectors are equal, where absent equals absent."""
    return len(first) == len(second) and all(
        one == other or (one != one and other != other) for one, other in zip(first, second, strict=True)
    )


def _inside(example: Example, box: Box) -> bool:
    return all(value in region for value, region in zip(example.values, box, strict=True))


def _ends(node: Node) -> tuple[float, ...]:
    """Return the thresholds of a node."""
    if node.test == TestKind.BELOW:
        return (node.high,)
    return (node.low, node.high) if node.test == TestKind.ARC else ()


def _nearest(examples: Sequence[Example], feature: int, cut: float, period: float | None) -> Iterator[int]:
    """Yield the numbers of the examples nearest to a cut on either side, all of those that are equally near."""
    present = [(each.number, each.values[feature]) for each in examples]
    present = [(number, value) for number, value in present if value == value]
    if period is None:
        above = [(value - cut, number) for number, value in present if value >= cut]
        under = [(cut - value, number) for number, value in present if value < cut]
    else:
        above = [((value - cut) % period, number) for number, value in present]
        under = [((cut - value) % period or period, number) for number, value in present]
    for side in (above, under):
        least = min(side, default=(0.0, 0))[0]
        yield from (number for far, number in side if far <= least + SIGNIFICANT)
