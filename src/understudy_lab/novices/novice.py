"""The model of a novice, who presses late or wrongly, looks away, and may misunderstand the two forward states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import isnan
from types import MappingProxyType

import numpy as np

from understudy.model.library import Library, TrainedAutomaton
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.novices.traits import ALIKE, UNDERSTOOD, SharedTraits, Traits
from understudy_lab.tasks.servo_teacher import MIDDLE_PX, THERE_PX, blob_x, four_states
from understudy_lab.tasks.soccer import Soccer, StartPose, kit
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson
from understudy_lab.teachers.teacher import FIRST_SEED

BEARINGS_DEG: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"ball left": (8.0, 28.0), "ball right": (-28.0, -8.0), "ball lost": (50.0, 310.0)}
)
"""The range of the ball's bearing in degrees where the robot is put down, by situation."""
FIELD_M = 2.85
"""The distance in m from the ball at which a robot touches the nearest line of the field."""


class Novice(SimulatedPerson):
    """A simulated novice who teaches with the buttons."""

    def __init__(self, traits: Traits, seed: int, habits: SharedTraits = ALIKE) -> None:
        draws = np.random.default_rng([seed, 3])
        mean_s = traits.reaction_s
        super().__init__(draws, ReactionTime(mean_s, habits.spread * mean_s, habits.least_s))
        self.traits, self.habits = traits, habits
        self.slipped = 0
        self.shown: Counter[str] = Counter()
        """The number of times the robot was put into each situation."""
        self.switched: set[tuple[str, str]] = set()
        """The switches that this novice meant to show, from and to."""
        self._away_until = 0.0
        self._side: str | None = None  # where they last saw the ball
        self._unlike_since: float | None = None  # when the robot began not to do what they wish

    def teach(self) -> TrainedAutomaton:
        """Put the robot into one situation after another, drive it for five minutes, and return its automaton."""
        traits, draws, given_s = self.traits, self._draws, self.habits.given_s
        body = Soccer([FIRST_SEED + int(draws.integers(2**40))], self.choose_start(traits.situations[0]))
        session = Session(body, Library(kit), four_states(Library(kit)))
        turn = int(draws.integers(len(traits.situations)))
        while self.seconds < given_s:
            situation = traits.situations[turn % len(traits.situations)]
            body.starts = [self.choose_start(situation)]
            session.reset(FIRST_SEED + int(draws.integers(2**40)))
            self.seconds = min(given_s, self.seconds + traits.carry_s)
            self._side = None
            self.shown[situation] += 1
            left = given_s - self.seconds
            self.show(session, self.wish, until=self.there, limit_s=min(traits.patience_s, left))
            turn += 1
        return session.make_trained_automaton()

    @property
    def draws(self) -> np.random.Generator:
        """The random generator of this novice."""
        return self._draws

    def look_afresh(self) -> None:
        """Forget on which side the ball was, because the robot has been moved."""
        self._side = None

    def notice(self, session: Session, patience_s: float) -> bool:
        """Watch the robot for one tick, correct it if it has been wrong for `patience_s`, and return whether it did."""
        screen, before = session.view(), self.presses
        wished = self.wish(screen)
        if wished in (None, screen.state):
            self._unlike_since = None
        elif self._unlike_since is None:
            self._unlike_since = self.seconds
        since = self._unlike_since
        waits = since is None or self.seconds - since < patience_s
        self._consider(session, None if waits else wished, self.seconds)
        return self.presses > before

    def say(self, session: Session, wished: str | None) -> None:
        """Press a button now, possibly a wrong one, or confirm (None), and run one tick."""
        self.press(session, wished)
        session.tick()

    def press(self, session: Session, wished: str | None) -> None:
        """Press a button now, possibly a wrong one, or confirm (None)."""
        if wished is None:
            session.confirm()
            self.presses += 1
        else:
            self._press(session, wished)

    def consider(self, session: Session, wished: str | None) -> None:
        """Press a wished button once the reaction time has passed, if this novice is looking."""
        self._consider(session, wished, self.seconds)

    def cancel_press(self) -> None:
        """Give up a press that is wished but not made yet."""
        self._due = None

    def choose_start(self, situation: str) -> StartPose:
        """Return the range of places in which this novice puts the robot down, by situation."""
        farthest_m = self.habits.distance_m
        return StartPose((0.4 * farthest_m, min(farthest_m, FIELD_M)), BEARINGS_DEG[situation])

    def there(self, screen: SessionView) -> bool:
        """Return whether the robot is at the ball in this novice's judgment."""
        return screen.features["blob_size(ball)"] >= THERE_PX / (1.0 + self.traits.misjudged) ** 2

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where this novice accepts the current one."""
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
            return self._forward() if inside > self.traits.edge_px + self.habits.emerged_px else None
        if state == "start" or abs(off) > self.habits.other_px:
            return self._forward(now=state)
        return None

    def _forward(self, *, now: str = "") -> str:
        """Return the forward state that this novice believes to belong to the side of the ball."""
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
    buttons: tuple[str, ...] = ("left", "right", "forwardL", "forwardR")
    """The buttons that a slip may hit."""

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        tick_s = session.body.tick_s
        if self.seconds < self._away_until:
            return
        mean_s, share = self.habits.lapse_s, self.traits.lapses
        if self._draws.random() < tick_s * share / (1.0 - share) / mean_s:
            self._away_until = self.seconds + float(self._draws.uniform(0.5 * mean_s, 1.5 * mean_s))
            return
        due = self._due
        if due is not None and wished != due[0] and due[1] - now <= self.habits.stop_s:
            if now >= due[1] - 1e-9:
                self._press(session, due[0])  # too late to hold it back
            return
        super()._consider(session, wished, now)

    def _press(self, session: Session, wished: str) -> None:
        self.switched.add((session.view().state, wished))
        others = [state for state in self.buttons if state != wished]
        if self._draws.random() < self.traits.slips:
            wished = others[int(self._draws.integers(len(others)))]
            self.slipped += 1
        self._either = ("forwardL", "forwardR")[int(self._draws.integers(2))]
        super()._press(session, wished)
