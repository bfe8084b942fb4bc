"""Worlds copied in mid-run, and sent to other processes: a copy goes on bit for bit as the original does."""

from __future__ import annotations

import copy
import pickle  # noqa: TID251 - between processes, never from files
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from tests.sim.random_scenarios import draw_commands, draw_world
from tests.sim.test_editing import world
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation import Evaluation
from understudy.model.library import Library
from understudy.runtime.body import list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT, Forage, ForageSettings
from understudy.sim.world import World

Copy = Callable[[Any], Any]
COPIES: dict[str, Copy] = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "deep copy": copy.deepcopy,
    "copy": copy.copy,
}
LIBRARY = Library.from_automata(FORAGE_KIT, *AUTOMATA)
FORAGE = find_scenario("forage")


def assert_goes_on_alike(original: World, copied: World, ticks: int = 40) -> None:
    """Both sense and do the same, and neither reaches into the other."""
    before, keys = original.snapshot(), list_reading_keys(original)
    assert copied.snapshot() == before
    assert copied.time_s == original.time_s
    commands = [draw_commands(np.random.default_rng(seed), original) for seed in range(ticks)]
    seen = []
    for each in commands:
        seen.append(copied.sense(keys))
        copied.act(each)
    assert original.snapshot() == before
    for each, percept in zip(commands, seen, strict=True):
        here = original.sense(keys)
        for key in keys:
            np.testing.assert_array_equal(percept[key], here[key], strict=True)
        original.act(each)
    assert copied.snapshot() == original.snapshot()


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("number", range(4))
def test_a_copy_goes_on_as_the_original(number: int, copied: Copy) -> None:
    original = draw_world(number)
    for tick in range(37):
        original.act(draw_commands(np.random.default_rng(100 + tick), original))
    assert_goes_on_alike(original, copied(original))


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
def test_what_was_changed_by_hand_comes_along(copied: Copy) -> None:
    original = world((0, 1))
    original.add_obstacle(6.5, 4.0, 0.1, world=1)
    original.add_object("food", 5.5, 4.0, amount=2)
    original.freeze(3)
    again = copied(original)
    assert_goes_on_alike(original, again)
    again.reset([7, 8])
    assert again.snapshot() == world((7, 8)).snapshot()


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
def test_a_copy_is_driven_in_one_go_as_the_original(copied: Copy) -> None:
    original = Forage([3, 4], ForageSettings(width=9.0))
    for _ in range(20):
        original.act({"drive": np.ones(2)})
    again = copied(original)
    assert (type(again), again.settings) == (Forage, original.settings)
    for each in (again, original):
        Engine.from_program(each, link(LIBRARY, "forage")).run(500)
    assert again.snapshot() == original.snapshot()


@pytest.mark.long
def test_other_processes_evaluate_a_taught_library() -> None:
    here = [evaluate(LIBRARY, "forage", FORAGE, [seed]) for seed in (5, 6)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        jobs = [pool.submit(evaluate, LIBRARY, "forage", FORAGE, [seed]) for seed in (5, 6)]
        there: list[Evaluation] = [job.result() for job in jobs]
    for one, other in zip(here, there, strict=True):
        assert one.success == other.success == 1.0
        assert one.taught.seconds.tolist() == other.taught.seconds.tolist()
        assert one.relative.tolist() == other.relative.tolist()


def step(body: World, ticks: int) -> World:
    """Let robots drive for so many ticks."""
    for _ in range(ticks):
        body.act({"drive": np.ones(body.agents)})
    return body


@pytest.mark.long
def test_another_process_goes_on_with_a_world() -> None:
    begun = step(World(FORAGE, [1, 2]), 10)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(step, begun, 10).result()
    assert there.snapshot() == step(begun, 10).snapshot()
