"""The time by which messages are late, found out without a common clock (docs/semantics.md).

Every message says when it was sent, by the sender's own clock. The difference to the receiver's clock at its arrival is
the offset of both clocks plus the time under way. The smallest difference of late is that of a message which nothing
held up; a message with a larger one is late by the difference.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from math import inf

WINDOW_S = 15.0
"""Differences are forgotten after one to two of these times, because clocks drift and computers are suspended, s."""
FORMER = 64
"""The number of programs that are remembered besides one for each sender: those that have ended."""


@dataclass(slots=True)
class SmallestDifference:
    """The smallest difference since the window began, and in the window before."""

    began_s: float
    present: float = inf
    former: float = inf


class LatenessMeter:
    """Measure how late the messages of other programs are.

    Parameters
    ----------
    senders
        The number of programs that may send at the same time.
    """

    def __init__(self, senders: int = 1) -> None:
        self._most = senders + FORMER
        self._smallest: OrderedDict[int, SmallestDifference] = OrderedDict()

    def measure(self, start: int, sent_s: float, now: float) -> float:
        """Return by how much a message is late.

        Parameters
        ----------
        start
            The random number of the sender's program.
        sent_s
            The time by the sender's clock when it was sent, s.
        now
            The time by the receiver's clock after the message was taken, s. A time before it, such as that of the
            tick's beginning, would make all later messages seem late if the program stood still in between.

        Returns
        -------
        float
            The time in s by which it was longer under way than the fastest of late; 0 for the first one.
        """
        smallest = self._smallest.pop(start, None) or SmallestDifference(now)
        self._smallest[start] = smallest
        if len(self._smallest) > self._most:
            self._smallest.popitem(last=False)
        if now - smallest.began_s >= WINDOW_S:
            smallest.former = smallest.present if now - smallest.began_s < 2 * WINDOW_S else inf
            smallest.began_s, smallest.present = now, inf
        smallest.present = min(smallest.present, now - sent_s)
        return now - sent_s - min(smallest.present, smallest.former)
