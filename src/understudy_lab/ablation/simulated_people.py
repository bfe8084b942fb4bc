"""Other people at the buttons: some look away, some say so when they do, some confirm what goes well."""

from __future__ import annotations

import numpy as np

from understudy.training.session import Session
from understudy_lab.teachers.person import ReactionTime, Seen, SimulatedPerson, TryResult, Wish

ATTENTIVE_S, AWAY_S = 8.0, 4.0
"""How long a person looks, and looks away, on average, s."""
CONTENT_S = 0.6
"""How long a person sees a robot do right before they say so, s."""


class Inattentive(SimulatedPerson):
    """Looks away a third of the time, for spans that are drawn exponentially, and presses only while looking."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._spans = np.random.default_rng(int(draws.integers(2**63)))
        self._looking = True
        self._left_s = self._spans.exponential(ATTENTIVE_S)

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        self._left_s -= session.body.tick_s
        if self._left_s <= 0:
            self._looking = not self._looking
            self._left_s = self._spans.exponential(ATTENTIVE_S if self._looking else AWAY_S)
            self._turned(session)
        super()._consider(session, wished if self._looking else None, now)

    def _turned(self, session: Session) -> None:
        """They look away, or back."""


class Candid(Inattentive):
    """Looks away as often, but says so: "I am not watching"."""

    def _turned(self, session: Session) -> None:
        session.watching = self._looking


class Confirming(SimulatedPerson):
    """Says of every state they directed the robot to that it should go on so, a moment later.

    So a person would have to teach if staying were not recorded automatically.
    """

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._confirm_at: float | None = None

    def show(self, session: Session, wish: Wish, *, until: Seen, limit_s: float) -> TryResult:
        """Direct the robot, and confirm where it stays."""
        self._confirm_at = None
        return super().show(session, wish, until=until, limit_s=limit_s)

    def test(
        self, session: Session, complaint: Wish, *, until: Seen, limit_s: float, patience_s: float
    ) -> TryResult:
        """Let the robot try; after a correction see whether it goes well, and confirm that."""
        self._confirm_at = None
        verdict = super().test(session, complaint, until=until, limit_s=limit_s, patience_s=patience_s)
        if verdict is TryResult.CORRECTED:
            session.run_for(CONTENT_S)
            self.seconds += CONTENT_S
            screen = session.screen()
            if screen.flag is None and complaint(screen) in (None, screen.state):
                self._confirm(session)
                session.tick()
                self.seconds += session.body.tick_s
        return verdict

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        before = self.presses
        super()._consider(session, wished, now)
        if self.presses > before:
            self._confirm_at = now + CONTENT_S
        elif wished is None and self._confirm_at is not None and now >= self._confirm_at - 1e-9:
            self._confirm_at = None
            if session.screen().flag is None:
                self._confirm(session)

    def _confirm(self, session: Session) -> None:
        session.confirm()
        self.presses += 1
