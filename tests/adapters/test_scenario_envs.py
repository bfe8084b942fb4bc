"""Scenarios as environments of Gymnasium and PettingZoo: the checkers of both, rewards, ends and refusals."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from understudy.addons.bridges.environments.gymnasium import ScenarioEnv
from understudy.addons.bridges.environments.pettingzoo import ScenarioParallelEnv
from understudy.errors import UnderstudyError
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # PettingZoo's tests import an environment in a way that it calls old
    from pettingzoo.test import parallel_api_test, parallel_seed_test

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*:UserWarning"
)  # the checkers' advice, such as to limit ranges


@pytest.mark.parametrize("actions", ["behaviors", "channels"])
def test_a_scenario_passes_the_checker_of_gymnasium(actions: Any) -> None:
    check_env(ScenarioEnv("forage", actions=actions, render_mode="rgb_array"))


@pytest.mark.parametrize("actions", ["behaviors", "channels"])
@pytest.mark.parametrize("scenario", ["forage", "forage-team", "patrol"])
def test_a_scenario_passes_the_tests_of_pettingzoo(scenario: str, actions: Any) -> None:
    parallel_api_test(ScenarioParallelEnv(scenario, actions=actions, limit_s=3), num_cycles=50)
    parallel_seed_test(lambda: ScenarioParallelEnv(scenario, actions=actions, limit_s=3), num_cycles=20)


def test_steps_are_those_of_the_world() -> None:
    env, world = ScenarioParallelEnv("forage-team"), World(load_scenario("forage-team"), [5])
    observed, _ = env.reset(seed=5)
    forward = env.task.behaviors.index("forward")
    keys = env.task.keys
    for _ in range(20):
        percept = world.sense(keys)
        for robot, agent in enumerate(env.agents):
            values = np.array([percept[key][robot] for key in keys])
            np.testing.assert_array_equal(
                observed[agent], np.where(np.isnan(values), -1.0, values).astype(np.float32)
            )
        observed, *_ = env.step(dict.fromkeys(env.agents, forward))
        world.act({"drive": np.ones(world.agents)})


def test_unloaded_food_is_rewarded_and_the_goal_ends_the_episode() -> None:
    from understudy.sim.forage import ForageSettings

    settings = ForageSettings(stored=3, sources=(0, 0), starts_at_station=True)
    env = ScenarioEnv(settings.scenario())
    env.reset(seed=1)
    unload, rewards, terminated = env.task.behaviors.index("unload_food"), list[float](), False
    truncated = False
    while not terminated and len(rewards) < 100:
        _, reward, terminated, truncated, _ = env.step(unload)
        rewards.append(reward)
    assert (sum(rewards), max(rewards), terminated, truncated) == (3.0, 1.0, True, False)


def test_reward_end_and_limit_of_ones_own() -> None:
    env = ScenarioEnv("forage", reward=lambda world: world.time_s, limit_s=1.0)
    env.reset(seed=1)
    steps = [env.step(0) for _ in range(10)]
    assert [step[1] for step in steps[:2]] == pytest.approx([0.1, 0.2])
    assert [step[3] for step in steps] == [False] * 9 + [True]
    ends = ScenarioEnv("forage", terminated=lambda world: world.time_s > 0.15)
    ends.reset(seed=1)
    assert [ends.step(0)[2] for _ in range(2)] == [False, True]


def test_chosen_readings_and_behaviors() -> None:
    env = ScenarioEnv("forage", readings=["range(station)", "food_stored"], actions=["forward", "load_food"])
    assert env.observation_space.shape == (2,)
    assert env.action_space.n == 2  # type: ignore[attr-defined]


REFUSALS = [
    (
        lambda: ScenarioEnv("forage-team"),
        "use understudy.addons.bridges.environments.pettingzoo.ScenarioParallelEnv",
    ),
    (lambda: ScenarioEnv("forage", readings=["sonar"]), "has no reading 'sonar'"),
    (lambda: ScenarioEnv("forage", readings=[]), "readings are none"),
    (lambda: ScenarioEnv("forage", actions=["fly"]), "has no basic behavior 'fly'"),
    (lambda: ScenarioEnv("forage", render_mode="human"), 'give "rgb_array" or None'),
    (lambda: _step(ScenarioEnv("forage"), 99), "it is 99; give a whole number from 0 to"),
    (lambda: _step(ScenarioEnv("forage"), "up"), "give a whole number from 0 to"),
    (
        lambda: _step(ScenarioEnv("forage", actions="channels"), [0, 9, 0, 0]),
        "give 4 numbers: drive from -1 to 1",
    ),
    (lambda: _step(ScenarioEnv("forage", reward=lambda _: np.nan), 0), "return a finite number"),
    (lambda: _step(ScenarioParallelEnv("forage-team"), {"robot_0": 0}), "they have none for 'robot_1'"),
]


def _step(env: Any, action: Any) -> None:
    env.reset(seed=1)
    env.step(action)


@pytest.mark.parametrize(("attempt", "said"), REFUSALS, ids=[said for _, said in REFUSALS])
def test_refusals_name_what_would_be_right(attempt: Any, said: str) -> None:
    with pytest.raises(UnderstudyError) as refused:
        attempt()
    assert said in str(refused.value)
