"""The cancellation of one goal of an action, whose request is repeated until the robot answers it.

An answer may be lost while the goal goes on, such as when the router restarts. So a goal counts as one that may run
until its server reports its end, or answers a request to cancel it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf
from threading import Lock

from understudy.addons.robots.ros.transport import Answered

CANCEL_S = 0.5
"""The time for which an answer to a request to cancel is awaited, in s; without one it is sent again."""
CANCELS = 60
"""The largest number of requests to cancel one goal, for each time that it has to be cancelled."""


class Cancellation:
    """The cancellation of one goal, which starts when the goal has to end. Methods may be called from any thread.

    Parameters
    ----------
    send
        Function that sends the request to cancel the goal, and passes the answer on.
    find_problem
        Function that returns why the request cannot be sent now; empty if it can.
    clock
        Function that returns monotonic time, in s.
    """

    def __init__(
        self, send: Callable[[Answered], None], find_problem: Callable[[], str], clock: Callable[[], float]
    ) -> None:
        self._send, self._find_problem, self._clock = send, find_problem, clock
        self._may_run, self._left, self._due_s = True, 0, -inf
        self._round = 0
        self._lock = Lock()

    def start(self) -> None:
        """Cancel the goal if it may still run: ask at once, unless an answer is awaited."""
        with self._lock:
            if not self._may_run:
                return
            self._left = CANCELS
        self.repeat()

    def restart(self) -> None:
        """Cancel the goal by a new request, for a server that may have answered earlier ones before it had the goal."""
        with self._lock:
            self._may_run, self._due_s = True, -inf
            self._round += 1
        self.start()

    def repeat(self) -> None:
        """Send the request again if it is due; call this often. Nothing is sent while the server is not there."""
        if not self._left or self._find_problem():
            return
        with self._lock:
            now = self._clock()
            if not self._left or now < self._due_s:
                return
            self._left, self._due_s = self._left - 1, now + CANCEL_S
            answered = partial(self._accept_answer, self._round)
        self._send(answered)

    def finish(self) -> None:
        """Send no more requests: the goal does not run."""
        with self._lock:
            self._may_run, self._left = False, 0

    def _accept_answer(self, round: int, answer: bytes | None) -> None:
        if answer is not None and round == self._round:
            self.finish()
