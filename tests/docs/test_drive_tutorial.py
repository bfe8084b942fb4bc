"""The tutorial of the drive, driven by a script: the labels, the rules, and that the robot goes by itself."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from pathlib import Path

import numpy as np
import pytest
from tests.inline_executor import InlineExecutor
from tests.ui.controller.test_live_drive import LEFT, RIGHT, Scripted

from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World
from understudy.ui.controller import live_drive
from understudy.ui.controller.live_drive import LiveDrive
from understudy.ui.controller.stick import StickPosition

FEATURES = "angle_to(nearest_food),food_below_me"
LOAD = StickPosition(held=frozenset({0}))


class Person:
    """Turns to the nearest food, drives there with a hand that trembles, and loads."""

    def __init__(self, seed: int) -> None:
        self._random, self._turns = np.random.default_rng(seed), True

    def __call__(self, live: LiveDrive) -> StickPosition:
        if live.percept["food_here", None][0] > 0:
            return LOAD
        angle = (float(live.percept["bearing", "nearest_food"][0]) + pi) % (2 * pi) - pi
        self._turns = abs(angle) > (0.08 if self._turns else 0.3)
        if self._turns:
            return LEFT if angle > 0 else RIGHT
        return StickPosition(0.04 * self._random.standard_normal(), 0.95)


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scripted]:
    """Four worlds, half a minute each; labels are found at once, in the same thread."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(live_drive, "ThreadPoolExecutor", InlineExecutor)
        yield drive_in_four_worlds(tmp_path_factory.mktemp("drive"))


def drive_in_four_worlds(folder: Path) -> Scripted:
    scripted = Scripted(folder, features=FEATURES)
    for seed in (3, 4, 5, 6):
        if seed != 3:
            scripted.live.begin_world(seed)
        scripted.live.drive()
        scripted.drive(Person(seed), 30)
        scripted.pause()
    return scripted


@pytest.mark.long
def test_the_drive_is_understood(driven: Scripted) -> None:
    review = driven.live.find_review()
    assert {label for label, _, _ in driven.spans} == {"forward", "rotate_left", "rotate_right", "load_food"}
    assert review.learn().agreement.share > 0.97


@pytest.mark.long
def test_the_robot_goes_by_itself(driven: Scripted) -> None:
    """In 20 new worlds it has food, or loads it, within a minute."""
    taught = driven.live.find_review().learn().taught
    scenario = load_scenario("forage")
    library = Library(make_scenario_kit(scenario)).with_automaton(taught)
    world = World(scenario, range(100, 120))
    engine = Engine.from_program(world, link(library, taught.automaton.name))
    loaded = np.zeros(20, np.bool_)
    for _ in range(600):
        engine.tick()
        loaded |= world.sense([("food_stored", None)])["food_stored", None] > 0
    assert loaded.sum() >= 18
