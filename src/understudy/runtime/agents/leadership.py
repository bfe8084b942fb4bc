"""Leadership: which of the agents that can lead a squad does, in which term (docs/semantics.md).

A leader sends orders at every tick. Another candidate that hears none for a while leads in the next term; of two that
do at the same time, the one listed first does. When the network splits, each part has a leader; when it heals, the
higher term remains. No agreement is needed, because members obey the highest term they have heard.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

SILENT_S = 0.4
"""A leader that was not heard for so long is replaced, s."""
GONE_S = 0.15
"""A leader that has left the network is replaced after so long without a message, s."""
APART_S = 0.12
"""The time in s by which each further candidate waits longer, so that two seldom begin at once."""
FROZEN_S = 0.5
"""A leader that did not run for so long listens before it leads again, s."""


class Leadership:
    """One candidate's knowledge of who leads a squad.

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
        self.term = int(leads)
        """The highest term that this candidate knows of."""
        self.leader: str | None = name if leads else None
        """The agent that leads in this term, as far as is known."""
        self._heard_s = self._ran_s = now

    @property
    def leads(self) -> bool:
        """Whether this candidate leads."""
        return self.leader == self.name

    def hear_orders(self, term: int, leader: str, now: float) -> bool:
        """Take note of a leader's message; return False if it is of a leader that was replaced."""
        if leader not in self.candidates:
            return False
        if self.leader is not None and rank(term, leader, self.candidates) < rank(
            self.term, self.leader, self.candidates
        ):
            return False
        self.term, self.leader, self._heard_s = term, leader, now
        return True

    def hear_report(self, term: int) -> None:
        """Take note of the term that a member obeys: a leader goes beyond it, to be obeyed, too."""
        if self.leads and term > self.term:
            self.term = term + 1
        elif self.leader is None:
            self.term = max(self.term, term)

    def update(self, now: float, present: Collection[str]) -> bool:
        """Decide whether this candidate leads now; call it at every tick, after the messages were heard.

        Parameters
        ----------
        now
            The present time, s.
        present
            The names of the agents that are there.

        Returns
        -------
        bool
            Whether it leads.
        """
        slept, self._ran_s = now - self._ran_s > FROZEN_S, now
        if slept:
            self._heard_s = now
            self.leader = None if self.leads else self.leader
        if self.leads or slept:
            return self.leads
        gone = self.leader is not None and self.leader not in present
        waiting = [name for name in self.candidates if name in present and name != self.leader]
        before = waiting.index(self.name) if self.name in waiting else len(waiting)
        if now - self._heard_s >= (GONE_S if gone else SILENT_S) + APART_S * before - 1e-9:
            self.term, self.leader, self._heard_s = self.term + 1, self.name, now
        return self.leads


def rank(term: int, leader: str, candidates: Sequence[str]) -> tuple[int, int]:
    """Return what decides between two leaders: the higher term, then the candidate listed first."""
    return term, -candidates.index(leader) if leader in candidates else -len(candidates)
