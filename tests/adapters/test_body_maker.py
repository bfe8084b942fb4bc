"""Functions MODULE:NAME that make worlds: scenarios, bodies and environments; anything else is refused."""

from __future__ import annotations

import numpy as np
import pytest
from tests.own_worlds import NAME, Slope

from understudy.addons.bridges.environments.body_maker import BodyMaker, find_world
from understudy.addons.bridges.environments.gymnasium import GymnasiumBody
from understudy.addons.bridges.environments.pettingzoo import PettingZooBody
from understudy.errors import UnderstudyError
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.schema import Scenario


def make(function: str, seed: int = 0) -> BodyWorld:
    maker = find_world(f"{NAME}:{function}")
    assert isinstance(maker, BodyMaker)
    return BodyWorld(maker, seed, name=maker.name)


def test_a_function_of_the_seed_makes_a_body() -> None:
    maker = find_world(f"{NAME}:make_slope")
    assert isinstance(maker, BodyMaker)
    body = maker(3)
    assert isinstance(body, Slope)
    assert body.x == 3.0
    assert set(maker.find_kit().behaviors) == {"ahead", "back"}


def test_an_environment_becomes_a_body_that_is_reset_with_the_seed() -> None:
    maker = find_world(f"{NAME}:make_cart")
    assert isinstance(maker, BodyMaker)
    body, keys = maker(5), [("obs_2", None)]
    assert isinstance(body, GymnasiumBody)
    assert body.sense(keys) == GymnasiumBody("CartPole-v1", [5]).sense(keys) != maker(6).sense(keys)


@pytest.mark.filterwarnings("ignore:The system font")  # which pursuit asks for
def test_a_parallel_environment_becomes_a_body_with_an_agent_per_robot() -> None:
    world = make("make_pursuit", 5)
    assert isinstance(world.ground, PettingZooBody)
    assert (world.agents, world.robots, len(world.view().robots), world.seeds) == (3, 3, 3, (5,))
    assert world.has_picture


def test_scenarios_are_found_as_before() -> None:
    for name in ("forage", f"{NAME}:make_scenario"):
        found = find_world(name)
        assert isinstance(found, Scenario)
        assert found.name == "forage"


def open_and_find_kit(function: str) -> None:
    make(function)
    BodyMaker(f"{NAME}:{function}").find_kit()


REFUSALS = [  # function, what is said of it
    ("make_number", "'tests.own_worlds:make_number' returned a int; name a function, as MODULE:NAME"),
    ("make_half", "returned a HalfSlope without 'targets'; let it return a body"),
    ("make_bare", "returned a BareSlope without a kit; give the kit: --kit MODULE:NAME"),
    ("make_of_two", "needs 2 arguments (seed, size); name a function"),
    ("make_carts", "makes 2 worlds; let it make one, since the seed is that of one world"),
    ("make_text", "is a Text, which is no list of numbers; wrap the environment"),
    ("make_broken", "it returned an array of float64 of shape (4, 12); return an array of uint8"),
    ("make_failing", "it failed: RuntimeError: no paint; return an array of uint8"),
    ("fail", "raised RuntimeError: no slope today; name a function"),
    ("NAME", "is a str; name a function"),
    ("make_nothing", "cannot be imported: AttributeError"),
]


@pytest.mark.parametrize(("function", "said"), REFUSALS, ids=[name for name, _ in REFUSALS])
def test_refused_in_one_sentence(function: str, said: str) -> None:
    with pytest.raises(UnderstudyError) as raised:
        open_and_find_kit(function)
    assert said in str(raised.value)


def test_a_body_as_a_world() -> None:
    """It has the body's readings, its pictures and its end; one without `reset` is made anew."""
    world = make("make_slope", 8)
    keys = [("x", None)]
    assert (float(world.sense(keys)["x", None][0]), world.is_over, world.seeds) == (8.0, False, (8,))
    assert world.has_picture
    assert world.scenario.size == (0.12, 0.04)
    for _ in range(4):
        world.act({"drive": np.ones(1)})
    assert (float(world.sense(keys)["x", None][0]), world.is_over, world.time_s) == (10.0, True, 2.0)
    assert (int(world.state.tick[0]), world.view().time_s) == (4, 2.0)
    picture = world.render()
    assert picture is not None
    assert picture[0, :, 0].tolist() == [0] * 10 + [255, 0]
    world.reset([2])
    assert (float(world.sense(keys)["x", None][0]), world.is_over, world.time_s, world.seeds) == (
        2.0,
        False,
        0.0,
        (2,),
    )
    assert not make("make_plain").has_picture
