"""Descriptions of trees in words: the conditions under which an automaton switches from one state to another.

Tests of one feature on the path to a leaf become one statement, leaves with the same outcome are joined, and
statements that make no difference are left out.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from math import ceil, degrees, floor, inf, isinf, nextafter
from typing import TypeAlias

from understudy.model.box_cover import cover_boxes
from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, PathStep, Tree
from understudy.model.tree_regions import (
    Box,
    Interval,
    ValueSet,
    find_known_absent,
    list_leaf_boxes,
    make_full_value_set,
    make_path_box,
)
from understudy.model.value_kinds import Categorical, Toroidal

HALF_TURN, FULL_TURN = 180.0, 360.0
MOST_DIGITS = 17


class FeatureText:
    """A writer of statements about one feature, with thresholds rounded to as few digits as possible.

    `cuts` are the feature's thresholds in a tree, `values` those of the examples. Rounded thresholds stay
    distinct, and every example stays on its side. The usual precision is whole degrees for angles, cm for
    lengths in m, otherwise three significant digits. Angles run from −180° to 180°, as readings do. `known_absent`
    is true if some example had the feature absent.
    """

    def __init__(
        self, bound: BoundFeature, cuts: Iterable[float], *, known_absent: bool, values: Iterable[float] = ()
    ) -> None:
        self.name, self.kind, self._known_absent = str(bound), bound.kind, known_absent
        self._angle = isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"
        self._unit = "°" if self._angle else f" {bound.feature.unit}" if bound.feature.unit else ""
        self._decimals = 0 if self._angle else 2 if bound.feature.unit == "m" else None
        self._said: dict[float, str] = {}
        present = sorted(value for value in values if value == value)
        self._shown_some = bool(present)
        before, rounded = -inf, -inf
        for cut in sorted(set(cuts)):
            at = bisect_left(present, cut)
            under = self._plain(present[at - 1]) if at else -inf
            over = self._plain(present[at]) if at < len(present) else inf
            exact = self._shown(cut)
            least = rounded if exact == before else nextafter(rounded, inf)
            self._said[cut], rounded = self._shortest(cut, least, under, over)
            before = exact

    def is_whole(self, region: ValueSet) -> bool:
        """Return whether a set of values excludes nothing that ever occurred, so that it need not be mentioned."""
        return region.parts == make_full_value_set(self.kind).parts and region.absent == self._known_absent

    def statement(self, region: ValueSet) -> str:
        """Describe a set of values in words, such as "distance is below 0.3 m or absent"."""
        whole = make_full_value_set(self.kind).parts
        if region.parts == whole:
            return f"{self.name} is {'anything' if region.absent else 'not absent'}"
        parts = self._labels(region) if isinstance(self.kind, Categorical) else self._parts(region)
        return f"{self.name} is {' or '.join([*parts, *(['absent'] if region.absent else [])])}"

    def number(self, value: float) -> str:
        """Format a threshold, or another value, with its unit."""
        text = self._text(value)
        if self._angle and Decimal(text) > HALF_TURN:
            text = f"−{Decimal(FULL_TURN) - Decimal(text)}"
        return f"{text}{self._unit}"

    def _text(self, value: float) -> str:
        return self._said.get(value) or self._rounded(self._shown(value), 0)[0]

    def _labels(self, region: ValueSet) -> list[str]:
        labels = self.kind.labels if isinstance(self.kind, Categorical) else ()
        left_out = [label for index, label in enumerate(labels) if float(index) not in region]
        if len(left_out) == 1 and len(labels) > 2:
            return [f"not {left_out[0]}"]
        return [label for index, label in enumerate(labels) if float(index) in region]

    def _parts(self, region: ValueSet) -> list[str]:
        parts = list(region.parts)
        if isinstance(self.kind, Toroidal):
            if len(parts) > 1 and parts[0][0] == 0.0 and parts[-1][1] == self.kind.period:
                parts = [*parts[1:-1], (parts[-1][0], parts[0][1])]
            return [self._arc(part) for part in parts]
        return [self._interval(part) for part in parts]

    def _arc(self, part: Interval) -> str:
        """Describe an arc, which may cross the seam where the numbers begin again: "at least 175° or below −178°"."""
        low, high = part
        if high == nextafter(low, inf):
            return self.number(low)
        start, end = float(self._text(low)), float(self._text(high))
        if self._angle:  # from −180° to 180°
            start -= FULL_TURN * (start >= HALF_TURN)
            end -= FULL_TURN * (end > HALF_TURN)
        if start >= end:
            return f"{self._from(low)} or {self._up_to(high)}"
        if self._angle and start == -HALF_TURN:
            return f"between −{HALF_TURN:g}° and {self.number(high)}"
        return self._between(part)

    def _interval(self, part: Interval) -> str:
        low, high = part
        if isinf(low):
            return self._up_to(high)
        if isinf(high):
            return self._from(low)
        if high == nextafter(low, inf):
            return self.number(low)
        if not _just_above(low) and not _just_above(high):
            return self._between(part)
        return f"{self._from(low)} and {self._up_to(high)}"

    def _between(self, part: Interval) -> str:
        low, high = part
        return f"between {self.number(low)} and {self.number(high)}"

    def _from(self, low: float) -> str:
        return f"above {self.number(low)}" if _just_above(low) else f"at least {self.number(low)}"

    def _up_to(self, high: float) -> str:
        return f"at most {self.number(high)}" if _just_above(high) else f"below {self.number(high)}"

    def _plain(self, value: float) -> float:
        return degrees(value) if self._angle else value

    def _shown(self, cut: float) -> float:
        return self._plain(nextafter(cut, -inf) if _just_above(cut) else cut)

    def _shortest(self, cut: float, least: float, under: float, over: float) -> tuple[str, float]:
        """Round a threshold to the fewest digits that fit; return the text and the number it stands for.

        The number is at least `least`. It lies above the neighboring value `under` and at most at `over`; for a
        threshold worded "at most", it lies at or above `under` and below `over`.
        """
        exact, above = self._shown(cut), _just_above(cut)
        taken = self._angle and "0" in self._said.values()
        for more in range(MOST_DIGITS):
            for text, number in self._near(exact, more):
                between = under <= number < over if above else under < number <= over
                vanishes = number == 0.0 != exact and not self._angle
                again = taken and number == FULL_TURN
                if least <= number and between and not vanishes and not again:
                    return text, number
        return repr(exact), exact

    def _near(self, exact: float, more: int) -> list[tuple[str, float]]:
        """Round to `more` more digits than usual: to the nearest number and, if examples are known, down and up."""
        text, number = self._rounded(exact, more)
        if self._decimals is None or not self._shown_some:
            return [(text, number)]
        step = 10.0 ** -(self._decimals + more)
        sides = [floor(exact / step) * step, ceil(exact / step) * step]
        return [(text, number), *(self._rounded(side, more) for side in sides)]

    def _rounded(self, value: float, more: int) -> tuple[str, float]:
        if self._decimals is not None:
            text = f"{value:.{self._decimals + more}f}"
        else:
            whole_digits = len(str(int(abs(value)))) if abs(value) < 1e9 else 0
            text = f"{value:.{max(3 + more, whole_digits)}g}"
            if "e" in text and 1e-6 <= abs(value) < 1e9:
                text = f"{float(text):.20f}"
        if "." in text and "e" not in text:
            text = text.rstrip("0").rstrip(".")
        number = float(text)
        seam = text == "-0" or (self._angle and number == FULL_TURN)
        return "0" if seam else text, number


def _just_above(cut: float) -> bool:
    """Return whether a threshold is the next float after a number with clearly fewer digits.

    Such a threshold is worded with that number: "at most 0.3" instead of "below 0.30000000000000004".
    """
    if isinf(cut):
        return False
    before = nextafter(cut, -inf)
    return before == 0.0 or len(repr(before)) + 4 < len(repr(cut))


Vectors: TypeAlias = Sequence[Sequence[float]]
"""Feature vectors of examples, which stay on their sides of rounded thresholds."""
MOST_LEAVES = 48
"""The largest number of leaves for which boxes are joined.

