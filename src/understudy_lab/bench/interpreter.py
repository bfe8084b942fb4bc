"""The time of one update of a three-level automaton, compared with a py_trees behavior tree in the same run.

Ours is a taught forager on its way to food: forage > harvest > goto, with flags tested at the upper levels and decision
trees of usual size. The other is a tree of 11 nodes that makes the same decisions about the way: memoryless composites,
conditions of one comparison, actions of one assignment, plain Python attributes instead of the blackboard (which is
slower), ticked through `BehaviourTree.tick` without visitors, as py_trees' users do. Sensing is excluded on both sides:
the sensor values are there as floats before the timing starts. Both get the same values, and a test checks that their
decisions agree. Our update also covers the upper levels, flags and time in state.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle, islice
from math import tau
from typing import Any

from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy_lab.bench.harness import import_peer, medians
from understudy_lab.tree_builder import (
    build_automaton,
    split_below,
    split_on_flag,
    split_on_left,
    split_within,
)

TICKS, ROUNDS = 2000, 25
NEAR, AHEAD = 0.4, 0.3
GOAL_US, GOAL_RATIO = 2.0, 10.0


def run() -> dict[str, Any]:
    """Return medians over rounds in which the two take turns, µs per update and per tick."""
    theirs = PyTreesForager(import_peer("py_trees", "py_trees"))
    rows = readings(TICKS)
    ours = interpreter()

    def run_ours() -> None:
        ours.start(0.0)
        pulse = ours.pulse
        for tick, row in enumerate(rows):
            pulse(row, tick * 0.1)

    def run_theirs() -> None:
        for row in rows:
            theirs.tick(row)

    taken_ms = medians(ROUNDS, ours=run_ours, theirs=run_theirs)
    pulse_us, tick_us = (taken_ms[f"{who}_ms"] / TICKS * 1e3 for who in ("ours", "theirs"))
    return {
        "levels": len(ours.path),
        "path": list(ours.path),
        "pulse_us": pulse_us,
        "goal_us": GOAL_US,
        "py_trees_nodes": theirs.nodes,
        "py_trees_us": tick_us,
        "ratio": tick_us / pulse_us,
        "goal_ratio": GOAL_RATIO,
        "passed": pulse_us <= GOAL_US and tick_us / pulse_us >= GOAL_RATIO,
    }


def interpreter() -> Interpreter:
    """Return a forager of three levels, for inputs (range, bearing, food stored)."""
    distance = Feature("distance_to", Continuous(), "range", of="A")
    angle = Feature("angle_to", Toroidal(), "bearing", of="A")
    stored = Feature("food_stored", Continuous(), "food_stored")
    a = Binding(A="A")
    readings = {
        "range": BoundFeature(distance, a),
        "bearing": BoundFeature(angle, a),
        "stored": BoundFeature(stored),
    }
    toward = split_within("bearing", AHEAD, "forward", split_on_left("bearing", "left", "right"))
    steer = split_below("range", NEAR, "done", toward)
    turns = ("forward", "left", "right")
    goto = build_automaton(
        "goto",
        dict.fromkeys(("start", *turns), steer),
        readings=readings,
        flags=("done",),
        basics=turns,
        parameters=("A",),
    )
    harvest = build_automaton(
        "harvest",
        {
            "start": "goto",
            "goto": split_on_flag("done", "load", "goto"),
            "load": split_below("stored", 5.0, "load", "done"),
        },
        readings=readings,
        runs={"goto": "goto", "load": "load"},
        flags=("done",),
        bindings={"goto": Binding(A="food")},
    )
    arrived = split_on_flag("done", "rest", "harvest")
    forage = build_automaton(
        "forage",
        {"start": "harvest", "harvest": arrived, "rest": arrived},
        readings=readings,
        runs={"harvest": "harvest", "rest": "load"},
    )
    basics = [Behavior(name, Command()) for name in (*turns, "load")]
    kit = Kit.from_parts(distance, angle, stored, *basics, Target("food"))
    return Interpreter(link(Library.from_automata(kit, goto, harvest, forage), "forage"))


class PyTreesForager:
    """The same decisions as a behavior tree of py_trees."""

    def __init__(self, trees: Any) -> None:
        self.row: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.action = ""
        peer, status = self, trees.common.Status

        class Condition(trees.behaviour.Behaviour):  # type: ignore[misc]
            def __init__(self, name: str, holds: Callable[[float, float], bool]) -> None:
                super().__init__(name)
                self.holds = holds

            def update(self) -> Any:
                return status.SUCCESS if self.holds(peer.row[0], peer.row[1]) else status.FAILURE

        class Action(trees.behaviour.Behaviour):  # type: ignore[misc]
            def update(self) -> Any:
                peer.action = self.name
                return status.RUNNING

        def when(name: str, holds: Callable[[float, float], bool], action: str) -> Any:
            children = [Condition(name, holds), Action(action)]
            return trees.composites.Sequence(f"if {name}", memory=False, children=children)

        root = trees.composites.Selector("forage", memory=False)
        root.add_children(
            [
                when("near", lambda distance, _: distance < NEAR, "load"),
                when("ahead", lambda _, angle: angle < AHEAD or angle >= tau - AHEAD, "forward"),
                when("to the left", lambda _, angle: angle < tau / 2, "left"),
                Action("right"),
            ]
        )
        self.nodes = sum(1 for _ in root.iterate())
        self._tree = trees.trees.BehaviourTree(root)

    def tick(self, row: tuple[float, ...]) -> None:
        """Run one tick on one set of sensor values."""
        self.row = row
        self._tree.tick()


def readings(count: int) -> list[tuple[float, ...]]:
    """Return sensor values (range, bearing, food stored) of a robot that turns to food, drives there, and repeats."""
    turn = [(5.0, 3.0 - 0.1 * tick, 3.0) for tick in range(28)]
    drive = [(5.0 - 0.1 * tick, 0.2, 3.0) for tick in range(45)]
    left = [*turn, *drive]
    right = [(distance, (tau - angle) % tau, stored) for distance, angle, stored in left]
    return list(islice(cycle([*left, *right]), count))
