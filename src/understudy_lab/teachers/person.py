"""Simulated persons who watch the screen, decide, and press buttons a moment later; some press wrong buttons at times.

A person sees the robot through `session.view()` only, and acts only by directing and by switching to testing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from math import pi, tau
from typing import TypeAlias

import numpy as np

from understudy.learning.mislabels import SuspectExample
from understudy.model.automaton import Automaton
from understudy.model.lesson import Example
from understudy.training.session import Session
from understudy.training.trainee import Mode, SessionView

Wish: TypeAlias = Callable[[SessionView], str | None]
"""A function that returns the state that the robot should be in; None or the current one means no change."""

KEEP = "(keep)"
"""The wish to confirm the current state, which a person does once each time it occurs."""

Seen: TypeAlias = Callable[[SessionView], bool]


def has_raised_flag(screen: SessionView) -> bool:
    """Return whether the automaton has raised a flag."""
    return screen.flag is not None


def after(seconds: float) -> Seen:
    """Return a predicate: at least `seconds` have passed since the world began."""
    return lambda screen: screen.time_s >= seconds


def find_bearing(screen: SessionView, target: str = "A") -> float:
    """Return the bearing of a target in rad, positive to the left, between -pi and pi."""
    return (screen.features[f"angle_to({target})"] + pi) % tau - pi


def never_confirm(wish: Wish) -> Wish:
    """Return a function that asks for the same states as `wish`, but never confirms the current one."""

    def complain(screen: SessionView) -> str | None:
        wished = wish(screen)
        return None if wished == KEEP else wished

    return complain


class TryResult(Enum):
    """The outcome of watching a robot."""

    ENOUGH = auto()  # what they waited for, with nothing to complain of
    CORRECTED = auto()  # they had to press while testing
    LOST = auto()  # nothing changed any more, or it took too long


FIDGETS, FIDGETING = 30, 0.2
"""The number of switches within this share of a person's patience that look like fidgeting."""


@dataclass(frozen=True, slots=True)
class ReactionTime:
    """The delay in s between a decision and the press: normally distributed, at least `least_s`."""

    mean_s: float = 0.25
    spread_s: float = 0.1
    least_s: float = 0.1


class SimulatedPerson:
    """A person who watches one session at a time and presses buttons; seconds and presses are counted."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        self.reaction = reaction
        self.seconds = 0.0
        self.presses = 0
        self._draws = draws
        self._due: tuple[str, float] | None = None
        self._kept: tuple[str, ...] | None = None

    def show(self, session: Session, wish: Wish, *, until: Seen, limit_s: float) -> TryResult:
        """Direct the robot to each state that the person wishes, `until` they have shown enough."""
        return self.watch(session, wish, until=until, limit_s=limit_s, patience_s=limit_s)

    def drive(self, session: Session, behavior: str, seconds: float) -> None:
        """Drive the robot elsewhere for a time, s; the automaton stays in its state, and nothing is recorded."""
        session.drive(behavior)
        session.run_for(seconds)
        session.drive(None)
        self.seconds += seconds

    def test(
        self, session: Session, complaint: Wish, *, until: Seen, limit_s: float, patience_s: float
    ) -> TryResult:
        """Let the robot show what it learned, and correct the first thing that looks wrong.

        They lose patience when all levels stay in their states for `patience_s`, or when it only fidgets.
        """
        session.test()
        verdict = self.watch(
            session,
            complaint,
            until=lambda screen: screen.mode is Mode.TRAINING or until(screen),
            limit_s=limit_s,
            patience_s=patience_s,
        )
        return TryResult.CORRECTED if session.mode is Mode.TRAINING else verdict

    def watch(
        self, session: Session, wish: Wish, *, until: Seen, limit_s: float, patience_s: float
    ) -> TryResult:
        """Watch the robot, and direct it to each state that the person wishes, `until` they have seen enough."""
        self._due = self._kept = None
        tick_s = session.body.tick_s
        path: tuple[str, ...] = ()
        changes = deque([0.0], maxlen=FIDGETS)
        passed = 0.0
        while passed < limit_s - tick_s / 2:
            screen = session.view()
            wished = wish(screen)
            said = wished == KEEP and screen.path[:1] == self._kept
            content = wished is None or wished == screen.state or said
            if content and screen.waiting is None and until(screen):
                return TryResult.ENOUGH
            if screen.path != path:
                self._kept = self._kept if screen.path[:1] == path[:1] else None
                path = screen.path
                changes.append(passed)
            if passed - changes[-1] > patience_s or (
                len(changes) == FIDGETS and passed - changes[0] < patience_s * FIDGETING
            ):
                return TryResult.LOST
            passed += self._go_on(session, None if content else wished, passed)
        return TryResult.LOST

    def _go_on(self, session: Session, wished: str | None, now: float) -> float:
        """Consider a wish, and let some of the robot's time pass; return how much, s."""
        self._consider(session, wished, now)
        session.tick()
        self.seconds += session.body.tick_s
        return session.body.tick_s

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        if wished is None:
            self._due = None  # no longer wanted: the hand is drawn back
            return
        if self._due is None or self._due[0] != wished:
            delay = self._draws.normal(self.reaction.mean_s, self.reaction.spread_s)
            self._due = (wished, now + max(self.reaction.least_s, delay))
        if now >= self._due[1] - 1e-9:
            self._press(session, wished)

    def _press(self, session: Session, wished: str) -> None:
        if wished == KEEP:
            session.confirm()
            self._kept = session.view().path[:1]
        else:
            session.direct(wished)
        self.presses += 1
        self._due = None


class SlippingPerson(SimulatedPerson):
    """A person who hits a wrong button with probability `chance`, and answers a question wrongly with `hasty`."""

    def __init__(
        self, draws: np.random.Generator, reaction: ReactionTime, chance: float, hasty: float
    ) -> None:
        super().__init__(draws, reaction)
        self._chance, self._hasty = chance, hasty
        self.slipped = 0
        self.asked = 0
        self.meant: dict[int, float] = {}
        """The doubt about each example in question, by example number."""

    def answer(self, suspect: SuspectExample, automaton: Automaton, wish: Wish) -> str:
        """Answer which state was meant by a suspect example: the recorded one or another.

        The example counts as right if the person would wish the same state in its situation, seen either from the state
        that the robot was in or from the start state.
        """
        example = suspect.example
        self.asked += 1
        self.meant[example.number] = suspect.doubt
        screen = rebuild_screen(example, automaton)
        wished = wish(screen) or example.state
        if wished != example.next:
            afresh = wish(rebuild_screen(example, automaton, automaton.states[0].name))
            wished = example.next if afresh == example.next else wished
        return self._hit(automaton, wished, self._hasty)

    def _press(self, session: Session, wished: str) -> None:
        super()._press(session, self._hit(session.automaton, wished, self._chance))

    def _hit(self, automaton: Automaton, wished: str, chance: float) -> str:
        others = [name for name in automaton.state_names[1:] if name != wished]
        if self._draws.random() >= chance:
            return wished
        self.slipped += 1
        return others[int(self._draws.integers(len(others)))]


def rebuild_screen(example: Example, automaton: Automaton, state: str = "") -> SessionView:
    """Return the view of the session at an example's moment, or as it would have been in another state."""
    return SessionView(
        time_s=0.0,
        mode=Mode.TRAINING,
        state=state or example.state,
        path=(state or example.state,),
        flag=None,
        features={str(bound): value for bound, value in zip(automaton.features, example.values, strict=True)},
        states=automaton.state_names,
        targets={},
        waiting=None,
        examples=0,
        undoable=None,
        redoable=None,
    )
