"""A scenario with any number of robots as a parallel environment of PettingZoo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from understudy.adapters.scenario_env import SEEDS, check_render_mode, make_action_space
from understudy.adapters.scenario_task import (
    ABSENT,
    EndFunction,
    Floats32,
    RewardFunction,
    ScenarioTask,
    TaskOptions,
)
from understudy.errors import DefinitionError
from understudy.sim.scenario.schema import Scenario
from understudy.viz.world_picture import draw_world_picture


class ScenarioParallelEnv(ParallelEnv[str, Floats32, Any]):
    """The robots of one world of a scenario, as agents robot_0, robot_1 and so on, that act at the same time.

    All agents have the same spaces. A reading that a robot's type lacks is absent. An episode ends for all agents at
    once. Of one step, the observations of all agents are rows of one array.

    Parameters
    ----------
    scenario
        The scenario, or the name or path of one.
    readings
        The readings to observe, in order, such as "range(station)" or "food_stored"; all if None.
    actions
        "behaviors": an action is the number of a basic behavior (`Discrete`). "channels": an action has a value for
        each channel (`Box`). Or the names of the basic behaviors to choose from.
    reward
        Function of the `World` after a tick that returns the reward of that tick, a number for all robots or one per
        robot. None: the units of food that each robot has unloaded, if food must be delivered; the boxes that all
        have gathered, if boxes must be; 1 for all in the tick in which robots reach the goal's target; 0 if the
        scenario has no goal.
    terminated
        Function of the `World` after a tick that returns whether the episode has ended. None: at the scenario's goal.
    limit_s
        Time after which an episode is truncated, s; the scenario's limit if None.
    absent
        The number that is observed where a reading is absent.
    render_mode
        "rgb_array", to draw the world with `render`; or None.

    Raises
    ------
    SettingError
        If the scenario has no such reading.
    """

    def __init__(
        self,
        scenario: Scenario | str,
        *,
        readings: Sequence[str] | None = None,
        actions: Literal["behaviors", "channels"] | Sequence[str] = "behaviors",
        reward: RewardFunction | None = None,
        terminated: EndFunction | None = None,
        limit_s: float | None = None,
        absent: float = ABSENT,
        render_mode: str | None = None,
    ) -> None:
        options = TaskOptions(
            readings=readings, actions=actions, reward=reward, terminated=terminated, limit_s=limit_s, absent=absent
        )  # fmt: skip
        self.task = ScenarioTask(scenario, options)
        name, fps = f"understudy_{self.task.scenario.name}", round(1.0 / self.task.scenario.tick_s)
        self.metadata = {"name": name, "render_modes": ["rgb_array"], "render_fps": fps}
        self.render_mode = check_render_mode(render_mode, where=self.task.where)
        self.possible_agents = [f"robot_{robot}" for robot in range(self.task.robots)]
        self.agents: list[str] = []
        box = (self.task.low, self.task.high)
        self.observation_spaces = {
            agent: spaces.Box(*box, dtype=np.float32) for agent in self.possible_agents
        }
        self.action_spaces = {agent: make_action_space(self.task) for agent in self.possible_agents}
        self._look_up = self.task.look_up_behaviors if self.task.behaviors else self.task.look_up_channels
        self._generator = np_random(None)[0]

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the observation space of an agent, the same object each time."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the action space of an agent, the same object each time."""
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

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the world [height, width, 3]; None without a render mode."""
        return None if self.render_mode is None else draw_world_picture(self.task.world.view())

    def close(self) -> None:
        """Do nothing: an environment holds nothing but memory."""
