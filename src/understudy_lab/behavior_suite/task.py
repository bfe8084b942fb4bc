"""A feat: one behavior of the repertoire, with how it is taught, who does it by hand, and how it is judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol, TypeAlias

from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.kit import Kit
from understudy.model.lesson import Options
from understudy.runtime.body import Commands
from understudy.sim.world import World
from understudy_lab.behavior_suite.tracks import Tracks
from understudy_lab.teachers.teacher import MakesBody, Topic


class Hand(Protocol):
    """A controller written by hand, for N robots at once, that does one basic behavior at a time."""

    @property
    def keys(self) -> Sequence[ReadingKey]:
        """What it reads."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        ...


@dataclass(frozen=True)
class Judged:
    """How W worlds went: columns [W]. A world is a success where it was done in time."""

    seconds: Column
    """How long it took; absent where it was not done."""
    measures: Mapping[str, Column] = field(default_factory=lambda: MappingProxyType({}))
    """What else was measured, by name."""


@dataclass(frozen=True)
class Trial:
    """Unseen worlds for one teaching: what they are, how to judge what was done in them, and what none can beat."""

    world: World
    seconds: float
    judge: Callable[[Tracks], Judged]
    bound: Callable[[Tracks], Column]
    """Seconds [W] that no robot can beat."""
    bindings: Sequence[Mapping[str, str]] = ({},)
    """What the parameters stand for, for each robot of a world in turn."""


MakesTrial: TypeAlias = Callable[[Sequence[int]], Trial]


@dataclass(frozen=True)
class Feat:
    """One behavior of the repertoire; `behavior` is the last of its topics."""

    name: str
    does: str
    measured: str
    bounded: str
    kit: Kit
    topics: Sequence[Topic]
    options: Mapping[str, Options]
    practice: MakesBody
    trial: MakesTrial
    hand: Callable[[World], Hand]

    @property
    def behavior(self) -> str:
        """The automaton that is judged."""
        return self.topics[-1].name
