"""Bands: the members that squads can have, by sort, with those who run them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.runtime.body import Body, Commands
from understudy.runtime.program import Program

Finds: TypeAlias = Callable[[str, Binding], Program]
"""A behavior that members can run, ready to run."""


class Runner(Protocol):
    """What runs the agents of a body: interpreters or an engine."""

    @property
    def keys(self) -> tuple[ReadingKey, ...]:
        """What they look at."""
        ...

    def begin(self, agents: NDArray[np.intp], program: Program) -> None:
        """Let these agents run a program from its start."""
        ...

    def raised(self, flag: str) -> NDArray[np.bool_]:
        """Which agents have raised a flag [N]."""
        ...

    def path(self, agent: int) -> tuple[str, ...]:
        """The current state of every level of an agent, from the root down."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """Pulse every agent on one snapshot; the commands of all."""
        ...


@dataclass
class Layer:
    """A body with those who run its agents, and what it has sensed in this tick."""

    body: Body
    runner: Runner
    percept: Percept = field(default_factory=dict)


@dataclass(frozen=True)
class Band:
    """Members of one sort: agents of a layer, who can be ordered to run what `finds` finds."""

    name: str
    layer: Layer
    finds: Finds
