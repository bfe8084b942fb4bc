"""Every world that ships: nothing overlaps in it, and it runs as it did before; see also `test_catalog.py`."""

from __future__ import annotations

from math import tau

import pytest
from tests.sim import golden
from tests.sim.laws import check_percept, check_state, check_tick, copy_state
from tests.sim.random_scenarios import draw_commands

from understudy.runtime.body import list_reading_keys
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario
from understudy.sim.world import World

RENEW = "the run changed; if it is meant to, bring it up to date with: python -m tests.sim.golden"


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_nothing_overlaps_leaves_or_is_lost(name: str) -> None:
    import numpy as np

    world = World(load_scenario(name), (4, 5, 6))
    draw, keys = np.random.default_rng(7), list_reading_keys(world)
    commands = draw_commands(draw, world)
    for tick in range(200):
        if tick % 10 == 0:
            commands = draw_commands(draw, world)
            check_percept(world, world.sense(keys))
        before = copy_state(world)
        world.act(commands)
        check_tick(world, before, commands)
        check_state(world)


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_golden_run(name: str) -> None:
    for now, then in zip(golden.moments(name), golden.read_golden(name), strict=True):
        assert now["counts"] == then["counts"], RENEW
        assert list(now["measures"]) == list(then["measures"]), RENEW
        for what, values in now["measures"].items():
            for value, before in zip(values, then["measures"][what], strict=True):
                if (
                    value is None
                    or before is None
                    or what.split(" of ")[0] not in ("bearing", "heading", "robots heading")
                ):
                    assert value == (before if before is None else pytest.approx(before, abs=1e-6)), (
                        what,
                        RENEW,
                    )
                else:  # on the circle
                    assert abs((value - before + tau / 2) % tau - tau / 2) < 1e-6, (what, RENEW)


def test_there_is_a_golden_run_of_each_and_no_other() -> None:
    assert {file.stem for file in golden.FOLDER.glob("*.json")} == set(list_builtin_scenarios())
