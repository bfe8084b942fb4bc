"""Leadership: which of the agents that can lead a squad does, in which term (docs/semantics.md).

A leader sends orders at every tick. Another candidate that hears none for a while leads in a higher term. Each
candidate has terms of its own, so that no term has two leaders. When the network splits, each part with two members has
a leader; when it heals, the higher term remains. No agreement is needed, because members obey the highest term they
have heard.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import inf

SILENT_S = 0.4
"""The time without a message after which a leader is replaced, s."""
GONE_S = 0.15
"""The time without a message after which a leader that has left the network is replaced, s."""
APART_S = 0.12
"""The time in s by which each further candidate waits longer, so that two seldom begin together."""
UNKNOWING_S = 0.24
"""The time in s by which a candidate waits longer that does not know what members execute: they report it meanwhile."""
COMPANY_S = 0.3
"""The time without a message of any other member after which a candidate is cut off: it does not begin to lead, s."""
FROZEN_S = 0.5
"""The time that a leader can be suspended, s; after a longer time it listens before it leads again."""


class Leadership:
    """One candidate's knowledge of the agent that leads a squad.

    Parameters
    ----------
    name
        The name of this candidate.
    candidates
        All agents that can lead the squad, the first choice first.
    now
        The present time by this agent's clock, s.
    leads
        Whether this candidate leads from the beginning, without listening first.
    """

    def __init__(self, name: str, candidates: Sequence[str], now: float, *, leads: bool = False) -> None:
        self.name, self.candidates = name, tuple(candidates)
        self.term = find_next_term(0, name, candidates) if leads else 0
        """The highest term that this candidate knows of."""
        self.leader: str | None = name if leads else None
        """The agent that leads in this term, as far as is known."""
        self._heard_s = self._ran_s = now
        self._company_s = -inf
        """When another member was heard last."""
        self._message = 0
        """The number of the leader's last message that is known of."""
        self._obeyed: tuple[int, float, int] | None = None
        """A higher term that members obey, when that was first heard, and the number of its message then."""

    @property
    def leads(self) -> bool:
        """Whether this candidate leads."""
        return self.leader == self.name

    def hear_orders(self, term: int, leader: str, now: float, message: int = 0) -> bool:
        """Take note of a leader's message, and of its number; return False if it is of a leader that was replaced."""
        if term < self.term or not is_term_of(term, leader, self.candidates):
            return False
        if term > self.term or self.leader is None:
            self._message = 0
        self._heard_s = max(self._heard_s, now)
        self._message = max(self._message, message)
        self.term, self.leader = term, leader
        return True

    def hear_report(self, member: str, term: int, message: int, now: float) -> None:
        """Take note of the term that a member obeys, and of the number of its leader's last message that it heard.

        A candidate that hears of a leader's newer message knows that it leads, even if the message itself was lost.
        """
        if member != self.name:
            self._company_s = max(self._company_s, now)
        if self.leader is None:
            self.term = max(self.term, term)
            leader = find_leader(term, self.candidates)
            if term == self.term and leader != self.name:
                self.leader = leader
        if term == self.term and not self.leads and message > self._message:
            self._message, self._heard_s = message, max(self._heard_s, now)
        elif term > self.term and (self._obeyed is None or term > self._obeyed[0]):
            self._obeyed = term, now, message
        elif self._obeyed is not None and term == self._obeyed[0] and message > self._obeyed[2]:
            self._follow(term, message, now)

    def _follow(self, term: int, message: int, now: float) -> None:
        """Follow the leader of a higher term, after members have received two of its messages."""
        leader = find_leader(term, self.candidates)
        if leader != self.name:
            self.term, self.leader, self._message, self._obeyed = term, leader, message, None
            self._heard_s = max(self._heard_s, now)

    def update(
        self, now: float, present: Collection[str], *, is_unknowing: Callable[[], bool] = lambda: False
    ) -> bool:
        """Decide whether this candidate leads now; call it at every tick, after the messages were heard.

        Parameters
        ----------
        now
            The present time, s.
        present
            The names of the agents that are there.
        is_unknowing
            A function that returns whether this candidate does not know the order that members execute.

        Returns
        -------
        bool
            Whether it leads.
        """
        slept, self._ran_s = now - self._ran_s > FROZEN_S, now
        if slept:
            self._heard_s = now
            self.leader = None if self.leads else self.leader
        if self._obeyed is not None and self._obeyed[0] <= self.term:
            self._obeyed = None
        if self.leads and self._obeyed is not None and now - self._obeyed[1] >= SILENT_S:
            # The leader of that term is silent, and members refuse the orders of a lower one.
            self.term = find_next_term(self._obeyed[0], self.name, self.candidates)
        if self.leads or slept or now - self._company_s > COMPANY_S:
            return self.leads
        gone = self.leader is not None and self.leader not in present
        waiting = [name for name in self.candidates if name in present and name != self.leader]
        before = waiting.index(self.name) if self.name in waiting else len(waiting)
        wait_s = (GONE_S if gone else SILENT_S) + APART_S * before - 1e-9
        silent_s = now - self._heard_s
        if silent_s >= wait_s + UNKNOWING_S or (silent_s >= wait_s and not is_unknowing()):
            self.term = find_next_term(self.term, self.name, self.candidates)
            self.leader, self._heard_s = self.name, now
        return self.leads


def find_next_term(after: int, name: str, candidates: Sequence[str]) -> int:
    """Return the first term after `after` that belongs to a candidate: terms belong to candidates in rotation."""
    first = candidates.index(name) + 1
    return first if after < first else after + len(candidates) - (after - first) % len(candidates)


def find_leader(term: int, candidates: Sequence[str]) -> str | None:
    """Return the candidate to whom a term belongs; None for 0, in which there is no leader."""
    return candidates[(term - 1) % len(candidates)] if term > 0 else None


def is_term_of(term: int, leader: str, candidates: Sequence[str]) -> bool:
    """Return whether a term belongs to a candidate."""
    return term > 0 and leader == find_leader(term, candidates)
