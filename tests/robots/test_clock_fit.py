"""Fits of one clock to another: the true time is always within the stated error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from understudy.records.clock_fit import CHANGE, FASTEST, ClockFit, NoExchange, fit_clock

SPAN_S = 100.0
EXCHANGES = [  # ahead s, delay to the other s, delay back s, expected middle s, expected error s
    (0.0, 0.010, 0.010, 0.0, 0.010),
    (0.0, 0.000, 0.000, 0.0, 0.000),
    (3600.0, 0.004, 0.004, 3600.0, 0.004),
    (-3600.0, 0.004, 0.004, -3600.0, 0.004),
    (0.5, 0.030, 0.010, 0.510, 0.020),  # asymmetric delays cannot be told from an offset
    (0.5, 0.000, 0.040, 0.480, 0.020),
    (1e9, 0.002, 0.002, 1e9, 0.002),  # a computer that believes it is 1970
]


def exchange(
    ahead_s: float, rate: float, there: list[tuple[float, float]], back: list[tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Messages received and sent, each by its time and delay; the other clock shows `ahead_s + rate * time`."""

    def other(time_s: float) -> float:
        return ahead_s + rate * time_s

    sent = [(at, other(at + delay)) for at, delay in there]
    received = [(at + delay, other(at)) for at, delay in back]
    return np.array(received).reshape(-1, 2), np.array(sent).reshape(-1, 2)


@pytest.mark.parametrize(("ahead_s", "there_s", "back_s", "middle_s", "error_s"), EXCHANGES)
def test_exchanges(ahead_s: float, there_s: float, back_s: float, middle_s: float, error_s: float) -> None:
    """As in NTP: half the difference of the delays is the fault, half their sum the error."""
    times = np.linspace(0.0, SPAN_S, 1001).tolist()
    fit = fit_clock(
        *exchange(ahead_s, 1.0, [(at, there_s) for at in times], [(at - back_s, back_s) for at in times]),
        0.0, SPAN_S,
    )  # fmt: skip
    assert fit.convert(0.0) == pytest.approx(middle_s, abs=1e-4)
    assert fit.find_largest_error(0.0, SPAN_S) == pytest.approx(error_s, rel=0.02, abs=1e-4)
    assert abs(fit.convert(50.0) - (50.0 + ahead_s)) <= fit.find_error(50.0)


DELAYS = st.floats(0.0, 10.0) | st.floats(0.0, 0.01)
TIMES = st.floats(0.0, SPAN_S)
MESSAGES = st.lists(st.tuples(TIMES, DELAYS), min_size=1, max_size=30)


@given(st.floats(-1e6, 1e6), st.floats(-FASTEST, FASTEST), MESSAGES, MESSAGES, TIMES)
def test_the_true_time_is_within_the_error(
    ahead_s: float,
    drift: float,
    there: list[tuple[float, float]],
    back: list[tuple[float, float]],
    time_s: float,
) -> None:
    """However long messages took: any delays that are not negative, an hour of offset, a clock that runs faster."""
    rate = 1.0 + drift
    fit = fit_clock(*exchange(ahead_s, rate, there, back), 0.0, SPAN_S)
    assert fit.uneven_s == 0.0
    assert abs(fit.convert(time_s) - (ahead_s + rate * time_s)) <= fit.find_largest_error(0.0, SPAN_S) + 1e-7
    assert abs(fit.convert(time_s) - (ahead_s + rate * time_s)) <= fit.find_error(time_s) + 1e-7


@dataclass(frozen=True)
class WanderingClock:
    """A clock whose rate differs from its mean by no more than `CHANGE`, by another share of that in each part.

    Before the first part and after the last one it goes on like these.
    """

    ahead_s: float
    mean: float
    shares: tuple[float, ...]

    def show(self, times_s: np.ndarray) -> np.ndarray:
        """What it shows at times, s."""
        rates = np.array([self.shares[0], *self.shares, self.shares[-1]]) * CHANGE
        ends = np.concatenate([[-SPAN_S], np.linspace(0.0, SPAN_S, len(self.shares) + 1), [2 * SPAN_S]])
        gained = np.append(0.0, np.cumsum(rates * np.diff(ends)))
        return np.asarray(self.ahead_s + self.mean * times_s + np.interp(times_s, ends, gained))


SHARES = st.sampled_from([-1.0, 0.0, 1.0]) | st.floats(-1.0, 1.0)
CLOCKS = st.builds(
    WanderingClock,
    st.floats(-1e6, 1e6),
    st.floats(1 - FASTEST + CHANGE, 1 + FASTEST - CHANGE),
    st.lists(SHARES, min_size=1, max_size=10).map(tuple),
)
FEW = [(0.0, 1e-3), (SPAN_S, 1e-3)]
"""Messages at both ends, in whose middle a clock can be anywhere that its rate allows."""
MANY = [(at, 1e-3) for at in np.linspace(0.0, SPAN_S, 1001).tolist()]


