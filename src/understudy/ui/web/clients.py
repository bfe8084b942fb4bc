"""The pages connected to a server: their queues of messages, and which of them is in control."""

from __future__ import annotations

from asyncio import Event
from collections import deque
from collections.abc import Awaitable, Callable, Iterator
from secrets import token_urlsafe
from typing import TypeAlias

from understudy.errors import SessionError

Wait: TypeAlias = Callable[[float], Awaitable[None]]
"""A function that lets other tasks run for some seconds, such as `asyncio.sleep`."""

FRAME_S = 1 / 60
REST_S = 0.002
"""The least pause (s) between two steps, in which messages are received."""
SILENT_S = 30.0
"""Seconds without a message after which another page may take control."""
PER_SECOND = 200
"""Messages per second that a page may send."""
MOST_REFUSED = 2_000
"""Number of messages above the rate after which a page is disconnected."""
MOST_WAITING = 500
"""Number of unsent answers after which a page is disconnected."""
MOST_KEYS = 1_000


class Client:
    """A connected page with its queued messages: all answers, and the newest scene, news, frame and picture.

    A page that reads slowly skips frames; it does not delay other pages.
    """

    def __init__(self, key: str, wall: Callable[[], float]) -> None:
        self.key = key
        self.closing = False
        self.spoke_s = wall()
        self.waits = Event()
        self._wall = wall
        self._allowance, self._refused = float(PER_SECOND), 0
        self._texts: deque[bytes] = deque()
        self._newest: dict[str, bytes] = {}
        self._sent_frame = False  # last of frame and picture, which take turns

    def allow_message(self) -> bool:
        """Count a received message and return whether it is within the message rate.

        A page that exceeds the rate by far is closed.
        """
        now = self._wall()
        passed, self.spoke_s = now - self.spoke_s, now
        self._allowance = min(float(PER_SECOND), self._allowance + passed * PER_SECOND) - 1
        if self._allowance >= 0:
            return True
        self._allowance = 0.0
        self._refused += 1
        if self._refused > MOST_REFUSED:
            self.close()
        return False

    def send_reply(self, text: bytes) -> None:
        """Queue an answer, which is never skipped; close a page on which too many answers wait."""
        self._texts.append(text)
        if len(self._texts) > MOST_WAITING:
            self._texts.clear()
            self.close()
        self.waits.set()

    def show(self, **parts: bytes) -> None:
        """Queue a `scene`, `news`, a `team`, a `frame` or a `picture` in place of an unsent one of the same sort."""
        self._newest |= parts
        self.waits.set()

    def close(self) -> None:
        """Mark the connection for closing."""
        self.closing = True
        self.waits.set()

    def next(self) -> tuple[bytes, bool] | None:
        """Remove and return the next queued message and whether it is binary; None if nothing is queued."""
        if self._texts:
            return self._texts.popleft(), False
        first, second = ("picture", "frame") if self._sent_frame else ("frame", "picture")
        for sort in ("scene", "news", "team", first, second):
            if sort in self._newest:
                is_binary = sort in ("frame", "picture")
                if is_binary:
                    self._sent_frame = sort == "frame"
                return self._newest.pop(sort), is_binary
        return None


class Clients:
    """All connected pages; at most one of them (`director`) is in control, and none if `closed` says why."""

    def __init__(self, wall: Callable[[], float], closed: str = "") -> None:
        self._wall, self.closed = wall, closed
        self._here: dict[Client, None] = {}
        self._keys: dict[str, None] = {}
        self.director: Client | None = None

    def __len__(self) -> int:
        return len(self._here)

    def __iter__(self) -> Iterator[Client]:
        return iter(tuple(self._here))

    def connect(self, key: str | None) -> Client:
        """Register a new page and return its client.

        It gets control if no page has it, or if `key` is that of the page in control, which reconnects.
        """
        former = self.director
        returned = former is not None and key == former.key
        if returned or key not in self._keys or key is None:
            key = token_urlsafe(18)  # a new one, too, where two pages have the same: the former has lost it
        viewer = Client(key, self._wall)
        self._here[viewer] = self._keys[key] = None
        while len(self._keys) > MOST_KEYS:
            del self._keys[next(iter(self._keys))]
        if (former is None or returned) and not self.closed:
            self.director = viewer
        if former is not None and returned:
            former.close()
        return viewer

    def disconnect(self, viewer: Client) -> bool:
        """Remove a page and return whether it was in control."""
        self._here.pop(viewer, None)
        directed = viewer is self.director
        if directed:
            self.director = None
        return directed

    @property
    def can_be_taken(self) -> bool:
        """Whether a page that asks for control gets it now."""
        if self.closed:
            return False
        return self.director is None or self._wall() - self.director.spoke_s >= SILENT_S

    def take_control(self, viewer: Client) -> None:
        """Give a page control; SessionError if another page has it and was not silent for long enough."""
        if self.closed:
            raise SessionError(self.closed)
        if self.director is not None and self.director is not viewer and not self.can_be_taken:
            silent_s = self._wall() - self.director.spoke_s
            raise SessionError(
                f"another page is in control: it can hand over control, or be replaced after {SILENT_S:g} s "
                f"without a message ({silent_s:.0f} s so far)"
            )
        self.director = viewer

    def hand_over_control(self, viewer: Client) -> None:
        """Release the control of a page; SessionError if it is not in control."""
        self.refuse_others(viewer)
        self.director = None

    def refuse_others(self, viewer: Client) -> None:
        """Raise SessionError unless a page is in control."""
        if self.closed:
            raise SessionError(self.closed)
        if viewer is not self.director:
            raise SessionError(
                "this page is not in control: take over first"
                if self.director is None
                else "this page is not in control: another page is"
            )


async def repeat_each_frame(step: Callable[[], None], *, clock: Callable[[], float], wait: Wait) -> None:
    """Call a step at most once per frame, and let other tasks run in between."""
    while True:
        began_s = clock()
        step()
        await wait(max(REST_S, FRAME_S - (clock() - began_s)))
