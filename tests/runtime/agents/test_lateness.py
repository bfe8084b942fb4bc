"""How late messages are, found out from the times at which they were sent and arrived: a table to check by hand."""

from __future__ import annotations

import pytest

from understudy.runtime.agents.lateness import FORMER, WINDOW_S, LatenessMeter

MESSAGES = [  # sent by the sender's clock, arrives by the receiver's, late by
    (50.0, 3.0, 0.0),  # the first one
    (50.5, 3.6, 0.1),
    (51.0, 3.9, 0.0),  # the fastest so far
    (51.5, 4.5, 0.1),
    (52.0, 8.9, 4.0),
]


def test_lateness_is_measured_from_the_fastest_message() -> None:
    meter = LatenessMeter()
    assert [meter.measure(1, sent_s, at_s) for sent_s, at_s, _ in MESSAGES] == pytest.approx(
        [late_s for _, _, late_s in MESSAGES]
    )


def test_each_program_has_a_clock_of_its_own() -> None:
    meter = LatenessMeter()
    assert meter.measure(1, 1000.0, 0.0) == 0.0
    assert meter.measure(2, 0.0, 0.0) == 0.0
    assert meter.measure(1, 1000.0, 1.0) == 1.0


def test_a_clock_that_was_stopped_is_believed_again_after_a_while() -> None:
    """The sender's computer was suspended for a moment, which its clock did not count."""
    meter = LatenessMeter()
    for tick in range(100):
        meter.measure(1, tick * 0.1, tick * 0.1)
    ticks = range(1, round(2 * WINDOW_S / 0.1) + 2)
    late_s = [meter.measure(1, 10.0 + tick * 0.1, 10.6 + tick * 0.1) for tick in ticks]
    assert late_s[0] == pytest.approx(0.6)
    assert late_s[-1] == pytest.approx(0.0, abs=1e-9)


def test_few_programs_are_remembered() -> None:
    meter = LatenessMeter()
    for start in range(10 * FORMER):
        meter.measure(start, 0.0, 0.0)
    assert meter.measure(10 * FORMER - 1, 0.0, 1.0) == 1.0
    assert meter.measure(0, 0.0, 1.0) == 0.0


def test_all_senders_are_remembered_however_many_there_are() -> None:
    meter = LatenessMeter(senders=3 * FORMER)
    for start in range(3 * FORMER):
        meter.measure(start, 0.0, 0.0)
    assert [meter.measure(start, 0.0, 1.0) for start in range(3 * FORMER)] == [1.0] * (3 * FORMER)
