"""Gymnasium environments as bodies: spaces as readings, channels and behaviors, and refusals in one sentence."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

from understudy.addons.bridges.environments.gymnasium import GymnasiumBody
from understudy.errors import UnderstudyError
from understudy.model.value_kinds import BOOLEAN, Toroidal
from understudy.testing import check_behavior, check_body, check_world

ENVIRONMENTS = ["CartPole-v1", "LunarLander-v3", "Pendulum-v1", "FrozenLake-v1", "Blackjack-v1"]


class Nested(gymnasium.Env[Any, Any]):
    """An environment with nested spaces, which asserts that its actions are elements of its action space."""

    observation_space = spaces.Dict(
        {
            "pos": spaces.Box(-1, 1, (2,)),
            "t": spaces.Tuple((spaces.Discrete(3, start=5), spaces.MultiBinary(2))),
        }
    )
    action_space = spaces.Dict({"m": spaces.Box(-1, 1, (2,)), "k": spaces.MultiDiscrete([2, 3])})

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        return self.observe(), {}

    def step(self, action: Any) -> Any:
        if action not in self.action_space:
            raise ValueError(f"{action} is not in the action space")
        return self.observe(), 1.0, False, False, {}

    def observe(self) -> Any:
        return {"pos": np.array([0.5, np.inf], np.float32), "t": (np.int64(7), np.array([0, 1], np.int8))}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_registered_environments_keep_the_laws_of_bodies(name: str) -> None:
    body = GymnasiumBody(name, [1, 2])
    check_body(body)
    check_world(lambda seeds: GymnasiumBody(name, seeds), seeds=[1, 2])
    for behavior in body.behaviors:
        check_behavior(behavior, body)


def test_nested_spaces_become_dotted_names() -> None:
    body = GymnasiumBody(Nested, [0])
    check_body(body)
    assert [reading.name for reading in body.readings[:5]] == ["pos.0", "pos.1", "t.0", "t.1.0", "t.1.1"]
    assert [channel.name for channel in body.channels] == ["k.0", "k.1", "m.0", "m.1"]
    percept = body.sense([("pos.0", None), ("pos.1", None), ("t.0", None), ("t.1.1", None)])
    assert percept["pos.0", None] == [0.5]
    assert np.isnan(percept["pos.1", None])  # infinite: absent
    assert percept["t.0", None] == [2.0]  # the third label, "7"
    assert body.readings[2].kind.labels == ("5", "6", "7")  # type: ignore[union-attr]


def test_names_units_kinds_and_behaviors_are_given() -> None:
    body = GymnasiumBody(
        "CartPole-v1",
        names=["x", "speed", "angle", "spin"],
        units={"x": "m"},
        kinds={"angle": Toroidal()},
        behaviors=["left", "right"],
    )
    assert [reading.name for reading in body.readings[:4]] == ["x", "speed", "angle", "spin"]
    assert (body.readings[0].unit, body.readings[2].kind) == ("m", Toroidal())
    assert [behavior.name for behavior in body.behaviors] == ["left", "right"]
    assert body.behaviors[1].command["action"] == 1.0
    assert body.tick_s == pytest.approx(0.02)
    assert set(body.kit.features) >= {"x", "angle", "return", "terminated", "time_in_state"}


def test_an_ended_episode_stays_as_it_is() -> None:
    body = GymnasiumBody("CartPole-v1", [3])
    while not body.is_over[0]:
        body.act({"action": np.ones(1)})
    keys = [(reading.name, None) for reading in body.readings if reading.name != "reward"]
    before, returned = body.sense(keys), body.returns
    body.act({"action": np.zeros(1)})
    assert body.sense(keys) == before
    assert body.returns == returned > 0
    assert body.sense([("reward", None)])["reward", None] == [0.0]
    assert next(each.kind for each in body.readings if each.name == "terminated") == BOOLEAN
    body.reset([3])
    assert not body.is_over[0]


def test_rendered() -> None:
    picture = GymnasiumBody("CartPole-v1").render()
    assert picture is not None
    assert picture.shape[2] == 3
    assert GymnasiumBody(Nested).render() is None


class Strange(Nested):
    """An environment whose observation is a text."""

    observation_space = spaces.Text(5)  # type: ignore[assignment]


REFUSALS = [
    (lambda: GymnasiumBody("Nope-v0"), "'Nope-v0' cannot be made"),
    (lambda: GymnasiumBody(3), "make is a int; give the name"),  # type: ignore[arg-type]
    (lambda: GymnasiumBody(lambda: 4), "make returned a int; return a gymnasium.Env"),  # type: ignore[arg-type, return-value]
    (lambda: GymnasiumBody(Strange), "is a Text, which is no list of numbers; wrap"),
    (
        lambda: GymnasiumBody("CartPole-v1", names=["a"]),
        "names are 1 for 4 numbers; give one for each of obs_0",
    ),
    (lambda: GymnasiumBody("CartPole-v1", behaviors=["a"]), "give 2 names"),
    (
        lambda: GymnasiumBody("CartPole-v1", behaviors={"a": {"action": 2.0}}),
        "give a whole number from 0 to 1",
    ),
    (lambda: GymnasiumBody("CartPole-v1", units={"y": "m"}), "has no reading for units 'y'"),
    (lambda: GymnasiumBody("CartPole-v1", [-1]), "give 1 whole numbers from 0 up"),
    (
        lambda: GymnasiumBody("CartPole-v1").act({"action": np.array([7.0])}),
        "it is 7 for agent 0 of environment CartPole-v1; give a whole number from 0 to 1",
    ),
    (
        lambda: GymnasiumBody("Pendulum-v1").act({"action_0": np.array([2.5])}),
        "give a finite number from -2 to 2",
    ),
]


@pytest.mark.parametrize(("attempt", "said"), REFUSALS, ids=[said for _, said in REFUSALS])
def test_refusals_name_what_would_be_right(attempt: Any, said: str) -> None:
    with pytest.raises(UnderstudyError) as refused:
        attempt()
    assert said in str(refused.value)
