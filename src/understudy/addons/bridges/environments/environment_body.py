"""Environments of other packages as a body: observations are its readings, actions its channels and basic behaviors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from math import nan
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar

import numpy as np
from gymnasium import Space
from numpy.typing import NDArray

from understudy.addons.bridges.environments.environment_interface import (
    OUTCOMES,
    BehaviorNames,
    Names,
    choose_tick_s,
    find_valid,
    format_range,
    map_behaviors,
    map_channels,
    map_readings,
)
from understudy.addons.bridges.environments.space_numbers import SpaceNumbers, rename_numbers
from understudy.errors import DefinitionError, SettingError, UnknownName
from understudy.model.features import Feature, FlagFeature, Percept, ReadingKey, TimeInState
from understudy.model.library import Kit
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.body import Channel, Commands, Reading, check_reading_keys

EnvironmentT = TypeVar("EnvironmentT")
SourceT = TypeVar("SourceT")


class EnvironmentStep(NamedTuple):
    """The results of a step or reset of an environment, by the names of its agents."""

    observations: Mapping[Any, Any]
    """The present observations. An agent that is left out observes nothing: NaN."""
    present: Collection[Any]
    """The agents that take part in the next step."""
    rewards: Mapping[Any, Any] = {}
    terminated: Mapping[Any, Any] = {}
    truncated: Mapping[Any, Any] = {}


class EnvironmentBody(ABC, Generic[EnvironmentT, SourceT]):
    """A body of environments, one per seed, each with N agents that act at the same time.

    Agent i of environment w is agent w*N + i of the body. An agent whose part has ended is not commanded and gets no
    reward; `return`, `terminated` and `truncated` stay as they are. An environment in which the parts of all agents
    have ended stays as it is until `reset`, while the others go on.

    Parameters
    ----------
    make
        A function that makes an environment, called once per seed; or, for a single seed, an environment.
    seeds
        One whole number from 0 up per environment.
    names
        Names of the observed numbers, in order, or by the name that they would have: obs_0, obs_1, or obs_0_0_2 for one
        in an array of three dimensions, and for nested spaces the keys, joined by dots: position.0.
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
        If an environment cannot be made, its agents have different spaces, or these cannot be mapped.
    """

    package: ClassVar[str]
    """The package of the environments, for error messages, and its checker, which may say more about a failure."""
    checker: ClassVar[str]
    environment_class: ClassVar[type]
    sources: ClassVar[str]
    """For errors: the kinds of `make` that are accepted, and the remedy if it returned something else."""
    returned: ClassVar[str]
    targets: Sequence[str] = ()

    def __init__(
        self,
        make: SourceT,
        seeds: Sequence[int] = (0,),
        *,
        names: Names | None = None,
        units: Mapping[str, str] | None = None,
        kinds: Mapping[str, Kind] | None = None,
        behaviors: BehaviorNames | None = None,
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
        self.environments: list[EnvironmentT] = self._make_environments(len(seeds))
        first: Any = self.environments[0]
        self.name = self._find_name(first)
        self._where = where = f"environment {self.name}"
        self.agent_names: tuple[Any, ...] = tuple(self._list_agents(first))
        observed, acted = self._find_spaces(first)
        self._observed = SpaceNumbers(observed, prefix="obs", where=where)
        self._acted = SpaceNumbers(acted, prefix="action", where=where)
        named = rename_numbers(self._observed.numbers, names, where=where)
        self.readings: Sequence[Reading] = (
            *map_readings(self._observed.numbers, named, units or {}, kinds or {}, where=where),
            *OUTCOMES,
        )
        self.channels: Sequence[Channel] = map_channels(self._acted.numbers, rest or {}, where=where)
        self.behaviors = map_behaviors(self.channels, behaviors, where=where)
        self._rest = np.array([channel.rest for channel in self.channels])
        self._rows = {reading.name: row for row, reading in enumerate(self.readings)}
        self.worlds, self.robots = len(self.environments), len(self.agent_names)
        self.agents = self.worlds * self.robots
        self.tick_s = choose_tick_s(tick_s, first.metadata)
        self.reset(seeds)

    # What differs between packages.

    def _find_maker(self) -> Any:
        """Return the function that makes an environment, or the only one."""
        return self._make

    @abstractmethod
    def _make_again(self, environment: Any) -> Callable[[], Any]:
        """Return a function that makes more environments like a given one; SettingError if there can be only one."""

    @abstractmethod
    def _find_name(self, environment: EnvironmentT) -> str: ...

    @abstractmethod
    def _list_agents(self, environment: EnvironmentT) -> Sequence[Any]: ...

    @abstractmethod
    def _find_spaces(self, environment: EnvironmentT) -> tuple[Space[Any], Space[Any]]:
        """Return the observation and action space of all agents."""

    @abstractmethod
    def _reset(self, environment: EnvironmentT, seed: int) -> EnvironmentStep: ...

    @abstractmethod
    def _step(self, environment: EnvironmentT, actions: Mapping[Any, Any]) -> EnvironmentStep: ...

    # What all have in common.

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
        """A flag per agent [N of all environments]: true if its episode has ended."""
        over: NDArray[np.bool_] = ~self._active
        return over

    @property
    def returns(self) -> Column:
        """The sum of the rewards of each agent since the last reset [N of all environments]."""
        returns: Column = self._values[-3].copy()
        return returns

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin new episodes.

        Parameters
        ----------
        seeds
            One whole number from 0 up per environment; SettingError otherwise.
        """
        self.seeds = self._check_seeds(seeds)
        self._ticks = 0
        self._values = np.zeros((len(self.readings), self.agents))
        self._active = np.zeros(self.agents, np.bool_)
        for world, (environment, seed) in enumerate(zip(self.environments, self.seeds, strict=True)):
            self._observe(self._list_rows(world), self._reset(environment, seed))

    def with_seeds(self, seeds: Sequence[int]) -> Self:
        """Make a body of the same environments with other seeds, at time 0; this one does not change.

        Parameters
        ----------
        seeds
            One whole number from 0 up per environment.

        Returns
        -------
        Self
            The body. SettingError if this one was given an environment of which there can be only one.
        """
        make: Any = self._make
        if isinstance(make, self.environment_class):
            make = self._make_again(make)
        return type(self)(make, seeds, **self._settings)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return what the agents observed last.

        Parameters
        ----------
        keys
            Pairs (reading, None). UnknownName or SettingError if there is no such reading.

        Returns
        -------
        Percept
            A column [N of all environments] for each key; NaN where nothing, an infinite number or NaN was observed.
        """
        check_reading_keys(keys, readings=self.readings, targets=(), where=self._where)
        return {key: self._values[self._rows[key[0]]].copy() for key in keys}

    def act(self, commands: Commands) -> None:
        """Take one step in all environments that have agents left; none is taken if a command is not valid.

        Parameters
        ----------
        commands
            A column [N of all environments] for each channel; one that is left out rests. UnknownName or
            DefinitionError if there is no such channel, or an action is out of the range of the action space, also for
            agents whose part has ended.
        """
        table = self._make_command_table(commands)
        self._values[-4] = 0.0
        for world, environment in enumerate(self.environments):
            rows = self._list_rows(world)
            actions = {
                name: self._acted.unflatten(table[row])
                for row, name in zip(rows, self.agent_names, strict=True)
                if self._active[row]
            }
            if actions:
                step = self._step(environment, actions)
                self._note_outcomes(rows, step)
                self._observe(rows, step)
        self._ticks += 1

    def _list_rows(self, world: int) -> range:
        return range(world * self.robots, (world + 1) * self.robots)

    def _note_outcomes(self, rows: range, step: EnvironmentStep) -> None:
        """Note how a step went for the agents that took part in it."""
        for row, name in zip(rows, self.agent_names, strict=True):
            if self._active[row]:
                reward = float(step.rewards.get(name, 0.0))
                self._values[-4, row] = reward
                self._values[-3, row] += reward
                self._values[-2, row] = bool(step.terminated.get(name, False))
                self._values[-1, row] = bool(step.truncated.get(name, False))

    def _observe(self, rows: range, step: EnvironmentStep) -> None:
        """Note what the agents observe, and whose part goes on."""
        for row, name in zip(rows, self.agent_names, strict=True):
            self._active[row] = name in step.present
            self._values[: -len(OUTCOMES), row] = (
                self._observed.flatten(step.observations[name]) if name in step.observations else nan
            )

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
        environment: Any = self.environments[world]
        if getattr(environment, "render_mode", None) != "rgb_array":
            return None
        return np.asarray(self._call("render", environment.render), np.uint8)

    def close(self) -> None:
        """Close all environments; the body cannot be used afterwards."""
        environment: Any
        for environment in self.environments:
            environment.close()

    def _call(self, name: str, function: Callable[..., Any], *args: Any, **named: Any) -> Any:
        """Call a method of an environment; turn any error into a DefinitionError, which names the checker."""
        try:
            return function(*args, **named)
        except Exception as error:  # an environment's code can raise any error
            raise DefinitionError(
                what=self._where,
                problem=f"its {name} failed: {type(error).__name__}: {error}",
                remedy=f"correct the environment; {self.checker} may say more",
            ) from error

    def _make_command_table(self, commands: Commands) -> NDArray[np.float64]:
        """Return commands as a table [N, C], at rest where they are left out; refuse what the action space lacks."""
        columns = {channel.name: column for column, channel in enumerate(self.channels)}
        table = np.tile(self._rest, (self.agents, 1))
        for name, values in commands.items():
            if name not in columns:
                raise UnknownName(what="channel", name=name, where=self._where, known=list(columns))
            column = np.asarray(values, np.float64)
            if column.shape != (self.agents,):
                problem = f"it has shape {column.shape}"
                remedy = f"give one number per agent: shape ({self.agents},)"
                raise DefinitionError(what=f"command {name!r}", problem=problem, remedy=remedy)
            channel = self.channels[columns[name]]
            wrong = np.flatnonzero(~find_valid(channel, column))
            if len(wrong):
                problem = f"it is {column[wrong[0]]:g} for agent {wrong[0]} of {self._where}"
                raise DefinitionError(
                    what=f"command {name!r}", problem=problem, remedy=f"give {format_range(channel)}"
                )
            table[:, columns[name]] = column
        return table

    def _check_seeds(self, seeds: Sequence[int]) -> tuple[int, ...]:
        values: list[Any] = list(seeds)
        whole = all(isinstance(seed, int | np.integer) and seed >= 0 for seed in values)
        if len(values) != self.worlds or not whole:
            raise SettingError(
                where=self._where,
                setting="seeds",
                problem=f"are {values!r:.60}",
                remedy=f"give {self.worlds} whole numbers from 0 up",
            )
        return tuple(int(seed) for seed in values)

    def _make_environments(self, count: int) -> list[Any]:
        if count < 1:
            raise refuse_source(self.package, "seeds", "are none", "give one whole number per environment")
        make, one = self._find_maker(), "give a function that makes one"
        if isinstance(make, self.environment_class):
            if count != 1:
                raise refuse_source(self.package, "make", f"is one environment for {count} seeds", one)
            return [make]
        if not callable(make):
            raise refuse_source(self.package, "make", f"is a {type(make).__name__}", self.sources)
        environments: list[Any] = [make() for _ in range(count)]
        wrong = [each for each in environments if not isinstance(each, self.environment_class)]
        if wrong:
            raise refuse_source(self.package, "make", f"returned a {type(wrong[0]).__name__}", self.returned)
        if count > 1 and environments[0] is environments[1]:
            problem, remedy = "returned the same environment twice", "return a new one in each call"
            raise refuse_source(self.package, "make", problem, remedy)
        return environments


def refuse_source(package: str, setting: str, problem: str, remedy: str) -> SettingError:
    """Make the error about what environments of a package are made of."""
    return SettingError(where=f"{package} environment", setting=setting, problem=problem, remedy=remedy)
