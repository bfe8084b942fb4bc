"""A person at the buttons: sees the screen, makes up their mind, and presses a moment later.

What they know of the robot is `session.screen()`; what they can do is direct, switch modes, restart and reset.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from understudy.training.screen import Screen
from understudy.training.session import Session
from understudy.training.trainee import Mode

Wish: TypeAlias = Callable[[Screen], str | None]
"""The state a person would rather have the robot in; None, or the current one, where they are content."""

Seen: TypeAlias = Callable[[Screen], bool]


@dataclass(frozen=True, slots=True)
class Reaction:
    """How long a person takes from making up their mind to the press, s: normal, but never under `least_s`."""

    mean_s: float = 0.25
    spread_s: float = 0.1
    least_s: float = 0.1


class Person:
    """Someone who watches one session and presses now and then."""

    def __init__(self, session: Session, draws: np.random.Generator, reaction: Reaction = Reaction()) -> None:
        self.session = session
        self.reaction = reaction
        self.seconds = 0.0
        self.presses = 0
        self._draws = draws
        self._due: tuple[str, float] | None = None

    def watch(self, wish: Wish, *, until: Seen, limit_s: float) -> bool:
        """Watch, and direct where the robot is not doing what they wish, `until` they see enough.

        False where that took longer than `limit_s`.
        """
        session, tick_s = self.session, self.session.body.tick_s
        self._due = None
        passed = 0.0
        while passed < limit_s - tick_s / 2:
            screen = session.screen()
            wished = wish(screen)
            if wished == screen.state:
                wished = None
            if wished is None and screen.waiting is None and until(screen):
                return True
            self._consider(wished, passed)
            session.tick()
            passed += tick_s
            self.seconds += tick_s
        return False

    def _consider(self, wished: str | None, now: float) -> None:
        if wished is None:
            self._due = None  # no longer wanted: the hand is drawn back
            return
        if self._due is None or self._due[0] != wished:
            delay = max(self.reaction.least_s, self._draws.normal(self.reaction.mean_s, self.reaction.spread_s))
            self._due = (wished, now + delay)
        if now >= self._due[1] - 1e-9:
            self.session.direct(wished)
            self.presses += 1
            self._due = None

    def test(self, complaint: Wish, *, until: Seen, limit_s: float) -> bool:
        """Let the robot show what it learned; True if nothing had to be corrected and they saw enough in time.

        Stops at the first correction, once it has acted.
        """
        self.session.test()
        finished = self.watch(
            complaint, until=lambda screen: screen.mode is Mode.TRAINING or until(screen), limit_s=limit_s
        )
        return finished and self.session.mode is Mode.TESTING
