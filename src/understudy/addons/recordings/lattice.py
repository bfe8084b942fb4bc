"""The most likely labels of ticks, and how certain each is, under a price for switching and a shortest stay.

A label has one state or several: a candidate that is an automaton has one for each way in which its levels can stand.
Within a label, the state at a tick follows from the state at the tick before. A switch of the label costs `price` and
begins a stay of at least `shortest` ticks; only the stay that a recording cuts off at its beginning or end can be
shorter. Under these rules both answers are exact: the labels by Viterbi's algorithm, the certainties by the
forward-backward algorithm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from understudy.records.record import Floats, Ints


@dataclass(frozen=True, slots=True)
class Lattice:
    """What is known about the labels of one episode of T ticks, with X states of K labels.

    Parameters
    ----------
    fit
        Logarithm of the likelihood of each tick in each state, shape [T, X].
    labels
        Label of each state, shape [X], from 0 to K - 1.
    entry
        State in which a label that begins at a tick is at this tick, shape [T, K].
    following
        State at each tick after each state at the tick before, shape [T, X]. None: states never change.
    price
        What a switch to each label costs, as the logarithm of a likelihood ratio, shape [K], or one number for all.
    shortest
        Fewest ticks of a stay, at least 1.
    moves
        What a switch from each label to each other adds at each tick beside the price, shape [T, K, K]. None: nothing.
    """

    fit: Floats
    labels: Ints
    entry: Ints
    following: Ints | None
    price: float | Floats
    shortest: int
    moves: Floats | None = None

    def get_moves(self, tick: int) -> Floats:
        """Return what a switch at a tick from each state to each label adds [K, X]; -inf to the label of the state."""
        labels = np.arange(self.entry.shape[1])[:, None]
        every = (
            np.zeros((len(labels), len(self.labels)))
            if self.moves is None
            else self.moves[tick].T[:, self.labels]
        )
        return np.where(self.labels == labels, -np.inf, every)


class StayWindows(NamedTuple):
    """The shortest stays: for one of each label that begins at each tick, its fit and its last state [T, K].

    At the end of the episode they are cut off.
    """

    fit: Floats
    last: Ints


def measure_windows(lattice: Lattice) -> StayWindows:
    """Measure the shortest stay of each label from each tick."""
    ticks, rows = len(lattice.fit), np.arange(len(lattice.fit))[:, None]
    state = lattice.entry.copy()
    total = lattice.fit[rows, state]
    for step in range(1, min(lattice.shortest, ticks)):
        rest = ticks - step
        if lattice.following is not None:
            state[:rest] = lattice.following[rows[step:], state[:rest]]
        total[:rest] += lattice.fit[rows[step:], state[:rest]]
    return StayWindows(total, state)


def find_states(lattice: Lattice) -> Ints:
    """Find the most likely state of each tick, by Viterbi's algorithm.

    Parameters
    ----------
    lattice
        The episode, of at least one tick.

    Returns
    -------
    int array, shape [T]
        The states; `lattice.labels` has the label of each.
    """
    fit, stay, ticks = lattice.fit, lattice.shortest, len(lattice.fit)
    windows = measure_windows(lattice)
    entered = windows.fit - lattice.price
    score = np.full(fit.shape, -np.inf)
    score[0, lattice.entry[0]] = fit[0, lattice.entry[0]]
    before = np.full(fit.shape, ENTERED)
    exits = _Exits(lattice)
    exits.note(0, score[0])
    every = np.arange(fit.shape[1])
    for tick in range(1, ticks):
        row, origin = score[tick], before[tick]
        if lattice.following is None:
            np.add(score[tick - 1], fit[tick], out=row)
            origin[:] = every
        else:
            _follow_best(score[tick - 1], lattice.following[tick], row, origin)
            row += fit[tick]
        begun = tick - stay + 1
        if begun >= 1:
            arrived = exits.score[begun - 1] + entered[begun]
            if lattice.following is None:
                better = arrived > row
                np.copyto(row, arrived, where=better)
                origin[better] = ENTERED
            else:
                for label, state in enumerate(windows.last[begun].tolist()):
                    if arrived[label] > row[state]:
                        row[state], origin[state] = arrived[label], ENTERED
        exits.note(tick, row)
    return _trace_back(lattice, windows, score[-1], before, exits)


ENTERED = -1
"""The predecessor of a state that was not reached by staying: its label began one shortest stay before."""


class _Exits:
    """The best score [T, K] of a path that leaves another label after a tick to begin this one, and its last state."""

    def __init__(self, lattice: Lattice) -> None:
        ticks, labels = lattice.entry.shape
        self._lattice = lattice
        # Where labels have one state and switches cost the same, beginning one again is never better than staying.
        self._alike = lattice.following is None and lattice.moves is None
        self._constant = lattice.get_moves(0) if lattice.moves is None else None
        self.score = np.empty((ticks, 1 if self._alike else labels))
        self.state = np.empty(self.score.shape, np.int64)

    def note(self, tick: int, row: Floats) -> None:
        """Note the scores of a tick."""
        if self._alike:
            best = int(row.argmax())
            self.state[tick, 0], self.score[tick, 0] = best, row[best]
            return
        if self._constant is None and tick + 1 == len(self.score):
            return
        others = row + (self._lattice.get_moves(tick + 1) if self._constant is None else self._constant)
        self.state[tick] = others.argmax(axis=1)
        self.score[tick] = others.max(axis=1)

    def find_state(self, tick: int, label: int) -> int:
        """Return the last state of the path that begins a label after this tick."""
        return int(self.state[tick, 0 if self._alike else label])


def _follow_best(score: Floats, following: Ints, row: Floats, origin: Ints) -> None:
    """Carry scores to the states that follow; where several lead to one, the best counts."""
    for state, target in enumerate(following.tolist()):
        if score[state] > row[target]:
            row[target], origin[target] = score[state], state


def _trace_back(lattice: Lattice, windows: StayWindows, final: Floats, before: Ints, exits: _Exits) -> Ints:
    ticks = len(before)
    states = np.empty(ticks, np.int64)
    tick, state, best = ticks - 1, int(final.argmax()), float(final.max())
    begun, label = ticks, 0
    for start in range(max(1, ticks - lattice.shortest + 1), ticks):  # a last stay that the end cuts off
        arrived = exits.score[start - 1] + windows.fit[start] - lattice.price
        if arrived.max() > best:
            best, begun, label = float(arrived.max()), start, int(arrived.argmax())
    if begun < ticks:
        _write_stay(lattice, states, begun, ticks, label)
        tick, state = begun - 1, exits.find_state(begun - 1, label)
    while tick >= 0:
        if tick and before[tick, state] == ENTERED:
            start, label = tick - lattice.shortest + 1, int(lattice.labels[state])
            _write_stay(lattice, states, start, tick + 1, label)
            tick, state = start - 1, exits.find_state(start - 1, label)
        else:
            states[tick] = state
            state = int(before[tick, state])
            tick -= 1
    return states


def _write_stay(lattice: Lattice, states: Ints, start: int, end: int, label: int) -> None:
    """Write the states of a label from the tick at which it begins."""
    state = int(lattice.entry[start, label])
    states[start] = state
    for tick in range(start + 1, end):
        if lattice.following is not None:
            state = int(lattice.following[tick, state])
        states[tick] = state
