"""Gymnasium environments as a body: observations are its readings, actions its channels and basic behaviors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from understudy.adapters.environment_interface import (
    OUTCOMES,
    BehaviorNames,
    EnvironmentInterface,
    Names,
    choose_tick_s,
)
from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column, Kind
from understudy.model.library import Kit
from understudy.runtime.body import Channel, Commands, Reading

AnyEnv: TypeAlias = "gymnasium.Env[Any, Any]"
EnvMaker: TypeAlias = Callable[[], AnyEnv]
CHECKER = "gymnasium.utils.env_checker.check_env"


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
        }
        self._given_tick_s = tick_s
        self.environments = _make_environments(make, len(seeds))
        first = self.environments[0]
        self.name = _name_environment(first)
        self._interface = EnvironmentInterface(
            first.observation_space,
            first.action_space,
            where=f"environment {self.name}",
            **self._settings,
        )
        self.readings: Sequence[Reading] = self._interface.readings
        self.channels: Sequence[Channel] = self._interface.channels
        self.behaviors = self._interface.behaviors
        self.agents = self.worlds = len(self.environments)
        self.tick_s = choose_tick_s(tick_s, first.metadata)
        self.reset(seeds)

    @property
    def kit(self) -> Kit:
        """A feature for each reading, those of the automaton itself, and the basic behaviors."""
        return self._interface.kit

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
        self.seeds = self._interface.check_seeds(seeds, self.agents)
        self._ticks = 0
        self._values = np.zeros((len(self.readings), self.agents))
        for agent, (environment, seed) in enumerate(zip(self.environments, self.seeds, strict=True)):
            observation, _ = self._call("reset", environment.reset, seed=seed)
            self._values[: -len(OUTCOMES), agent] = self._interface.observed.flatten(observation)

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
            return GymnasiumBody(
                lambda: gymnasium.make(spec), seeds, tick_s=self._given_tick_s, **self._settings
            )
        return GymnasiumBody(make, seeds, tick_s=self._given_tick_s, **self._settings)

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
        return self._interface.select_readings(self._values, keys)

    def act(self, commands: Commands) -> None:
        """Take one step in all environments whose episode has not ended; none is taken if a command is not valid.

        Parameters
        ----------
        commands
            A column [N] for each channel; one that is left out rests. UnknownName or DefinitionError if there is no
            such channel, or an action is out of the range of the action space.
        """
        table = self._interface.make_command_table(commands, self.agents)
        running = np.flatnonzero(~self.is_over)
        self._values[-4] = 0.0
        for agent in running:
            step = self.environments[agent].step
            observation, reward, terminated, truncated, _ = self._call(
                "step", step, self._interface.acted.unflatten(table[agent])
            )
            self._values[: -len(OUTCOMES), agent] = self._interface.observed.flatten(observation)
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
        return self._interface.call(name, function, *args, checker=CHECKER, **named)


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
