"""What kernels work out, as one hash a case, so that the modes they run in can be compared (UNDERSTUDY_KERNELS).

As a script it prints the hashes of all cases: a mode is chosen once, where kernels are imported.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from hashlib import sha256
from math import isnan, nan
from random import Random
from typing import Any

import numpy as np
from tests.runtime.random_libraries import draw_library, draw_program, play_random_body
from tests.sim.golden import each_in_turn
from tests.sim.random_scenarios import draw_commands, draw_pulling_world, draw_world

from understudy.learning._linalg_kernels import invert_matrix
from understudy.learning.tree_growth import grow_tree
from understudy.model.tree import Tree
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal
from understudy.runtime.body import list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.sim.scenario.files import load_scenario
from understudy.sim.team.libraries import make_team
from understudy.sim.world import World
from understudy_lab.bench import standard_task
from understudy_lab.bench.handwritten_baseline import HandwrittenBaseline
from understudy_lab.tasks.swarm_world import SWARM, make_expert_libraries, of_platoons

TICKS, SEEDS = 40, (5, 6)
SCENARIOS = ("arena", "forage", "patrol", "rooms")
RANDOM, PULLING, PULSES, TREES = (2, 3, 5, 7, 9), (2, 4, 6, 8, 10), (2, 6), (2, 11)
"""Numbers of random cases. All cases together reach every branch that twelve of each kind, with all scenarios, do."""


def cases() -> Iterator[tuple[str, Callable[[], bytes]]]:
    """All cases: names, and what gives the bytes to compare."""
    for name in SCENARIOS:
        yield name, partial(_run, name)
    for number in RANDOM:
        yield f"random {number}", partial(_obey, draw_world, number)
    for number in PULLING:
        yield f"pulling {number}", partial(_obey, draw_pulling_world, number)
    yield "squads", _lead
    for number in PULSES:
        yield f"pulses {number}", partial(_pulse, number)
    for number in TREES:
        yield f"tree {number}", partial(_grow, number)
    yield "prototype", _by_hand
    yield "inverse", _invert


def _run(name: str) -> bytes:
    """A built-in scenario in which all robots do the same simple program."""
    world = World(load_scenario(name), SEEDS)
    engine = Engine.from_program(world, each_in_turn(world))
    engine.run(TICKS)
    return _state(world)


def _obey(make: Callable[..., World], number: int) -> bytes:
    """A random world whose robots do something else every few ticks."""
    world = make(number, worlds=2)
    draw = np.random.default_rng(number)
    for _ in range(TICKS // 4):
        commands = draw_commands(draw, world)
        for _ in range(4):
            world.act(commands)
    return _state(world)


def _lead() -> bytes:
    """A platoon under its coordinators."""
    team = make_team(of_platoons(1), [0], make_expert_libraries(), {SWARM: ("swarm_work", {})})
    team.run(TICKS)
    world: Any = team.ground
    return _state(world)


def _pulse(number: int) -> bytes:
    """Random programs on random readings."""
    random = Random(number)
    library = draw_library(random)
    body = play_random_body(random, agents=6, ticks=20)
    engine = Engine(body, [draw_program(random, library) for _ in range(6)])
    engine.run(20)
    return repr((body.commanded, [engine.path(agent) for agent in range(6)])).encode()


def _grow(number: int) -> bytes:
    """A tree of random examples on a coarse grid, some readings absent."""
    random = Random(number)
    kinds: list[Kind] = [Continuous(), Toroidal(), Categorical(("no", "some", "many"))]
    values = [
        [random.choice((0.0, 0.5, 1.0, 2.0, nan)), random.random(), random.choice((0.0, 1.0, 2.0, nan))]
        for _ in range(60)
    ]
    outcomes = [random.randrange(4) if random.random() < 0.3 else int(row[0] == 1.0) for row in values]
    groups = [random.randrange(3 if random.random() < 0.5 else 2) for _ in values]
    apart = [3 if row[0] == 2.0 else outcome % 3 for row, outcome in zip(values, outcomes, strict=True)]
    trees = [
        grow_tree(
            np.array(values), np.array(shown), np.array(groups), kinds, states=4, current=0, flags=flags
        )
        for shown, flags in ((outcomes, ()), (outcomes, (1,)), (apart, (3,)))
    ]
    pressed = np.minimum(np.array(groups), 1)
    trees += [grow_tree(np.array(values), np.array(outcomes), pressed, kinds, states=4, current=0)]
    trees += [grow_tree(np.array(values)[:, 1:2], np.array(outcomes), pressed, [Continuous()], states=4)]
    by_label = np.array([3 if isnan(row[2]) else int(row[2]) for row in values])
    trees += [grow_tree(np.array(values)[:, 2:], by_label, pressed, kinds[2:], states=4)]
    return repr(
        [*trees, _limit_decisions(random), *(_tell_two_flags_apart(each) for each in (False, True))]
    ).encode()


def _tell_two_flags_apart(default_among: bool) -> Tree:
    """Grow a tree with two flags that no one test tells from all else, but each alone; or with a default beside one."""
    rows = [
        (5.0, 0.0, 0, 0),
        (4.0, 0.0, 1, 1),
        (1.1, 0.0, 0, 0),
        (0.9, 0.0, 1, 1),
        (0.3, 0.0, 2, 1),
        (2.2, 1.0, 3, 1),
    ]
    rows += [(2.5, 1.0, 0, 0), (0.35, 0.0, 0, 0)] if default_among else []
    x, y, outcomes, groups = (np.array(column) for column in zip(*rows, strict=True))
    kinds: list[Kind] = [Continuous(), Categorical(("no", "yes"))]
    return grow_tree(
        np.stack([x, y], axis=1), outcomes, groups, kinds, states=4, current=0, silence=True, flags=(2, 3)
    )


def _limit_decisions(random: Random) -> Tree:
    """Grow a tree in which watched stays limit what was pressed, on either side, with equal values at the limits."""
    pressed = [(0.0, 5.0, 0, 0), (2.0, 5.0, 1, 1), (3.0, 5.0, 1, 1), (2.5, nan, 1, 1), (2.0, 9.0, 2, 1)]
    stays = [(random.choice((1.6, 2.0, 3.0, 4.0)), random.choice((4.0, 5.0, 6.0)), 0, 2) for _ in range(40)]
    x, y, outcomes, groups = (np.array(column) for column in zip(*pressed, *stays, strict=True))
    kinds = [Continuous(), Continuous()]
    values = np.stack([x, y], axis=1).astype(np.float64)
    return grow_tree(values, outcomes, groups, kinds, states=4, current=0, silence=True)


def _state(world: World) -> bytes:
    percept = world.sense(list_reading_keys(world))
    readings = b"".join(np.asarray(percept[key]).tobytes() for key in sorted(percept, key=str))
    return readings + b"".join(array.tobytes() for array in world.state)


def _by_hand() -> bytes:
    """The tick that benchmarks compare with."""
    subject = HandwrittenBaseline(
        30, standard_task.make_full_library(), standard_task.FULL, sonar=True, threads=1
    )
    subject.reset()
    subject.run(TICKS)
    return subject.place.tobytes()


def _invert() -> bytes:
    columns = np.random.default_rng(1).integers(-9, 9, (8, 8)).astype(np.float64)
    return invert_matrix(columns @ columns.T + np.eye(8)).tobytes()


def main() -> None:
    """Print the hash of each case, but for those named."""
    warnings.simplefilter("error", RuntimeWarning)
    left_out = sys.argv[1:]
    found = {name: sha256(work()).hexdigest()[:16] for name, work in cases() if name not in left_out}
    sys.stdout.write(json.dumps({"numba": "numba" in sys.modules, "cases": found}))


if __name__ == "__main__":
    main()
