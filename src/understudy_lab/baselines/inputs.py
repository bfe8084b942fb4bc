"""Inputs of flat learners: normalized numbers for each tick, optionally with those of earlier ticks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Categorical, Kind, Toroidal
from understudy_lab.baselines.demonstrations import RESTING, Ints, Raw, RecordedTicks

Floats: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class InputSpec:
    """The input encoding of a flat learner.

    `lags` are the earlier ticks that are included; `before` includes the last behavior of the robot; `advance` shifts
    the labels by that many ticks, because people press late; `weigh` gives all behaviors the same total weight.
    """

    lags: tuple[int, ...] = ()
    before: bool = False
    advance: int = 0
    weigh: bool = False
    drawn: bool = False


class Inputs:
    """The encoding of sensor values [N, K], all or the chosen ones, as inputs [N, F], scaled by the values in `raw`.

    An angle becomes its sine and cosine; a label gets a column per value, or one if there are two; any other number is
    standardized. NaN becomes 0, with an extra column for each value that was ever NaN.
    """

    def __init__(self, kinds: Sequence[Kind], raw: Raw, chosen: Sequence[int] | None = None) -> None:
        self._chosen = list(range(len(kinds)) if chosen is None else chosen)
        self._kinds = [kinds[k] for k in self._chosen]
        raw = raw[:, self._chosen]
        self._absent = np.isnan(raw).any(axis=0)
        filled = np.where(np.isnan(raw), 0.0, raw)
        count = np.maximum(1, (~np.isnan(raw)).sum(axis=0))
        self._mean = filled.sum(axis=0) / count
        variance = np.where(np.isnan(raw), 0.0, (filled - self._mean) ** 2).sum(axis=0) / count
        self._deviation = np.maximum(np.sqrt(variance), 1e-3)

    def __call__(self, raw: Raw) -> Floats:
        """Return inputs [N, F] for sensor values [N, K]."""
        raw = raw[:, self._chosen]
        columns: list[Floats] = []
        missing = np.isnan(raw)
        for k, kind in enumerate(self._kinds):
            column = raw[:, k]
            match kind:
                case Toroidal(period=period):
                    turned = column * (2 * np.pi / period)
                    columns += [np.sin(turned), np.cos(turned)]
                case Categorical(labels=labels) if len(labels) > 2:
                    columns += [(column == index) * 1.0 for index in range(len(labels))]
                case Categorical():
                    columns.append(2.0 * column - 1.0)
                case _:
                    columns.append((column - self._mean[k]) / self._deviation[k])
        filled = np.nan_to_num(np.stack(columns, axis=1), nan=0.0)
        return np.hstack([filled, missing[:, self._absent]])


Classifier: TypeAlias = Callable[[Floats], Floats]
"""A fitted classifier: from inputs [N, F] to the probabilities of the P learned behaviors [N, P]."""


@dataclass(frozen=True)
class LabeledTicks:
    """Training data: inputs [T, F], indices into `behaviors` [T], and the weight of each tick."""

    x: Floats
    y: Ints
    weight: Floats
    behaviors: Ints
    inputs: Inputs


def lesson_of(
    ticks: RecordedTicks,
    kinds: Sequence[Kind],
    manner: InputSpec,
    *,
    basics: int,
    chosen: Sequence[int] | None = None,
) -> LabeledTicks:
    """Return ticks as training data of a flat learner, with all sensor values or the chosen ones."""
    inputs = Inputs(kinds, ticks.raw, chosen)
    now = inputs(ticks.raw)
    parts = [now, *(now[_earlier(ticks.episode, lag)] for lag in manner.lags)]
    if manner.before:
        parts.append(encode_one_hot(ticks.before, basics))
    behaviors, y, counts = np.unique(ticks.advanced(manner.advance), return_inverse=True, return_counts=True)
    weight = (len(y) / (len(counts) * counts))[y] if manner.weigh else np.ones(len(y))
    return LabeledTicks(np.hstack(parts), y.astype(np.int64), weight, behaviors, inputs)


def encode_one_hot(behaviors: Ints, basics: int) -> Floats:
    """Encode behaviors in one column each, with one for resting [N, basics + 1]."""
    return np.eye(basics + 1)[np.where(behaviors == RESTING, basics, behaviors)]


def _earlier(episode: Ints, lag: int) -> Ints:
    """Return the index of the tick `lag` ticks earlier, or of the first one in the same world [T]."""
    first = np.searchsorted(episode, episode, side="left")
    return np.maximum(np.arange(len(episode)) - lag, first).astype(np.int64)


class Policy:
    """A classifier that drives N robots, with the memory that its encoding needs."""

    def __init__(self, lesson: LabeledTicks, classify: Classifier, manner: InputSpec, *, basics: int) -> None:
        self._lesson, self._classify, self._manner, self._basics = lesson, classify, manner, basics
        self._draws = np.random.default_rng(len(lesson.y))
        self.begin()

    def begin(self) -> None:
        """Clear the memory of earlier ticks."""
        self._past: list[Floats] = []
        self._before: Ints | None = None

    def decide(self, raw: Raw) -> Ints:
        """Return the index of the behavior that each robot is to run, or RESTING [N]."""
        now = self._lesson.inputs(raw)
        lags, parts = self._manner.lags, [now]
        if lags:
            self._past = [now, *(self._past or [now] * max(lags))][: max(lags) + 1]
            parts += [self._past[lag] for lag in lags]
        if self._manner.before:
            before = np.full(len(raw), RESTING) if self._before is None else self._before
            parts.append(encode_one_hot(before, self._basics))
        shares = self._classify(np.hstack(parts))
        if self._manner.drawn:
            below = np.cumsum(shares, axis=1) < self._draws.random(len(raw))[:, None]
            places = np.minimum(below.sum(axis=1), shares.shape[1] - 1)
        else:
            places = shares.argmax(axis=1)
        self._before = self._lesson.behaviors[places]
        return self._before
