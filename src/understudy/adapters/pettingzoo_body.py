"""Parallel environments of PettingZoo as a body, whose agents act in worlds that they share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nan
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

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

AnyParallelEnv: TypeAlias = "ParallelEnv[Any, Any, Any]"
CHECKER = "pettingzoo.test.parallel_api_test"


class PettingZooBody:
    """A body of parallel environments, one per seed, each with N agents that act at the same time.

    Agent i of environment w is agent w*N + i of the body, in the order of the environment's `possible_agents`. All have
    the same observation space and the same action space.

    An agent takes part as long as its environment lists it among its `agents`. From the step on that ends its part, its
    observed readings are absent (NaN), its commands are ignored and its reward is 0; `return`, `terminated` and
    `truncated` stay as they are. An environment that all agents have left stays as it is until `reset`, whatever the
    others do.

    Parameters
    ----------
    make
        A function that makes a parallel environment, such as `pursuit_v5.parallel_env`, called once per seed; or, for a
        single seed, an environment.
    seeds
        One whole number from 0 up per environment.
    names
        Names of the observed numbers, in order, or by the name that they would have: obs_0, obs_1, or obs_0_0_2 for one
        in an array of three dimensions, and for nested spaces the keys, joined by dots.
    units
        Unit of a reading, by name.
    kinds
        Kind of a reading, by name, where the space does not tell: `Toroidal()` for an angle.
    behaviors
        Basic behaviors: names for the values of the only action, in order; or a command by name, as values of
        channels. By default as for `GymnasiumBody`.
    rest
        Value of channels while idling, by channel. By default the first action, or 0, or the nearest to it.
    tick_s
        Length of a tick, s. By default from the `render_fps` of the environment, or else 0.1 s.

    Raises
    ------
    SettingError
        If an environment cannot be made, its agents have different spaces, or these cannot be mapped.
    """

    targets: Sequence[str] = ()

    def __init__(
        self,
        make: Callable[[], AnyParallelEnv] | AnyParallelEnv,
        seeds: Sequence[int] = (0,),
        *,
        names: Names | None = None,
        units: Mapping[str, str] | None = None,
        kinds: Mapping[str, Kind] | None = None,
        behaviors: BehaviorNames | None = None,
        rest: Mapping[str, float] | None = None,
        tick_s: float | None = None,
    ) -> None:
        self._make, self._given_tick_s = make, tick_s
        self._settings: dict[str, Any] = {
            "names": names,
            "units": units,
            "kinds": kinds,
            "behaviors": behaviors,
            "rest": rest,
        }
        self.environments = _make_environments(make, len(seeds))
        first = self.environments[0]
        self.name = str(first.metadata.get("name", type(first.unwrapped).__name__))
        where = f"environment {self.name}"
        self.agent_names: tuple[Any, ...] = tuple(first.possible_agents)
        self._interface = EnvironmentInterface(*_find_spaces(first, where), where=where, **self._settings)
        self.readings: Sequence[Reading] = self._interface.readings
        self.channels: Sequence[Channel] = self._interface.channels
        self.behaviors = self._interface.behaviors
        self.worlds, self.robots = len(self.environments), len(self.agent_names)
        self.agents = self.worlds * self.robots
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
        """True for each agent that has left its environment [N of all environments]."""
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
        self.seeds = self._interface.check_seeds(seeds, self.worlds)
        self._ticks = 0
        self._values = np.zeros((len(self.readings), self.agents))
        self._active = np.zeros(self.agents, np.bool_)
        for world, (environment, seed) in enumerate(zip(self.environments, self.seeds, strict=True)):
            observations, _ = self._call("reset", environment.reset, seed=seed)
            self._observe(world, observations)

    def with_seeds(self, seeds: Sequence[int]) -> PettingZooBody:
        """Make a body of the same environments with other seeds, at time 0; this one does not change.

        Parameters
        ----------
        seeds
            One whole number from 0 up per environment.

        Returns
        -------
        PettingZooBody
            The body. SettingError if this one was given an environment, of which there can be only one.
        """
        if isinstance(self._make, ParallelEnv):
            raise _wrong_make(
                "make", "is an environment, so that there can be only one", "give a function that makes one"
            )
        return PettingZooBody(self._make, seeds, tick_s=self._given_tick_s, **self._settings)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return what the agents observed last.

        Parameters
        ----------
        keys
            Pairs (reading, None). UnknownName or SettingError if there is no such reading.

        Returns
        -------
        Percept
            A column [N of all environments] for each key; NaN for agents that have left, and where an infinite number
            or NaN was observed.
        """
        return self._interface.select_readings(self._values, keys)

    def act(self, commands: Commands) -> None:
        """Take one step in all environments that have agents left; none is taken if a command is not valid.

        Parameters
        ----------
        commands
            A column [N of all environments] for each channel; one that is left out rests. UnknownName or
            DefinitionError if there is no such channel, or an action is out of the range of the action space, also for
            agents that have left.
        """
        table = self._interface.make_command_table(commands, self.agents)
        self._values[-4] = 0.0
        for world, environment in enumerate(self.environments):
            rows = range(world * self.robots, (world + 1) * self.robots)
            actions = {
                name: self._interface.acted.unflatten(table[row])
                for row, name in zip(rows, self.agent_names, strict=True)
                if self._active[row]
            }
            if not actions:
                continue
            observations, *outcomes, _ = self._call("step", environment.step, actions)
            self._note_outcomes(rows, *outcomes)
            self._observe(world, observations)
        self._ticks += 1

    def _note_outcomes(
        self,
        rows: range,
        rewards: Mapping[Any, Any],
        terminated: Mapping[Any, Any],
        truncated: Mapping[Any, Any],
    ) -> None:
        """Note how a step went for the agents that took part in it."""
        for row, name in zip(rows, self.agent_names, strict=True):
            if self._active[row]:
                reward = float(rewards.get(name, 0.0))
                self._values[-4, row] = reward
                self._values[-3, row] += reward
                self._values[-2, row] = bool(terminated.get(name, False))
                self._values[-1, row] = bool(truncated.get(name, False))

    def _observe(self, world: int, observations: Mapping[Any, Any]) -> None:
        """Note what the agents observe, and which of them have left."""
        here = set(self.environments[world].agents)
        for index, name in enumerate(self.agent_names):
            row = world * self.robots + index
            self._active[row] = name in here
            self._values[: -len(OUTCOMES), row] = (
                self._interface.observed.flatten(observations[name])
                if name in here and name in observations
                else nan
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
        environment = self.environments[world]
        if getattr(environment, "render_mode", None) != "rgb_array":
            return None
        return np.asarray(self._call("render", environment.render), np.uint8)

    def close(self) -> None:
        """Close all environments; the body cannot be used afterwards."""
        for environment in self.environments:
            environment.close()

    def _call(self, name: str, function: Callable[..., Any], *args: Any, **named: Any) -> Any:
        return self._interface.call(name, function, *args, checker=CHECKER, **named)


def _make_environments(
    make: Callable[[], AnyParallelEnv] | AnyParallelEnv, count: int
) -> list[AnyParallelEnv]:
    if count < 1:
        raise _wrong_make("seeds", "are none", "give one whole number per environment")
    if isinstance(make, ParallelEnv):
        if count != 1:
            raise _wrong_make(
                "make", f"is one environment for {count} seeds", "give a function that makes one"
            )
        return [make]
    if not callable(make):
        remedy = "give a function that makes a parallel environment, or one"
        raise _wrong_make("make", f"is a {type(make).__name__}", remedy)
    made: list[Any] = [make() for _ in range(count)]
    wrong = [each for each in made if not isinstance(each, ParallelEnv)]
    if wrong:
        remedy = "return a pettingzoo.ParallelEnv; pettingzoo.utils.aec_to_parallel makes one of an AECEnv"
        raise _wrong_make("make", f"returned a {type(wrong[0]).__name__}", remedy)
    if count > 1 and made[0] is made[1]:
        raise _wrong_make("make", "returned the same environment twice", "return a new one in each call")
    return made


def _find_spaces(environment: AnyParallelEnv, where: str) -> tuple[Any, Any]:
    """Return the observation and action space of all agents, which must be the same for each."""
    agents = list(environment.possible_agents)
    if not agents:
        raise SettingError(
            where=where, setting="possible_agents", problem="are none", remedy="give at least one"
        )
    found = []
    for setting, find in (
        ("observation spaces", environment.observation_space),
        ("action spaces", environment.action_space),
    ):
        first, *others = (find(agent) for agent in agents)
        for agent, other in zip(agents[1:], others, strict=True):
            if other != first:
                problem = f"of {agents[0]} and {agent} differ"
                remedy = "wrap the environment so that all agents have the same"
                raise SettingError(where=where, setting=setting, problem=problem, remedy=remedy)
        found.append(first)
    observed, acted = found
    return observed, acted


def _wrong_make(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="PettingZoo environment", setting=setting, problem=problem, remedy=remedy)
