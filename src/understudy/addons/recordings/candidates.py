"""Candidates: behaviors that may explain the commands of a tick, and the command that each would give there.

A basic behavior states what the driver aims at; commands follow late and inexactly. A `CommandModel`
whose function takes the command before states the command itself.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from types import MappingProxyType
from typing import Protocol, TypeAlias

import numpy as np

from understudy.errors import DefinitionError, UnknownName
from understudy.model.features import ReadingKey, ReadingsView, call_user_function
from understudy.model.value_kinds import Column
from understudy.records.record import Floats, Ints, Record
from understudy.runtime.link import GroundBehavior

Constants: TypeAlias = Mapping[str, float]
"""The numbers of a command model by name."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """The commands that a candidate with X states would give at each tick.

    Parameters
    ----------
    commands
        Command in each state, shape [X, T, C]; NaN where the candidate cannot say.
    entry
        State at a tick if the candidate begins there, shape [T]. None: there is one state only.
    following
        State at each tick after each state at the tick before, shape [T, X]. None: there is one state only.
    """

    commands: Floats
    entry: Ints | None = None
    following: Ints | None = None


class Candidate(Protocol):
    """A behavior that may explain commands."""

    @property
    def name(self) -> str:
        """The name by which labels refer to it."""
        ...

    @property
    def follows_last(self) -> bool:
        """Whether it states the command itself, not only what the driver aims at."""
        return False

    def predict(self, drive: Record) -> Prediction:
        """Return the commands that it would give at each tick of a drive."""
        ...


@dataclass(frozen=True, slots=True)
class CommandModel:
    """A candidate that is a function of readings and of the command before, with constants.

    Parameters
    ----------
    name
        Name of the behavior.
    function
        Function that takes a `ReadingsView` of the robot, and one of the commands of the tick before if its second
        argument is called `last`. Its keyword-only arguments are the constants, with their values as defaults. It
        returns a column of T values by channel, one per tick. A channel that it leaves out rests.
    unknown
        Range (lowest, highest) of each constant that is to be found from the recording. Constants of one name have
        one value in all models that are segmented together.
    values
        Values of constants that differ from the defaults.

    Raises
    ------
    DefinitionError
        If the function has no such constant, or a range is empty or not finite.
    """

    name: str
    function: Callable[..., Mapping[str, Column]] = field(compare=False)
    unknown: Mapping[str, tuple[float, float]] = field(default_factory=lambda: MappingProxyType({}))
    values: Constants = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        constants = self.constants
        for constant in (*self.unknown, *self.values):
            if constant not in constants:
                raise DefinitionError(
                    what=f"command model {self.name!r}",
                    problem=f"its function has no constant {constant!r}",
                    remedy="make it a keyword-only argument with a default",
                )
        for constant, (low, high) in self.unknown.items():
            if not (isfinite(low) and isfinite(high) and low < high):
                raise DefinitionError(
                    what=f"command model {self.name!r}",
                    problem=f"its constant {constant!r} is sought from {low} to {high}",
                    remedy="give two finite numbers, the lower one first",
                )

    @property
    def constants(self) -> Constants:
        """The values of all constants."""
        parameters = inspect.signature(self.function).parameters.values()
        defaults = {each.name: each.default for each in parameters if each.kind is each.KEYWORD_ONLY}
        return {**defaults, **self.values}

    @property
    def follows_last(self) -> bool:
        """Whether its function takes the command before."""
        return "last" in inspect.signature(self.function).parameters

    def with_constants(self, values: Constants) -> CommandModel:
        """Return the model with other values of those constants that it has.

        Parameters
        ----------
        values
            Value of each constant by name; names that it does not have are ignored.

        Returns
        -------
        CommandModel
            The model.
        """
        own = {name: value for name, value in values.items() if name in self.constants}
        return replace(self, values={**self.values, **own})

    def predict(self, drive: Record) -> Prediction:
        """Return the commands of the function at each tick; DefinitionError if it fails.

        Parameters
        ----------
        drive
            The drive.

        Returns
        -------
        Prediction
            Its commands, in one state.
        """
        arguments = [ReadingsView(drive.percept)]
        if self.follows_last:
            last = drive.list_last_commands()
            columns: dict[ReadingKey, Column] = {
                (each.name, None): last[:, index] for index, each in enumerate(drive.channels)
            }
            arguments.append(ReadingsView(columns))
        constants = self.constants

        def compute(*readings: ReadingsView) -> Mapping[str, Column]:
            return self.function(*readings, **constants)

        commands = call_user_function(f"command model {self.name!r}", compute, arguments)
        return Prediction(arrange_commands(commands, drive, of=f"command model {self.name!r}")[None])


@dataclass(frozen=True, slots=True)
class BehaviorCandidate(Candidate):
    """A candidate that is a basic behavior with the targets of its parameters."""

    ground: GroundBehavior

    @property
    def name(self) -> str:
        """The behavior with its targets, such as "goto(ball)"."""
        return str(self.ground)

    def predict(self, drive: Record) -> Prediction:
        """Return the command of the behavior at each tick."""
        return Prediction(compute_behavior_commands(self.ground, drive)[None])


@dataclass(frozen=True, slots=True)
class SplitState:
    """A candidate under a second label, for a state of its own that does the same.

    Parameters
    ----------
    name
        The second label.
    original
        The candidate.
    """

    name: str
    original: Candidate

    @property
    def follows_last(self) -> bool:
        """As the candidate says."""
        return self.original.follows_last

    def predict(self, drive: Record) -> Prediction:
        """Return the commands of the candidate."""
        return self.original.predict(drive)


def find_original(candidate: Candidate) -> Candidate:
    """Return the candidate that a label of a split state stands for, or the candidate itself.

    Parameters
    ----------
    candidate
        The candidate.

    Returns
    -------
    Candidate
        The one that is no `SplitState`.
    """
    return candidate.original if isinstance(candidate, SplitState) else candidate


def compute_behavior_commands(ground: GroundBehavior, drive: Record) -> Floats:
    """Compute the commands [T, C] of a basic behavior at each tick of a drive.

    Parameters
    ----------
    ground
        The behavior, with a target for each parameter.
    drive
        The drive, whose readings a function of the behavior gets as columns over ticks.

    Returns
    -------
    array, shape [T, C]
        Commands; NaN where its function returns NaN, such as for a target that is not seen.

    Raises
    ------
    DefinitionError
        If its function fails, or returns something else than numbers by channel.
    UnknownName
        If it commands a channel that the drive does not have.
    """
    behavior = ground.behavior
    if behavior.function is None:
        return arrange_commands(behavior.command, drive, of=f"behavior {ground}")
    targets = [ReadingsView(drive.percept, ground.binding[name]) for name in behavior.parameters]
    arguments = [ReadingsView(drive.percept), *targets]
    commands = call_user_function(f"behavior {ground}", behavior.function, arguments)
    return arrange_commands(commands, drive, of=f"behavior {ground}")


def arrange_commands(result: object, drive: Record, *, of: str) -> Floats:
    """Arrange values by channel as an array [T, C]; channels that are left out rest."""
    if not isinstance(result, Mapping):
        raise DefinitionError(
            what=of,
            problem=f"it returned {result!r:.60}",
            remedy="return a number for every tick, by channel",
        )
    channels = [each.name for each in drive.channels]
    commands = np.tile([each.rest for each in drive.channels], (drive.ticks, 1)).astype(np.float64)
    for channel, values in result.items():
        if channel not in channels:
            where = f"the recording, for {of},"
            raise UnknownName(what="command channel", name=str(channel), where=where, known=channels)
        try:
            commands[:, channels.index(channel)] = np.asarray(values, np.float64)
        except (TypeError, ValueError):
            raise DefinitionError(
                what=of,
                problem=f"it returned {values!r:.60} for channel {channel!r}",
                remedy=f"return one number, or one for each of the {drive.ticks} ticks",
            ) from None
    commands[~np.isfinite(commands)] = np.nan
    return commands
