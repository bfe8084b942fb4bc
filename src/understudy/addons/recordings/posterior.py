"""How certain each label is at each tick: the forward-backward algorithm under a shortest stay.

Sums are kept relative to their largest term, so that products over hours neither vanish nor overflow: a weight at a
tick is `exp(scale[tick]) * row`, beside the best fit of every tick, which is left out.
"""

from __future__ import annotations

from math import exp, log
from typing import NamedTuple

import numpy as np

from understudy.addons.recordings.lattice import Lattice, measure_windows
from understudy.records.record import Floats, Ints


def compute_posteriors(lattice: Lattice) -> Floats:
    """Compute the probability of each label at each tick, over all ways to label the episode.

    A way to label it weighs as much as the fit of its states, less the price of its switches.

    Parameters
    ----------
    lattice
        The episode, of at least one tick.

    Returns
    -------
    array, shape [T, K]
        Probabilities; each row sums to 1.
    """
    terms = _compute_terms(lattice)
    forward, leaving, forward_scale = _sum_forward(lattice, terms)
    backward, backward_scale = _sum_backward(lattice, terms)
    total = log(float(forward[-1] @ backward[-1] + _sum_cut_off(lattice, terms, leaving, forward_scale)))
    total += forward_scale[-1]
    stays = forward * backward * np.exp(forward_scale + backward_scale - total)[:, None]
    members = (lattice.labels[:, None] == np.arange(lattice.entry.shape[1])).astype(np.float64)
    weights = stays @ members
    if lattice.shortest > 1:
        weights += _sum_windows(lattice, terms, leaving, (forward_scale, backward, backward_scale, total))
    normal: Floats = weights / weights.sum(axis=1, keepdims=True)
    return normal


class _Terms(NamedTuple):
    """The factors of the sums: of each state at each tick [T, X], and of each shortest stay from each tick [T, K].

    `last` has the last state of each shortest stay, and `others` what a switch weighs from each state to each label
    [K, X], if that is the same at every tick.
    """

    fit: Floats
    stay: Floats
    last: Ints
    others: Floats | None

    def weigh_moves(self, lattice: Lattice, tick: int) -> Floats:
        """Return what a switch at a tick weighs from each state to each label [K, X]."""
        return np.exp(lattice.get_moves(tick)) if self.others is None else self.others


def _compute_terms(lattice: Lattice) -> _Terms:
    best = lattice.fit.max(axis=1)
    before = np.concatenate([[0.0], np.cumsum(best)])
    windows, ticks = measure_windows(lattice), len(best)
    ends = np.minimum(np.arange(ticks) + lattice.shortest, ticks)
    stay = np.exp(windows.fit - (before[ends] - before[:ticks])[:, None] - lattice.price)
    others = np.exp(lattice.get_moves(0)) if lattice.moves is None else None
    return _Terms(np.exp(lattice.fit - best[:, None]), stay, windows.last, others)


def _sum_forward(lattice: Lattice, terms: _Terms) -> tuple[Floats, Floats, Floats]:
    """Sum over the beginnings of the episode that end in each state after a whole stay.

    Return the sums [T, X], those over the states of all other labels [T, K], and their scales [T].
    """
    ticks, count = terms.fit.shape
    forward, leaving, scale = np.zeros(terms.fit.shape), np.zeros(terms.stay.shape), np.zeros(ticks)
    forward[0, lattice.entry[0]] = terms.fit[0, lattice.entry[0]]
    following, shortest, scaled = lattice.following, lattice.shortest, 0.0
    for tick in range(ticks):
        row = forward[tick]
        if tick:
            former = forward[tick - 1]
            if following is not None:
                former = np.bincount(following[tick], former, count)
            np.multiply(former, terms.fit[tick], out=row)
        if (begun := tick - shortest + 1) >= 1:
            arrived = leaving[begun - 1] * terms.stay[begun]
            arrived *= exp(scale[begun - 1] - scaled)
            row += arrived if following is None else np.bincount(terms.last[begun], arrived, count)
        top = float(row.max())
        row /= top
        scaled += log(top)
        scale[tick] = scaled
        if tick + 1 < ticks:
            np.dot(terms.weigh_moves(lattice, tick + 1), row, out=leaving[tick])
    return forward, leaving, scale


def _sum_backward(lattice: Lattice, terms: _Terms) -> tuple[Floats, Floats]:
    """Sum over the ways in which the episode can go on after each state that may end; return them and their scales."""
    ticks = len(terms.fit)
    backward, scale = np.ones(terms.fit.shape), np.zeros(ticks)
    following, shortest, scaled = lattice.following, lattice.shortest, 0.0
    for tick in range(ticks - 2, -1, -1):
        row = backward[tick]
        np.multiply(backward[tick + 1], terms.fit[tick + 1], out=row)
        if following is not None:
            row[:] = row[following[tick + 1]]
        begun, end = terms.stay[tick + 1], tick + shortest
        if end < ticks:
            begun = begun * backward[end][terms.last[tick + 1]]
            begun *= exp(scale[end] - scaled)
        else:
            begun = begun * exp(-scaled)
        row += begun @ terms.weigh_moves(lattice, tick + 1)
        top = float(row.max())
        row /= top
        scaled += log(top)
        scale[tick] = scaled
    return backward, scale


def _sum_cut_off(lattice: Lattice, terms: _Terms, leaving: Floats, scale: Floats) -> float:
    """Sum over the ways whose last stay is cut off by the end of the episode."""
    starts = np.arange(max(1, len(scale) - lattice.shortest + 1), len(scale))
    weight = np.exp(scale[starts - 1] - scale[-1])[:, None] * leaving[starts - 1] * terms.stay[starts]
    return float(weight.sum())


def _sum_windows(
    lattice: Lattice, terms: _Terms, leaving: Floats, sums: tuple[Floats, Floats, Floats, float]
) -> Floats:
    """Return how probable it is that a label is in its shortest stay, but not at the last tick of it [T, K]."""
    forward_scale, backward, backward_scale, total = sums
    ticks, labels = lattice.entry.shape
    starts = np.arange(1, ticks)
    ends = starts + lattice.shortest - 1
    rest, scale, whole = np.ones((ticks - 1, labels)), forward_scale[:-1] - total, ends < ticks
    rest[whole] = np.take_along_axis(backward[ends[whole]], terms.last[starts[whole]], axis=1)
    scale[whole] += backward_scale[ends[whole]]
    weight = np.exp(scale)[:, None] * leaving[:-1] * terms.stay[1:] * rest
    summed = np.zeros((ticks, labels))
    for step in range(
        min(lattice.shortest - 1, ticks - 1)
    ):  # a sum of differences would round small terms away
        summed[1 + step :] += weight[: ticks - 1 - step]
    return summed
