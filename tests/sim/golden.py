"""Golden runs: what happens in a world of each built-in scenario in 20 s of the same simple program.

After something changed that is meant to change them, bring the stored ones up to date with:
python -m tests.sim.golden
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, TimeInState
from understudy.model.library import Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.runtime.body import list_reading_keys
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import Program, link
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario
from understudy.sim.world import World

FOLDER = Path(__file__).parents[1] / "golden" / "worlds"
SECONDS, EVERY_S, EACH_S, SEED = 20, 4, 0.95, 2011
MOST = 25
"""Of more robots than that, so many are written down, evenly spread."""


def each_in_turn(world: World) -> Program:
    """All basic behaviors of the world's kit, one after the other, each for about a second."""
    names = list(world.kit.behaviors)
    states = (START, *(State(f"{name} {index}", name) for index, name in enumerate(names)))
    now = BoundFeature(TimeInState(), Binding({}))
    transitions = {"start": Tree((make_leaf(1),))}
    for index, state in enumerate(states[1:]):
        following = 1 + (index + 1) % len(names)
        node = Node(TestKind.BELOW, 0, low=EACH_S, high=EACH_S, yes=1, no=2, absent=1)
        transitions[state.name] = Tree((node, make_leaf(1 + index), make_leaf(following)))
    return link(
        Library.from_automata(world.kit, Automaton("turns", states, (now,), (), False, transitions)), "turns"
    )


def moments(name: str) -> list[dict[str, Any]]:
    """The run: what can be counted, and what is measured, now and then."""
    world = World(load_scenario(name), (SEED,))
    engine = Engine.from_program(world, each_in_turn(world))
    found = [_moment(world, engine)]
    for _ in range(SECONDS // EVERY_S):
        engine.run(round(EVERY_S / world.tick_s))
        found.append(_moment(world, engine))
    return found


def _moment(world: World, engine: Engine) -> dict[str, Any]:
    some = slice(None, None, max(1, world.agents // MOST))
    robots, objects = world.state.robots[some], world.state.objects[0]
    percept = world.sense(list_reading_keys(world))
    return {
        "counts": {
            **{field: robots[field].tolist() for field in ("stored", "delivered", "blocked")},
            **{field: objects[field].tolist() for field in ("present", "amount", "appeared")},
            "states": [engine.path(agent)[-1] for agent in range(world.agents)[some]],
        },
        "measures": {
            **{f"robots {field}": robots[field].tolist() for field in ("x", "y", "heading")},
            **{f"objects {field}": objects[field][objects["present"] != 0].tolist() for field in ("x", "y")},
            **{
                reading if target is None else f"{reading} of {target}": [
                    None if value != value else value for value in percept[reading, target][some].tolist()
                ]
                for reading, target in percept
            },
        },
    }


def read_golden(name: str) -> list[dict[str, Any]]:
    """The golden run of a scenario."""
    found: list[dict[str, Any]] = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    return found


if __name__ == "__main__":
    for name in list_builtin_scenarios():
        text = json.dumps(moments(name), indent=1)
        (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
