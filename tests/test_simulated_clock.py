"""The simulated clock: who is woken when, and that a thread that hangs is an error."""

from __future__ import annotations

from threading import Event, Lock, Thread

import pytest
from tests import simulated_clock
from tests.simulated_clock import ReadOnlyClock, SimulatedClock


class Ticker:
    """A thread that notes the time once a period until it is ended."""

    def __init__(
        self, name: str, clock: SimulatedClock, period_s: float, noted: list[tuple[str, float]]
    ) -> None:
        self.name, self.clock, self.period_s, self.noted = name, clock, period_s, noted
        self.end = Event()
        self.thread = Thread(target=self.run, name=name, daemon=True)
        self.thread.start()

    def run(self) -> None:
        while not self.clock.wait(self.end, self.period_s):
            self.noted.append((self.name, round(self.clock(), 3)))

    def close(self) -> None:
        self.end.set()
        self.thread.join()


def test_time_passes_where_the_test_waits() -> None:
    clock, event = SimulatedClock(5.0), Event()
    assert clock() == 5.0
    clock.sleep(2.0)
    clock.sleep(-1.0)
    assert clock() == 7.0
    assert not clock.wait(event, 1.0)
    assert clock() == 8.0
    event.set()
    assert clock.wait(event, 1.0)
    clock.jump(0.5)
    assert clock() == 8.5


def test_threads_are_woken_in_order_of_their_times() -> None:
    clock, noted = SimulatedClock(0.0), list[tuple[str, float]]()
    slow = Ticker("slow", clock, 0.25, noted)
    clock.expect(1)
    fast = Ticker("fast", clock, 0.1, noted)
    clock.expect(2)
    clock.advance(0.3)
    assert noted == [("fast", 0.1), ("fast", 0.2), ("slow", 0.25), ("fast", 0.3)]
    assert clock() == 0.3
    slow.close()
    clock.advance(0.25)
    assert noted[4:] == [("fast", 0.4), ("fast", 0.5)]
    fast.close()
    clock.advance(1.0)
    assert (len(noted), clock()) == (6, 1.55)


def test_an_event_wakes_a_thread_before_any_time_passes() -> None:
    """Whether the test sets it, or another thread that was woken."""
    clock, noted = SimulatedClock(0.0), list[tuple[str, float]]()
    first, second = Event(), Event()

    def hand_on() -> None:
        clock.wait(first, 10.0)
        noted.append(("first", clock()))
        clock.sleep(1.0)
        second.set()

    def receive() -> None:
        clock.wait(second, 10.0)
        noted.append(("second", clock()))

    threads = [Thread(target=hand_on, daemon=True), Thread(target=receive, daemon=True)]
    for thread in threads:
        thread.start()
    clock.expect(2)
    first.set()
    clock.advance(5.0)
    assert noted == [("first", 0.0), ("second", 1.0)]
    assert clock() == 5.0


def test_time_passes_until_a_state_is_reached() -> None:
    clock, noted = SimulatedClock(0.0), list[tuple[str, float]]()
    ticker = Ticker("ticker", clock, 0.5, noted)
    clock.expect(1)
    clock.advance_until(lambda: len(noted) == 3)
    assert clock() == 1.5
    with pytest.raises(TimeoutError, match="not reached within 2 s"):
        clock.advance_until(lambda: False, 2.0)
    assert clock() == 3.5
    assert clock.wait(ticker.end, 0.0) is False
    ticker.close()


def test_a_time_that_was_jumped_over_comes_late() -> None:
    clock, noted = SimulatedClock(0.0), list[tuple[str, float]]()
    ticker = Ticker("ticker", clock, 0.5, noted)
    clock.expect(1)
    clock.jump(2.0)
    assert noted == []
    clock.advance(0.5)
    assert noted == [("ticker", 2.0), ("ticker", 2.5)]
    ticker.close()


def test_a_thread_that_hangs_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, held = SimulatedClock(), Lock()

    def hang() -> None:
        clock.sleep(1.0)
        with held:
            clock.sleep(1.0)

    with held:
        thread = Thread(target=hang, name="hanging", daemon=True)
        thread.start()
        clock.expect(1)
        monkeypatch.setattr(simulated_clock, "BOUND_S", 0.05)
        with pytest.raises(TimeoutError, match="these threads run: hanging"):
            clock.advance(2.0)
        monkeypatch.undo()
    clock.advance(2.0)
    thread.join()


def test_only_the_test_lets_time_pass() -> None:
    clock, errors = SimulatedClock(), list[RuntimeError]()

    def advance() -> None:
        try:
            clock.advance(1.0)
        except RuntimeError as error:
            errors.append(error)

    thread = Thread(target=advance)
    thread.start()
    thread.join()
    assert len(errors) == 1


def test_nothing_waits_by_a_clock_that_is_only_read() -> None:
    clock = ReadOnlyClock(lambda: 3.0)
    assert clock() == 3.0
    with pytest.raises(RuntimeError, match="nothing waits"):
        clock.sleep(1.0)
    with pytest.raises(RuntimeError, match="nothing waits"):
        clock.wait(Event(), 1.0)