Larger trees are described leaf by leaf: joining takes long, and the result would be too long to read.
"""


def describe_tree_outcomes(
    tree: Tree, features: Sequence[BoundFeature], vectors: Vectors = ()
) -> Mapping[int, tuple[str, ...]]:
    """Describe for each outcome of a tree the conditions that lead to it; "always" if there is no other outcome.

    A feature vector leads to an outcome exactly if it fulfills one of that outcome's conditions.
    """
    boxes_by_outcome = simplify_outcome_boxes(tree, features)
    return {
        outcome: describe_boxes(tree, features, boxes, vectors) for outcome, boxes in boxes_by_outcome.items()
    }


def describe_boxes(
    tree: Tree, features: Sequence[BoundFeature], outcome_boxes: Sequence[Box], vectors: Vectors = ()
) -> tuple[str, ...]:
    """Describe in words the condition of each box of a tree's regions."""
    words = _words(list_cuts(tree, len(features)), find_known_absent(tree, len(features)), features, vectors)
    return tuple(" and ".join(_statements(box, words)) or "always" for box in outcome_boxes)


def describe_box(
    box: Box, features: Sequence[BoundFeature], known_absent: Sequence[bool], vectors: Vectors = ()
) -> str:
    """Describe in words the condition of one box, of any trees; `known_absent` says what can be absent in them."""
    ends = [[end for part in region.parts for end in part if not isinf(end)] for region in box]
    return " and ".join(_statements(box, _words(ends, known_absent, features, vectors))) or "always"


