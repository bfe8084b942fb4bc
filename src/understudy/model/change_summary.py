"""Summaries of changes: what an automaton decides otherwise than before, in one line.

Nothing is said of what a press itself says: that the pressed switch is made around the press. Said are decisions that
are gone or new, those that look at other features than before, and those whose conditions moved, where the change is
more than a little.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

from understudy.errors import join_names
from understudy.model.automaton import name_next_state
from understudy.model.box_cover import cover_boxes, find_hull
from understudy.model.describe import list_shown_vectors
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import STAY, TestKind, Tree, make_leaf
from understudy.model.tree_overlay import OverlayCell, ReadingSpread, find_features_between, overlay_boxes
from understudy.model.tree_regions import Box, find_known_absent, list_leaf_boxes
from understudy.model.tree_text import describe_box, describe_tree_outcomes

LITTLE = 0.05
"""A change is little if it concerns less than this share of the readings at the presses in its state.

A decision that looks at other features changes, too, where no press was, so the range of these readings counts as well.
A cut that moved counts by the presses that it passed: between two presses, it has to lie somewhere.
"""
NARROW = 0.02
"""A cut moved a little, too, if it moved by less than this share of the range: 7° of a circle, or 9 cm of 4.5 m.

A decision that lost half of its conditions lost much, however narrow they were. Nor does this hold for other features:
a flag that is raised within 5° at any distance ends every drive.
"""
MOST_NAMED = 2
"""The largest number of changed decisions that a line names."""
MOST_CELLS = 1_600
"""The largest product of the leaves of two trees that are compared in full.

Of larger ones, which fit noise, only decisions that are gone, new or overruled are named, without their conditions.
"""

HowChanged: TypeAlias = Literal["overruled", "gone", "new", "features", "less", "more"]
"""The way in which a decision changed, most important first.

