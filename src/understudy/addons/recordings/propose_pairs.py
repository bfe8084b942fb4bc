"""Pairs of readings with which automata repeat more of drives that they were not learned from.

A driver may look at the time until the car ahead is reached, where a recording has the gap and the speed. All
quotients and differences with fitting units are ranked by how well they alone tell examples apart that no feature tells
apart, and the first are tried. One is taken where automata that are learned without a drive then clearly repeat more of
it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from math import comb
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.drive_examples import list_drive_steady_readings
from understudy.addons.recordings.lesson_from_drive import DriveLesson
from understudy.addons.recordings.rerun_drive import (
    OTHER,
    Agreement,
    count_repeated,
    measure_agreement,
    run_left_out,
)
from understudy.addons.recordings.segment import Segmentation
from understudy.model.features import BoundFeature, Feature, Percept, pair_features
from understudy.model.lesson import Lesson
from understudy.model.reading_pairs import PairOperation, ReadingPair, find_pair_kind, pair_units
from understudy.model.value_kinds import Column, Continuous, Toroidal
from understudy.records.record import Floats, Ints, Record
from understudy.runtime.feature_columns import read_feature_column
from understudy.training.feature_values import find_shifted_row

Bools = NDArray[np.bool_]

MOST_TRIED, LEAST_TRIED = 40, 2
"""The largest number of pairs that are tried in a round, and the number that are tried for drives of any length."""
MOST_TICKS = 150_000
"""The ticks of the drive times the pairs that are tried in a round, at most: of long drives, fewer pairs are tried."""
MOST_ROUNDS = 4
"""The largest number of rounds, in each of which the best pair is taken, or the best pairs with one divisor."""
LEAST_SHARE, LEAST_LESS = 0.01, 0.25
"""By which share of all ticks, and of those that were not repeated before, more must be repeated with a pair."""
PIECES, CHANCE = 10, 0.1
"""The number of pieces of time in which drives are compared, and the chance that as many gain if nothing is better."""
FITTING_UNITS = ("", "s")
"""The units of quotients that are tried: ratios, and times."""


@dataclass(frozen=True, slots=True)
class TakenPairs:
    """Pairs of readings that were taken into a lesson together: one, or several with the same divisor.

    Parameters
    ----------
    features
        The pairs.
    instead_of
        The features that they take the place of.
    before
        How much automata repeated of what was left out of learning, without the pairs.
    after
        How much they repeat with them.
    """

    features: tuple[BoundFeature, ...]
    instead_of: tuple[BoundFeature, ...]
    before: Agreement
    after: Agreement


@dataclass(frozen=True, slots=True)
class PairSearch:
    """The result of a search for pairs of readings.

    Parameters
    ----------
    features
        The features of the lesson, with the pairs that were taken.
    taken
        The pairs, in the order in which they were taken.
    fitting
        The number of pairs with fitting units.
    tried
        The number of pairs that were tried.
    agreement
        How much automata repeat of what was left out of learning, with these features.
    """

    features: tuple[BoundFeature, ...]
    taken: tuple[TakenPairs, ...]
    fitting: int
    tried: int
    agreement: Agreement


def propose_pairs(
    segmentation: Segmentation,
    drive_lesson: DriveLesson,
    sides: Sequence[BoundFeature],
    *,
    targets: Mapping[str, str] = MappingProxyType({}),
    report: Callable[[int, int], None] = lambda done, of: None,
) -> PairSearch:
    """Search for pairs of readings with which automata repeat more of what they were not learned from.

    Parameters
    ----------
    segmentation
        The drive that the lesson was made of, with its labels.
    drive_lesson
        The lesson.
    sides
        Features that are readings, or pairs of readings, which may be sides of pairs.
    targets
        Targets of the automaton's parameters, by parameter.
    report
        Called after each measurement with the number of those done, and of all in this round.

    Returns
    -------
    PairSearch
        The pairs that were taken, with both numbers, and how many were tried.
    """
    search = _Search(segmentation, drive_lesson, targets, report)
    sides, taken = list(filter(_can_be_side, sides)), list[TakenPairs]()
    while len(taken) < MOST_ROUNDS:
        best = search.take_best(sides)
        if best is None:
            break
        taken.append(best)
        sides += best.features
    return PairSearch(
        search.lesson.automaton.features, tuple(taken), len(search.met), len(search.tried), search.agreement
    )


def list_fitting_pairs(sides: Sequence[BoundFeature]) -> list[BoundFeature]:
    """List the pairs of features whose units fit.

    Parameters
    ----------
    sides
        Features that are readings, or pairs of readings. Others are left out.

    Returns
    -------
    list
        Differences of the same unit, of earlier sides less later ones; ratios of the same unit, both ways, but of a
        difference only as the dividend; quotients that are times. Quotients of quotients are left out, and so are
        differences of pairs.
    """
    readings = [each for each in sides if _can_be_side(each) and _find_pair(each) is None]
    differences = [each for each in sides if _is_difference(each)]
    pairs = [
        *_list_pairs(PairOperation.DIFFERENCE, combinations(readings, 2)),
        *_list_pairs(PairOperation.QUOTIENT, permutations(readings, 2)),
        *_list_pairs(
            PairOperation.QUOTIENT,
            ((left, right) for left in differences for right in (*readings, *differences) if left != right),
        ),
    ]
    return list(dict.fromkeys(pairs))


def _can_be_side(bound: BoundFeature) -> bool:
    """Return whether a feature is a number or an angle, and a reading or a pair of readings."""
    feature = bound.feature
    if not isinstance(feature, Feature) or feature.fresh is not None:
        return False
    is_read = feature.reading is not None or feature.pair is not None
    return is_read and isinstance(bound.kind, Continuous | Toroidal)


def _find_pair(bound: BoundFeature) -> ReadingPair | None:
    return bound.feature.pair if isinstance(bound.feature, Feature) else None


def _is_difference(bound: BoundFeature) -> bool:
    pair = _find_pair(bound)
    return pair is not None and pair.operation is PairOperation.DIFFERENCE and pair.depth == 1


def _list_pairs(
    operation: PairOperation, sides: Iterator[tuple[BoundFeature, BoundFeature]]
) -> Iterator[BoundFeature]:
    for left, right in sides:
        unit = pair_units(operation, left.feature.unit, right.feature.unit)
        fits = unit is not None and (operation is PairOperation.DIFFERENCE or unit in FITTING_UNITS)
        if fits and find_pair_kind(operation, left.kind, right.kind) is not None:
            yield pair_features(operation, left, right)


@dataclass(frozen=True, slots=True)
class _Trial:
    """Pairs as features, and the features that they take the place of."""

    features: tuple[BoundFeature, ...]
    instead_of: tuple[BoundFeature, ...] = ()


def _has_unit_of(one: BoundFeature, other: BoundFeature) -> bool:
    return one.feature.unit == other.feature.unit


class _Search:
    """A search with the lesson as it is so far."""

    def __init__(
        self,
        segmentation: Segmentation,
        drive_lesson: DriveLesson,
        targets: Mapping[str, str],
        report: Callable[[int, int], None],
    ) -> None:
        self.segmentation, self.drive_lesson, self.targets = segmentation, drive_lesson, targets
        self.report = report
        self.lesson = drive_lesson.lesson
        self.percept = _read_examples(self.lesson, segmentation.drive)
        self.met: dict[BoundFeature, None] = {}
        self.tried: dict[BoundFeature, None] = {}
        self.agreement = measure_agreement(segmentation, drive_lesson, targets=targets)
        self.repeated = self.find_repeated(self.lesson)

    def find_repeated(self, lesson: Lesson) -> Bools:
        """Find the ticks that automata repeat without having been learned from them."""
        drive_lesson = replace(self.drive_lesson, lesson=lesson)
        states = run_left_out(self.segmentation, drive_lesson, targets=self.targets)
        return np.equal(states, self.segmentation.labels)

    def read(self, bound: BoundFeature) -> Column:
        """Read the values of a feature at the moments of all examples."""
        ground = BoundFeature(bound.feature, bound.binding.substitute(self.targets))
        return read_feature_column(ground, self.percept, agents=len(self.lesson.examples))

    def sort_sides(self, sides: Sequence[BoundFeature]) -> list[BoundFeature]:
        """Sort sides by their medians, so that differences are mostly positive."""
        columns = {each: self.read(each) for each in sides}
        there = {each: column[~np.isnan(column)] for each, column in columns.items()}
        medians = {each: float(np.median(column)) for each, column in there.items() if len(column)}
        return sorted(medians, key=lambda each: -medians[each])

    def take_best(self, sides: Sequence[BoundFeature]) -> TakenPairs | None:
        """Try the pairs that tell examples apart best; take the first that is clearly better than none, if any is.

        A later one is taken only if it is clearly better than that. Which is best by a few ticks would be chance.
        """
        features = self.lesson.automaton.features
        pairs = list_fitting_pairs(self.sort_sides(sides))
        columns = {each: self.read(each) for each in pairs if each not in features}
        self.met |= dict.fromkeys(columns)
        ranked = rank_pairs(self.lesson, columns)
        count = min(MOST_TRIED, max(LEAST_TRIED, MOST_TICKS // self.segmentation.drive.ticks))
        trials = list(
            dict.fromkeys(trial for pair in ranked[:count] for trial in self.list_trials(pair, sides))
        )
        best, most = None, self.repeated
        for done, trial in enumerate(trials, 1):
            self.tried |= dict.fromkeys(trial.features)
            repeated = self.find_repeated(self.exchange(trial))
            self.report(done, len(trials))
            if is_clearly_better(self.segmentation, most, repeated):
                best, most = trial, repeated
        return None if best is None else self.take(best, most)

    def list_trials(self, pair: BoundFeature, others: Sequence[BoundFeature]) -> Iterator[_Trial]:
        """Yield what a pair may take the place of: its sides, or nothing.

        Before that, a quotient is one of several with the same divisor: a driver who looks at the time to what is ahead
        rather than at the distance may do so in all directions.
        """
        features = self.lesson.automaton.features
        sides = find_sides(pair, (*features, *others))
        reading_pair = _find_pair(pair)
        if reading_pair is not None and reading_pair.operation is PairOperation.QUOTIENT and len(sides) == 2:
            alike = [each for each in features if _is_difference(each) and _has_unit_of(each, sides[0])]
            if sides[0] in alike and sides[1] not in alike and len(alike) > 1:
                quotients = (pair_features(PairOperation.QUOTIENT, each, sides[1]) for each in alike)
                replaced = (each for each in (*alike, sides[1]) if each in features)
                yield _Trial(tuple(each for each in quotients if each not in features), tuple(replaced))
        yield _Trial((pair,), tuple(each for each in sides if each in features))
        yield _Trial((pair,))

    def exchange(self, trial: _Trial) -> Lesson:
        """Return the lesson with pairs as features, in place of others."""
        features = self.lesson.automaton.features
        staying = [index for index, each in enumerate(features) if each not in trial.instead_of]
        automaton = replace(
            self.lesson.automaton, features=(*(features[index] for index in staying), *trial.features)
        )
        added = np.array([self.read(each) for each in trial.features]).T.tolist()
        examples = (
            replace(each, values=(*(each.values[index] for index in staying), *values))
            for each, values in zip(self.lesson.examples, added, strict=True)
        )
        return replace(self.lesson, automaton=automaton, examples=tuple(examples))

    def take(self, trial: _Trial, repeated: Bools) -> TakenPairs:
        """Take pairs into the lesson."""
        before = self.agreement
        self.lesson, self.repeated = self.exchange(trial), repeated
        states = np.where(repeated, self.segmentation.labels, OTHER)
        self.agreement = count_repeated(self.segmentation, states, before.left_out)
        return TakenPairs(trial.features, trial.instead_of, before, self.agreement)


def find_sides(pair: BoundFeature, features: Sequence[BoundFeature]) -> tuple[BoundFeature, ...]:
    """Find the features that are the two sides of a pair.

    Parameters
    ----------
    pair
        The pair.
    features
        Features, among which its sides are looked for.

    Returns
    -------
    tuple
        The sides that were found, the left one first.
    """
    reading_pair = _find_pair(pair)
    if reading_pair is None:
        return ()
    by_text = {str(each): each for each in reversed(features)}
    sides = (each.format(pair.binding) for each in (reading_pair.left, reading_pair.right))
    return tuple(by_text[each] for each in sides if each in by_text)


def is_clearly_better(segmentation: Segmentation, before: Bools, after: Bools) -> bool:
    """Return whether clearly more is repeated of what was left out of learning.

    Parameters
    ----------
    segmentation
        The labels; ticks that nothing explains do not count.
    before
        The ticks that are repeated without a pair, shape [T].
    after
        The ticks that are repeated with it, shape [T].

    Returns
    -------
    bool
        Whether at least a hundredth of all ticks, and a quarter of those that were not repeated, are repeated in
        addition; and more of ten pieces of time, or of the drives if they are more, gain than lose: so many more as
        happens by chance in a tenth of the cases (a sign test).
    """
    drive = segmentation.drive
    counted = segmentation.labels < len(segmentation.candidates)
    change = np.where(counted, after.astype(np.int64) - before.astype(np.int64), 0)
    wrong = int((counted & ~before).sum())
    if change.sum() < max(1.0, LEAST_SHARE * float(counted.sum()), LEAST_LESS * wrong):
        return False
    count = -(-PIECES // len(drive.episodes))
    pieces = [piece.sum() for each in drive.episodes for piece in np.array_split(change[each.ticks], count)]
    gained, lost = sum(int(each > 0) for each in pieces), sum(int(each < 0) for each in pieces)
    decided = gained + lost
    as_many = sum(comb(decided, more) for more in range(gained, decided + 1))
    return bool(as_many <= CHANCE * 2**decided)


def rank_pairs(lesson: Lesson, columns: Mapping[BoundFeature, Column]) -> list[BoundFeature]:
    """Rank features by how well they alone tell examples apart that no feature of a lesson tells apart.

    Parameters
    ----------
    lesson
        The lesson.
    columns
        The values of each feature at the moments of the examples, shape [n]; NaN where absent.

    Returns
    -------
    list
        The features, best first; of those that are no better than the features of the lesson, the ones that tell more
        examples apart.

    Notes
    -----
    How well a feature tells two next states apart is the Kolmogorov-Smirnov statistic of its values before the one and
    before the other: the largest difference of the shares of examples below a threshold. The differences to the best
    feature of the lesson are added up, with the number of examples of the rarer next state as weights.
    """
    groups = _list_contrasts(lesson)
    own = np.array([each.values for each in lesson.examples]).reshape(len(lesson.examples), -1).T
    nearest = [max((_separate(column, *each) for column in own), default=0.0) for each in groups]
    scores = {}
    for bound, column in columns.items():
        apart = [(min(map(len, each)), _separate(column, *each)) for each in groups]
        gain = sum(count * max(0.0, mine - best) for (count, mine), best in zip(apart, nearest, strict=True))
        scores[bound] = (gain, sum(count * mine for count, mine in apart))
    return sorted(scores, key=lambda each: scores[each], reverse=True)


def _list_contrasts(lesson: Lesson) -> list[tuple[Ints, Ints]]:
    """List the rows of examples of every two next states in a state, or in all if one tree decides for all."""
    rows: dict[str, dict[str, list[int]]] = {}
    for row, each in enumerate(lesson.examples):
        if not each.quarantined:
            state = "" if lesson.automaton.stateless else each.state
            rows.setdefault(state, {}).setdefault(each.next, []).append(row)
    return [
        (np.array(one), np.array(other))
        for by_next in rows.values()
        for one, other in combinations(by_next.values(), 2)
    ]


def _separate(column: Column, one: Ints, other: Ints) -> float:
    """Measure how well a threshold tells two groups of rows apart, from 0 to 1; absent values are the largest."""
    first, second = (np.sort(np.where(np.isnan(column[rows]), np.inf, column[rows])) for rows in (one, other))
    places = np.concatenate([first, second])
    below = (np.searchsorted(each, places, side="right") / len(each) for each in (first, second))
    return float(np.abs(np.subtract(*below)).max())


def _read_examples(lesson: Lesson, drive: Record) -> Percept:
    """Return the readings at the moments of examples, those of presses a reaction time earlier, as columns."""
    record, steady = lesson.record, list_drive_steady_readings(drive)
    exact = [each.moment or 0 for each in lesson.examples]
    shifted = [find_shifted_row(each, record, lesson.options.reaction_s) for each in lesson.examples]
    values: Floats = record.values
    return {
        key: values[exact if key[0] in steady else shifted, column] for column, key in enumerate(record.keys)
    }
