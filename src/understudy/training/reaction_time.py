"""Estimates of how late a demonstrator presses: the shift of the record under which similar presses agree best.

A person who switches at a boundary presses some time after the robot crossed it, and so the later past it the faster
the robot is. The readings at late presses therefore scatter, and those at the right moment before them coincide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import degrees
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnderstudyError
from understudy.model.describe import is_angle
from understudy.model.features import BoundFeature, Percept
from understudy.model.learner_options import LONGEST_REACTION_S
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.runtime.feature_columns import read_feature_column
from understudy.training.feature_values import find_shifted_row

STEP_S = 0.05
"""The distance between the reaction times that are tried, s."""
SHIFTS_S = np.round(np.arange(0.0, LONGEST_REACTION_S - 0.2 + STEP_S / 2, STEP_S), 3)
FEWEST_ALIKE, FEWEST = 4, 8
"""The least number of presses from one state to another that count, and of all that count together."""
CLEAR = 4.0
"""The least difference of log likelihoods by which a shift is clear: of the presses with the best shift to those
without any, or without any to those with the longest."""
WITHIN = 8.0
"""The largest difference of log likelihoods by which a shift may be less likely than the best and still be possible."""

FEWEST_CHANGES = 0.15
"""Readings that change in fewer of the steps before presses, such as counts, are events rather than motion.

Any shift back to before the event looks alike, so the agreement of presses says nothing about how late they are.
"""

Shifted: TypeAlias = NDArray[np.float64]
"""A feature's values [shifts, presses], a row for each of SHIFTS_S."""


@dataclass(frozen=True, slots=True)
class ReactionEstimate:
    """An estimate of how late presses come, s, with its bounds, and the evidence in a sentence."""

    reaction_s: float
    least_s: float
    most_s: float
    presses: int
    evidence: str

    def __str__(self) -> str:
        return self.evidence


class _ShiftLikelihood(NamedTuple):
    """Likelihood and scatter, by shift, of the presses from one state to another for one feature."""

    state: str
    next: str
    bound: BoundFeature
    presses: int
    likelihood: NDArray[np.float64]
    scatter: NDArray[np.float64]

    @property
    def weight(self) -> float:
        """How much the likelihood depends on the shift."""
        return float(self.likelihood.max() - np.median(self.likelihood))


def estimate_reaction_time(
    lesson: Lesson, *, steady: frozenset[str] = frozenset()
) -> ReactionEstimate | None:
    """Estimate from a lesson's record how late its directives came.

    The reaction time that the lesson is set to makes no difference.

    Parameters
    ----------
    lesson
        The lesson, with its record.
    steady
        Names of readings that are never shifted, such as categories.

    Returns
    -------
    ReactionEstimate
        The estimate; 0 s if presses are not late. None if there are too few to tell.
    """
    groups = _list_telling(lesson, steady)
    presses = sum(each.presses for each in groups)
    if presses < FEWEST:
        return None
    total = np.sum([each.likelihood for each in groups], axis=0)
    likely = SHIFTS_S[total >= total.max() - WITHIN]
    best = int(np.flatnonzero(total >= total.max() - 1e-9)[-1])  # between two ticks, the later is as good
    if total[best] - total[0] < CLEAR:
        best = 0  # without clear evidence, presses count as timely
    if best == 0 and total[0] - total[-1] < CLEAR:
        return None
    clearest = max(groups, key=lambda each: each.likelihood[best] - each.likelihood[0])
    return ReactionEstimate(
        float(SHIFTS_S[best]), float(likely[0]), float(likely[-1]), presses, _evidence(clearest, best)
    )


def compute_shift_likelihood(lesson: Lesson, *, steady: frozenset[str] = frozenset()) -> NDArray[np.float64]:
    """Compute how much less likely each of `SHIFTS_S` is as a reaction time than the likeliest.

    It is a logarithm, at most 0. If no press tells anything, all are as likely.
    """
    total = np.zeros(len(SHIFTS_S))
    for each in _list_telling(lesson, steady):
        total += each.likelihood
    total -= total.max()
    return total


def _list_telling(lesson: Lesson, steady: frozenset[str]) -> list[_ShiftLikelihood]:
    """List the likelihoods of all groups of presses that tell how late they are."""
    return [each for group in _groups(lesson) if (each := _telling(lesson, group, steady)) is not None]


def _groups(lesson: Lesson) -> Iterator[list[Example]]:
    """Yield groups of directives between the same states, with a whole second of record before each."""
    alike: dict[tuple[str, str], list[Example]] = {}
    for example in lesson.examples:
        recorded = example.moment is not None and not example.edited and not example.quarantined
        recorded = recorded and example.reaction_s is None  # otherwise the person's reaction time is known
        if example.kind is ExampleKind.DIRECTIVE and recorded and _reaches(example, lesson):
            alike.setdefault((example.state, example.next), []).append(example)
    return (group for group in alike.values() if len(group) >= FEWEST_ALIKE)


