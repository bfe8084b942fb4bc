"""A body whose ticks are written down while somebody presses: what was sensed, what the demonstrator wanted done.

The session drives it like any other body, so that whoever presses does so through the session alone. With a policy
aboard (DAgger, Ross et al. 2011) the robot does what the policy says, and what is pressed is only a label.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.runtime.body import Channel, Commands, Reading, list_reading_keys
from understudy.sim.walker import Walker
from understudy.sim.world import World

Robots: TypeAlias = World | Walker

Ints = NDArray[np.int64]
Raw = NDArray[np.float64]
"""Readings [N, K], absent is NaN."""

RESTING = -1
"""No basic behavior: every channel at rest."""


class OnboardPolicy(Protocol):
    """A policy that decides instead of whoever presses."""

    def begin(self) -> None:
        """Forget: the robot was put into another world."""
        ...

    def decide(self, raw: Raw) -> Ints:
        """Which behavior to run, by its index, or RESTING, for each row of readings."""
        ...


@dataclass(frozen=True)
class RecordedTicks:
    """T recorded ticks, in order."""

    raw: Raw  # [T, K]
    wanted: Ints  # [T] the behavior the demonstrator wanted, by its index, or RESTING
    before: Ints  # [T] what the robot did at the tick before
    decisions: Ints  # [T] how many presses had been made
    episode: Ints  # [T] in which world, counted
    seconds: Column  # [T] what had been spent of the demonstrator's time, s

    def __len__(self) -> int:
        return len(self.wanted)

    def upto(self, decisions: int) -> Self:
        """The ticks until the press after so many."""
        kept = int(np.searchsorted(self.decisions, decisions, side="right"))
        return self[:kept]

    def __getitem__(self, part: slice) -> Self:
        return type(self)(*(getattr(self, name)[part] for name in self.__dataclass_fields__))

    def advanced(self, ticks: int) -> Ints:
        """What was wanted so many ticks later in the same world: people press late."""
        later = np.minimum(np.arange(len(self)) + ticks, len(self) - 1)
        return np.where(self.episode[later] == self.episode, self.wanted[later], self.wanted)


class RecordingWorld:
    """A world of one robot whose ticks are written down, once somebody has pressed.

    `make` makes a world from a seed; `basics` are the commands of the basic behaviors; `count` says how many presses
    were made so far, `spent` how many seconds they took.
    """

    def __init__(
        self,
        make: Callable[[Sequence[int]], Robots],
        seeds: Sequence[int],
        basics: Sequence[Mapping[str, float]],
        *,
        count: Callable[[], int],
        spent: Callable[[], float],
    ) -> None:
        self._make, self._count, self._spent = make, count, spent
        self._world = make(seeds)
        self._basics = {_spelled(commands): index for index, commands in enumerate(basics)}
        self._commands = [dict(commands) for commands in basics]
        self._keys = list_reading_keys(self._world)
        self._rows: list[tuple[list[float], int, int, int, int, float]] = []
        self._episode = 0
        self.aboard: OnboardPolicy | None = None
        self.on = True
        self._begin()

    @property
    def agents(self) -> int:
        """One."""
        return self._world.agents

    @property
    def readings(self) -> Sequence[Reading]:
        """What it can sense."""
        return self._world.readings

    @property
    def targets(self) -> Sequence[str]:
        """What readings can be of."""
        return self._world.targets

    @property
    def channels(self) -> Sequence[Channel]:
        """What it obeys."""
        return self._world.channels

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self._world.tick_s

    @property
    def time_s(self) -> float:
        """The world's clock, s."""
        return self._world.time_s

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """As the world."""
        return self._world.sense(keys)

    def reset(self, seeds: Sequence[int]) -> None:
        """Another world; another episode begins."""
        self._world = self._make(seeds)
        self._episode += 1
        self._begin()

    def _begin(self) -> None:
        self._pressed, self._did = self._count(), RESTING
        if self.aboard is not None:
            self.aboard.begin()

    def act(self, commands: Commands) -> None:
        """Write the tick down, and obey: what is pressed, or the policy aboard."""
        percept = self._world.sense(self._keys)
        raw = [float(percept[key][0]) for key in self._keys]
        wanted = self._basics.get(
            _spelled({name: float(column[0]) for name, column in commands.items()}), RESTING
        )
        if self.on and self._count() > self._pressed:
            spent = self._spent()
            self._rows.append((raw, wanted, self._did, self._count(), self._episode, spent))
        if self.aboard is None:
            self._did = wanted
            self._world.act(commands)
            return
        self._did = int(self.aboard.decide(np.array([raw]))[0])
        doing = self._commands[self._did] if self._did != RESTING else {}
        self._world.act({name: np.array([value]) for name, value in doing.items()})

    def ticks(self) -> RecordedTicks:
        """What was written down."""
        raw, wanted, before, decisions, episode, seconds = zip(*self._rows, strict=True)
        return RecordedTicks(
            np.array(raw),
            np.array(wanted, np.int64),
            np.array(before, np.int64),
            np.array(decisions, np.int64),
            np.array(episode, np.int64),
            np.array(seconds, np.float64),
        )


def _spelled(commands: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    return tuple(sorted((name, value) for name, value in commands.items() if value))
