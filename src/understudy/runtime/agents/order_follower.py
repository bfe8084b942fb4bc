"""A member's side of orders: which coordinator it obeys, and how long an order holds (docs/semantics.md)."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import inf

from understudy.runtime.agents.lateness import LatenessMeter
from understudy.runtime.agents.leadership import is_term_of
from understudy.runtime.agents.messages import Duty, OrderId, Orders

KEPT_S = 0.15
"""A leader that was not heard for longer may be replaced soon, s: members then report its last message."""


class Refusal(StrEnum):
    """Why a coordinator's message is not obeyed."""

    UNNAMED = "its sender is not named in the team file"
    OLDER = "its term is over"
    LATE = "a later one of the same leader came before"
    STALE = "it was held up for longer than it holds"
    LIBRARY = "its coordinator has another library"


class OrderFollower:
    """The order that one member executes.

    Parameters
    ----------
    member
        The name of the member.
    candidates
        The agents that may lead its squad.
    library
        The fingerprint that a coordinator's library must have; None: any.
    """

    def __init__(self, member: str, candidates: Sequence[str], *, library: str | None = None) -> None:
        self.member, self.candidates, self._library = member, tuple(candidates), library
        self.term = 0
        """The term of the coordinator that it obeys."""
        self.leader: str | None = None
        """The coordinator that it obeys."""
        self.order: OrderId | None = None
        """The order that it executes; None: none."""
        self.duty: Duty | None = None
        """What the order tells it to do."""
        self.heard = 0
        """The number of the last message of this coordinator that was obeyed."""
        self._start = -1
        self._lateness = LatenessMeter()
        self._ended: set[int] = set()
        """Former starts of the leader's program in this term."""
        self._until_s = -inf
        self._given: tuple[OrderId | None, Duty | None] = (None, None)
        self._last: tuple[Orders, float] | None = None
        """The last message that was obeyed, and when it would have come if nothing had held it up."""

    def receive(self, message: Orders, now: float) -> Refusal | None:
        """Take a coordinator's message.

        Parameters
        ----------
        message
            The message.
        now
            The time by the member's clock, s.

        Returns
        -------
        Refusal or None
            Why the message is not obeyed; None if it is.
        """
        if not is_term_of(message.term, message.leader, self.candidates):
            return Refusal.UNNAMED
        if self._library is not None and message.library != self._library:
            return Refusal.LIBRARY
        if message.term < self.term:
            return Refusal.OLDER
        late_s = self._lateness.measure(message.start, message.sent_s, now)
        if late_s >= message.lease_s:
            return Refusal.STALE
        if message.term > self.term:
            self._ended.clear()
        elif message.start in self._ended:
            return Refusal.LATE
        elif (
            message.start != self._start
        ):  # its numbers of orders and messages begin again: an equal one is new
            self._ended.add(self._start)
            self.order = None
        elif message.sequence <= self.heard:
            return Refusal.LATE
        self.term, self.leader = message.term, message.leader
        self._start, self.heard = message.start, message.sequence
        self._until_s = now - late_s + message.lease_s
        self._given = message.order, message.duties.get(self.member)
        self._last = message, now - late_s
        return None

    def update(self, now: float) -> bool:
        """Take up the order that holds now; return whether it is a new one, or none any more.

        Parameters
        ----------
        now
            The time by the member's clock until which the order has to hold, s.

        Returns
        -------
        bool
            Whether the member has to begin again: its duty, or the behavior that it runs when it is alone.
        """
        order, duty = self._given if self.holds(now) else (None, None)
        duty = None if order is None else duty
        if (order, duty) == (self.order, self.duty):
            return False
        self.order, self.duty = order, duty
        return True

    def find_kept_message(self, now: float) -> tuple[Orders, float] | None:
        """Return the last message of a leader that is silent, and its age.

        Parameters
        ----------
        now
            The time by the member's clock, s.

        Returns
        -------
        tuple or None
            The message and its age, s; None if the leader was just heard, or its order holds no longer.
        """
        if self.order is None or self._last is None or now - self._last[1] <= KEPT_S:
            return None
        return self._last[0], now - self._last[1]

    def holds(self, now: float) -> bool:
        """Return whether the lease of the last message lasts at a time (s) of the member's clock."""
        return now < self._until_s
