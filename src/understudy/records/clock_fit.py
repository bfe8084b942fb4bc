"""Fits of one clock to another from messages in both directions, with a bound of the error, as in NTP.

A message arrives after it was sent. Each message thus bounds the time that one clock shows when the other shows a given
time: from below in one direction, from above in the other. What is returned is the straight line in the middle of all
that are within these bounds. No clock is quite a straight line, because its rate changes with its temperature. So the
error is the largest distance from this line to any clock within the bounds whose rate changes by no more than `CHANGE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.value_kinds import Column

FASTEST = 1e-3
"""The largest difference between the rates of two clocks that is considered."""
CHANGE = 2.5e-5
"""The largest difference between a clock's rate, by another one, and its mean that is considered; temperature changes
it by less."""
BINS = 256
"""The number of periods in each of which lines are only compared with the tightest bound of each direction."""
LEAST_UNEVEN_S = 1e-5
"""The unevenness that is tried first for clocks that no straight line fits, s."""
RESOLUTION_S = 1e-6
"""The slack of every bound, s, because times are rounded."""


class NoExchange(Exception):
    """Two recordings without messages in both directions."""


@dataclass(frozen=True)
class ClockFit:
    """A fit of another clock to that of a recording.

    Attributes
    ----------
    first_s
        The first time of the recording by its own clock, s.
    last_s
        The last one, s.
    middle
        The other clock at these two times, s.
    error_s
        The largest error of `convert` between them, s.
    error_rate
        By how much the error grows in each second before or after them.
    uneven_s
        How far messages are from any straight line, s; 0 for clocks that run evenly.
    """

    first_s: float
    last_s: float
    middle: tuple[float, float]
    error_s: float
    error_rate: float
    uneven_s: float = 0.0

    def convert(self, time_s: float) -> float:
        """Return the other clock's time at a time of the recording's clock, s."""
        return self.middle[0] + (self.middle[1] - self.middle[0]) * self._place(time_s)

    @property
    def rate(self) -> float:
        """How fast the other clock runs relative to the recording's."""
        return (self.middle[1] - self.middle[0]) / (self.last_s - self.first_s)

    def find_error(self, time_s: float) -> float:
        """Return the largest error of `convert` at a time, s."""
        return self.error_s + self.error_rate * max(self.first_s - time_s, time_s - self.last_s, 0.0)

    def find_largest_error(self, first_s: float, last_s: float) -> float:
        """Return the largest error of `convert` between two times, s; it is largest at one of them."""
        return max(self.find_error(first_s), self.find_error(last_s))

    def _place(self, time_s: float) -> float:
        return (time_s - self.first_s) / (self.last_s - self.first_s)


def fit_clock(
    received: NDArray[np.float64], sent: NDArray[np.float64], first_s: float, last_s: float
) -> ClockFit:
    """Fit another clock to that of a recording.

    Parameters
    ----------
    received
        Messages from the other program [N, 2]: when each was received by the recording's clock, and when it was sent by
        the other clock, s.
    sent
        Messages to the other program [M, 2]: when each was sent by the recording's clock, and when it was received by
        the other clock, s.
    first_s
        The first time of the recording by its own clock, s.
    last_s
        The last one, s.

    Returns
    -------
    ClockFit
        The fit. If the rates of the clocks differ by less than 0.1 %, and by less than 25 ppm more or less than on
        average, the other clock's true time is within the error of it, however long messages took.

    Raises
    ------
    NoExchange
        If there are no messages in one direction.
    """
    if not len(received) or not len(sent):
        raise NoExchange
    last_s = max(last_s, first_s + 1.0)
    least, most = _keep_tightest(received, -1.0, first_s, last_s), _keep_tightest(sent, 1.0, first_s, last_s)
    uneven_s = 0.0
    corners = _find_region(least, most, first_s, last_s, RESOLUTION_S)
    while not len(corners):
        uneven_s = max(2 * uneven_s, LEAST_UNEVEN_S)
        corners = _find_region(least, most, first_s, last_s, RESOLUTION_S + uneven_s)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    rates = (corners[:, 1] - corners[:, 0]) / (last_s - first_s)
    rate = float(middle[1] - middle[0]) / (last_s - first_s)
    # The mean rate of a clock is at most CHANGE outside those of the lines, and its rate at most as much from the mean.
    change = 2 * CHANGE + float(np.abs(rates - rate).max())
    start = float(middle[0]) - rate * first_s
    above = _Envelope.from_bounds(sent, 1.0, start, rate, change)
    below = _Envelope.from_bounds(received, -1.0, start, rate, change)
    error_s = _find_farthest(above, below, first_s, last_s) + RESOLUTION_S
    return ClockFit(first_s, last_s, (float(middle[0]), float(middle[1])), error_s, change, uneven_s)


