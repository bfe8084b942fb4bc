"""Flat learners and their inputs: normalized numbers for each tick, optionally with those of earlier ticks.

A tree, nearest neighbors and a perceptron are those of scikit-learn, behavior cloning is done with PyTorch.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.value_kinds import Categorical, Kind, Toroidal
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


Fit: TypeAlias = Callable[[LabeledTicks, int], Classifier]
"""A function that fits a classifier to training data with a seed."""


def fit_tree(lesson: LabeledTicks, seed: int, *, leaf: int = 5) -> Classifier:
    """Fit a CART tree by entropy (Breiman et al. 1984), with at least `leaf` ticks in a leaf."""
    from sklearn.tree import DecisionTreeClassifier

    tree = DecisionTreeClassifier(criterion="entropy", min_samples_leaf=leaf, random_state=seed)
    tree.fit(lesson.x, lesson.y, sample_weight=lesson.weight)
    counts = tree.tree_.value[:, 0, :]
    shares: Floats = counts / counts.sum(axis=1, keepdims=True)

    def classify(inputs: Floats) -> Floats:
        chances: Floats = shares[tree.tree_.apply(inputs.astype(np.float32))]
        return chances

    return classify


def fit_nearest(lesson: LabeledTicks, seed: int, *, neighbors: int = 5) -> Classifier:
    """Fit a classifier by the majority of the nearest ticks (Fix and Hodges 1951)."""
    from sklearn.neighbors import KDTree

    tree, places = KDTree(lesson.x), np.arange(len(lesson.behaviors))
    k = min(neighbors, len(lesson.y))

    def classify(inputs: Floats) -> Floats:
        near = tree.query(inputs, k=k, return_distance=False)
        votes = ((lesson.y[near][..., None] == places) * lesson.weight[near][..., None]).sum(axis=1)
        chances: Floats = votes / votes.sum(axis=1, keepdims=True)
        return chances

    return classify


def fit_perceptron(lesson: LabeledTicks, seed: int, *, alpha: float = 1e-4, steps: int = 1_500) -> Classifier:
    """Fit a perceptron with two hidden layers of 64 (Rumelhart et al. 1986), trained with Adam."""
    from sklearn.neural_network import MLPClassifier

    if len(lesson.behaviors) == 1:
        return lambda inputs: np.ones((len(inputs), 1))
    rounds = int(np.clip(steps * 200 / len(lesson.y), 10, 300))
    net = MLPClassifier((64, 64), alpha=alpha, max_iter=rounds, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it might go on
        net.fit(lesson.x, lesson.y)
    return MlpWeights(list(zip(net.coefs_, net.intercepts_, strict=True)))


class MlpWeights:
    """A net of rectified linear layers, by weights and offsets."""

    def __init__(self, layers: list[tuple[Floats, Floats]]) -> None:
        self._layers = layers

    def __call__(self, inputs: Floats) -> Floats:
        """Return the probability of each behavior for each row (softmax)."""
        *hidden, (weights, offset) = self._layers
        for before, beside in hidden:
            inputs = np.maximum(inputs @ before + beside, 0.0)
        outputs = inputs @ weights + offset
        if outputs.shape[1] == 1:  # scikit-learn has one output for two
            outputs = np.hstack([np.zeros_like(outputs), outputs])
        likely = np.exp(outputs - outputs.max(axis=1, keepdims=True))
        shares: Floats = likely / likely.sum(axis=1, keepdims=True)
        return shares


CLASSICAL: Mapping[str, Fit] = {"tree": fit_tree, "nearest": fit_nearest, "perceptron": fit_perceptron}


HIDDEN = 64


def fit_nets(
    lessons: Sequence[LabeledTicks],
    seed: int,
    *,
    steps: int = 1_000,
    batch: int = 128,
    rate: float = 3e-3,
    decay: float = 1e-2,
) -> list[MlpWeights]:
    """Train a net of two hidden layers for each lesson: AdamW, a cosine schedule (Loshchilov and Hutter 2017, 2019).

    Each net sees only the ticks of its own lesson.
    """
    import torch

    torch.set_num_threads(1)
    draws = torch.Generator().manual_seed(seed)
    places = max(len(lesson.behaviors) for lesson in lessons)
    widths = (max(lesson.x.shape[1] for lesson in lessons), HIDDEN, HIDDEN, places)
    layers = [_layer(torch, len(lessons), *pair, draws) for pair in pairwise(widths)]
    counts = torch.tensor([len(lesson.y) for lesson in lessons])
    first = torch.cumsum(counts, 0) - counts
    every_x = torch.from_numpy(np.concatenate([_padded(lesson.x, widths[0]) for lesson in lessons]))
    every_y = torch.from_numpy(np.concatenate([lesson.y for lesson in lessons]))
    every_weight = torch.from_numpy(np.concatenate([lesson.weight for lesson in lessons]).astype(np.float32))
    closed = torch.stack([torch.arange(places) >= len(lesson.behaviors) for lesson in lessons])
    closed = (closed * -1e9)[:, None, :]
    parameters = [each for layer in layers for each in layer]
    optimizer = torch.optim.AdamW(parameters, lr=rate, weight_decay=decay, fused=True)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    for _ in range(steps):
        drawn = torch.rand((len(lessons), batch), generator=draws)
        rows = ((drawn * counts[:, None]).long() + first[:, None]).flatten()
        x = every_x[rows].view(len(lessons), batch, -1)
        for weights, offset in layers[:-1]:
            x = torch.relu(torch.baddbmm(offset, x, weights))
        weights, offset = layers[-1]
        outputs = (torch.baddbmm(offset, x, weights) + closed).flatten(0, 1)
        losses = torch.nn.functional.cross_entropy(outputs, every_y[rows], reduction="none")
        optimizer.zero_grad()
        ((losses * every_weight[rows]).sum() / batch).backward()
        optimizer.step()
        schedule.step()
    return [_net(layers, k, lesson) for k, lesson in enumerate(lessons)]


def _layer(torch: Any, nets: int, before: int, after: int, draws: Any) -> tuple[Any, Any]:
    """Draw weights [nets, before, after] (He et al. 2015) and offsets [nets, 1, after]."""
    weights = torch.randn((nets, before, after), generator=draws) * (2.0 / before) ** 0.5
    return weights.requires_grad_(), torch.zeros((nets, 1, after), requires_grad=True)


def _padded(x: Any, width: int) -> Any:
    return np.hstack([x, np.zeros((len(x), width - x.shape[1]))]).astype(np.float32)


def _net(layers: Sequence[tuple[Any, Any]], k: int, lesson: LabeledTicks) -> MlpWeights:
    """Return net number k as plain arrays, as wide as its lesson."""
    plain = [[each[k].detach().numpy().astype(np.float64) for each in layer] for layer in layers]
    plain[0][0] = plain[0][0][: lesson.x.shape[1]]
    plain[-1] = [each[:, : len(lesson.behaviors)] for each in plain[-1]]
    return MlpWeights([(weights, offset[0]) for weights, offset in plain])
