"""Basic behaviors: what a robot can do without being taught (paper section 3).

Most are data: a constant command, in the body's own speeds. `@behavior` makes one from a function of readings.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Literal

from understudy.errors import DefinitionError
from understudy.model.features import PartWithFunction
from understudy.model.kinds import Column
from understudy.model.squad import Order


class Command(Mapping[str, float]):
    """Channel -> value, frozen. A channel left out is at the rest value that the body declares for it."""

    __slots__ = ("_channels",)

    def __init__(self, **channels: float) -> None:
        for channel, value in channels.items():
            if not isfinite(value):
                raise DefinitionError(
                    what="command",
                    problem=f"channel {channel!r} is {value}",
                    remedy="give a finite number, or leave the channel out to rest",
                )
        self._channels = dict(sorted(channels.items()))

    def __getitem__(self, channel: str) -> float:
        return self._channels[channel]

    def __iter__(self) -> Iterator[str]:
        return iter(self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def __hash__(self) -> int:
        return hash(tuple(self._channels.items()))

    def __repr__(self) -> str:
        return f"Command({', '.join(f'{key}={value!r}' for key, value in self._channels.items())})"


IDLE = Command()


@dataclass(frozen=True, slots=True)
class StateEffect:
    """What a basic behavior does, once, when started, to a counter or timer of the automaton that holds the state.

    A counter is set to `value`, incremented by it, or reset to 0; a timer is set (it reads the seconds since) or
    reset (it is absent).
    """

    action: Literal["set", "increment", "reset"]
    of: Literal["counter", "timer"]
    name: str
    value: float = 0.0

    def __post_init__(self) -> None:
        if self.of == "timer" and self.action == "increment":
            raise DefinitionError(
                what=f"timer {self.name!r}",
                problem="a timer cannot be incremented",
                remedy="set it or reset it",
            )
        if not isfinite(self.value):
            raise DefinitionError(
                what=f"{self.of} {self.name!r}",
                problem=f"a behavior changes it by or to {self.value}",
                remedy="give a finite number, or reset it",
            )


def set_counter(name: str, value: float) -> StateEffect:
    """Set a counter of the automaton to `value`."""
    return StateEffect("set", "counter", name, value)


def increment(name: str, by: float = 1.0) -> StateEffect:
    """Add `by` to a counter of the automaton."""
    return StateEffect("increment", "counter", name, by)


def reset_counter(name: str) -> StateEffect:
    """Set a counter of the automaton to 0."""
    return StateEffect("reset", "counter", name)


def set_timer(name: str) -> StateEffect:
    """Start a timer of the automaton: from now on it reads the seconds since."""
    return StateEffect("set", "timer", name)


def reset_timer(name: str) -> StateEffect:
    """Make a timer of the automaton absent again."""
    return StateEffect("reset", "timer", name)


@dataclass(frozen=True, slots=True)
class Behavior(PartWithFunction):
    """A basic behavior: a constant command, a function of readings, or an order; and changes made once as it starts.

    A function takes the robot's Readings and one Readings per parameter, and returns channel -> column [N].
    """

    name: str
    command: Command = IDLE
    changes: tuple[StateEffect, ...] = ()
    doc: str = ""
    function: Callable[..., Mapping[str, Column]] | None = field(default=None, compare=False)
    parameters: tuple[str, ...] = ()
    order: Order | None = None


def behavior(function: Callable[..., Mapping[str, Column]]) -> Behavior:
    """Make a basic behavior of a function: its name, its docstring, a parameter for each argument after the first."""
    _, *parameters = inspect.signature(function).parameters
    return Behavior(
        function.__name__,
        doc=inspect.cleandoc(function.__doc__ or ""),
        function=function,
        parameters=tuple(parameters),
    )
