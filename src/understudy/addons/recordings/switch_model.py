"""When drivers switch: the chance of each next label, which depends on features.

Two behaviors often command the same for a while, such as braking and coasting down to a standstill. Then only the
moment of the switch tells them apart: in other demonstrations, the driver switched at such readings. So the chances of
switches are learned from all of them and used in each. This is an input-output hidden Markov model (Bengio and
Frasconi, An Input Output HMM Architecture, 1995) with a logistic regression for each label, found by expectation
maximization: expected numbers of switches by the forward-backward algorithm, then regressions on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from understudy.model.features import BoundFeature
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.records.record import Episode, Floats, Record
from understudy.runtime.feature_columns import read_feature_column

ROUNDS = 24
STEPS = 100
RIDGE = 0.1
"""Weight of the squares of the coefficients in a regression, for features in units of their spread."""
CONSTANT_SHARE = 0.02
"""The share of that weight that the constant term gets."""
FIRST_PRICE = 1.5
"""The price of a switch in the first round, before anything is known about switches."""
LEAST = -30.0
"""The smallest logarithm of a chance."""


@dataclass(frozen=True, slots=True)
class FeatureScale:
    """How the features of a drive become inputs of a regression: less the mean, in units of the spread, both [F]."""

    features: tuple[BoundFeature, ...]
    mean: Floats
    spread: Floats

    def encode(self, drive: Record) -> Floats:
        """Return the inputs [T, F + 1] of a drive, the last of which is 1."""
        raw = _read_inputs(drive, self.features)
        scaled = np.nan_to_num((raw - self.mean) / self.spread)
        return np.column_stack([scaled, np.ones(drive.ticks)])


def measure_scale(drive: Record, features: Sequence[BoundFeature]) -> FeatureScale:
    """Measure mean and spread of the inputs that features of a drive give."""
    raw = _read_inputs(drive, features)
    present = np.isfinite(raw)
    count = np.maximum(present.sum(axis=0), 1)
    mean = np.where(present, raw, 0.0).sum(axis=0) / count
    spread = np.sqrt(np.where(present, np.square(raw - mean), 0.0).sum(axis=0) / count)
    spread[spread <= 0] = 1.0
    return FeatureScale(tuple(features), mean, spread)


def _read_inputs(drive: Record, features: Sequence[BoundFeature]) -> Floats:
    """Return columns for a regression: angles as sine and cosine, labels one by one, and whether a value is absent."""
    columns = []
    for each in features:
        values = read_feature_column(each, drive.percept, agents=drive.ticks)
        if isinstance(each.kind, Toroidal):
            angle = 2 * np.pi * values / each.kind.period
            columns += [np.sin(angle), np.cos(angle)]
        elif isinstance(each.kind, Categorical):
            columns += [np.where(values == label, 1.0, 0.0) for label in range(len(each.kind.labels))]
        else:
            columns.append(values)
        columns.append(np.isnan(values).astype(np.float64))
    return np.column_stack(columns) if columns else np.zeros((drive.ticks, 0))


@dataclass(frozen=True, slots=True)
class SwitchModel:
    """The chances of switches between K labels.

    Parameters
    ----------
    scale
        How features become inputs.
    weights
        Coefficients for each label, next label and input, shape [K, F + 1, K].
    """

    scale: FeatureScale
    weights: Floats

    def predict(self, drive: Record) -> Floats:
        """Return the logarithm of the chance of each next label after each label at each tick [T, K, K]."""
        return _predict(self.weights, self.scale.encode(drive))


def _predict(weights: Floats, inputs: Floats) -> Floats:
    scores = np.einsum("tf,ifj->tij", inputs, weights)
    normal: Floats = scores - np.logaddexp.reduce(scores, axis=2)[:, :, None]
    return np.maximum(normal, LEAST)


def learn_switches(
    drive: Record,
    fit: Floats,
    features: Sequence[BoundFeature],
) -> SwitchModel:
    """Learn when the driver switches, from how well each label fits each tick.

    Parameters
    ----------
    drive
        The drive.
    fit
        Logarithm of the likelihood of each tick's command with each label, shape [T, K].
    features
        What the driver's decisions may depend on.

    Returns
    -------
    SwitchModel
        The chances of switches.
    """
    scale = measure_scale(drive, features)
    inputs, count = scale.encode(drive), fit.shape[1]
    weights = np.zeros((count, inputs.shape[1], count))
    weights[:, -1] = np.where(np.eye(count, dtype=bool), 0.0, -FIRST_PRICE)
    for _ in range(ROUNDS):
        chances, expected = _predict(weights, inputs), np.zeros((drive.ticks, count, count))
        for episode in drive.episodes:
            expected[episode.ticks] = count_switches(fit, chances, episode)
        weights = np.stack([_regress(inputs, expected[:, label], weights[label]) for label in range(count)])
    return SwitchModel(scale, weights)


def count_switches(fit: Floats, chances: Floats, episode: Episode) -> Floats:
    """Return how probable each label [K, K] before and at each tick of an episode is; zero at its first tick."""
    near = np.exp(fit[episode.ticks] - fit[episode.ticks].max(axis=1, keepdims=True))
    moves = np.exp(chances[episode.ticks])
    ticks = len(near)
    forward, backward, scale = np.empty_like(near), np.ones_like(near), np.ones(ticks)
    for tick in range(ticks):
        row = near[tick] if tick == 0 else (forward[tick - 1] @ moves[tick]) * near[tick]
        scale[tick] = row.sum()
        forward[tick] = row / scale[tick]
    for tick in range(ticks - 2, -1, -1):
        backward[tick] = moves[tick + 1] @ (near[tick + 1] * backward[tick + 1]) / scale[tick + 1]
    expected = np.zeros((ticks, *moves.shape[1:]))
    after = near[1:] * backward[1:] / scale[1:, None]
    expected[1:] = forward[:-1, :, None] * moves[1:] * after[:, None, :]
    return expected


def _regress(inputs: Floats, expected: Floats, weights: Floats) -> Floats:
    """Fit a multinomial logistic regression [F + 1, K] to expected numbers [T, K], from weights to begin with.

    Steps divide by a bound on the curvature (Boehning, Multinomial logistic regression algorithm, 1992), so that none
    goes too far.
    """
    total = expected.sum(axis=1)
    used = total > 1e-6
    if not used.any():
        return weights
    inputs, expected, total = inputs[used], expected[used], total[used]
    penalty = RIDGE * np.append(np.ones(len(weights) - 1), CONSTANT_SHARE)
    bound = np.linalg.inv(0.5 * (inputs * total[:, None]).T @ inputs + np.diag(penalty))
    for _ in range(STEPS):
        scores = inputs @ weights
        chance = np.exp(scores - np.logaddexp.reduce(scores, axis=1)[:, None])
        gradient = inputs.T @ (expected - total[:, None] * chance) - penalty[:, None] * weights
        weights = weights + bound @ gradient
    return weights
