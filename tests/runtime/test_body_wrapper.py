"""A wrapper passes on what every body has, and claims nothing that only some bodies can do."""

from __future__ import annotations

import numpy as np

from understudy.runtime.body import (
    BODY_ATTRIBUTES,
    Fused,
    Resettable,
    Rewindable,
    SeededBody,
    SkillPerformer,
    Viewable,
    list_reading_keys,
)
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World
from understudy.testing import check_body


def make_world(seed: int) -> World:
    return World(load_scenario("forage-team"), [seed])


def test_a_bare_wrapper_is_the_body_below() -> None:
    wrapper, world = BodyWrapper(make_world(3)), make_world(3)
    for name in ("agents", "readings", "targets", "channels", "tick_s"):
        assert getattr(wrapper, name) == getattr(world, name)
    for _ in range(5):
        for body in (wrapper, world):
            body.act({"drive": np.ones(body.agents)})
        assert wrapper.time_s == world.time_s > 0
        seen, wanted = (body.sense(list_reading_keys(world)) for body in (wrapper, world))
        for key, column in wanted.items():
            np.testing.assert_array_equal(seen[key], column, str(key))
    check_body(BodyWrapper(make_world(4)))


def test_what_only_some_bodies_can_do_is_left_to_subclasses() -> None:
    wrapper = BodyWrapper(make_world(1))
    for ability in (Rewindable, Resettable, Viewable, SeededBody, SkillPerformer, Fused):
        assert isinstance(wrapper.ground, ability)
        assert not isinstance(wrapper, ability)
    assert {name for name in dir(wrapper) if not name.startswith("_")} == {*BODY_ATTRIBUTES, "ground"}


def test_another_body_below_is_passed_on_from_then_on() -> None:
    class Moving(BodyWrapper[World]):
        def move_to(self, world: World) -> None:
            self._stand_on(world)

    alone = World(load_scenario("forage"), [1])
    moving = Moving(make_world(1))
    moving.act({})
    moving.move_to(alone)
    assert (moving.agents, moving.time_s, moving.readings) == (1, 0.0, alone.readings)
