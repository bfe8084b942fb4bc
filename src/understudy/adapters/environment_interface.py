"""Readings, channels and basic behaviors of environments, which their observation and action spaces define."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space
from numpy.typing import NDArray

from understudy.adapters.space_numbers import SpaceNumber, SpaceNumbers, rename_numbers
from understudy.errors import DefinitionError, SettingError, UnknownName, join_names
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import Feature, FlagFeature, Percept, ReadingKey, TimeInState
from understudy.model.kinds import BOOLEAN, Categorical, Column, Continuous, Kind
from understudy.model.library import Kit
from understudy.runtime.body import Channel, Commands, Reading, check_reading_keys

Names: TypeAlias = Sequence[str] | Mapping[str, str]
BehaviorNames: TypeAlias = Sequence[str] | Mapping[str, Mapping[str, float]]
OUTCOMES = (
    Reading("reward", Continuous(), doc="The reward of the last step."),
    Reading("return", Continuous(), doc="The sum of all rewards since the reset."),
    Reading("terminated", BOOLEAN, doc="Whether the episode has ended in the environment's own sense."),
    Reading("truncated", BOOLEAN, doc="Whether the episode was cut off, by a time limit, say."),
)
"""The readings that every environment has besides its observation."""
TICK_S = 0.1
"""The length of a tick of an environment that does not say how many frames a second it renders, s."""
MOST_NAMED = 64
"""The most values of a whole number that each get a basic behavior; of more, only the least and the greatest do."""


class EnvironmentInterface:
    """The common parts of bodies of environments: readings, channels and basic behaviors, and a table of readings.

    The rows of a table of readings [R, N] are the numbers of the observation and, last, those of `OUTCOMES`.

    Parameters
    ----------
    observation_space
        The space of the observations of each agent.
    action_space
        The space of the actions of each agent.
    where
        The environment, for error messages.
    names
        Names of the observed numbers, in order, or by the name that they would have.
    units
        Unit of a reading, by name.
    kinds
        Kind of a reading, by name.
    behaviors
        Names for the values of the only action, in order; or a command by name.
    rest
        Value of channels while idling, by channel.

    Raises
    ------
    SettingError
        If a space cannot be mapped, or a setting does not fit it.
    """

    def __init__(
        self,
        observation_space: Space[Any],
        action_space: Space[Any],
        *,
        where: str,
        names: Names | None = None,
        units: Mapping[str, str] | None = None,
        kinds: Mapping[str, Kind] | None = None,
        behaviors: BehaviorNames | None = None,
        rest: Mapping[str, float] | None = None,
    ) -> None:
        self.where = where
        self.observed = SpaceNumbers(observation_space, prefix="obs", where=where)
        self.acted = SpaceNumbers(action_space, prefix="action", where=where)
        named = rename_numbers(self.observed.numbers, names, where=where)
        self.readings: tuple[Reading, ...] = (
            *_make_readings(self.observed.numbers, named, units or {}, kinds or {}, where=where),
            *OUTCOMES,
        )
        self.channels = _make_channels(self.acted.numbers, rest or {}, where=where)
        self.behaviors = _make_behaviors(self.channels, behaviors, where=where)
        self._rest = np.array([channel.rest for channel in self.channels])
        self._rows = {reading.name: row for row, reading in enumerate(self.readings)}

    @property
    def kit(self) -> Kit:
        """A feature for each reading, those of the automaton itself, and the basic behaviors."""
        features = (
            Feature(each.name, each.kind, each.name, unit=each.unit, doc=each.doc) for each in self.readings
        )
        own = (FlagFeature("done"), FlagFeature("failed"), TimeInState())
        return Kit.from_parts(*features, *own, *self.behaviors)

    def select_readings(self, table: NDArray[np.float64], keys: Sequence[ReadingKey]) -> Percept:
        """Return a copy of the rows [N] of a table of readings; UnknownName or SettingError for other keys."""
        check_reading_keys(keys, readings=self.readings, targets=(), where=self.where)
        return {key: table[self._rows[key[0]]].copy() for key in keys}

    def make_command_table(self, commands: Commands, agents: int) -> NDArray[np.float64]:
        """Return commands as a table [N, C], at rest where they are left out; refuse what the action space lacks."""
        known = {channel.name: column for column, channel in enumerate(self.channels)}
        table = np.tile(self._rest, (agents, 1))
        for name, values in commands.items():
            if name not in known:
                raise UnknownName(what="channel", name=name, where=self.where, known=list(known))
            column = np.asarray(values, np.float64)
            if column.shape != (agents,):
                problem = f"it has shape {column.shape}"
                remedy = f"give one number per agent: shape ({agents},)"
                raise DefinitionError(what=f"command {name!r}", problem=problem, remedy=remedy)
            channel = self.channels[known[name]]
            wrong = np.flatnonzero(~_find_valid(channel, column))
            if len(wrong):
                problem = f"it is {column[wrong[0]]:g} for agent {wrong[0]} of {self.where}"
                raise DefinitionError(
                    what=f"command {name!r}", problem=problem, remedy=f"give {_format_range(channel)}"
                )
            table[:, known[name]] = column
        return table

    def check_seeds(self, seeds: Sequence[int], count: int) -> tuple[int, ...]:
        """Return seeds as whole numbers; SettingError if they are not `count` whole numbers from 0 up."""
        given: list[Any] = list(seeds)
        whole = all(isinstance(seed, int | np.integer) and seed >= 0 for seed in given)
        if len(given) != count or not whole:
            raise SettingError(
                where=self.where,
                setting="seeds",
                problem=f"are {given!r:.60}",
                remedy=f"give {count} whole numbers from 0 up",
            )
        return tuple(int(seed) for seed in given)

    def call(self, name: str, function: Callable[..., Any], *args: Any, checker: str, **named: Any) -> Any:
        """Call a method of an environment; whatever it raises becomes a DefinitionError, which names the `checker`."""
        try:
            return function(*args, **named)
        except Exception as error:  # whatever code of the environment does
            raise DefinitionError(
                what=self.where,
                problem=f"its {name} failed: {type(error).__name__}: {error}",
                remedy=f"correct the environment; {checker} may say more",
            ) from error


def choose_tick_s(tick_s: float | None, metadata: Mapping[str, Any]) -> float:
    """Return the length of a tick, s: as given, or else as an environment's metadata say."""
    fps = metadata.get("render_fps")
    return float(tick_s if tick_s is not None else 1.0 / fps if fps else TICK_S)


