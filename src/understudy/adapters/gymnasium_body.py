"""Gymnasium environments as a body: observations are its readings, actions its channels and basic behaviors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from understudy.adapters.space_numbers import SpaceNumber, SpaceNumbers, rename_numbers
from understudy.errors import DefinitionError, SettingError, UnknownName, join_names
from understudy.model.behaviors import Behavior, Command
from understudy.model.features import Feature, FlagFeature, Percept, ReadingKey, TimeInState
from understudy.model.kinds import BOOLEAN, Categorical, Column, Continuous, Kind
from understudy.model.library import Kit
from understudy.runtime.body import Channel, Commands, Reading, check_reading_keys

AnyEnv: TypeAlias = "gymnasium.Env[Any, Any]"
EnvMaker: TypeAlias = Callable[[], AnyEnv]
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


class GymnasiumBody:
    """A body of N agents, each alone in a Gymnasium environment of its own, reset with a seed of its own.

    An agent whose episode has ended stays as it is, whatever it is commanded, until `reset`.

    Parameters
    ----------
    make
        Name of a registered environment, such as "CartPole-v1"; or a function that makes an environment, called once
        per seed; or, for a single seed, an environment.
    seeds
        One whole number from 0 up per environment.
    names
        Names of the observed numbers, in order, or by the name that they would have. Those are obs_0, obs_1 and so on,
        and for nested spaces the keys, joined by dots: position.0.
    units
        Unit of a reading, by name.
    kinds
        Kind of a reading, by name, where the space does not tell: `Toroidal()` for an angle.
    behaviors
        Basic behaviors: names for the values of the only action, in order; or a command by name, as values of
        channels. By default one for each value of a whole number, such as action_0; for other numbers their least and
        greatest value, such as action_low, where these are finite.
    rest
        Value of channels while idling, by channel. By default the first action, or 0, or the nearest to it.
    tick_s
        Length of a tick, s. By default from the `render_fps` of the environment, or else 0.1 s.

    Raises
    ------
    SettingError
        If an environment cannot be made, or its spaces cannot be mapped.
    """

    targets: Sequence[str] = ()
    robots = 1

    def __init__(
        self,
        make: str | EnvMaker | AnyEnv,
        seeds: Sequence[int] = (0,),
        *,
        names: Sequence[str] | Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        kinds: Mapping[str, Kind] | None = None,
        behaviors: Sequence[str] | Mapping[str, Mapping[str, float]] | None = None,
        rest: Mapping[str, float] | None = None,
        tick_s: float | None = None,
    ) -> None:
        self._make = make
        self._settings: dict[str, Any] = {
            "names": names,
            "units": units,
            "kinds": kinds,
            "behaviors": behaviors,
            "rest": rest,
            "tick_s": tick_s,
        }
        self.environments = _make_environments(make, len(seeds))
        first = self.environments[0]
        self.name = _name_environment(first)
        where = f"environment {self.name}"
        self._observed = SpaceNumbers(first.observation_space, prefix="obs", where=where)
        self._acted = SpaceNumbers(first.action_space, prefix="action", where=where)
        named = rename_numbers(self._observed.numbers, names, where=where)
        self.readings: Sequence[Reading] = (
            *_make_readings(self._observed.numbers, named, units or {}, kinds or {}, where=where),
            *OUTCOMES,
        )
        self.channels: Sequence[Channel] = _make_channels(self._acted.numbers, rest or {}, where=where)
        self._rest = np.array([channel.rest for channel in self.channels])
        self.behaviors = _make_behaviors(self.channels, behaviors, where=where)
        self.agents = self.worlds = len(self.environments)
        fps = first.metadata.get("render_fps")
        self.tick_s = float(tick_s if tick_s is not None else 1.0 / fps if fps else TICK_S)
        self.reset(seeds)

    @property
    def kit(self) -> Kit:
        """A feature for each reading, those of the automaton itself, and the basic behaviors."""
        features = (
            Feature(each.name, each.kind, each.name, unit=each.unit, doc=each.doc) for each in self.readings
        )
        own = (FlagFeature("done"), FlagFeature("failed"), TimeInState())
        return Kit.from_parts(*features, *own, *self.behaviors)

    @property
    def time_s(self) -> float:
        """The time since the last reset, s."""
        return self._ticks * self.tick_s

    @property
    def is_over(self) -> NDArray[np.bool_]:
        """Whether the episode of each agent has ended [N]."""
        over: NDArray[np.bool_] = self._values[-2:].max(axis=0) > 0
        return over

    @property
    def returns(self) -> Column:
        """The sum of the rewards of each agent since the last reset [N]."""
        returns: Column = self._values[-3].copy()
        return returns

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin new episodes.

        Parameters
        ----------
        seeds
            One whole number from 0 up per environment; SettingError otherwise.
        """
        seeds = list(seeds)
        given: list[Any] = seeds
        whole = all(isinstance(seed, int | np.integer) and seed >= 0 for seed in given)
        if len(seeds) != self.agents or not whole:
            raise SettingError(
                where=f"environment {self.name}",
                setting="seeds",
                problem=f"are {seeds!r:.60}",
                remedy=f"give {self.agents} whole numbers from 0 up",
            )
        self.seeds = tuple(int(seed) for seed in seeds)
        self._ticks = 0
        self._values = np.zeros((len(self.readings), self.agents))
        for agent, (environment, seed) in enumerate(zip(self.environments, self.seeds, strict=True)):
            observation, _ = self._call("reset", environment.reset, seed=seed)
            self._values[: -len(OUTCOMES), agent] = self._observed.flatten(observation)

    def with_seeds(self, seeds: Sequence[int]) -> GymnasiumBody:
        """Make a body of the same environments with other seeds, at time 0; this one does not change.

        Parameters
        ----------
        seeds
            One whole number from 0 up per environment.

        Returns
        -------
        GymnasiumBody
            The body. SettingError if this one was given an environment that is not registered.
        """
        make: Any = self._make
        if isinstance(make, gymnasium.Env):
            if make.spec is None:
                raise SettingError(
                    where=f"environment {self.name}",
                    setting="make",
                    problem="is an environment that is not registered, so that there can be only one",
                    remedy="give a function that makes one",
                )
            spec = make.spec
            return GymnasiumBody(lambda: gymnasium.make(spec), seeds, **self._settings)
        return GymnasiumBody(make, seeds, **self._settings)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return what the environments observed last.

        Parameters
        ----------
        keys
            Pairs (reading, None). UnknownName or SettingError if there is no such reading.

        Returns
        -------
        Percept
            A column [N] for each key; NaN where the environment observed an infinite number or NaN.
        """
        check_reading_keys(keys, readings=self.readings, targets=(), where=f"environment {self.name}")
        places = {reading.name: place for place, reading in enumerate(self.readings)}
        return {key: self._values[places[key[0]]].copy() for key in keys}

    def act(self, commands: Commands) -> None:
        """Take one step in all environments whose episode has not ended; none is taken if a command is not valid.

        Parameters
        ----------
        commands
            A column [N] for each channel; one that is left out rests. UnknownName or DefinitionError if there is no
            such channel, or an action is out of the range of the action space.
        """
        table = self._check_commands(commands)
        running = np.flatnonzero(~self.is_over)
        self._values[-4] = 0.0
        for agent in running:
            step = self.environments[agent].step
            observation, reward, terminated, truncated, _ = self._call(
                "step", step, self._acted.unflatten(table[agent])
            )
            self._values[: -len(OUTCOMES), agent] = self._observed.flatten(observation)
            self._values[-4, agent] = float(reward)
            self._values[-3, agent] += float(reward)
            self._values[-2, agent], self._values[-1, agent] = bool(terminated), bool(truncated)
        self._ticks += 1

    def render(self, world: int = 0) -> NDArray[np.uint8] | None:
        """Draw an environment.

        Parameters
        ----------
        world
            Index of the environment, from 0.

        Returns
        -------
        NDArray[np.uint8] or None
            The picture [height, width, 3]; None if the environment was not made with the render mode "rgb_array".
        """
        environment = self.environments[world]
        if environment.render_mode != "rgb_array":
            return None
        return np.asarray(self._call("render", environment.render), np.uint8)

    def close(self) -> None:
        """Close all environments; the body cannot be used afterwards."""
        for environment in self.environments:
            environment.close()

    def _call(self, name: str, function: Callable[..., Any], *args: Any, **named: Any) -> Any:
        try:
            return function(*args, **named)
        except Exception as error:  # whatever code of the environment does
            raise DefinitionError(
                what=f"environment {self.name}",
                problem=f"its {name} failed: {type(error).__name__}: {error}",
                remedy="correct the environment; gymnasium.utils.env_checker.check_env may say more",
            ) from error

    def _check_commands(self, commands: Commands) -> NDArray[np.float64]:
        """Return the commands as a table [N, C]; refuse those that the action space does not have."""
        known = {channel.name: column for column, channel in enumerate(self.channels)}
        table = np.tile(self._rest, (self.agents, 1))
        for name, values in commands.items():
            if name not in known:
                where = f"environment {self.name}"
                raise UnknownName(what="channel", name=name, where=where, known=list(known))
            column = np.asarray(values, np.float64)
            if column.shape != (self.agents,):
                problem = f"it has shape {column.shape}"
                remedy = f"give one number per agent: shape ({self.agents},)"
                raise DefinitionError(what=f"command {name!r}", problem=problem, remedy=remedy)
            channel = self.channels[known[name]]
            wrong = np.flatnonzero(~_find_valid(channel, column))
            if len(wrong):
                problem = f"it is {column[wrong[0]]:g} for agent {wrong[0]} of environment {self.name}"
                raise DefinitionError(
                    what=f"command {name!r}", problem=problem, remedy=f"give {_format_range(channel)}"
                )
            table[:, known[name]] = column
        return table


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


def _make_environments(make: str | EnvMaker | AnyEnv, count: int) -> list[AnyEnv]:
    if count < 1:
        raise _wrong_make("seeds", "are none", "give one whole number per environment")
    if isinstance(make, gymnasium.Env):
        if count != 1:
            raise _wrong_make(
                "make", f"is one environment for {count} seeds", "give a function that makes one"
            )
        return [make]
    if isinstance(make, str):
        return [make_registered(make) for _ in range(count)]
    if not callable(make):
        remedy = "give the name of a registered one, a function that makes one, or one"
        raise _wrong_make("make", f"is a {type(make).__name__}", remedy)
    made: list[Any] = [make() for _ in range(count)]
    wrong = [each for each in made if not isinstance(each, gymnasium.Env)]
    if wrong:
        raise _wrong_make("make", f"returned a {type(wrong[0]).__name__}", "return a gymnasium.Env")
    if count > 1 and made[0] is made[1]:
        raise _wrong_make("make", "returned the same environment twice", "return a new one in each call")
    return made


def make_registered(name: str) -> AnyEnv:
    """Make a registered environment that can be drawn if it has the render mode "rgb_array"; or raise SettingError."""
    try:
        spec = gymnasium.spec(name)
        environment = gymnasium.make(spec)
        if "rgb_array" in environment.metadata.get("render_modes", ()):
            environment.close()
            environment = gymnasium.make(spec, render_mode="rgb_array")
        return environment
    except (gymnasium.error.Error, ImportError) as error:
        remedy = "name one of gymnasium.registry, such as CartPole-v1, and install what it needs"
        raise _wrong_make(repr(name), f"cannot be made: {error}", remedy) from error


def _wrong_make(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="Gymnasium environment", setting=setting, problem=problem, remedy=remedy)


def _name_environment(environment: AnyEnv) -> str:
    return environment.spec.id if environment.spec else type(environment.unwrapped).__name__


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