class _Envelope(NamedTuple):
    """The farthest distance on one side of a line at which a clock can be, at each time.

    A clock that was within a bound is now within the bound and what its rate, which differs from the line's by at most
    `change`, can have added since; likewise for bounds that come later.
    """

    times: Column
    since: Column
    """For the bounds up to each, the distance at time 0 from which it has grown [N + 1]; infinite before the first."""
    until: Column
    """For the bounds from each on, the distance at time 0 from which it falls [N + 1]; infinite after the last."""
    change: float

    @classmethod
    def from_bounds(
        cls, bounds: NDArray[np.float64], sign: float, start: float, rate: float, change: float
    ) -> _Envelope:
        """Make the envelope of bounds above (sign 1) or below (sign -1) the line `start + rate * time`."""
        times, others = bounds[np.argsort(bounds[:, 0])].T
        distances = sign * (others - start - rate * times)
        since = np.minimum.accumulate(distances - change * times)
        until = np.minimum.accumulate((distances + change * times)[::-1])[::-1]
        return cls(times, np.append(inf, since), np.append(until, inf), change)

    @property
    def breaks(self) -> Column:
        """The times between which the envelope is straight: those of the bounds, and its peaks between them."""
        peaks = (self.until[1:-1] - self.since[1:-1]) / (2 * self.change)
        return np.append(self.times, np.clip(peaks, self.times[:-1], self.times[1:]))

    def find(self, times: Column) -> Column:
        """Find the farthest distances at times."""
        place = np.searchsorted(self.times, times, side="right")
        return np.minimum(self.since[place] + self.change * times, self.until[place] - self.change * times)


def _find_farthest(above: _Envelope, below: _Envelope, first_s: float, last_s: float) -> float:
    """Find how far from the line a clock can be between two times; further by what bounds contradict each other."""
    times = np.concatenate([[first_s, last_s], above.breaks, below.breaks])
    up, down = above.find(times), below.find(times)
    return float(max(up.max(), down.max()) + max(0.0, -(up + down).min()))


def _keep_tightest(
    bounds: NDArray[np.float64], sign: float, first_s: float, last_s: float
) -> NDArray[np.float64]:
    """Return the tightest bound of each of BINS periods; the others would hardly change the fit."""
    bins = np.clip((bounds[:, 0] - first_s) / (last_s - first_s) * BINS, 0, BINS - 1).astype(np.intp)
    height = sign * (bounds[:, 1] - bounds[:, 0])
    order = np.lexsort((height, bins))
    starts = np.flatnonzero(np.diff(bins[order], prepend=-1))
    return np.asarray(bounds[order[starts]])


def _find_region(
    least: NDArray[np.float64], most: NDArray[np.float64], first_s: float, last_s: float, slack: float
) -> NDArray[np.float64]:
    """Find the corners of all pairs of times at both ends whose line is within the bounds; none if there is no line."""
    span = last_s - first_s
    slow, fast = (1 - FASTEST) * span, (1 + FASTEST) * span
    low = max(_extrapolate(least, first_s, FASTEST)) - slack
    high = min(_extrapolate(most, first_s, -FASTEST)) + slack
    if not -inf < low <= high:
        return np.empty((0, 2))
    corners = np.array([[low, low + slow], [high, high + slow], [high, high + fast], [low, low + fast]])
    for bounds, sign in ((least, -1.0), (most, 1.0)):
        for at, bound in bounds.tolist():
            place = (at - first_s) / span
            excess = sign * (corners[:, 0] * (1 - place) + corners[:, 1] * place - bound) - slack
            corners = _clip(corners, excess)
            if not len(corners):
                return corners
    return corners


def _extrapolate(bounds: NDArray[np.float64], first_s: float, rate: float) -> Column:
    """Convert bounds at other times to bounds at the first one, if the rates differ as much as possible."""
    passed = bounds[:, 0] - first_s
    return np.asarray(bounds[:, 1] - passed - rate * np.abs(passed))


def _clip(corners: NDArray[np.float64], excess: Column) -> NDArray[np.float64]:
    """Cut off the part of a convex polygon in which `excess`, given at its corners, is positive."""
    inside = excess <= 0.0
    if inside.all():
        return corners
    clipped = []
    for here in range(len(corners)):
        after = (here + 1) % len(corners)
        if inside[here]:
            clipped.append(corners[here])
        if inside[here] != inside[after]:
            share = excess[here] / (excess[here] - excess[after])
            clipped.append(corners[here] + share * (corners[after] - corners[here]))
    return np.array(clipped).reshape(-1, 2)
