"""The reel: moments of a run, kept for some minutes, to go back to."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from understudy.errors import SessionError
from understudy.model.example import Example
from understudy.training.company import Instant
from understudy.training.session import Session

EVERY_S = 0.5
KEPT_S = 300.0
"""How long a moment is kept, s of the world's time."""
MOST_BYTES = 64 * 1024 * 1024
"""What all moments together may take; of a large world fewer are kept."""


class Frame(NamedTuple):
    """A moment, when it was (s of the world's time), and how much room it takes."""

    time_s: float
    instant: Instant
    size: int


class Reel:
    """The moments of one run of one session, oldest first."""

    def __init__(self) -> None:
        self._frames: deque[Frame] = deque()
        self._size = 0
        self._shown: dict[int, float] = {}  # when examples were shown, by number

    def see(self, session: Session) -> None:
        """A tick passed. Where time went back before, what came after is forgotten."""
        now = session.body.time_s
        while self._frames and self._frames[-1].time_s >= now:
            self._size -= self._frames.pop().size
        self._note(session.examples, now)
        if self._frames and now < self._frames[-1].time_s + EVERY_S - session.body.tick_s / 2:
            return
        instant = session.instant()
        frame = Frame(now, instant, len(instant.body))
        self._frames.append(frame)
        self._size += frame.size
        while len(self._frames) > 1 and (self._frames[0].time_s < now - KEPT_S or self._size > MOST_BYTES):
            self._size -= self._frames.popleft().size

    def _note(self, examples: Sequence[Example], now: float) -> None:
        for example in reversed(examples):
            if example.number in self._shown:
                return
            self._shown[example.number] = now

    def at(self, time_s: float) -> Frame:
        """The last moment kept before a time, or the first there is; SessionError where there is none."""
        if not self._frames:
            raise SessionError("nothing of this run is kept yet: let it go on for a moment")
        times = [frame.time_s for frame in self._frames]
        return self._frames[max(0, bisect_right(times, time_s + 1e-9) - 1)]

    def of(self, number: int) -> Frame:
        """The moment before an example was shown; SessionError where it is not kept any more."""
        if number not in self._shown:
            raise SessionError(f"example {number} was shown in another run: its moment is not kept")
        frame = self.at(self._shown[number] - EVERY_S)
        if frame.time_s > self._shown[number]:
            raise SessionError(f"the moment of example {number} is not kept any more")
        return frame

    def forget(self) -> None:
        """Another run begins."""
        self._frames.clear()
        self._size = 0
        self._shown = {}