def _find_valid(channel: Channel, column: Column) -> NDArray[np.bool_]:
    """Find the values that a channel takes: within its limits as single-precision numbers, which spaces are."""
    single = column.astype(np.float32)
    valid: NDArray[np.bool_] = (
        np.isfinite(column) & (single >= np.float32(channel.least)) & (single <= np.float32(channel.most))
    )
    return valid & (np.rint(column) == column) if channel.whole else valid


def _format_range(channel: Channel) -> str:
    sort = "a whole number" if channel.whole else "a finite number"
    return f"{sort} from {channel.least:g} to {channel.most:g}"


def _make_readings(
    numbers: Sequence[SpaceNumber],
    names: Sequence[str],
    units: Mapping[str, str],
    kinds: Mapping[str, Kind],
    *,
    where: str,
) -> list[Reading]:
    own = {reading.name for reading in OUTCOMES}
    taken = [name for name in names if name in own]
    if taken:
        remedy = f"give it another with names={{{taken[0]!r}: ...}}; each environment has {join_names(own)}"
        raise SettingError(
            where=where, setting="observation", problem=f"has the name {taken[0]!r}", remedy=remedy
        )
    for setting, given in (("units", units), ("kinds", kinds)):
        for name in given:
            if name not in names:
                raise UnknownName(what=f"reading for {setting}", name=name, where=where, known=names)
    return [
        Reading(name, kinds.get(name, number.kind), units.get(name, ""), doc=_describe_observed(number))
        for number, name in zip(numbers, names, strict=True)
    ]


