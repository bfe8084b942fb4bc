"""Ties between features: combinations of readings that a scenario excludes, as assumptions of a check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf

from understudy.addons.checks.verification.cells import Axis
from understudy.model.features import BoundFeature
from understudy.model.tree_regions import ValueSet

MOST_STEPS = 20_000
"""The number of values that are tried in turn to find a possible feature vector; then the box counts as possible."""


@dataclass(frozen=True, slots=True)
class Tie:
    """Something that readings never do together: a linear inequality that holds in a box, or a box that never occurs.

    Parameters
    ----------
    sentence
        The tie in words, as an assumption.
    where
        By feature the values for which the tie says something.
    terms
        Features with their factors: their sum is at most `bound` where all of `where` hold and all are present. Empty:
        what `where` describes never occurs.
    bound
        The largest possible sum of the terms.
    """

    sentence: str
    where: Mapping[BoundFeature, ValueSet]
    terms: tuple[tuple[BoundFeature, float], ...] = ()
    bound: float = 0.0

    @property
    def features(self) -> tuple[BoundFeature, ...]:
        """The features that the tie is about."""
        return tuple(dict.fromkeys((*self.where, *(bound for bound, _ in self.terms))))

    @property
    def cuts(self) -> dict[BoundFeature, list[float]]:
        """The values at which axes must be divided, by feature."""
        return {
            bound: [end for part in region.parts for end in part if not isinf(end)]
            for bound, region in self.where.items()
        }


class _PreparedTie:
    """A tie, prepared to test cells: one that is in all regions of the tie and has too large a sum is impossible.

    Regions are bit masks over the parts of each feature's axis.
    """

    __slots__ = ("axes", "bound", "places", "terms", "whole")

    def __init__(
        self, tie: Tie, axes: Mapping[BoundFeature, Axis], order: Mapping[BoundFeature, int]
    ) -> None:
        self.axes = tuple(axes[bound] for bound in tie.features)
        self.places = frozenset(order[bound] for bound in tie.features)
        self.whole = tuple(axes[bound].mask(region) for bound, region in tie.where.items())
        self.bound = tie.bound
        self.terms = tuple(_list_least(axes[bound], factor) for bound, factor in tie.terms)

    def may_exclude(self, box: int) -> bool:
        """Return whether the tie says something about part of a box."""
        return all(box & bits for bits in self.whole)

    def excludes(self, cell: int) -> bool:
        """Return whether values of one part of each axis never occur together."""
        for bits in self.whole:
            if not cell & bits:
                return False
        if not self.terms:
            return True
        least = 0.0
        for by_bit in self.terms:
            value = next((value for bit, value in by_bit if cell & bit), None)
            if value is None:
                return False
            least += value
        return least > self.bound


def _list_least(axis: Axis, factor: float) -> tuple[tuple[int, float], ...]:
    """List the least value of a term for each part of an axis, with its bit; absence has none."""
    return tuple(
        (bit, factor * (part.parts[0][0] if factor > 0 else part.parts[0][1]))
        for bit, part in axis.list_parts(axis.whole)
        if part.parts
    )


class Possibility:
    """The test whether ties allow any feature vector in a box.

    Ties whose features are not all among the axes say nothing here and are left out.
    """

    def __init__(self, ties: Sequence[Tie], axes: Sequence[Axis]) -> None:
        axis_of = {axis.bound: axis for axis in axes}
        order = {axis.bound: at for at, axis in enumerate(axes)}
        self.ties = tuple(tie for tie in ties if all(bound in axis_of for bound in tie.features))
        self._axes = tuple(axes)
        self._prepared = [_PreparedTie(tie, axis_of, order) for tie in self.ties]
        self._involved = sum({axis.whole for each in self._prepared for axis in each.axes})
        self._answers: dict[int, int] = {}

    def narrow(self, box: int) -> int:
        """Return a box of possible feature vectors inside a box; 0 if there are none.

        It has one part of each axis that matters for a tie there, and of the other axes all that the box has.
        """
        key = box & self._involved
        if key not in self._answers:
            self._answers[key] = self._search(key)
        answer = self._answers[key]
        return answer | (box & ~self._involved) if answer or not self._involved else 0

    def _search(self, box: int) -> int:
        """Return part of a box that no tie excludes, by trying the parts of each axis in turn."""
        ties = [each for each in self._prepared if each.may_exclude(box)]
        if not ties:
            return box
        places = sorted({place for each in ties for place in each.places})
        checks: dict[int, list[_PreparedTie]] = {place: [] for place in places}
        for each in ties:
            checks[max(each.places)].append(each)
        steps = 0

        def extend(at: int, narrowed: int) -> int:
            nonlocal steps
            if at == len(places):
                return narrowed
            axis = self._axes[places[at]]
            rest, mine = narrowed & ~axis.whole, checks[places[at]]
            for bit in axis.bits:
                if not box & bit:
                    continue
                steps += 1
                if steps > MOST_STEPS:
                    return narrowed
                chosen = rest | bit
                for tie in mine:
                    if tie.excludes(chosen):
                        break
                else:
                    if answer := extend(at + 1, chosen):
                        return answer
            return 0

        return extend(0, box)


def make_range_tie(bound: BoundFeature, low: float, high: float, sentence: str) -> Tie:
    """Make the tie that a present reading is at least `low` and less than `high`; absence stays possible."""
    parts = [(-inf, low)] if low > -inf else []
    parts += [(high, inf)] if high < inf else []
    return Tie(sentence, {bound: ValueSet(tuple(parts), False)})


def make_presence_tie(bound: BoundFeature, sentence: str) -> Tie:
    """Make the tie that a reading is never absent."""
    return Tie(sentence, {bound: ValueSet((), True)})