def _reaches(example: Example, lesson: Lesson) -> bool:
    """Return whether the readings before an example were recorded for at least the longest shift tried."""
    moment, seconds = example.moment or 0, lesson.record.seconds
    return bool(seconds[moment] - seconds[moment - example.window] >= SHIFTS_S[-1] - 1e-9)


def _telling(lesson: Lesson, group: Sequence[Example], steady: frozenset[str]) -> _ShiftLikelihood | None:
    """Return the likelihood of a group by the feature that tells most about the shift; None if no feature changes."""
    percept, candidates = _percept(lesson.record, group, steady), []
    for bound in lesson.automaton.features:
        if bound.is_own or isinstance(bound.kind, Categorical):
            continue
        values = _shifted(bound, percept, group)
        if values is None or np.isnan(values[0]).all() or _is_stepped(values):
            continue
        scatter = _scatter(values, bound)
        if scatter.min() > 0:
            likelihood = -len(group) * np.log(scatter)
            candidates.append(
                _ShiftLikelihood(group[0].state, group[0].next, bound, len(group), likelihood, scatter)
            )
    return max(candidates, key=lambda each: each.weight, default=None)


def _percept(record: ReadingLog, group: Sequence[Example], steady: frozenset[str]) -> Percept:
    """Return all readings of a group, shift by shift, and press by press within each."""
    rows = np.array(
        [[find_shifted_row(each, record, shift) for each in group] for shift in SHIFTS_S.tolist()]
    )
    unshifted = np.broadcast_to(rows[0], rows.shape)
    return {
        key: record.values[(unshifted if key[0] in steady else rows).ravel(), column]
        for column, key in enumerate(record.keys)
    }


def _shifted(bound: BoundFeature, percept: Percept, group: Sequence[Example]) -> Shifted | None:
    """Return a feature's values, with the targets at each press; None if the record does not have them.

    That is so for a reading that was not recorded then, or a function of a kit that is not there.
    """
    values_by_shift = np.full((len(SHIFTS_S), len(group)), np.nan)
    bindings = [each.binding for each in group]
    for binding in dict.fromkeys(bindings):
        ground = BoundFeature(bound.feature, bound.binding.substitute(binding))
        try:
            values = read_feature_column(ground, percept, agents=values_by_shift.size).reshape(
                values_by_shift.shape
            )
        except (UnderstudyError, KeyError):
            return None
        mine = [each == binding for each in bindings]
        values_by_shift[:, mine] = values[:, mine]
    return values_by_shift


def _is_stepped(values: Shifted) -> bool:
    """Return whether values change seldom, though they do change."""
    steps = np.diff(values, axis=0)
    changed = steps[~np.isnan(steps)] != 0
    return bool(changed.any() and changed.mean() < FEWEST_CHANGES)


def _scatter(values: Shifted, bound: BoundFeature) -> NDArray[np.float64]:
    """Return the mean distance from the middle [shifts], at least as large as the change of readings in a tick.

    Absent values count as far off, since they tell nothing about a boundary.
    """
    steps = np.diff(values, axis=0)
    if isinstance(bound.kind, Toroidal):
        period = bound.kind.period
        turned = np.nansum(np.exp(2j * np.pi * values / period), axis=1, keepdims=True)
        apart = np.mod(values - np.angle(turned) * period / (2 * np.pi) + period / 2, period) - period / 2
        steps, far = np.mod(steps + period / 2, period) - period / 2, period / 4
    else:
        middle = [[np.median(row[~np.isnan(row)])] if not np.isnan(row).all() else [0.0] for row in values]
        apart, far = values - np.array(middle), float(np.nanmax(values) - np.nanmin(values)) / 2
    finite = steps[~np.isnan(steps)]
    least = float(np.abs(finite).mean()) / 2 if len(finite) else far
    scatter: NDArray[np.float64] = np.where(np.isnan(apart), far, np.abs(apart)).mean(axis=1) + least
    return scatter


def _evidence(group: _ShiftLikelihood, best: int) -> str:
    now, then = (_format_spread(group.bound, group.scatter[shift]) for shift in (0, best))
    where = f"the {group.presses} presses from {group.state} to {group.next}"
    if best == 0:
        return f"By {group.bound}, {where} hardly agree better at any earlier moment: they do not seem late."
    return (
        f"Taken {SHIFTS_S[best]:g} s earlier, {where} lie about {then} from each other by {group.bound}, "
        f"instead of {now}."
    )


def _format_spread(bound: BoundFeature, spread: float) -> str:
    """Format how far apart values lie; angles in degrees, as everywhere that people read."""
    if is_angle(bound):
        return f"{degrees(spread):.3g}°"
    unit = bound.feature.unit
    return f"{spread:.3g}{f' {unit}' if unit else ''}"
