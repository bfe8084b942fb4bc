"""Parallel environments of PettingZoo as bodies: agents that share a world, leave it one by one, and are taught."""

from __future__ import annotations

from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
import pytest
from gymnasium import spaces
from pettingzoo import ParallelEnv

from understudy import Library, Session, evaluate, new_lesson
from understudy.addons.bridges.environments.gymnasium import GymnasiumBody
from understudy.addons.bridges.environments.pettingzoo import PettingZooBody
from understudy.errors import UnderstudyError
from understudy.testing import check_behavior, check_body, check_world

make_pursuit = partial(
    pettingzoo.make,
    "parallel",
    "sisl/pursuit-v5",
    x_size=8,
    y_size=8,
    n_pursuers=2,
    n_evaders=3,
    max_cycles=20,
)


class Stairs(ParallelEnv[str, Any, int]):
    """Two agents climb: the action is added to the height. Ann ends above 3, and all are cut off after 4 steps."""

    metadata = {"name": "stairs", "render_modes": ["rgb_array"], "render_fps": 2}  # noqa: RUF012
    possible_agents = ["ann", "bob"]  # noqa: RUF012
    render_mode = "rgb_array"

    def observation_space(self, agent: str) -> spaces.Box:
        return spaces.Box(0, 100, (1,))

    def action_space(self, agent: str) -> spaces.Discrete:
        return spaces.Discrete(3)

    def reset(self, seed: int | None = None, options: Any = None) -> Any:
        self.agents = list(self.possible_agents)
        self.height = dict.fromkeys(self.agents, float(seed or 0))
        self.steps = 0
        return self.observe(), {agent: {} for agent in self.agents}

    def observe(self) -> dict[str, Any]:
        return {agent: np.array([self.height[agent]], np.float32) for agent in self.agents}

    def step(self, actions: dict[str, int]) -> Any:
        if set(actions) != set(self.agents):
            raise ValueError(f"actions of {sorted(actions)}, and {self.agents} are there")
        self.steps += 1
        for agent, action in actions.items():
            self.height[agent] += action
        ended = {agent: agent == "ann" and self.height[agent] > 3 for agent in self.agents}
        cut = dict.fromkeys(self.agents, self.steps == 4)
        seen, rewards = self.observe(), {agent: float(actions[agent]) for agent in self.agents}
        self.agents = [agent for agent in self.agents if not (ended[agent] or cut[agent])]
        return seen, rewards, ended, cut, {agent: {} for agent in seen}

    def render(self) -> Any:
        return np.full((2, 3, 3), self.steps, np.uint8)


NAN = float("nan")
STEPS = [  # actions of ann and bob; then their height, reward, return, terminated, truncated, over
    ((2, 0), (2, 0), (2, 0), (2, 0), (0, 0), (0, 0), (0, 0)),
    ((2, 1), (NAN, 1), (2, 1), (4, 1), (1, 0), (0, 0), (1, 0)),  # ann is above 3, and leaves
    ((2, 1), (NAN, 2), (0, 1), (4, 2), (1, 0), (0, 0), (1, 0)),  # her command is ignored
    ((0, 2), (NAN, NAN), (0, 2), (4, 4), (1, 0), (0, 1), (1, 1)),  # bob is cut off
    ((1, 1), (NAN, NAN), (0, 0), (4, 4), (1, 0), (0, 1), (1, 1)),  # nothing happens any more
]
COLUMNS = ("height", "reward", "return", "terminated", "truncated")


def read(body: PettingZooBody, name: str) -> list[float]:
    values: list[float] = body.sense([(name, None)])[name, None].tolist()
    return values


def test_agents_leave_one_by_one() -> None:
    body = PettingZooBody(Stairs, names=["height"])
    assert (body.agents, body.robots, body.worlds, body.tick_s, body.name) == (2, 2, 1, 0.5, "stairs")
    for actions, *columns, over in STEPS:
        body.act({"action": np.array(actions, float)})
        for name, column in zip(COLUMNS, columns, strict=True):
            np.testing.assert_equal(read(body, name), column, name)
        assert body.is_over.tolist() == list(map(bool, over))
    assert body.returns.tolist() == [4, 4]
    assert body.time_s == 2.5
    body.reset([1])
    assert (read(body, "height"), bool(body.is_over.any()), body.time_s) == ([1.0, 1.0], False, 0.0)


def test_worlds_are_rows_after_each_other() -> None:
    """Agent 1 of world 1 is agent 3; a world whose agents have left waits for the others."""
    body = PettingZooBody(Stairs, [0, 2], names=["height"])
    body.act({"action": np.array([0, 1, 2, 1])})
    np.testing.assert_equal(read(body, "height"), [0, 1, NAN, 3])
    for _ in range(3):
        body.act({"action": np.zeros(4)})
    assert body.is_over.all()
    one = body.with_seeds([5])
    assert (read(one, "height"), one.agents) == ([5.0, 5.0], 2)


def test_environments_keep_the_laws_of_bodies() -> None:
    for make in (Stairs, make_pursuit):
        body = PettingZooBody(make, [1, 2])
        check_body(body)
        check_world(lambda seeds, make=make: PettingZooBody(make, seeds), seeds=[1, 2])  # type: ignore[misc]
        for behavior in body.behaviors[:2]:
            check_behavior(behavior, body)


def test_rendered() -> None:
    body = PettingZooBody(Stairs)
    body.act({})
    picture = body.render()
    assert picture is not None
    assert picture.tolist() == np.full((2, 3, 3), 1).tolist()
    assert PettingZooBody(make_pursuit).render() is None


