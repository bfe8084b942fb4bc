"""Traces: what a run did, level by level, with why each switch was made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from understudy.model.tree import Step
from understudy.runtime.interpreter import Interpreter, Machine


@dataclass(frozen=True, slots=True)
class Switch:
    """One switch of one automaton, with the feature vector and the tests it passed on the way to the decision."""

    time_s: float
    automaton: str
    before: str
    after: str
    values: tuple[float, ...]
    steps: tuple[Step, ...]


class Trace:
    """Records every switch of an interpreter's automata while attached."""

    def __init__(self, interpreter: Interpreter) -> None:
        self.switches: list[Switch] = []
        self.interpreter = interpreter
        interpreter.watch(self._switched)

    def close(self) -> None:
        """Stop recording."""
        self.interpreter.watch(None)

    def _switched(
        self, machine: Machine, before: int, after: int, values: Sequence[float], now: float
    ) -> None:
        automaton = machine.automaton
        states = automaton.state_names
        steps, _ = automaton.transitions[states[before]].path(values)
        self.switches.append(Switch(now, automaton.name, states[before], states[after], tuple(values), steps))
