"""Traces: the decisions of a run, level by level, with the reason of each switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from understudy.model.tree import STAY, PathStep
from understudy.runtime.interpreter import Interpreter, RunningAutomaton


@dataclass(frozen=True, slots=True)
class Decision:
    """A decision of one automaton, with the feature vector and the tests it passed on the way.

    `after` is `before` where it stays because there are no examples there.
    """

    time_s: float
    automaton: str
    before: str
    after: str
    values: tuple[float, ...]
    steps: tuple[PathStep, ...]


class DecisionTrace:
    """A recorder of the decisions of an interpreter's automata.

    `switches` are the decisions that left a state. `unshown` are those that kept one only because there are no examples
    there, once for each place in the tree until the automaton switches.

    Parameters
    ----------
    interpreter
        The interpreter, which is observed until `close`.
    """

    def __init__(self, interpreter: Interpreter) -> None:
        self.switches: list[Decision] = []
        self.unshown: list[Decision] = []
        self.interpreter = interpreter
        self._noted: set[tuple[RunningAutomaton, tuple[PathStep, ...]]] = set()
        interpreter.observe_switches(self._decided)

    def close(self) -> None:
        """Stop recording."""
        self.interpreter.observe_switches(None)

    def _decided(
        self, machine: RunningAutomaton, before: int, after: int, values: Sequence[float], now: float
    ) -> None:
        automaton = machine.automaton
        state = automaton.states[before].name
        steps, leaf = automaton.transitions[state].path(values)
        if after != STAY:
            following = automaton.states[after].name
            self.switches.append(Decision(now, automaton.name, state, following, tuple(values), steps))
            self._noted = {(other, place) for other, place in self._noted if other is not machine}
        elif leaf == STAY and (machine, steps) not in self._noted:
            self._noted.add((machine, steps))
            self.unshown.append(Decision(now, automaton.name, state, state, tuple(values), steps))
