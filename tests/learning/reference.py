"""The learner again, as plainly as it can be said: every candidate is built and counted from scratch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf, isnan, log2, nextafter
from typing import Any, NamedTuple

from understudy.model.tree import STAY, TestKind, Tree
from understudy.model.value_kinds import Categorical, Kind, Toroidal

DEFAULT, SHOWN, WATCHED = 0, 1, 2


class Row(NamedTuple):
    values: tuple[float, ...]
    outcome: int
    group: int


class Split(NamedTuple):
    key: tuple[float, ...]
    test: tuple[Any, ...]
    children: dict[int, list[Row]]
    absent: int


def entropy(rows: Sequence[Row], weights: tuple[int, int]) -> float:
    counts: Counter[int] = Counter()
    for row in rows:
        counts[row.outcome] += weights[row.group == WATCHED]
    total = sum(counts.values())
    return -sum(count / total * log2(count / total) for count in counts.values() if count)


def weigh(rows: Sequence[Row], weights: tuple[int, int]) -> int:
    return sum(weights[row.group == WATCHED] for row in rows)


def scores(parts: Sequence[Sequence[Row]], weights: tuple[int, int]) -> tuple[float, float]:
    """Gain ratio and gain, rounded."""
    everything = [row for part in parts for row in part]
    total = weigh(everything, weights)
    shares = [weigh(part, weights) / total for part in parts]
    gain = entropy(everything, weights) - sum(
        share * entropy(part, weights) for share, part in zip(shares, parts, strict=True) if share
    )
    info = -sum(share * log2(share) for share in shares if share)
    return round(gain / info, 9) + 0.0 if info else 0.0, round(gain, 9) + 0.0


class Learner:
    def __init__(
        self,
        rows: Sequence[Row],
        kinds: Sequence[Kind],
        current: int = STAY,
        midpoints: bool = False,
        flags: Sequence[int] = (),
        silence: bool = False,
    ) -> None:
        self.kinds, self.current, self.flags = kinds, current, flags
        self.silence = silence and current != STAY
        self.watched = any(row.group == WATCHED for row in rows)
        self.midpoints = midpoints or self.watched
        self.weights = (10, 1) if self.watched else (1, 1)
        self.ranges = []
        for feature in range(len(kinds)):
            present = [row.values[feature] for row in rows if not isnan(row.values[feature])]
            extent = max(present) - min(present) if present else 0.0
            size = max(map(abs, present), default=0.0)
            self.ranges.append(extent if extent > 1e-9 * size else 2 * size)
        self.tree = self.grow(list(rows))

    def grow(self, rows: list[Row], tested: frozenset[int] = frozenset()) -> Any:
        pressed = [row for row in rows if row.group != WATCHED]
        if len({row.outcome for row in pressed}) > 1:
            splits = list(self.splits(rows))
            if self.watched:
                apart = [
                    split
                    for split in splits
                    if sum(any(row.group != WATCHED for row in part) for part in split.children.values()) > 1
                ]
                gaining = []
                for split in apart:
                    parts = [
                        [row for row in part if row.group != WATCHED] for part in split.children.values()
                    ]
                    if scores(parts, (1, 1))[1] > 0:
                        gaining.append(split)
                splits = gaining or apart
            if splits:
                return self.split(max(splits, key=lambda split: split.key), tested)
        elif limits := list(self.limits(rows, pressed[0].outcome, tested)):
            return self.split(max(limits, key=lambda split: split.key), tested, silent=self.current)
        return self.vote(pressed)

    def split(self, best: Split, tested: frozenset[int], silent: int | None = None) -> Any:
        """The test and what is grown below it; `silent` where only watched examples are."""
        kind, feature = best.test[:2]
        below = tested | {feature} if kind == TestKind.BELOW else tested
        grown = {
            side: self.grow(part, below) if any(row.group != WATCHED for row in part) else silent
            for side, part in best.children.items()
        }
        shown = {side: child for side, child in grown.items() if child is not None}
        children = shown if kind == TestKind.LABEL else grown
        return (*best.test, best.absent if best.absent in shown else None, children)

    def limits(self, rows: list[Row], outcome: int, tested: frozenset[int]) -> Iterator[Split]:
        """The thresholds, of features tested above, that have four watched stays or more on one side, and all else on
        the other."""
        if not self.silence or outcome == self.current or outcome in self.flags:
            return
        for feature in tested:
            absent = [row for row in rows if isnan(row.values[feature])]
            present = [row for row in rows if not isnan(row.values[feature])]
            values = sorted({row.values[feature] for row in present})
            for low, high in pairwise(values):
                sides = (
                    [row for row in present if row.values[feature] <= low],
                    [row for row in present if row.values[feature] >= high],
                )
                for side, part in enumerate(sides):
                    quiet = all(row.group == WATCHED and row.outcome == self.current for row in part)
                    if quiet and len(part) >= 4:
                        parts = {side: part, 1 - side: sides[1 - side] + absent}
                        test = (TestKind.BELOW, feature, self.find_cut(feature, low, high, present))
                        pressed = any(row.group != WATCHED for row in absent)
                        key = (len(part), -feature, -side)
                        yield Split(key, test, parts, 1 - side if pressed else STAY)

    def vote(self, pressed: list[Row]) -> int:
        heard = [row for row in pressed if row.group == SHOWN] or pressed
        counts = Counter(row.outcome for row in heard)
        most = max(counts.values())
        tied = sorted(outcome for outcome, count in counts.items() if count == most)
        return self.current if self.current in tied else tied[0]

    def splits(self, rows: list[Row]) -> Iterator[Split]:
        for feature, kind in enumerate(self.kinds):
            absent = [row for row in rows if isnan(row.values[feature])]
            present = [row for row in rows if not isnan(row.values[feature])]
            if absent and present:
                yield Split(
                    (*self.score([absent, present]), 1.0, -feature, 1, 0, 0, 0),
                    (TestKind.ABSENT, feature),
                    {0: absent, 1: present},
                    -1,
                )
            values = sorted({row.values[feature] for row in present})
            if len(values) < 2:
                continue
            if isinstance(kind, Categorical):
                parts = {
                    int(value): [row for row in present if row.values[feature] == value] for value in values
                }
                yield from self.with_absent(
                    parts, absent, feature, (TestKind.LABEL, feature), 1.0, (0, 0), None
                )
            elif isinstance(kind, Toroidal):
                yield from self.arcs(feature, kind.period, values, present, absent)
            else:
                for index in range(len(values) - 1):
                    low, high = values[index], values[index + 1]
                    parts = {
                        0: [row for row in present if row.values[feature] <= low],
                        1: [row for row in present if row.values[feature] >= high],
                    }
                    test = (TestKind.BELOW, feature, self.find_cut(feature, low, high, present))
                    gap = (high - low) / self.ranges[feature]
                    yield from self.with_absent(parts, absent, feature, test, gap, (0, -index), 0)

    def arcs(
        self, feature: int, period: float, values: list[float], present: list[Row], absent: list[Row]
    ) -> Iterator[Split]:
        count = len(values)
        gaps = [(values[index], values[(index + 1) % count]) for index in range(count)]

        def wide(gap: tuple[float, float]) -> float:
            return (gap[1] - gap[0]) if gap[0] < gap[1] else period - gap[0] + gap[1]

        for first in range(count):
            for second in range(first + 1, count):
                within = values[first + 1 : second + 1]
                middle, middle2 = (values[at] + wide(gaps[at]) / 2 for at in (first, second))
                inner = round((middle2 - middle) / period, 9) <= 0.5
                ends = (gaps[first], gaps[second]) if inner else (gaps[second], gaps[first])
                inside = [row for row in present if (row.values[feature] in within) == inner]
                parts = {0: inside, 1: [row for row in present if row not in inside]}
                mixed = [gap for gap in ends if self.sort(feature, gap, present)]
                follows = None
                if mixed and not self.midpoints:
                    follows = min(mixed, key=lambda gap: round(wide(gap) / period, 9))
                cuts = []
                for gap in ends:
                    low, high = gap
                    if gap is follows:
                        cut = high if self.sort(feature, gap, present) < 0 else nextafter(low, inf)
                    else:
                        cut = low + wide(gap) / 2
                        if cut <= low:
                            cut = high
                    cuts.append(cut if cut < period else 0.0 if gap is follows else min(cut - period, high))
                gap_share = min(wide(gaps[first]), wide(gaps[second])) / period
                test = (TestKind.ARC, feature, *cuts)
                yield from self.with_absent(parts, absent, feature, test, gap_share, (-first, -second), 0)

    def with_absent(
        self,
        parts: dict[int, list[Row]],
        absent: list[Row],
        feature: int,
        test: tuple[Any, ...],
        gap: float,
        order: tuple[int, int],
        favored: int | None,
    ) -> Iterator[Split]:
        for rank, side in enumerate(parts):
            joined = {key: part + (absent if key == side else []) for key, part in parts.items()}
            heavy = weigh(parts[side], self.weights)
            key = (
                *self.score(list(joined.values()), arc=test[0] == TestKind.ARC),
                round(gap, 9),
                -feature,
                0,
                *order,
                heavy,
                -rank,
            )
            pressed = any(row.group != WATCHED for row in absent)
            yield Split(key, test, joined, side if pressed else STAY)
            if not absent:
                return

    def score(self, parts: Sequence[Sequence[Row]], *, arc: bool = False) -> tuple[float, ...]:
        """How well it tells all flags apart, or one of them; gain ratio, and gain."""
        ratio, gain = scores(parts, self.weights)
        apart = 0
        for flags, least in ((self.flags, 2), *(([flag], 0) for flag in self.flags)):
            for groups, how in (((DEFAULT, SHOWN), 2), ((SHOWN,), 1)):
                flagged = [[row.outcome in flags for row in part if row.group in groups] for part in parts]
                count, others = (sum(part.count(is_flag) for part in flagged) for is_flag in (True, False))
                if count and others and any(part in ([True] * count, [False] * others) for part in flagged):
                    apart = max(apart, least + how)
        return 0 if arc else apart, ratio, gain

    def sort(self, feature: int, gap: tuple[float, float], rows: list[Row]) -> int:
        low, high = (
            all(row.group == DEFAULT for row in rows if row.values[feature] == value) for value in gap
        )
        return int(high) - int(low)

    def find_cut(self, feature: int, low: float, high: float, rows: list[Row]) -> float:
        sort = 0 if self.midpoints else self.sort(feature, (low, high), rows)
        middle = (low + high) / 2
        return nextafter(low, inf) if sort > 0 else high if sort < 0 or middle <= low else middle


def nest_tree(tree: Tree, index: int = 0) -> Any:
    """A tree in the reference's terms: an outcome, None (nothing was shown), or a test and its children."""
    if index == STAY:
        return None
    node = tree.nodes[index]
    if node.test == TestKind.LEAF:
        return node.yes
    if node.test == TestKind.LABEL:
        children = {label: at for label, at in enumerate(node.branches) if at != STAY}
    else:
        children = {0: node.yes, 1: node.no}
    away = next((side for side, at in children.items() if at == node.absent != STAY), None)
    cuts = {TestKind.BELOW: (node.high,), TestKind.ARC: (node.low, node.high)}.get(TestKind(node.test), ())
    return (
        TestKind(node.test),
        node.feature,
        *cuts,
        away,
        {side: nest_tree(tree, at) for side, at in children.items()},
    )