def test_taught_and_evaluated() -> None:
    """Agent 0 is shown to stop at 3; both then do it in worlds that were not shown."""
    make = partial(PettingZooBody, Stairs, names=["height"], behaviors=["stay", "one", "two"])
    body = make()
    lesson = new_lesson(Library(body.kit), "climb", states=["one", "stay"], features=["height"], live=False)
    session = Session(body, Library(body.kit), lesson)
    session.direct("one")
    session.run_for(1.5)
    session.direct("stay")
    session.tick()
    library = Library(body.kit).with_automaton(session.make_trained_automaton())
    result = evaluate(
        library,
        "climb",
        lambda seed: make([seed]),
        range(4),
        goal="truncated",
        metrics=["return"],
        limit_s=3.0,
    )
    assert result.taught.finished.tolist() == [
        True,
        True,
        True,
        False,
    ]  # begun at 3, the first step is too much
    assert result.metrics["return"].tolist() == [3.0, 2.0, 1.0, 1.0]


class CartPoleOfOne(ParallelEnv[str, Any, Any]):
    """CartPole of Gymnasium as a parallel environment whose only agent is the cart."""

    possible_agents = ["cart"]  # noqa: RUF012

    def __init__(self) -> None:
        self.inner = gymnasium.make("CartPole-v1")
        self.metadata = self.inner.metadata

    def observation_space(self, agent: str) -> Any:
        return self.inner.observation_space

    def action_space(self, agent: str) -> Any:
        return self.inner.action_space

    def reset(self, seed: int | None = None, options: Any = None) -> Any:
        self.agents = ["cart"]
        return {"cart": self.inner.reset(seed=seed)[0]}, {"cart": {}}

    def step(self, actions: dict[str, Any]) -> Any:
        seen, reward, terminated, truncated, _ = self.inner.step(actions["cart"])
        self.agents = [] if terminated or truncated else ["cart"]
        return {"cart": seen}, {"cart": reward}, {"cart": terminated}, {"cart": truncated}, {"cart": {}}


def test_an_environment_of_gymnasium_is_a_parallel_one_with_one_agent() -> None:
    """Two carts pushed alike fall alike; one that has fallen is seen where it fell by Gymnasium only."""
    alone, parallel = (
        GymnasiumBody("CartPole-v1", [3], tick_s=0.5).with_seeds([1, 2]),
        PettingZooBody(CartPoleOfOne, [3], tick_s=0.5).with_seeds([1, 2]),
    )
    keys = [(reading.name, None) for reading in alone.readings]
    while not alone.is_over.all():
        for body in (alone, parallel):
            body.act({"action": np.array([1.0, 2.0 * (body.time_s % 1.0)])})
        seen, other = alone.sense(keys), parallel.sense(keys)
        for key in keys[-4:]:
            np.testing.assert_array_equal(seen[key], other[key], key[0])
        for key in keys[:-4]:
            np.testing.assert_array_equal(seen[key][~alone.is_over], other[key][~alone.is_over], key[0])
            assert np.isnan(other[key][alone.is_over]).all()
            assert not np.isnan(seen[key]).any()
        assert parallel.is_over.tolist() == alone.is_over.tolist()
    assert alone.returns.tolist() == parallel.returns.tolist()
    assert alone.time_s == parallel.time_s
    assert alone.returns[0] < alone.returns[1]


class Unequal(Stairs):
    def action_space(self, agent: str) -> spaces.Discrete:
        return spaces.Discrete(3 if agent == "ann" else 4)


class Wordy(Stairs):
    def observation_space(self, agent: str) -> Any:
        return spaces.Text(5)


class Broken(Stairs):
    def step(self, actions: dict[str, int]) -> Any:
        raise RuntimeError("no stairs")


NUMBER: Any = 3
one_environment = Stairs()
REFUSALS: list[tuple[Any, str]] = [
    (lambda: PettingZooBody(NUMBER), "make is a int; give a function that makes a parallel environment"),
    (lambda: PettingZooBody(lambda: NUMBER), "make returned a int; return a pettingzoo.ParallelEnv"),
    (
        lambda: PettingZooBody(partial(pettingzoo.make, "aec", "sisl/pursuit-v5")),
        "make returned a OrderEnforcingWrapper; return a pettingzoo",
    ),
    (lambda: PettingZooBody(lambda: one_environment, [1, 2]), "returned the same environment twice"),
    (lambda: PettingZooBody(one_environment, [1, 2]), "is one environment for 2 seeds"),
    (lambda: PettingZooBody(one_environment).with_seeds([1]), "there can be only one"),
    (lambda: PettingZooBody(Stairs, []), "seeds are none"),
    (
        lambda: PettingZooBody(Stairs, [-1]),
        "environment stairs: seeds are [-1]; give 1 whole numbers from 0 up",
    ),
    (lambda: PettingZooBody(Unequal), "action spaces of ann and bob differ; wrap the environment"),
    (lambda: PettingZooBody(Wordy), "is a Text, which is no list of numbers; wrap"),
    (
        lambda: PettingZooBody(Broken).act({}),
        "its step failed: RuntimeError: no stairs; correct the environment",
    ),
    (
        lambda: PettingZooBody(Stairs).act({"action": np.array([0, 3])}),
        "it is 3 for agent 1 of environment stairs; give a whole number from 0 to 2",
    ),
]


@pytest.mark.parametrize(("do", "sentence"), REFUSALS, ids=[sentence[:40] for _, sentence in REFUSALS])
def test_refused(do: Any, sentence: str) -> None:
    with pytest.raises(UnderstudyError) as raised:
        do()
    assert sentence in str(raised.value)