def _describe_observed(number: SpaceNumber) -> str:
    return (
        ""
        if abs(number.least) == inf or abs(number.most) == inf
        else f"From {number.least:g} to {number.most:g}."
    )


def _make_channels(
    numbers: Sequence[SpaceNumber], rest: Mapping[str, float], *, where: str
) -> tuple[Channel, ...]:
    names = [number.name for number in numbers]
    for name in rest:
        if name not in names:
            raise UnknownName(what="channel", name=name, where=where, known=names)
    channels = []
    for number in numbers:
        usual = (
            number.least if isinstance(number.kind, Categorical) else min(max(0.0, number.least), number.most)
        )
        value = float(rest.get(number.name, usual))
        channel = Channel(
            number.name, value, least=number.least, most=number.most, whole=number.whole,
            doc=_describe_observed(number),
        )  # fmt: skip
        if not _find_valid(channel, np.array([value])).all():
            remedy = f"give {_format_range(channel)}"
            raise SettingError(
                where=where, setting=f"rest of {number.name!r}", problem=f"is {value:g}", remedy=remedy
            )
        channels.append(channel)
    return tuple(channels)


def _make_behaviors(
    channels: Sequence[Channel],
    given: Sequence[str] | Mapping[str, Mapping[str, float]] | None,
    *,
    where: str,
) -> tuple[Behavior, ...]:
    """Make the basic behaviors: those given, or one for each value or limit of each channel."""
    if isinstance(given, Mapping):
        return tuple(_check_behavior(name, command, channels, where) for name, command in given.items())
    if given is None:
        found = []
        for channel in channels:
            for ending, value in _list_values(channel):
                doc = f"Set {channel.name} to {value:g}."
                found.append(Behavior(f"{channel.name}_{ending}", Command(**{channel.name: value}), doc=doc))
        return tuple(found)
    only, *others = channels
    values = [value for _, value in _list_values(only)]
    if others or not only.whole or len(given) != len(values):
        counted = f"the {len(values)} values" if only.whole and not others else "no single whole number"
        problem, remedy = f"are {len(given)} names, for {counted}", "give {name: {channel: value}} instead"
        if only.whole and not others:
            remedy = f"give {len(values)} names, or {{name: {{{only.name!r}: value}}}}"
        raise SettingError(where=where, setting="behaviors", problem=problem, remedy=remedy)
    return tuple(
        Behavior(name, Command(**{only.name: value}), doc=f"Take action {value:g}.")
        for name, value in zip(given, values, strict=True)
    )


def _list_values(channel: Channel) -> list[tuple[str, float]]:
    """Return the values of a channel that get a basic behavior each, with what their names end in."""
    if channel.whole and channel.most - channel.least < MOST_NAMED:
        values = np.arange(channel.least, channel.most + 1.0).tolist()
        return [(f"{value:g}", value) for value in values]
    limits = {"low": channel.least, "high": channel.most}
    return [(ending, limit) for ending, limit in limits.items() if abs(limit) < inf]


def _check_behavior(
    name: str, command: Mapping[str, float], channels: Sequence[Channel], where: str
) -> Behavior:
    known = {channel.name: channel for channel in channels}
    for channel, value in command.items():
        if channel not in known:
            raise UnknownName(
                what=f"channel for behavior {name!r}", name=channel, where=where, known=list(known)
            )
        if not _find_valid(known[channel], np.array([value], np.float64)).all():
            raise SettingError(
                where=where,
                setting=f"behavior {name!r}",
                problem=f"sets {channel!r} to {value:g}",
                remedy=f"give {_format_range(known[channel])}",
            )
    return Behavior(name, Command(**command))
