"""Ties between features: combinations of readings that a scenario excludes, as assumptions of a check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf

from understudy.model.features import BoundFeature
from understudy.model.tree_regions import ValueSet
from understudy.verification.cells import Axis

MOST_STEPS = 20_000
"""So many values are tried in turn to find a possible feature vector; then the box counts as possible."""


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

    def excludes(self, parts: Mapping[BoundFeature, ValueSet]) -> bool:
        """Return whether no values of the given parts of axes, one for each feature of the tie, occur together."""
        for bound, region in self.where.items():
            part = parts[bound]
            inside = region.absent if part.absent else (part & region).parts == part.parts
            if not inside:
                return False
        if not self.terms:
            return True
        least = 0.0
        for bound, factor in self.terms:
            if parts[bound].absent:
                return False
            low, high = parts[bound].parts[0]
            least += factor * (low if factor > 0 else high)
        return least > self.bound


class Possibility:
    """The test whether ties allow any feature vector in a box.

    Ties whose features are not all among the axes say nothing here and are left out.
    """

    def __init__(self, ties: Sequence[Tie], axes: Sequence[Axis]) -> None:
        known = {axis.bound: axis for axis in axes}
        self.ties = tuple(tie for tie in ties if all(bound in known for bound in tie.features))
        involved = dict.fromkeys(bound for tie in self.ties for bound in tie.features)
        self._axes = [known[bound] for bound in involved]
        place = {bound: at for at, bound in enumerate(involved)}
        self._checks: list[list[Tie]] = [[] for _ in self._axes]
        for tie in self.ties:
            self._checks[max(place[bound] for bound in tie.features)].append(tie)
        self._answers: dict[int, int] = {}

    def narrow(self, box: int) -> int:
        """Return a box of possible feature vectors inside a box; 0 if there are none.

        It has one part of each axis that a tie involves, and of the other axes all that the box has.
        """
        if not self._axes:
            return box
        if box not in self._answers:
            self._answers[box] = self._search(box)
        return self._answers[box]

    def _search(self, box: int) -> int:
        chosen: dict[BoundFeature, ValueSet] = {}
        steps = 0

        def extend(at: int, narrowed: int) -> int:
            nonlocal steps
            if at == len(self._axes):
                return narrowed
            axis = self._axes[at]
            for bit, part in axis.list_parts(box):
                steps += 1
                if steps > MOST_STEPS:
                    return narrowed
                chosen[axis.bound] = part
                if any(tie.excludes(chosen) for tie in self._checks[at]):
                    continue
                if found := extend(at + 1, (narrowed & ~axis.whole) | bit):
                    return found
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
