"""Readings, channels and basic behaviors of environments, which their observation and action spaces define."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.environments.space_numbers import SpaceNumber
from understudy.errors import SettingError, UnknownName, join_names
from understudy.model.behaviors import Behavior, Command
from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Continuous, Kind
from understudy.runtime.body import Channel, Reading

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
"""The largest number of values of a whole-number channel that each get a basic behavior; of more, only the least and
the greatest value do."""


def choose_tick_s(tick_s: float | None, metadata: Mapping[str, Any]) -> float:
    """Return the length of a tick, s: as given, or else as an environment's metadata say."""
    fps = metadata.get("render_fps")
    return float(tick_s if tick_s is not None else 1.0 / fps if fps else TICK_S)


def find_valid(channel: Channel, column: Column) -> NDArray[np.bool_]:
    """Find the values that a channel takes: within its limits as single-precision numbers, which spaces are."""
    single = column.astype(np.float32)
    valid: NDArray[np.bool_] = (
        np.isfinite(column) & (single >= np.float32(channel.least)) & (single <= np.float32(channel.most))
    )
    return valid & (np.rint(column) == column) if channel.whole else valid


def format_range(channel: Channel) -> str:
    """Describe the numbers that a channel takes."""
    number = "a whole number" if channel.whole else "a finite number"
    return f"{number} from {channel.least:g} to {channel.most:g}"


def map_readings(
    numbers: Sequence[SpaceNumber],
    names: Sequence[str],
    units: Mapping[str, str],
    kinds: Mapping[str, Kind],
    *,
    where: str,
) -> list[Reading]:
    """Make the readings of observed numbers; refuse names that have another meaning, and settings of other names."""
    own = {reading.name for reading in OUTCOMES}
    taken = [name for name in names if name in own]
    if taken:
        remedy = f"give it another with names={{{taken[0]!r}: ...}}; each environment has {join_names(own)}"
        raise SettingError(
            where=where, setting="observation", problem=f"has the name {taken[0]!r}", remedy=remedy
        )
    for setting, settings in (("units", units), ("kinds", kinds)):
        for name in settings:
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


def map_channels(
    numbers: Sequence[SpaceNumber], rest: Mapping[str, float], *, where: str
) -> tuple[Channel, ...]:
    """Make the channels of the numbers of an action, with their values at rest; refuse what is out of range."""
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
        if not find_valid(channel, np.array([value])).all():
            remedy = f"give {format_range(channel)}"
            raise SettingError(
                where=where, setting=f"rest of {number.name!r}", problem=f"is {value:g}", remedy=remedy
            )
        channels.append(channel)
    return tuple(channels)


def map_behaviors(
    channels: Sequence[Channel],
    definitions: Sequence[str] | Mapping[str, Mapping[str, float]] | None,
    *,
    where: str,
) -> tuple[Behavior, ...]:
    """Make the basic behaviors: those given, or one for each value or limit of each channel."""
    if isinstance(definitions, Mapping):
        return tuple(_check_behavior(name, command, channels, where) for name, command in definitions.items())
    if definitions is None:
        behaviors = []
        for channel in channels:
            for ending, value in _list_values(channel):
                doc = f"Set {channel.name} to {value:g}."
                behaviors.append(
                    Behavior(f"{channel.name}_{ending}", Command(**{channel.name: value}), doc=doc)
                )
        return tuple(behaviors)
    only, *others = channels
    values = [value for _, value in _list_values(only)]
    if others or not only.whole or len(definitions) != len(values):
        counted = f"the {len(values)} values" if only.whole and not others else "no single whole number"
        problem, remedy = (
            f"are {len(definitions)} names, for {counted}",
            "give {name: {channel: value}} instead",
        )
        if only.whole and not others:
            remedy = f"give {len(values)} names, or {{name: {{{only.name!r}: value}}}}"
        raise SettingError(where=where, setting="behaviors", problem=problem, remedy=remedy)
    return tuple(
        Behavior(name, Command(**{only.name: value}), doc=f"Take action {value:g}.")
        for name, value in zip(definitions, values, strict=True)
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
    channel_of = {channel.name: channel for channel in channels}
    for channel, value in command.items():
        if channel not in channel_of:
            raise UnknownName(
                what=f"channel for behavior {name!r}", name=channel, where=where, known=list(channel_of)
            )
        if not find_valid(channel_of[channel], np.array([value], np.float64)).all():
            raise SettingError(
                where=where,
                setting=f"behavior {name!r}",
                problem=f"sets {channel!r} to {value:g}",
                remedy=f"give {format_range(channel_of[channel])}",
            )
    return Behavior(name, Command(**command))
