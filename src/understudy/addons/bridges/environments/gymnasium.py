"""Gymnasium environments as bodies, and scenarios with one robot as Gymnasium environments.

It needs the extra `gymnasium`; without it, the import raises ExtraMissing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, TypeAlias

from understudy.extras import ExtraMissing

try:
    import gymnasium
except ImportError:
    raise ExtraMissing(what="a Gymnasium environment", extra="gymnasium") from None

from understudy.addons.bridges.environments.environment_body import (
    EnvironmentBody,
    EnvironmentStep,
    refuse_source,
)
from understudy.addons.bridges.environments.scenario_task import SEEDS, Floats32, ScenarioEnvironment
from understudy.errors import SettingError

AnyEnv: TypeAlias = gymnasium.Env[Any, Any]
EnvSource: TypeAlias = str | Callable[[], AnyEnv] | AnyEnv
AGENT = "agent"


class GymnasiumBody(EnvironmentBody[AnyEnv, EnvSource]):
    """A body of N agents, each alone in a Gymnasium environment of its own, reset with a seed of its own.

    It has the parameters of `EnvironmentBody`. `make` may also be the name of a registered environment, such as
    "CartPole-v1". An agent whose episode has ended goes on to observe what it observed last.
    """

    package = "Gymnasium"
    checker = "gymnasium.utils.env_checker.check_env"
    environment_class = gymnasium.Env
    sources = "give the name of a registered one, a function that makes one, or one"
    returned = "return a gymnasium.Env"

    def _find_maker(self) -> Any:
        return partial(make_registered, self._make) if isinstance(self._make, str) else self._make

    def _make_again(self, environment: AnyEnv) -> Callable[[], AnyEnv]:
        if environment.spec is None:
            raise SettingError(
                where=f"environment {self.name}",
                setting="make",
                problem="is an environment that is not registered, so that there can be only one",
                remedy="give a function that makes one",
            )
        return partial(gymnasium.make, environment.spec)

    def _find_name(self, environment: AnyEnv) -> str:
        return environment.spec.id if environment.spec else type(environment.unwrapped).__name__

    def _list_agents(self, environment: AnyEnv) -> Sequence[str]:
        return (AGENT,)

    def _find_spaces(self, environment: AnyEnv) -> tuple[gymnasium.Space[Any], gymnasium.Space[Any]]:
        return environment.observation_space, environment.action_space

    def _reset(self, environment: AnyEnv, seed: int) -> EnvironmentStep:
        observation, _ = self._call("reset", environment.reset, seed=seed)
        return EnvironmentStep({AGENT: observation}, (AGENT,))

    def _step(self, environment: AnyEnv, actions: Mapping[Any, Any]) -> EnvironmentStep:
        observation, *outcomes, _ = self._call("step", environment.step, actions[AGENT])
        reward, terminated, truncated = ({AGENT: outcome} for outcome in outcomes)
        present = () if terminated[AGENT] or truncated[AGENT] else (AGENT,)
        return EnvironmentStep({AGENT: observation}, present, reward, terminated, truncated)


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
        raise refuse_source("Gymnasium", repr(name), f"cannot be made: {error}", remedy) from error


class ScenarioEnv(ScenarioEnvironment, gymnasium.Env[Floats32, Any]):
    """The world of a scenario with one robot, as an environment for reinforcement learning.

    It has the parameters of `ScenarioEnvironment`; SettingError if the scenario has more than one robot. An observation
    is a `Box` with a float32 per reading. A reset without a seed draws the world; with a seed, the world is that of the
    seed.
    """

    def _set_up(self) -> None:
        if self.task.robots != 1:
            raise SettingError(
                where=self.task.where,
                setting="robots",
                problem=f"are {self.task.robots}, and a Gymnasium environment has one",
                remedy="use understudy.addons.bridges.environments.pettingzoo.ScenarioParallelEnv",
            )
        self.observation_space, self.action_space = self._make_spaces()
        self._look_up = self.task.look_up_behavior if self.task.behaviors else self.task.look_up_channels

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats32, dict[str, Any]]:
        """Begin a new episode.

        Parameters
        ----------
        seed
            Seed of the world, from 0 up. None: drawn.
        options
            Not used.

        Returns
        -------
        tuple
            What is observed [F], and an empty mapping.
        """
        super().reset(seed=seed)
        world = int(self.np_random.integers(SEEDS)) if seed is None else seed
        return self.task.reset(world)[0], {}

    def step(self, action: Any) -> tuple[Floats32, float, bool, bool, dict[str, Any]]:
        """Advance one tick.

        Parameters
        ----------
        action
            Number of a basic behavior, or a value for each channel.

        Returns
        -------
        tuple
            What is observed [F], the reward, whether the episode is terminated and truncated, and an empty mapping.
        """
        observed, (reward,), terminated, truncated = self.task.step(self._look_up((action,)))
        return observed[0], reward, terminated, truncated, {}
