"""A simulated person who presses late and sometimes hits another button than intended."""

from __future__ import annotations

import numpy as np

from understudy.learning.mislabels import SuspectExample
from understudy.model.automaton import Automaton
from understudy.model.lesson import Example
from understudy.training.session import Session
from understudy.training.trainee import Mode, SessionView
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson, Wish


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
