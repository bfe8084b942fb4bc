"""What a flat learner is given at a tick: numbers of order one, with what was earlier where that is wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Categorical, Kind, Toroidal
from understudy_lab.baselines.recording_body import RESTING, Ints, Raw, RecordedTicks

Floats: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class InputSpec:
    """How a flat learner is given its ticks.

    `lags` are the earlier ticks that it sees, too; `before` whether it sees what the robot did last; `advance` by
    how many ticks the labels are taken earlier, since people press late; `weigh` whether all behaviors count alike.
    """

    lags: tuple[int, ...] = ()
    before: bool = False
    advance: int = 0
    weigh: bool = False
    drawn: bool = False


class Inputs:
    """Readings [N, K], all or those chosen, as inputs [N, F], scaled to what was seen in `raw`.

    An angle is its sine and cosine, a label a column of its own unless there are two, anything else a number less
    its mean over its deviation. What is absent is 0, and a column says so for each reading that was ever absent.
    """

    def __init__(self, kinds: Sequence[Kind], raw: Raw, chosen: Sequence[int] | None = None) -> None:
        self._chosen = list(range(len(kinds)) if chosen is None else chosen)
        self._kinds = [kinds[k] for k in self._chosen]
        raw = raw[:, self._chosen]
        self._absent = np.isnan(raw).any(axis=0)
        known = np.where(np.isnan(raw), 0.0, raw)
        count = np.maximum(1, (~np.isnan(raw)).sum(axis=0))
        self._mean = known.sum(axis=0) / count
        variance = np.where(np.isnan(raw), 0.0, (known - self._mean) ** 2).sum(axis=0) / count
        self._deviation = np.maximum(np.sqrt(variance), 1e-3)

    def __call__(self, raw: Raw) -> Floats:
        """Inputs [N, F] for readings [N, K]."""
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
        known = np.nan_to_num(np.stack(columns, axis=1), nan=0.0)
        return np.hstack([known, missing[:, self._absent]])


class Classifier(Protocol):
    """What was fitted: inputs [N, F] to how likely each of the P learned behaviors is [N, P]."""

    def __call__(self, inputs: Floats, /) -> Floats:
        """The shares [N, P]."""
        ...


@dataclass(frozen=True)
class LabeledTicks:
    """What a classifier is fitted to: inputs [T, F], places among `behaviors` [T], and how much each tick counts."""

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
    """The ticks as a flat learner is given them, with all readings or those chosen."""
    inputs = Inputs(kinds, ticks.raw, chosen)
    now = inputs(ticks.raw)
    parts = [now, *(now[_earlier(ticks.episode, lag)] for lag in manner.lags)]
    if manner.before:
        parts.append(encode_one_hot(ticks.before, basics))
    behaviors, y, counts = np.unique(ticks.advanced(manner.advance), return_inverse=True, return_counts=True)
    weight = (len(y) / (len(counts) * counts))[y] if manner.weigh else np.ones(len(y))
    return LabeledTicks(np.hstack(parts), y.astype(np.int64), weight, behaviors, inputs)


def encode_one_hot(behaviors: Ints, basics: int) -> Floats:
    """Which behavior it is, a column each, with one for resting [N, basics + 1]."""
    return np.eye(basics + 1)[np.where(behaviors == RESTING, basics, behaviors)]


def _earlier(episode: Ints, lag: int) -> Ints:
    """Where the tick so many before lies, in the same world: its first where there is none [T]."""
    first = np.searchsorted(episode, episode, side="left")
    return np.maximum(np.arange(len(episode)) - lag, first).astype(np.int64)


class Policy:
    """A classifier aboard N robots, with the memory that its manner asks for."""

    def __init__(self, lesson: LabeledTicks, classify: Classifier, manner: InputSpec, *, basics: int) -> None:
        self._lesson, self._classify, self._manner, self._basics = lesson, classify, manner, basics
        self._draws = np.random.default_rng(len(lesson.y))
        self.begin()

    def begin(self) -> None:
        """Forget what was before."""
        self._past: list[Floats] = []
        self._before: Ints | None = None

    def decide(self, raw: Raw) -> Ints:
        """Which behavior each robot is to run [N], by its index, or RESTING."""
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
