"""Someone who knows what they want, presses late, and now and then hits another button than they meant."""

from __future__ import annotations

import numpy as np

from understudy.learning.mislabels import SuspectExample
from understudy.model.automaton import Automaton
from understudy.model.lesson import Example
from understudy.training.session import Session
from understudy.training.trainee import Mode, SessionView
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson, Wish


class SlippingPerson(SimulatedPerson):
    """A person who slips: each press hits another button by `chance`, each answer to a question by `hasty`."""

    def __init__(
        self, draws: np.random.Generator, reaction: ReactionTime, chance: float, hasty: float
    ) -> None:
        super().__init__(draws, reaction)
        self._chance, self._hasty = chance, hasty
        self.slipped = 0
        self.asked = 0
        self.meant: dict[int, float] = {}
        """The examples that they were asked about, with the doubt about each then."""

    def answer(self, suspect: SuspectExample, automaton: Automaton, wish: Wish) -> str:
        """What they meant there, asked about an example: the state that it says, or another.

        It is right to them if they wish the same in its situation, as the robot was or at the start.
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
    """What the screen showed at an example's moment, or would have shown in another state."""
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
