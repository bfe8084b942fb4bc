"""Values copied, and sent to other processes by pickle: the copies are equal, and behave alike."""

from __future__ import annotations

import copy
import pickle  # noqa: TID251 - between processes, never from files
from collections.abc import Callable
from math import nan
from typing import Any

import numpy as np
import pytest
from tests.make.automata import make_goto, make_kit
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior, behavior
from understudy.model.features import Feature, Percept, ReadingsView, feature
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Column, Continuous
from understudy.sim.team.libraries import collect_libraries

Copy = Callable[[Any], Any]


def send(value: Any) -> Any:
    """A value as another process gets it."""
    return pickle.loads(pickle.dumps(value))


COPIES: dict[str, Copy] = {"pickle": send, "deep copy": copy.deepcopy, "copy": copy.copy}
copied = pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)


@feature(Continuous(), unit="m")
def nearer(_: Any, target: Any) -> Column:
    return np.asarray(target.range / 2)


@behavior
def approach(_: Any, target: Any) -> dict[str, Column]:
    return {"drive": np.asarray(target.range)}


class Holder:
    """Functions need not be at the top of a module."""

    @staticmethod
    @feature(Continuous())
    def farther(_: Any, target: Any) -> Column:
        return np.asarray(target.range * 2)


TAUGHT = make_goto()
OWN = Kit.from_parts(nearer, approach, Holder.farther)
LIBRARY = Library(make_kit(TAUGHT.automaton) + OWN).with_automaton(TAUGHT)
PERCEPT: Percept = {("range", "ball"): np.array([1.0, nan])}

VALUES: dict[str, Any] = {
    "kit": OWN,
    "lesson": TAUGHT.lesson,
    "automaton": TAUGHT.automaton,
    "library": LIBRARY,
    "libraries of a team": collect_libraries(SCENARIO, ROBOTS),
    "options": SklearnOptions("SVC"),
    "scenario": SCENARIO,
}


@copied
@pytest.mark.parametrize("value", VALUES.values(), ids=VALUES)
def test_a_copy_is_equal(value: Any, copied: Copy) -> None:
    again = copied(value)
    assert type(again) is type(value)
    assert again == value


@copied
def test_functions_come_along(copied: Copy) -> None:
    readings, target = ReadingsView(PERCEPT), ReadingsView(PERCEPT, "ball")
    kit: Kit = copied(OWN)
    for name, column in (("nearer", [0.5, nan]), ("farther", [2.0, nan])):
        made = kit.features[name]
        assert isinstance(made, Feature)
        assert made.function is not None
        assert made.parameters == ("target",)
        np.testing.assert_array_equal(made.function(readings, target), column)
    assert kit.behaviors["approach"].function is approach.function


@copied
def test_automata_decide_alike(copied: Copy) -> None:
    lesson, again = TAUGHT.lesson, copied(LIBRARY).taught["goto"]
    assert isinstance(lesson, Lesson)
    assert isinstance(again.automaton, Automaton)
    for state, transition in TAUGHT.automaton.transitions.items():
        for example in lesson.examples:
            other = again.automaton.transitions[state]
            assert other.decide(example.values) == transition.decide(example.values)
            assert other.path(example.values) == transition.path(example.values)


def test_a_deep_tree_is_sent() -> None:
    depth = 3000  # deeper than Python recurses
    nodes = [
        Node(TestKind.BELOW, 0, high=float(at), yes=at + 1, no=depth + 1, absent=-1) for at in range(depth)
    ]
    tree = Tree((*nodes, make_leaf(1), make_leaf(2)))
    assert send(tree) == tree
    assert copy.deepcopy(tree).decide([-1.0]) == 1


LOCAL: dict[str, Any] = {
    "feature 'near'": Feature("near", Continuous(), function=lambda robot: robot.x),
    "behavior 'go'": Behavior("go", function=lambda robot: {"drive": robot.x}),
}


@pytest.mark.parametrize(("named", "part"), LOCAL.items(), ids=LOCAL)
def test_a_function_that_no_other_process_finds(named: str, part: Any) -> None:
    with pytest.raises(DefinitionError, match=f"{named}: .*; define it at the top level of a module"):
        send(part)
    assert copy.deepcopy(part) == part
