"""Parallel environments of PettingZoo as bodies, and scenarios with any number of robots as such environments.

It needs the extra `pettingzoo`; without it, the import raises ExtraMissing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from understudy.extras import ExtraMissing

try:
    from gymnasium import Space
    from gymnasium.utils.seeding import np_random
    from pettingzoo import ParallelEnv
except ImportError:
    raise ExtraMissing(what="a PettingZoo environment", extra="pettingzoo") from None

from understudy.addons.bridges.environments.environment_body import (
    EnvironmentBody,
    EnvironmentStep,
    refuse_source,
)
from understudy.addons.bridges.environments.scenario_task import SEEDS, Floats32, ScenarioEnvironment
from understudy.errors import DefinitionError, SettingError

AnyParallelEnv: TypeAlias = ParallelEnv[Any, Any, Any]
ParallelEnvSource: TypeAlias = Callable[[], AnyParallelEnv] | AnyParallelEnv


class PettingZooBody(EnvironmentBody[AnyParallelEnv, ParallelEnvSource]):
    """A body of parallel environments, one per seed, each with N agents that act at the same time.

    It has the parameters of `EnvironmentBody`; `make` is such as `pursuit_v5.parallel_env`. Agents are in the order of
    the environment's `possible_agents`, and all have the same observation space and the same action space. An agent
    takes part as long as its environment lists it among its `agents`; afterwards its observed readings are absent
    (NaN).
    """

    package = "PettingZoo"
    checker = "pettingzoo.test.parallel_api_test"
    environment_class = ParallelEnv
    sources = "give a function that makes a parallel environment, or one"
    returned = "return a pettingzoo.ParallelEnv; pettingzoo.utils.aec_to_parallel makes one of an AECEnv"

    def _make_again(self, environment: AnyParallelEnv) -> Callable[[], AnyParallelEnv]:
        problem = "is an environment, so that there can be only one"
        raise refuse_source(self.package, "make", problem, "give a function that makes one")

    def _find_name(self, environment: AnyParallelEnv) -> str:
        return str(environment.metadata.get("name", type(environment.unwrapped).__name__))

    def _list_agents(self, environment: AnyParallelEnv) -> Sequence[Any]:
        return environment.possible_agents

    def _find_spaces(self, environment: AnyParallelEnv) -> tuple[Space[Any], Space[Any]]:
        if not self.agent_names:
            raise self._refuse_agents("possible_agents", "are none", "give at least one")
        observed = self._find_space("observation spaces", environment.observation_space)
        return observed, self._find_space("action spaces", environment.action_space)

    def _find_space(self, setting: str, find: Callable[[Any], Space[Any]]) -> Space[Any]:
        """Return the space of all agents; SettingError if they differ."""
        name, *others = self.agent_names
        space = find(name)
        for other in others:
            if find(other) != space:
                remedy = "wrap the environment so that all agents have the same"
                raise self._refuse_agents(setting, f"of {name} and {other} differ", remedy)
        return space

    def _refuse_agents(self, setting: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where=f"environment {self.name}", setting=setting, problem=problem, remedy=remedy)

    def _reset(self, environment: AnyParallelEnv, seed: int) -> EnvironmentStep:
        observations, _ = self._call("reset", environment.reset, seed=seed)
        return _keep_present(environment, observations)

    def _step(self, environment: AnyParallelEnv, actions: Mapping[Any, Any]) -> EnvironmentStep:
        observations, *outcomes, _ = self._call("step", environment.step, actions)
        return _keep_present(environment, observations, *outcomes)


def _keep_present(
    environment: AnyParallelEnv, observations: Mapping[Any, Any], *outcomes: Mapping[Any, Any]
) -> EnvironmentStep:
    """Make a step, without the last observations of agents that have left."""
    present = set(environment.agents)
    present_observations = {
        name: observation for name, observation in observations.items() if name in present
    }
    return EnvironmentStep(present_observations, present, *outcomes)


class ScenarioParallelEnv(ScenarioEnvironment, ParallelEnv[str, Floats32, Any]):
    """The robots of one world of a scenario, as agents robot_0, robot_1 and so on, that act at the same time.

    It has the parameters of `ScenarioEnvironment`. All agents have the same spaces. A reading that a robot's type lacks
    is absent. An episode ends for all agents at once. Of one step, the observations of all agents are rows of one
    array.
    """

    def _set_up(self) -> None:
        self.metadata = {"name": f"understudy_{self.task.scenario.name}", **self.metadata}
        self.possible_agents = [f"robot_{robot}" for robot in range(self.task.robots)]
        self.agents: list[str] = []
        each = [self._make_spaces() for _ in self.possible_agents]
        self.observation_spaces = {
            agent: observed for agent, (observed, _) in zip(self.possible_agents, each, strict=True)
        }
        self.action_spaces = {
            agent: acted for agent, (_, acted) in zip(self.possible_agents, each, strict=True)
        }
        self._look_up = self.task.look_up_behaviors if self.task.behaviors else self.task.look_up_channels
        self._generator = np_random(None)[0]

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the observation space of an agent, the same object each time.

        Parameters
        ----------
        agent
            Name of the agent, one of `possible_agents`.

        Returns
        -------
        Space
            The space of its observations.
        """
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        """Return the action space of an agent, the same object each time.

        Parameters
        ----------
        agent
            Name of the agent, one of `possible_agents`.

        Returns
        -------
        Space
            The space of its actions.
        """
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Floats32], dict[str, dict[str, Any]]]:
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
            What each agent observes [F], and an empty mapping for each.
        """
        if seed is not None:
            self._generator = np_random(seed)[0]
        world = int(self._generator.integers(SEEDS)) if seed is None else seed
        self.agents = list(self.possible_agents)
        return dict(zip(self.agents, self.task.reset(world), strict=True)), {
            agent: {} for agent in self.agents
        }

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, Floats32], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Advance one tick.

        Parameters
        ----------
        actions
            For each agent the number of a basic behavior, or a value for each channel.

        Returns
        -------
        tuple
            For each agent what it observes [F], its reward, whether its episode is terminated and truncated, and an
            empty mapping. All are empty once the episode has ended.
        """
        agents = self.agents
        if not agents:
            return {}, {}, {}, {}, {}
        try:
            chosen = [actions[agent] for agent in agents]
        except KeyError as missing:
            raise DefinitionError(
                what=f"actions in {self.task.where}",
                problem=f"they have none for {missing.args[0]!r}",
                remedy=f"give one for each of the {len(agents)} agents",
            ) from None
        observed, reward, terminated, truncated = self.task.step(self._look_up(chosen))
        if terminated or truncated:
            self.agents = []
        return (
            dict(zip(agents, observed, strict=True)),
            dict(zip(agents, reward, strict=True)),
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            {agent: {} for agent in agents},
        )

    def close(self) -> None:
        """Do nothing: an environment holds nothing but memory."""
