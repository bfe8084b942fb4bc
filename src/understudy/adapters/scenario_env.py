"""A scenario with one robot as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from understudy.adapters.scenario_task import (
    ABSENT,
    EndFunction,
    Floats32,
    RewardFunction,
    ScenarioTask,
    TaskOptions,
)
from understudy.errors import SettingError
from understudy.sim.scenario.schema import Scenario
from understudy.viz.world_picture import draw_world_picture

SEEDS = 2**31
"""The number of worlds from which a reset without a seed draws one."""


class ScenarioEnv(gymnasium.Env[Floats32, Any]):
    """The world of a scenario with one robot, as an environment for reinforcement learning.

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
        Function of the `World` after a tick that returns the reward of that tick. None: the units of food unloaded,
        if food must be delivered; the boxes gathered, if boxes must be; 1 in the tick in which the robot reaches the
        goal's target; 0 if the scenario has no goal.
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
        If the scenario has more than one robot, or no such reading.

    Notes
    -----
    An observation is a `Box` with a float32 per reading. Angles are in radians from 0 to 2π, and a categorical reading
    is the index of its label. A reset without a seed draws the world; with a seed, the world is that of the seed.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 (as its base has it)

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
        if self.task.robots != 1:
            raise SettingError(
                where=self.task.where,
                setting="robots",
                problem=f"are {self.task.robots}, and a Gymnasium environment has one",
                remedy="use understudy.adapters.pettingzoo.ScenarioParallelEnv",
            )
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self.task.scenario.tick_s)}
        self.render_mode = check_render_mode(render_mode, where=self.task.where)
        self.observation_space = spaces.Box(self.task.low, self.task.high, dtype=np.float32)
        self.action_space = make_action_space(self.task)
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

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the world [height, width, 3]; None without a render mode."""
        return None if self.render_mode is None else draw_world_picture(self.task.world.view())


def check_render_mode(mode: str | None, *, where: str) -> str | None:
    """Return a render mode; raise SettingError if it is neither None nor "rgb_array"."""
    if mode not in (None, "rgb_array"):
        raise SettingError(
            where=where, setting="render_mode", problem=f"is {mode!r}", remedy='give "rgb_array" or None'
        )
    return mode


def make_action_space(task: ScenarioTask) -> spaces.Space[Any]:
    """Make the action space of one robot: `Discrete` over basic behaviors, or `Box` over channels."""
    if task.behaviors:
        return spaces.Discrete(len(task.behaviors))
    return spaces.Box(task.least, task.most, dtype=np.float32)
