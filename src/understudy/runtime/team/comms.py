"""Delay and lose messages between coordinators and members, and keep what members report (paper section 5).

In every tick a coordinator sends each member its order, and each member sends its readings, its flags, and the order
that they refer to. The next message therefore makes up for a lost one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import ReadingKey
from understudy.model.value_kinds import YES, Column, clear_infinite
from understudy.runtime.team.members import MemberGroup, Membership

ORDER_BYTES = 12
"""The bytes of an order: the squad's number (2), the order's number (2), and the time at which it was given (8)."""
REPORT_BYTES, READING_BYTES, FLAG_BYTES = 10, 8, 1
"""The bytes of a report: the member's number (2) and the time of the order that it answers (8); those of each reading;
and those of each flag."""
DOWN, UP = 1, 2


@dataclass(frozen=True, slots=True)
class Traffic:
    """The messages and bytes per tick between coordinators of one sort and their members."""

    messages: int
    bytes: int


def make_traffic(members: int, readings: int, flags: int) -> Traffic:
    """Compute the traffic of an order to each member, and of a report from each with its readings and flags."""
    report = REPORT_BYTES + READING_BYTES * readings + FLAG_BYTES * flags
    return Traffic(2 * members, members * (ORDER_BYTES + report))


@dataclass(frozen=True)
class CommsChannel:
    """A channel whose messages arrive `ticks` later, and a share `loss` of them never. `keys` [M] identify members."""

    ticks: int
    loss: float
    keys: NDArray[np.uint64]

    @property
    def is_perfect(self) -> bool:
        """Whether all messages arrive at once."""
        return self.ticks == 0 and self.loss == 0.0

    def draw_arrivals(self, tick: int, way: int) -> NDArray[np.bool_]:
        """Draw the members whose message of this tick arrives [M]."""
        if self.loss == 0.0:
            return np.ones(len(self.keys), np.bool_)
        drawn = _mixed(_mixed(self.keys ^ np.uint64(way)) ^ np.uint64(tick))
        return (drawn >> np.uint64(11)) * 2.0**-53 >= self.loss


def make_member_draw_keys(seeds: NDArray[np.int64], members: int, level: int) -> NDArray[np.uint64]:
    """Make the keys of the members of one sort of squads in worlds of these seeds, `members` in each."""
    each = _mixed(np.asarray(seeds, np.uint64) + np.uint64(level + 1))
    return _mixed(np.repeat(each, members) ^ np.tile(np.arange(members, dtype=np.uint64), len(each)))


def _mixed(keys: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Mix numbers into numbers that look random (splitmix64)."""
    with np.errstate(over="ignore"):
        mixed = keys + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    scrambled: NDArray[np.uint64] = mixed ^ (mixed >> np.uint64(31))
    return scrambled


class DelayedValues:
    """Values of M members as they arrive: the last one that got through, absent before the first."""

    def __init__(self, radio: CommsChannel, way: int) -> None:
        self._radio, self._way = radio, way
        self._sent = np.full((radio.ticks + 1, len(radio.keys)), np.nan)
        self._ticks = np.full(radio.ticks + 1, -1)
        self._last = np.full(len(radio.keys), np.nan)

    def push_and_get(self, values: Column, tick: int) -> Column:
        """Send values now, and return those that have arrived by now; the same for each call in one tick."""
        size = len(self._sent)
        self._sent[tick % size], self._ticks[tick % size] = values, tick
        then = tick - self._radio.ticks
        if then >= 0 and self._ticks[then % size] == then:
            arrived = self._radio.draw_arrivals(then, self._way)
            self._last = np.where(arrived, self._sent[then % size], self._last)
        return self._last


Bools: TypeAlias = NDArray[np.bool_]
SILENT_S = 1.0
"""The time without a report after which a member is no longer counted, s."""


@runtime_checkable
class HasFailures(Protocol):
    """A body whose agents can fail: frozen simulated robots, or squads without members left."""

    @property
    def failed(self) -> Bools:
        """The agents that are out of action [N]."""
        ...


class MemberReports:
    """What M members report, each of them a row of one of the bodies below.

    `drops` names a reading: members for which it is yes have dropped out, like failed and silent ones.
    """

    def __init__(
        self,
        roster: Membership,
        bands: Sequence[MemberGroup],
        radio: CommsChannel | None,
        drops: str | None,
        tick_s: float,
    ) -> None:
        self.roster, self.bands, self._radio, self._drops, self._tick_s = roster, bands, radio, drops, tick_s
        self._delayed: dict[ReadingKey | str, DelayedValues] = {}
        self._of_band = [
            (roster.band == number, roster.row[roster.band == number]) for number in range(len(bands))
        ]
        """Which members are of each band, and their rows in it."""
        self._failing = [isinstance(band.layer.body, HasFailures) for band in bands]  # which is slow to ask

    @property
    def is_perfect(self) -> bool:
        """Whether all reports arrive at once."""
        return self._radio is None

    def clear(self) -> None:
        """Forget all reports."""
        self._delayed.clear()

    def readings(self, key: ReadingKey, now: float) -> Column:
        """Return the reading of each member [M]; absent where it has no such reading."""
        values = np.full(len(self.roster), np.nan)
        for band, (there, rows) in zip(self.bands, self._of_band, strict=True):
            if key in band.layer.percept:
                values[there] = clear_infinite(np.asarray(band.layer.percept[key])[rows])
        return self._through(key, values, now)

    def flags(self, flag: str, answering: Column, issued: Column, now: float) -> Column:
        """Return the members that have raised a flag [M].

        A report names the time of the order that it refers to (`answering` [M]). It does not count unless that is the
        present order (`issued` [M]).
        """
        up = np.zeros(len(self.roster))
        for band, (there, rows) in zip(self.bands, self._of_band, strict=True):
            up[there] = band.layer.runner.find_raised(flag)[rows]
        if self._radio is None:
            return up
        up, about = self._through(f"flag {flag}", up, now), self._through("about", answering, now)
        return np.where(about == issued, up, 0.0)

    def select_present(self, now: float) -> Bools:
        """Return the members that are present [M]: not failed, not dropped out, and heard from lately."""
        there = np.ones(len(self.roster), np.bool_)
        for number, band in enumerate(self.bands):
            if self._failing[number]:
                body: Any = band.layer.body
                mine, rows = self._of_band[number]
                there[mine] = ~body.failed[rows]
        if self._radio is not None:
            heard = self._through("heard", np.where(there, now, np.nan), now)
            there = now - heard <= SILENT_S + self._radio.ticks * self._tick_s
        if self._drops is not None:
            there &= self.readings((self._drops, None), now) != YES
        return there

    def _through(self, key: ReadingKey | str, values: Column, now: float) -> Column:
        if self._radio is None:
            return values
        if key not in self._delayed:
            self._delayed[key] = DelayedValues(self._radio, UP)
        return self._delayed[key].push_and_get(values, round(now / self._tick_s))
