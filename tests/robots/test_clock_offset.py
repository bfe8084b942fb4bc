"""The offset of two clocks that cannot be read at one time, in a program that may be held up at any reading."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.simulated_clock import HeldUpReadings

from understudy.clock import ATTEMPTS, PROMPT_S, measure_clock_offset

AHEAD_S = 3600
"""How far the other clock is ahead, s."""
HELD_UP = [  # the readings that are held up by 2.6 ms, the error of the offset in s
    ((), 0.0),
    ((0,), 0.0),  # before the first reading: nothing is lost
    ((1,), 0.0),  # between the first and the other clock: measured again
    ((2,), 0.0),
    ((1, 4, 7, 10), 0.0),
    (range(3 * ATTEMPTS), 0.0),  # always, in equal parts
    (range(1, 3 * ATTEMPTS, 3), 1.3e-3),  # always before the other clock: half of the time in between
]


def measure_error(readings: HeldUpReadings) -> float:
    """Measure the offset, and return the error of that, s."""
    return abs(measure_clock_offset(readings.read, readings.read_other) / 1e9 - AHEAD_S)


@pytest.mark.parametrize(("held", "error_s"), HELD_UP)
def test_readings_that_are_held_up(held: range | tuple[int, ...], error_s: float) -> None:
    readings = HeldUpReadings(dict.fromkeys(held, 2.6e-3), ahead_s=AHEAD_S)
    assert measure_error(readings) == pytest.approx(error_s, abs=1e-8)


def test_readings_that_are_not_held_up_are_done_once() -> None:
    """The safety monitor does this at each check."""
    readings = HeldUpReadings({}, ahead_s=AHEAD_S)
    measure_error(readings)
    assert readings.readings == 3


@given(st.dictionaries(st.integers(0, 3 * ATTEMPTS), st.floats(0.0, 3.0), max_size=ATTEMPTS - 1))
@example({1: 2.6e-3})
def test_the_error_is_below_what_is_stated(holds_s: dict[int, float]) -> None:
    """Fewer readings are held up than there are attempts, so that one attempt is prompt."""
    assert measure_error(HeldUpReadings(holds_s, ahead_s=AHEAD_S)) <= PROMPT_S / 2 + 1e-8
