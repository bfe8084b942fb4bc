"""The radio between coordinators and their members: what it takes, how long, and what gets lost (paper section 5).

In every tick a coordinator sends each member its order, and each member sends back what it senses, its flags, and
which order it answers. So what is lost is made up for by the next message.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column

ORDER_BYTES = 12
"""An order: whose (2), what (2), when it was given (8)."""
REPORT_BYTES, READING_BYTES, FLAG_BYTES = 10, 8, 1
"""A report: whose (2), which order it answers (8), a number for each reading, a byte for each flag."""
DOWN, UP = 1, 2


@dataclass(frozen=True, slots=True)
class Traffic:
    """Messages and bytes that a tick takes between coordinators of one sort and their members."""

    messages: int
    bytes: int


def traffic(members: int, readings: int, flags: int) -> Traffic:
    """An order to each member and a report from it, with so many readings and flags in it."""
    report = REPORT_BYTES + READING_BYTES * readings + FLAG_BYTES * flags
    return Traffic(2 * members, members * (ORDER_BYTES + report))


@dataclass(frozen=True)
class Radio:
    """Messages arrive `ticks` later, a share `loss` of them never. `keys` [M] tell members apart in all worlds."""

    ticks: int
    loss: float
    keys: NDArray[np.uint64]

    @property
    def perfect(self) -> bool:
        """Whether all arrives at once."""
        return self.ticks == 0 and self.loss == 0.0

    def arrives(self, tick: int, way: int) -> NDArray[np.bool_]:
        """Whose message of this tick arrives [M]."""
        if self.loss == 0.0:
            return np.ones(len(self.keys), np.bool_)
        drawn = _mixed(_mixed(self.keys ^ np.uint64(way)) ^ np.uint64(tick))
        return (drawn >> np.uint64(11)) * 2.0**-53 >= self.loss


def radio_keys(seeds: NDArray[np.int64], members: int, level: int) -> NDArray[np.uint64]:
    """Keys of the members of one sort of squads in worlds of these seeds, `members` in each."""
    each = _mixed(np.asarray(seeds, np.uint64) + np.uint64(level + 1))
    return _mixed(np.repeat(each, members) ^ np.tile(np.arange(members, dtype=np.uint64), len(each)))


def _mixed(keys: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Numbers that look like chance, from numbers (splitmix64)."""
    with np.errstate(over="ignore"):
        mixed = keys + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    found: NDArray[np.uint64] = mixed ^ (mixed >> np.uint64(31))
    return found


class Delayed:
    """Values of M members as they arrive: the last that got through, absent before the first."""

    def __init__(self, radio: Radio, way: int) -> None:
        self._radio, self._way = radio, way
        self._sent = np.full((radio.ticks + 1, len(radio.keys)), np.nan)
        self._ticks = np.full(radio.ticks + 1, -1)
        self._last = np.full(len(radio.keys), np.nan)

    def through(self, values: Column, tick: int) -> Column:
        """What has arrived by now, given what is sent now; asked again in the same tick it answers the same."""
        size = len(self._sent)
        self._sent[tick % size], self._ticks[tick % size] = values, tick
        then = tick - self._radio.ticks
        if then >= 0 and self._ticks[then % size] == then:
            arrived = self._radio.arrives(then, self._way)
            self._last = np.where(arrived, self._sent[then % size], self._last)
        return self._last
