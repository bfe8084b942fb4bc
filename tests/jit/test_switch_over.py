"""A run in which compiled kernels take over from plain Python is, bit by bit, the run of either."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.sim.golden import each_in_turn
from tests.sim.random_scenarios import draw_commands, draw_world

from understudy.jit.dispatchers import make_dispatcher
from understudy.runtime.body import list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.sim.kernels.placement import place_objects
from understudy.sim.kernels.tick import run_ticks
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World

TICKS = 24
FIRST = 50
"""The number of ticks after each of which compiled kernels take over in one run."""
WORLDS, QUICK = range(200), range(20)
OTHER_BRANCHES = (24, 31, 62, 63, 110, 126, 129, 151)
"""They reach, with the first 20, every branch of kernels that all of WORLDS reach as plain Python."""
MORE = sorted({*OTHER_BRANCHES, *WORLDS[20::20]})
REST = sorted({*WORLDS} - {*QUICK, *MORE})
KERNELS = (run_ticks, place_objects)


def use(monkeypatch: pytest.MonkeyPatch, *, compiled: bool) -> None:
    """Run the kernels of worlds compiled, or as plain Python."""
    for kernel in KERNELS:
        monkeypatch.setattr(kernel, "run", make_dispatcher(kernel.function) if compiled else kernel.run_plain)


def read_state(world: World) -> bytes:
    """All that a world is, and all that its robots measure."""
    percept = world.sense(list_reading_keys(world))
    readings = b"".join(np.asarray(percept[key]).tobytes() for key in sorted(percept, key=str))
    return readings + b"".join(array.tobytes() for array in world.state)


def play(number: int, switch_at: int, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """A random world whose robots do something else every few ticks; compiled from the tick `switch_at` on."""
    use(monkeypatch, compiled=switch_at == 0)
    world: Any = draw_world(number, worlds=2)
    draw = np.random.default_rng(number)
    commands = draw_commands(draw, world)
    for turn in range(TICKS):
        if turn == switch_at:
            use(monkeypatch, compiled=True)
        if turn % 4 == 0:
            commands = draw_commands(draw, world)
        world.act(commands)
    return read_state(world)


def check(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """All the same: compiled from the first tick on, from one of the others on, and never."""
    compiled = play(number, 0, monkeypatch)
    assert play(number, 1 + number % (TICKS - 1), monkeypatch) == compiled
    assert play(number, TICKS, monkeypatch) == compiled


@pytest.mark.parametrize("number", QUICK)
def test_random_worlds(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    check(number, monkeypatch)


@pytest.mark.long
@pytest.mark.parametrize("number", MORE)
def test_more_random_worlds(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    check(number, monkeypatch)


@pytest.mark.soak
@pytest.mark.parametrize("number", REST)
def test_the_other_random_worlds(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    check(number, monkeypatch)


def test_at_each_of_the_first_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(switch_at: int) -> bytes:
        use(monkeypatch, compiled=False)
        world = World(load_scenario("forage"), (7,))
        engine = Engine.from_program(world, each_in_turn(world))
        for turn in range(FIRST):
            if turn == switch_at:
                use(monkeypatch, compiled=True)
            engine.run(1)
        return read_state(world)

    assert {run(switch_at) for switch_at in range(FIRST + 1)} == {run(0)}