"overruled": an example of the press is decided otherwise than it shows. "gone", "new": the next state is reached no
more, or for the first time. "features": other features decide about it. "less", "more": it is decided under fewer or
more conditions.
"""
NEVER_LEFT = Tree((make_leaf(STAY),))
"""The tree of a state that has no transition function."""
_ORDER: tuple[HowChanged, ...] = ("overruled", "gone", "new", "features", "less", "more")


@dataclass(frozen=True, slots=True)
class TransitionChange:
    """A decision that changed: to go from `state`, which is empty in a stateless automaton, to `next`, or to stay.

    `said` is a sentence: "forward no longer goes to rotate_left". `was` and `now` are the former and the present
    conditions in words, one for each alternative. `share` is the share of the state's readings, from 0 to 1, for which
    it is decided otherwise. `looks` are the features at which it looks now and did not, and those at which it no longer
    looks; None unless these changed.
    """

    state: str
    next: str
    how: HowChanged
    said: str
    was: tuple[str, ...]
    now: tuple[str, ...]
    share: float
    looks: tuple[tuple[str, ...], tuple[str, ...]] | None = None

    def list_differences(self) -> tuple[list[str], list[str]]:
        """List the conditions that are gone, and those that are new, in words."""
        gone = [when for when in self.was if when not in self.now]
        return gone, [when for when in self.now if when not in self.was]


@dataclass(frozen=True, slots=True)
class ChangeSummary:
    """What an automaton decides otherwise than before; `str` is one line.

    Parameters
    ----------
    changes
        The changed decisions, the most important first; at least one.
    """

    changes: tuple[TransitionChange, ...]

    def __str__(self) -> str:
        sentences = dict.fromkeys(self._say(each) for each in self.changes)
        named, more = list(sentences)[:MOST_NAMED], len(sentences) - MOST_NAMED
        return "; ".join([*named, *([f"and {more} more"] if more > 0 else [])])

    def _say(self, change: TransitionChange) -> str:
        """Describe a change, together with those of the same state that depend on the same other features."""
        if change.looks is None:
            return change.said
        alike = [
            each.next for each in self.changes if (each.state, each.looks) == (change.state, change.looks)
        ]
        return _say_features(change.state, alike, change.looks)


def summarize_change(
    before: TrainedAutomaton, after: TrainedAutomaton, pressed: Sequence[Example] = ()
) -> ChangeSummary | None:
    """Summarize what an automaton decides otherwise than its former version.

    Parameters
    ----------
    before
        The former version.
    after
        The later version. Its examples say which readings occur in a state.
    pressed
        The examples by which they differ. What they say themselves is left out.

    Returns
    -------
    ChangeSummary | None
        The changed decisions. None if there is nothing to say, if the versions look at different features, or if
        they are not decision trees.
    """
    old, new = before.automaton, after.automaton
    looks = [[(str(bound), bound.kind) for bound in each.features] for each in (old, new)]
    if looks[0] != looks[1] or old.stateless != new.stateless:
        return None
    changes: list[TransitionChange] = []
    for state, was in list(old.transitions.items())[: 1 if old.stateless else None]:
        now = new.transitions.get(state, NEVER_LEFT)
        if state in new.state_names and isinstance(was, Tree) and isinstance(now, Tree):
            here = [each for each in pressed if new.stateless or each.state == state]
            versions = (_Version(was, before, state), _Version(now, after, state))
            if was != now or here:
                changes += _StateComparison(*versions, here).list_changes()
    flags = {state.name for each in (old, new) for state in each.states if state.flag is not None}
    changes.sort(key=lambda each: _rank(each, flags))
    return ChangeSummary(tuple(changes)) if changes else None


def _rank(change: TransitionChange, flags: Set[str]) -> tuple[int, bool, int, float]:
    """Return the rank of a change, least for the most important: a flag that is raised elsewhere ends a behavior."""
    order = _ORDER.index(change.how)
    return min(order, _ORDER.index("features")), change.next not in flags, order, -change.share


class _Version:
    """One version of the decisions in a state."""

    def __init__(self, tree: Tree, taught: TrainedAutomaton, state: str) -> None:
        automaton = taught.automaton
        self.tree, self.automaton = tree, automaton
        self.state = "" if automaton.stateless else state
        self.shown = list_shown_vectors(taught.lesson, state)
        self.pressed = [
            each.values
            for each in (() if taught.lesson is None else taught.lesson.examples)
            if each.is_from_press and not each.quarantined and (not self.state or each.state == state)
        ]
        self.reached = {self.name(each) for each in _list_outcomes(tree)}

    def name(self, outcome: int) -> str:
        """Return the name of the next state, which is the state itself if it is kept."""
        return name_next_state(self.automaton, self.state, outcome)

    def decide(self, example: Example) -> str:
        """Return the name of the next state for the readings of an example."""
        return self.name(self.tree.decide(example.values))

    @cached_property
    def conditions(self) -> Mapping[str, tuple[str, ...]]:
        """The conditions in words for each next state."""
        texts_by_outcome = describe_tree_outcomes(self.tree, self.automaton.features, self.shown)
        return {self.name(outcome): texts for outcome, texts in texts_by_outcome.items()}


class _StateComparison:
    """The comparison of two versions of the decisions in one state, apart from what examples of presses say."""

    def __init__(self, old: _Version, new: _Version, pressed: Sequence[Example]) -> None:
        self._old, self._new, self._state = old, new, new.state
        self._features = new.automaton.features
        self._kinds = [bound.kind for bound in self._features]
        absent = (find_known_absent(version.tree, len(self._kinds)) for version in (old, new))
        self._known_absent = list(map(any, zip(*absent, strict=True)))
        self._pressed = [example for example in pressed if not example.quarantined]
        self._pressed_next = {example.next for example in self._pressed}
        self._own = {(old.decide(example), example.next) for example in self._pressed}
        states = [state for each in (old, new) for state in each.automaton.states]
        self._flags = {state.name for state in states if state.flag is not None}
        self._spread = ReadingSpread(new.pressed or old.pressed, self._kinds)

    @cached_property
    def _leaves(self) -> tuple[list[tuple[str, Box]], list[tuple[str, Box]]]:
        """The next state and the box of each leaf of both versions."""
        old, new = (
            [
                (version.name(each), box)
                for each, box in list_leaf_boxes(version.tree, self._kinds, known_absent=self._known_absent)
            ]
            for version in (self._old, self._new)
        )
        return old, new

    @cached_property
    def _cells(self) -> Sequence[OverlayCell]:
        """The boxes in which both versions decide in one way each; none if the trees are too large."""
        return overlay_boxes(*self._leaves) if self._is_compared else ()

    @cached_property
    def _is_compared(self) -> bool:
        old, new = self._leaves
        return len(old) * len(new) <= MOST_CELLS

    def list_changes(self) -> Iterator[TransitionChange]:
        """Yield the change of each next state that has one to be said."""
        overruled = {each.next: each for each in self._pressed if self._new.decide(each) != each.next}
        names = (self._state, *self._new.automaton.state_names, *self._old.automaton.state_names)
        for following in dict.fromkeys(names):
            was, now = following in self._old.reached, following in self._new.reached
            if following in overruled:
                example = overruled[following]
                yield self._make(following, "overruled", self._say_overruled(example))
            elif was and not now:
                yield self._make(following, "gone", self._say_gone(following))
            elif now and not was and following not in self._pressed_next and following != self._state:
                yield self._make(following, "new", f"{self._name} now also {self._goes(following)}")
            elif was and now and following != self._state and (change := self._compare(following)):
                yield change

    def _compare(self, following: str) -> TransitionChange | None:
        """Compare the conditions for a next state that is reached in both versions."""
        changed = self._list_changed(following)
        if self._measure(changed) < LITTLE:
            return None
        was, now = self._find_features(following)
        if was != now:
            come, gone = (
                tuple(str(self._features[each]) for each in sorted(some)) for some in (now - was, was - now)
            )
            sentence = _say_features(self._state, [following], (come, gone))
            return replace(self._make(following, "features", sentence), looks=(come, gone))
        return self._compare_conditions(following, changed)

    def _compare_conditions(self, following: str, changed: Sequence[OverlayCell]) -> TransitionChange | None:
        """Compare the conditions of a next state on the same features; a swap of two states is reported once."""
        beyond = [cell for cell in changed if (cell.was, cell.now) not in self._own]
        before = (
            {self._state} if following not in self._flags else {cell.was for cell in beyond} - {following}
        )
        less = [cell for cell in beyond if cell.was == following and cell.now not in self._flags]
        more = [cell for cell in beyond if cell.was in before]
        narrow = min(NARROW, self._cover([cell for cell in self._cells if cell.was == following]) / 2)
        is_less = self._count(less) >= LITTLE and self._cover(less) >= narrow
        is_more = self._count(more) >= LITTLE and self._cover(more) >= NARROW
        if not (is_less or is_more):
            return None
        sentence = self._say_where(following, more if is_more else (), less if is_less else ())
        return self._make(following, "more" if is_more else "less", sentence)

    def _find_features(self, following: str) -> tuple[set[int], set[int]]:
        """Find the features that a next state depends on, formerly and now.

        What another pressed state has taken makes no difference: the press says so itself.
        """
        taken = self._pressed_next - {following}
        old, new = self._leaves
        outside = [box for name, box in new if name != following and name not in taken]
        outside += [cell.box for cell in self._cells if cell.was == cell.now in taken]
        return (
            find_features_between(
                [box for name, box in old if name == following],
                [box for name, box in old if name != following],
            ),
            find_features_between([box for name, box in new if name == following], outside),
        )

    def _list_changed(self, following: str) -> list[OverlayCell]:
        return [cell for cell in self._cells if (cell.was == following) != (cell.now == following)]

    def _count(self, cells: Sequence[OverlayCell]) -> float:
        """Return the share of the values at presses that lie in some cells, which a moved cut has passed."""
        return self._spread.count_values(cell.box for cell in cells)

    def _measure(self, cells: Sequence[OverlayCell]) -> float:
        """Return the share of the values of presses, or of their range, whichever is larger."""
        return max(self._count(cells), self._cover(cells))

    def _cover(self, cells: Sequence[OverlayCell]) -> float:
        """Return the share of the range of presses in some cells."""
        return self._spread.cover_range(cell.box for cell in cells)

    def _make(self, following: str, how: HowChanged, sentence: str) -> TransitionChange:
        changed = self._list_changed(following)
        is_described = following != self._state and self._is_compared
        was, now = (
            version.conditions.get(following, ()) if is_described else ()
            for version in (self._old, self._new)
        )
        return TransitionChange(self._state, following, how, sentence, was, now, self._measure(changed))

    # Words

    @property
    def _name(self) -> str:
        return self._state or "it"

    def _goes(self, following: str) -> str:
        """Say that a state is gone to, or that its flag is raised."""
        return f"{'raises' if following in self._flags else 'goes to'} {following}"

    def _say_overruled(self, example: Example) -> str:
        decided = self._new.decide(example)
        goes = "stays" if decided in (self._state, example.state) else self._goes(decided)
        if example.kind is ExampleKind.DEFAULT:
            return f"{example.state} {goes} at once"
        if example.next == example.state:
            return f"{example.state} still {goes} where it was confirmed"
        return f"{example.state} still {goes} where {example.next} was pressed"

    def _say_gone(self, following: str) -> str:
        if following == self._state:
            return f"{self._name} is now always left"
        return f"{self._name} no longer {self._goes(following)}"

    def _say_where(self, following: str, more: Sequence[OverlayCell], less: Sequence[OverlayCell]) -> str:
        """Describe for which readings a next state is decided now that was not before, and for which no longer."""
        unchanged = [cell.box for cell in self._cells if cell.was == following == cell.now]
        if not unchanged:
            return f"{self._name} now {self._goes(following)} elsewhere than before"
        goes = self._goes(following)
        if not more:
            return f"{self._name} no longer {goes} where {self._describe(less, unchanged)}"
        rest = f", but no longer where {self._describe(less, unchanged)}" if less else ""
        return f"{self._name} now also {goes} where {self._describe(more, unchanged)}{rest}"

    def _describe(self, cells: Sequence[OverlayCell], unchanged: Sequence[Box]) -> str:
        """Describe the largest part of the cells that are decided otherwise, compared with those that are not."""
        changed = [cell.box for cell in cells]
        largest = max(cover_boxes(changed, unchanged), key=lambda box: self._spread.count_values([box]))
        hull, whole = find_hull([*changed, *unchanged]), find_hull(cell.box for cell in self._cells)
        simplified = tuple(  # what always held where it was decided so need not be said
            full if region == widest else region
            for region, widest, full in zip(largest, hull, whole, strict=True)
        )
        return describe_box(simplified, self._features, self._known_absent, self._new.shown)


def _say_features(state: str, following: Sequence[str], looks: tuple[Sequence[str], Sequence[str]]) -> str:
    """Describe that decisions depend on other features."""
    come, gone = (join_names(names) if names else "" for names in looks)
    who = f"{f'in {state}, ' if state else ''}{join_names(following)}"
    look = "looks" if len(following) == 1 else "look"
    if come and gone:
        return f"{who} now {look} at {come}, no longer at {gone}"
    return f"{who} now also {look} at {come}" if come else f"{who} no longer {look} at {gone}"


def _list_outcomes(tree: Tree) -> list[int]:
    """List the outcome of each leaf, and STAY if there are labels that no example had."""
    leaves = [node.yes for node in tree.nodes if node.test == TestKind.LEAF]
    return [*leaves, *([STAY] if any(STAY in node.branches for node in tree.nodes) else [])]
