"""Statistics over the members of squads, and their memory of earlier ticks (paper section 5.1)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.model.squad import TELLING, YES_OR_NO, Statistic
from understudy.model.value_kinds import BOOLEAN, YES, Column, Kind, Toroidal
from understudy.runtime.team.members import Membership

Bools = NDArray[np.bool_]


def select_matching_members(statistic: Statistic, values: Column, kind: Kind | None) -> Bools:
    """Return the members for which a statistic's condition holds [M], by their reading or flag."""
    if kind is None or (kind == BOOLEAN and statistic.least is None and statistic.below is None):
        yes: Bools = np.equal(values, YES)
        return yes
    least = -np.inf if statistic.least is None else statistic.least
    below = np.inf if statistic.below is None else statistic.below
    true: Bools = (values >= least) & (values < below)  # what is absent is neither
    return true


def count_matching_members(how: str, true: Bools, counted: Bools, roster: Membership) -> Column:
    """Count for each squad [S] the counted members [M] for which the condition holds, in the way that `how` names."""
    everyone = np.bincount(roster.squad, counted, minlength=roster.squads)
    number = np.bincount(roster.squad, true & counted, minlength=roster.squads)
    values: NDArray[Any] = number
    if how == "fraction":
        values = np.divide(number, everyone, out=np.full(roster.squads, np.nan), where=everyone > 0)
    elif how == "all":
        values = (number == everyone) & (everyone > 0)
    elif how != "count":
        values = (number > 0) == (how == "any")
    return values.astype(np.float64)


def aggregate_readings(how: str, values: Column, counted: Bools, roster: Membership, kind: Kind) -> Column:
    """Compute the mean, minimum, maximum or spread over counted members [M] of each squad [S]; absent if none.

    Sums go in the order of members, so that they are the same for one squad alone and among others.
    """
    there = counted & ~np.isnan(values)
    number = np.bincount(roster.squad, there, minlength=roster.squads)
    nothing = np.full(roster.squads, np.nan)

    def mean(of: Column) -> Column:
        total = np.bincount(roster.squad, np.where(there, of, 0.0), minlength=roster.squads)
        aggregate: Column = np.divide(total, number, out=nothing.copy(), where=number > 0)
        return aggregate

    if isinstance(kind, Toroidal) and how in ("mean", "spread"):
        turn = 2.0 * np.pi / kind.period
        east, north = mean(np.cos(values * turn)), mean(np.sin(values * turn))
        if how == "mean":
            return kind.wrap(np.arctan2(north, east) / turn)
        scatter: Column = np.sqrt(-2.0 * np.log(np.clip(np.hypot(east, north), 1e-300, 1.0))) / turn
        return scatter
    if how == "mean":
        return mean(values)
    if how == "spread":
        middle = mean(values)
        deviation: Column = np.sqrt(mean((values - middle[roster.squad]) ** 2))
        return deviation
    ends, worst = (np.minimum, np.inf) if how == "minimum" else (np.maximum, -np.inf)
    aggregate = np.full(roster.squads, worst)
    ends.at(aggregate, roster.squad[there], values[there])
    return np.where(number > 0, aggregate, np.nan)


@dataclass
class StatisticMemory:
    """The memory of one statistic: when it was last yes, since when it is yes, and its last values, for each squad."""

    statistic: Statistic
    kind: Kind
    squads: int
    tick_s: float
    last: Column = field(init=False)
    since: Column = field(init=False)
    values: Column = field(init=False)
    times: Column = field(init=False)

    def __post_init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Clear the memory."""
        span = self.statistic.within_s if self.statistic.how not in YES_OR_NO else None
        ticks = 0 if span is None else round(span / self.tick_s) + 1
        self.last, self.since = np.full(self.squads, np.nan), np.full(self.squads, np.nan)
        self.values, self.times = np.full((ticks, self.squads), np.nan), np.full(ticks, -np.inf)

    def update(self, value: Column, now: float) -> Column:
        """Return the statistic over time, given its present value; the same for each call in one tick."""
        statistic = self.statistic
        if statistic.how not in YES_OR_NO:
            return self._over(value, now)
        yes = value == YES
        self.last[yes] = now
        self.since = np.where(yes, np.where(np.isnan(self.since), now, self.since), np.nan)
        if statistic.since:
            return _seconds(now, self.last)
        if statistic.within_s is not None:
            return (_seconds(now, self.last) <= round(statistic.within_s, 9)).astype(np.float64)
        return (_seconds(now, self.since) >= round(statistic.for_s or 0.0, 9)).astype(np.float64)

    def _over(self, value: Column, now: float) -> Column:
        """Return the mean, minimum or maximum of the last values; absent if there are none."""
        slot = round(now / self.tick_s) % len(self.values)
        self.values[slot], self.times[slot] = value, now
        lately = _seconds(now, self.times) <= round(self.statistic.within_s or 0.0, 9)
        columns = np.tile(np.arange(self.squads), int(lately.sum()))
        moments = Membership(self.squads, columns, columns, columns, columns)
        how = self.statistic.how if self.statistic.how in ("minimum", "maximum") else "mean"
        values = self.values[lately].ravel()
        return aggregate_readings(how, values, np.ones(len(values), np.bool_), moments, self.kind)


def _seconds(now: float, since: Column) -> Column:
    """Return the seconds from a time to now, rounded as by the interpreter."""
    steps = 1e9 if now < 4194304.0 else 1e6
    seconds: Column = np.floor((now - since) * steps + 0.5) / steps
    return seconds


def compute_statistic(
    statistic: Statistic, values: Column, counted: Bools, roster: Membership, kind: Kind | None
) -> Column:
    """Compute a statistic [S] without its past; `kind` is that of the reading, None for a flag."""
    if statistic.how in TELLING:
        return count_matching_members(
            statistic.how, select_matching_members(statistic, values, kind), counted, roster
        )
    return aggregate_readings(statistic.how, values, counted, roster, kind or BOOLEAN)