def describe_exits(
    tree: Tree,
    features: Sequence[BoundFeature],
    state_names: Sequence[str],
    state: str,
    vectors: Vectors = (),
) -> tuple[str, ...]:
    """Describe when a state is left, one line per condition, such as "load when food_below_me is yes".

    The last line is "stays otherwise" or "stays always" if the tree may keep the state.
    """
    texts_by_outcome = describe_tree_outcomes(tree, features, vectors)
    here = list(state_names).index(state) if state in state_names else STAY
    leaves = tuple(
        f"{state_names[outcome]} {text if text == 'always' else 'when ' + text}"
        for outcome in sorted(texts_by_outcome)
        if outcome != here
        for text in texts_by_outcome[outcome]
    )
    if here not in texts_by_outcome:
        return leaves
    return (*leaves, "stays otherwise" if leaves else "stays always")


def describe_path(
    tree: Tree, steps: Iterable[PathStep], features: Sequence[BoundFeature], vectors: Vectors = ()
) -> tuple[str, ...]:
    """Describe the condition that one decision fulfilled, one statement for each feature that was tested."""
    steps = tuple(steps)
    words = _words(list_cuts(tree, len(features)), find_known_absent(tree, len(features)), features, vectors)
    box = make_path_box(tree, steps, [bound.kind for bound in features])
    tested = {tree.nodes[step.node].feature for step in steps}
    return tuple(words[feature].statement(box[feature]) for feature in sorted(tested))


def simplify_outcome_boxes(tree: Tree, features: Sequence[BoundFeature]) -> dict[int, list[Box]]:
    """Cover the feature vectors of each outcome with few, wide boxes; boxes of different outcomes do not overlap."""
    leaves = list_leaf_boxes(tree, [bound.kind for bound in features])
    boxes_by_outcome: dict[int, list[Box]] = {}
    for outcome in sorted({outcome for outcome, _ in leaves if outcome != STAY}):
        mine = [box for leads_to, box in leaves if leads_to == outcome]
        if len(leaves) <= MOST_LEAVES:
            others = [box for leads_to, box in leaves if leads_to != outcome]
            mine = cover_boxes(mine, others)
        boxes_by_outcome[outcome] = mine
    return boxes_by_outcome


def list_cuts(tree: Tree, features: int) -> list[list[float]]:
    """List the thresholds of a tree for each of its features."""
    cuts: list[list[float]] = [[] for _ in range(features)]
    for node in tree.nodes:
        if 0 <= node.feature < features:
            cuts[node.feature] += [cut for cut in (node.low, node.high) if cut == cut]
    return cuts


def _words(
    cuts: Sequence[Sequence[float]],
    known_absent: Sequence[bool],
    features: Sequence[BoundFeature],
    vectors: Vectors,
) -> list[FeatureText]:
    values = list(zip(*vectors, strict=True)) or [()] * len(features)
    return [
        FeatureText(bound, own, known_absent=can_be_absent, values=there)
        for bound, own, can_be_absent, there in zip(features, cuts, known_absent, values, strict=True)
    ]


def _statements(box: Box, words: Sequence[FeatureText]) -> list[str]:
    return [
        word.statement(region) for region, word in zip(box, words, strict=True) if not word.is_whole(region)
    ]