@given(CLOCKS, MESSAGES, MESSAGES, st.floats(-SPAN_S, 2 * SPAN_S))
@example(WanderingClock(0.0, 1.0, (1.0, -1.0)), FEW, FEW, 50.0)
@example(WanderingClock(0.0, 1.0, (-1.0, 1.0)), FEW, FEW, 50.0)
@example(WanderingClock(0.0, 1.0, (1.0, 0.0, -1.0)), MANY, MANY, 2 * SPAN_S)
@example(WanderingClock(0.0, 1.0, (1.0, 0.0, -1.0)), MANY, MANY, -SPAN_S)
def test_a_clock_whose_rate_changes_is_within_the_error(
    clock: WanderingClock, there: list[tuple[float, float]], back: list[tuple[float, float]], time_s: float
) -> None:
    """As with temperature, between messages and where they show it."""
    sent = np.array([(at, at + delay) for at, delay in there])
    received = np.array([(at + delay, at) for at, delay in back])
    for each in (sent, received):
        each[:, 1] = clock.show(each[:, 1])
    fit = fit_clock(received, sent, 0.0, SPAN_S)
    true_s = float(clock.show(np.array([time_s]))[0])
    assert abs(fit.convert(time_s) - true_s) <= fit.find_error(time_s) + 1e-7


WANDERED = [  # shares of CHANGE, which is 2.5e-5; what the clock gains on one that runs evenly, s
    ((0.0,), 0.0),
    ((1.0, -1.0), 1.25e-3),
    ((1.0, 0.0, -1.0), 0.833e-3),
    ((1.0, -1.0) * 20, 0.0625e-3),
]


@pytest.mark.parametrize(("shares", "gains_s"), WANDERED)
def test_the_error_of_a_clock_whose_rate_changes(shares: tuple[float, ...], gains_s: float) -> None:
    """It is half of what the clock gains, or all of it, and the delay of messages, 0.3 ms each way."""
    clock, times = WanderingClock(0.0, 1.0, shares), np.linspace(0.0, SPAN_S, 10001)
    sent = np.stack([times, clock.show(times + 3e-4)], 1)
    received = np.stack([times, clock.show(times - 3e-4)], 1)
    error_s = fit_clock(received, sent, 0.0, SPAN_S).find_error(50.0)
    assert gains_s / 2 + 0.29e-3 <= error_s <= gains_s + 0.31e-3


@pytest.mark.parametrize(("there", "back"), [(FEW, MANY), (MANY, FEW)])
def test_the_error_where_one_direction_was_not_heard(
    there: list[tuple[float, float]], back: list[tuple[float, float]]
) -> None:
    """It is the delay of 1 ms and what a rate that is 2.5e-5 off, beside a mean as far off, can add in 50 s."""
    error_s = fit_clock(*exchange(0.0, 1.0, there, back), 0.0, SPAN_S).find_error(50.0)
    assert 1e-3 + 2 * 1.25e-3 <= error_s <= 1e-3 + 2 * 1.25e-3 + 1.1e-3  # the last: lines that rise by 1 ms


def fit_drift(rate: float, jump_s: float = 0.0) -> ClockFit:
    times = np.linspace(0.0, SPAN_S, 1001).tolist()
    received, sent = exchange(0.0, rate, [(at, 0.002) for at in times], [(at, 0.002) for at in times])
    for each in (received, sent):
        each[each[:, 0] > SPAN_S / 2, 1] += jump_s
    return fit_clock(received, sent, 0.0, SPAN_S)


def test_a_clock_that_runs_faster_is_followed() -> None:
    fit = fit_drift(1.0 + 2e-4)
    assert fit.rate == pytest.approx(1.0 + 2e-4, abs=1e-5)
    assert fit.find_largest_error(0.0, SPAN_S) < 0.005


def test_a_clock_that_jumps_is_said_to_be_uneven() -> None:
    """No straight line fits; the error covers both sides of the jump."""
    fit = fit_drift(1.0, jump_s=0.5)
    assert fit.uneven_s > 0.1
    for at, true in ((1.0, 1.0), (49.0, 49.0), (51.0, 51.5), (99.0, 99.5)):
        assert abs(fit.convert(at) - true) <= fit.find_error(at)


def test_one_direction_is_not_enough() -> None:
    one, none = np.array([[1.0, 1.0]]), np.empty((0, 2))
    for received, sent in ((one, none), (none, one), (none, none)):
        with pytest.raises(NoExchange):
            fit_clock(received, sent, 0.0, SPAN_S)
