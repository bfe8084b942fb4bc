"""A body that records each tick of a demonstration: the sensor values and the behavior that the person wants.

A session drives it like any other body. With a policy aboard (DAgger, Ross et al. 2011) the robot does what the policy
decides, and presses are only labels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands, list_reading_keys
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.sim.walker import Walker
from understudy.sim.world import World

Robots: TypeAlias = World | Walker

Ints = NDArray[np.int64]
Raw = NDArray[np.float64]
"""Sensor values [N, K], NaN where absent."""

RESTING = -1
"""The index that stands for no behavior, with every channel at rest."""


class OnboardPolicy(Protocol):
    """A policy that drives the robot instead of the person."""

    def begin(self) -> None:
        """Clear the memory, because the robot was put into another world."""
        ...

    def decide(self, raw: Raw) -> Ints:
        """Return the index of the behavior to run, or RESTING, for each row of sensor values."""
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
        """Return the ticks recorded with at most `decisions` presses."""
        count = int(np.searchsorted(self.decisions, decisions, side="right"))
        return self[:count]

    def __getitem__(self, part: slice) -> Self:
        return type(self)(*(getattr(self, name)[part] for name in self.__dataclass_fields__))

    def advanced(self, ticks: int) -> Ints:
        """Return the behavior wanted `ticks` ticks later in the same world, because people press late."""
        later = np.minimum(np.arange(len(self)) + ticks, len(self) - 1)
        return np.where(self.episode[later] == self.episode, self.wanted[later], self.wanted)


class RecordingWorld(BodyWrapper[Robots]):
    """A world of one robot whose ticks are recorded from the first press on.

    `make` makes a world from a seed; `basics` are the commands of the basic behaviors; `count` returns the number of
    presses so far, `spent` the seconds they took.
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
        super().__init__(make(seeds))
        self._make, self._count, self._spent = make, count, spent
        self._basics = {_spelled(commands): index for index, commands in enumerate(basics)}
        self._commands = [dict(commands) for commands in basics]
        self._keys = list_reading_keys(self)
        self._rows: list[tuple[list[float], int, int, int, int, float]] = []
        self._episode = 0
        self.aboard: OnboardPolicy | None = None
        self.on = True
        self._begin()

    def reset(self, seeds: Sequence[int]) -> None:
        """Start another world and another episode."""
        self._stand_on(self._make(seeds))
        self._episode += 1
        self._begin()

    def _begin(self) -> None:
        self._pressed, self._did = self._count(), RESTING
        if self.aboard is not None:
            self.aboard.begin()

    def act(self, commands: Commands) -> None:
        """Record the tick, and execute the pressed command or that of the policy aboard."""
        percept = self.sense(self._keys)
        raw = [float(percept[key][0]) for key in self._keys]
        wanted = self._basics.get(
            _spelled({name: float(column[0]) for name, column in commands.items()}), RESTING
        )
        if self.on and self._count() > self._pressed:
            spent = self._spent()
            self._rows.append((raw, wanted, self._did, self._count(), self._episode, spent))
        if self.aboard is None:
            self._did = wanted
            super().act(commands)
            return
        self._did = int(self.aboard.decide(np.array([raw]))[0])
        doing = self._commands[self._did] if self._did != RESTING else {}
        super().act({name: np.array([value]) for name, value in doing.items()})

    def ticks(self) -> RecordedTicks:
        """Return the recorded ticks."""
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
