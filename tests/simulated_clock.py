"""A clock whose time passes only as a test lets it, for the test's own thread and for the threads of what it tests."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Condition, Event, Thread, current_thread

BOUND_S = 60.0
"""Longest real time for threads to wait again or end, s; it is reached only where one of them hangs."""
READING_S = 1e-7
"""The time that a reading of one of `HeldUpReadings` takes at least, s."""
POLL_S = 0.002
"""Real time between two looks at what tells of no change: events that are set, and threads that end, s."""


@dataclass(eq=False)
class _Waiting:
    thread: Thread
    due_s: float
    event: Event | None
    woken: bool = False

    @property
    def event_set(self) -> bool:
        return self.event is not None and self.event.is_set()


class SimulatedClock:
    """A `Clock` in simulated time.

    The thread that makes it is the test's: where that waits, time passes at once. Other threads wait until the test
    lets time pass. Each is woken at its own time, one after another in order of these times, and the next only once
    this one waits again or has ended. The order is thereby the same in every run.

    A thread is known from its first wait on. Call `expect` after starting threads, so that none misses an advance.
    A thread that is woken and then neither waits by this clock nor ends, or needs a lock that the test's thread holds,
    is an error.

    Parameters
    ----------
    now_s
        The first time, s.
    """

    def __init__(self, now_s: float = 100.0) -> None:
        self._now_s, self._driver = now_s, current_thread()
        self._changed = Condition()
        self._waiting: list[_Waiting] = []
        self._running: set[Thread] = set()

    def __call__(self) -> float:
        """Return the simulated time, s."""
        return self._now_s

    def sleep(self, seconds: float) -> None:
        """Return after some simulated seconds; in the test's own thread they pass at once."""
        if seconds > 0:
            self._wait(None, seconds)

    def wait(self, event: Event, timeout_s: float) -> bool:
        """Wait until an event is set, for some simulated seconds at most; return whether it is."""
        if not event.is_set() and timeout_s > 0:
            self._wait(event, timeout_s)
        return event.is_set()

    def advance(self, seconds: float) -> None:
        """Let time pass, with everything that threads do in it; only the test's thread may do so."""
        self._advance(self._later(seconds), lambda: False)

    def advance_until(self, reached: Callable[[], object], timeout_s: float = BOUND_S) -> None:
        """Let time pass, from one wake-up of a thread to the next, until a state is reached.

        TimeoutError is raised if it is not reached in this simulated time (s).
        """
        self._advance(self._later(timeout_s), lambda: bool(reached()))
        if not reached():
            raise TimeoutError(f"this was not reached within {timeout_s:g} s of simulated time")

    def jump(self, seconds: float) -> None:
        """Let time pass in which no thread runs, as on a computer that stood still."""
        self._now_s = self._later(seconds)

    def expect(self, threads: int) -> None:
        """Return once as many threads wait by this clock."""
        with self._changed:
            self._change(lambda: len(self._waiting) >= threads, f"{threads} threads that wait by this clock")

    def _later(self, seconds: float) -> float:
        """Return the time after some seconds, in whole nanoseconds, so that three times 0.1 s are 0.3 s."""
        return round(self._now_s + seconds, 9)

    def _wait(self, event: Event | None, seconds: float) -> None:
        if current_thread() is self._driver:
            self._advance(self._later(seconds), lambda: event is not None and event.is_set())
            return
        waiting = _Waiting(current_thread(), self._later(seconds), event)
        with self._changed:
            self._running.discard(waiting.thread)
            self._waiting.append(waiting)
            self._changed.notify_all()
            while not waiting.woken and not waiting.event_set:
                self._changed.wait(None if event is None else POLL_S)
            self._running.add(waiting.thread)
            if not waiting.woken:
                self._waiting.remove(waiting)

    def _advance(self, until_s: float, reached: Callable[[], bool]) -> None:
        if current_thread() is not self._driver:
            raise RuntimeError("only the thread that made this clock may let time pass")
        with self._changed:
            self._settle()
            while not reached():
                due = min(self._waiting, key=lambda each: each.due_s, default=None)
                if due is None or due.due_s > until_s:
                    self._now_s = max(self._now_s, until_s)
                    return
                self._now_s = max(self._now_s, due.due_s)
                due.woken = True
                self._waiting.remove(due)
                self._running.add(due.thread)
                self._changed.notify_all()
                self._settle()

    def _settle(self) -> None:
        """Return once no thread runs: each waits or has ended, and none waits for an event that is set."""

        def is_settled() -> bool:
            self._running = {thread for thread in self._running if thread.is_alive()}
            return not self._running and not any(each.event_set for each in self._waiting)

        self._change(is_settled, "all threads to wait by this clock, or to end")

    def _change(self, reached: Callable[[], bool], what: str) -> None:
        until = time.monotonic() + BOUND_S
        while not reached():
            if time.monotonic() > until:
                names = ", ".join(sorted(thread.name for thread in self._running)) or "none"
                raise TimeoutError(f"waited in vain for {what}; these threads run: {names}")
            self._changed.wait(POLL_S)


class ReadOnlyClock:
    """The time that something else keeps; nothing may wait by it.

    Parameters
    ----------
    read
        Function that returns the time, s.
    """

    def __init__(self, read: Callable[[], float]) -> None:
        self._read = read

    def __call__(self) -> float:
        """Return the time, s."""
        return self._read()

    def sleep(self, seconds: float) -> None:
        """Raise an error."""
        raise RuntimeError("nothing waits by this clock")

    def wait(self, event: Event, timeout_s: float) -> bool:
        """Raise an error."""
        raise RuntimeError("nothing waits by this clock")


class HeldUpReadings:
    """Two clocks as a program reads them that is held up at some of its readings.

    Parameters
    ----------
    holds_s
        For how long it is held up, s, by the number of the reading.
    ahead_s
        How far the other clock is ahead, s.
    """

    def __init__(self, holds_s: Mapping[int, float], *, ahead_s: int) -> None:
        self.readings, self._holds_s = 0, holds_s
        self._true_s, self._ahead_ns = 100.0, ahead_s * 10**9

    def read(self) -> float:
        """Read the clock, s."""
        self._true_s += READING_S + self._holds_s.get(self.readings, 0.0)
        self.readings += 1
        return self._true_s

    def read_other(self) -> int:
        """Read the other clock, ns."""
        return self._ahead_ns + round(self.read() * 1e9)
