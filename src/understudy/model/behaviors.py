"""Basic behaviors: the actions of a robot that need no teaching (paper section 3).

Most are a constant command in the robot's own speeds. `@behavior` makes one from a function of readings.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Literal

from understudy.errors import DefinitionError
from understudy.model.features import PartWithFunction
from understudy.model.squad import Order
from understudy.model.value_kinds import Column


class Command(Mapping[str, float]):
    """A frozen mapping from channels of a body to numbers, such as speeds.

    Parameters
    ----------
    **channels
        Finite value of each channel, in the unit that the body declares. A channel left out takes the rest value that
        the body declares for it.

    Raises
    ------
    DefinitionError
        If a value is infinite or NaN.

    Examples
    --------
    >>> Command(turn=0.5, forward=1.0)
    Command(forward=1.0, turn=0.5)
    """

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


MOST_COUNTED = 2.0**53
"""The largest number by or to which a behavior changes a counter: no run makes the counter infinite."""

IDLE = Command()
"""The command that leaves all channels at rest."""


@dataclass(frozen=True, slots=True)
class StateEffect:
    """A change to a counter or timer that a basic behavior makes once, when it starts.

    It changes the automaton whose state runs the behavior. `value` is the number that a counter is set to or
    incremented by. A reset counter is 0. A set timer counts seconds from 0; a reset timer is absent (NaN).
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
        if not abs(self.value) <= MOST_COUNTED:
            raise DefinitionError(
                what=f"{self.of} {self.name!r}",
                problem=f"a behavior changes it by or to {self.value}",
                remedy=f"give a number from -{MOST_COUNTED:.0f} to {MOST_COUNTED:.0f}, or reset it",
            )


def set_counter(name: str, value: float) -> StateEffect:
    """Make an effect that sets a counter of the automaton, for the `changes` of a `Behavior`.

    Parameters
    ----------
    name
        Name of the counter.
    value
        Number that the counter is set to, at most 2**53 in size.

    Returns
    -------
    StateEffect
        The effect. It happens once, each time the behavior starts.

    Raises
    ------
    DefinitionError
        If `value` is larger, infinite or NaN.
    """
    return StateEffect("set", "counter", name, value)


def increment(name: str, by: float = 1.0) -> StateEffect:
    """Make an effect that adds a number to a counter of the automaton, for the `changes` of a `Behavior`.

    Parameters
    ----------
    name
        Name of the counter.
    by
        Number that is added, at most 2**53 in size; it may be negative.

    Returns
    -------
    StateEffect
        The effect. It happens once, each time the behavior starts.

    Raises
    ------
    DefinitionError
        If `by` is larger, infinite or NaN.
    """
    return StateEffect("increment", "counter", name, by)


def reset_counter(name: str) -> StateEffect:
    """Make an effect that sets a counter of the automaton to 0, for the `changes` of a `Behavior`.

    Parameters
    ----------
    name
        Name of the counter.

    Returns
    -------
    StateEffect
        The effect. It happens once, each time the behavior starts.
    """
    return StateEffect("reset", "counter", name)


def set_timer(name: str) -> StateEffect:
    """Make an effect that starts a timer of the automaton at 0 s, for the `changes` of a `Behavior`.

    Parameters
    ----------
    name
        Name of the timer.

    Returns
    -------
    StateEffect
        The effect. It happens once, each time the behavior starts; the timer then counts the seconds since.
    """
    return StateEffect("set", "timer", name)


def reset_timer(name: str) -> StateEffect:
    """Make an effect that stops a timer of the automaton and makes it absent, for the `changes` of a `Behavior`.

    Parameters
    ----------
    name
        Name of the timer.

    Returns
    -------
    StateEffect
        The effect. It happens once, each time the behavior starts; the timer reads NaN until it is set again.
    """
    return StateEffect("reset", "timer", name)


@dataclass(frozen=True, slots=True)
class Behavior(PartWithFunction):
    """A basic behavior: a constant command, a function of readings, or an order to the members of a squad.

    Parameters
    ----------
    name
        Name of the behavior.
    command
        Values of the body's channels while the behavior runs. The default leaves all channels at rest.
    changes
        Changes to counters and timers of the automaton, made once when the behavior starts.
    doc
        A sentence for people about what the behavior does.
    function
        Function that computes the command in each tick instead of `command`. It takes a `ReadingsView` of the robot
        and one of each parameter's target, and returns a column of N values by channel, one value per robot.
    parameters
        Names of the parameters, which a state binds to targets.
    order
        Order that a coordinator gives to its squad while the behavior runs. None for a robot's behavior.
    """

    name: str
    command: Command = IDLE
    changes: tuple[StateEffect, ...] = ()
    doc: str = ""
    function: Callable[..., Mapping[str, Column]] | None = field(default=None, compare=False)
    parameters: tuple[str, ...] = ()
    order: Order | None = None


def behavior(function: Callable[..., Mapping[str, Column]]) -> Behavior:
    """Make a basic behavior from a function; use it as a decorator.

    The function's name and docstring become those of the behavior.

    Parameters
    ----------
    function
        Function that takes a `ReadingsView` of the robot and one more for each parameter, and returns a column of N
        values by channel, one value per robot. The names of its arguments after the first are the parameters.

    Returns
    -------
    Behavior
        The behavior, which calls the function in each tick in which it runs.

    Examples
    --------
    >>> @behavior
    ... def approach(robot, target):
    ...     "Drive toward the target, slower when near."
    ...     return {"forward": 0.5 * target.distance}
    >>> approach.parameters
    ('target',)
    """
    _, *parameters = inspect.signature(function).parameters
    return Behavior(
        function.__name__,
        doc=inspect.cleandoc(function.__doc__ or ""),
        function=function,
        parameters=tuple(parameters),
    )
