"""Asking: transition functions that are no trees, such as classifiers. Agents that wait for one are asked together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.runtime.engine.compiler import PythonTransition, StateSlot

Ints = NDArray[np.int32]


@runtime_checkable
class BatchTransition(Protocol):
    """A transition function that decides for many agents at once, for each as it would alone."""

    def decide_all(self, values: NDArray[np.float64], /) -> Sequence[int] | NDArray[Any]:
        """The next state's index, or STAY, for each of n feature vectors [n, F]."""
        ...


def query_python_transition(
    asked: PythonTransition, values: NDArray[np.float64], *, place: StateSlot, agents: Ints
) -> Ints:
    """The state's index (or STAY) that a transition function answers for each agent's feature vector [n, F]."""
    transition = asked.transition
    if isinstance(transition, BatchTransition):
        answered = np.asarray(transition.decide_all(values))
    else:
        answered = np.array([transition.decide(row) for row in values.tolist()])
    known = np.arange(-1, asked.states)
    wrong = np.flatnonzero(~np.isin(answered, known))
    if answered.shape != agents.shape or len(wrong):
        found = (
            f"{answered[wrong[0]]} for agent {agents[wrong[0]]}"
            if len(wrong)
            else f"{answered.shape} answers"
        )
        raise DefinitionError(
            what=f"automaton {place.automaton!r}, state {place.state!r}",
            problem=f"its transition function answered {found}",
            remedy=f"it has to answer a state, from 0 to {asked.states - 1}, or -1 to stay",
        )
    return np.where(answered < 0, -1, answered + asked.first).astype(np.int32)
