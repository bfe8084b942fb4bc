"""A novice: presses late, slips, does not always look, and may have misunderstood what forwardL is for."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from types import MappingProxyType

import numpy as np

from understudy.experiments.novices.traits import LAPSE_S, MINUTES_S, STOP_S, UNDERSTOOD, Traits
from understudy.model.library import Library, Taught
from understudy.training.demonstrators.person import Person, Reaction
from understudy.training.demonstrators.servo import (
    EMERGED_PX,
    MIDDLE_PX,
    OTHER_PX,
    THERE_PX,
    blob_x,
    four_states,
)
from understudy.training.demonstrators.teacher import FIRST_SEED
from understudy.training.screen import Screen
from understudy.training.session import Session
from understudy.worlds.soccer import Soccer, Start, kit

STARTS: Mapping[str, Start] = MappingProxyType(
    {
        "ball left": Start((1.0, 2.5), (8.0, 28.0)),
        "ball right": Start((1.0, 2.5), (-28.0, -8.0)),
        "ball lost": Start((1.0, 2.5), (50.0, 310.0)),
    }
)
"""Where they put the robot, by situation."""
RADIUS_M = 0.4
"""From the middle of the robot to that of the ball where it is there."""


class Novice(Person):
    """One novice at the buttons."""

    def __init__(self, traits: Traits, seed: int) -> None:
        draws = np.random.default_rng([seed, 3])
        super().__init__(draws, Reaction(traits.reaction_s, 0.3 * traits.reaction_s, 0.15))
        self.traits = traits
        self.slipped = 0
        self._away_until = 0.0
        self._side: str | None = None  # where they last saw the ball

    def teach(self) -> Taught:
        """Put the robot into one situation after the other and drive it, for five minutes; what it learned then."""
        traits, draws = self.traits, self._draws
        body = Soccer([FIRST_SEED + int(draws.integers(2**40))], STARTS[traits.situations[0]])
        session = Session(body, Library(kit), four_states(Library(kit)))
        turn = int(draws.integers(len(traits.situations)))
        while self.seconds < MINUTES_S:
            body.starts = [STARTS[traits.situations[turn % len(traits.situations)]]]
            session.reset(FIRST_SEED + int(draws.integers(2**40)))
            self.seconds = min(MINUTES_S, self.seconds + traits.carry_s)
            self._side = None
            left = MINUTES_S - self.seconds
            self.show(session, self.wish, until=self.there, limit_s=min(traits.patience_s, left))
            turn += 1
        return session.taught()

    def there(self, screen: Screen) -> bool:
        """The robot is there, as they judge it."""
        return screen.features["blob_size(ball)"] >= THERE_PX / (1.0 + self.traits.misjudged) ** 2

    def wish(self, screen: Screen) -> str | None:
        """The state they would rather have the robot in."""
        x, state = blob_x(screen), screen.state
        if isnan(x):
            if self._side is not None:
                return self._side
            return None if state in ("left", "right") else self.traits.search
        off = x - MIDDLE_PX - self.traits.off_middle_px
        self._side = "left" if off < 0 else "right"
        inside = min(x, 2 * MIDDLE_PX - x)
        if inside < self.traits.edge_px:
            return self._side
        if state in ("left", "right"):
            return self._forward() if inside > self.traits.edge_px + EMERGED_PX else None
        if state == "start" or abs(off) > OTHER_PX:
            return self._forward(now=state)
        return None

    def _forward(self, *, now: str = "") -> str:
        """The forward that they think belongs to the side of the ball."""
        right = self._side == "right"
        if self.traits.mistake == UNDERSTOOD:
            return "forwardR" if right else "forwardL"
        if self.traits.mistake == "other side":
            return "forwardL" if right else "forwardR"
        if self.traits.mistake == "one only" or now == "forwardL":
            return "forwardL"
        if now == "forwardR":
            return now
        return self._either

    _either = "forwardL"

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        tick_s = session.body.tick_s
        if self.seconds < self._away_until:
            return
        mean_s, share = sum(LAPSE_S) / 2, self.traits.lapses
        if self._draws.random() < tick_s * share / (1.0 - share) / mean_s:
            self._away_until = self.seconds + float(self._draws.uniform(*LAPSE_S))
            return
        due = self._due
        if due is not None and wished != due[0] and due[1] - now <= STOP_S:
            if now >= due[1] - 1e-9:
                self._press(session, due[0])  # too late to hold it back
            return
        super()._consider(session, wished, now)

    def _press(self, session: Session, wished: str) -> None:
        others = [state for state in ("left", "right", "forwardL", "forwardR") if state != wished]
        if self._draws.random() < self.traits.slips:
            wished = others[int(self._draws.integers(len(others)))]
            self.slipped += 1
        self._either = ("forwardL", "forwardR")[int(self._draws.integers(2))]
        super()._press(session, wished)
