"""Features and behaviors that are functions of somebody's own: each slip is one paragraph that names them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from understudy.errors import DefinitionError, KindError, UnderstudyError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, behavior
from understudy.model.features import BoundFeature, Feature, ReadingsView, feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Kind
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.sim.forage import FORAGE_KIT, Forage


def tick(part: Feature | Behavior) -> None:
    """Run an automaton that uses the part for a tick, with two robots."""
    does = part.name if isinstance(part, Behavior) else "forward"
    features = () if isinstance(part, Behavior) else (BoundFeature(part),)
    states = (START, State("on", does))
    automaton = Automaton("go", states, features, transitions={"start": Tree((make_leaf(1),))})
    Run.from_program(
        Forage([1, 2]), link(Library.from_automata(FORAGE_KIT + Kit.from_parts(part), automaton), "go")
    ).tick()


def odd(robot: ReadingsView) -> Any:
    return robot.nonsense


def raise_error(robot: ReadingsView) -> Any:
    raise ValueError("oh")


def make_constant(value: object) -> Callable[[ReadingsView], Any]:
    def read_value(robot: ReadingsView) -> Any:
        return value

    return read_value


BEHAVIORS: list[tuple[Callable[[ReadingsView], Any], str]] = [
    (make_constant(None), "behavior read_value: it returned None; return a command"),
    (make_constant([1.0]), "behavior read_value: it returned \\[1.0\\]; return a command"),
    (
        make_constant({"drive": np.ones(7)}),
        "behavior read_value, channel 'drive': it returned shape \\(7,\\) for 2 agents",
    ),
    (make_constant({"drive": "fast"}), "behavior read_value, channel 'drive': it returned 'fast'"),
    (make_constant({"drive": np.nan}), "channel 'drive' is not finite for agent 0: it is nan"),
    (make_constant({"fly": 1.0}), "no channel 'fly'; it has drive"),
    (odd, "behavior odd: its function failed: AttributeError: the body has no reading 'nonsense'"),
    (raise_error, "behavior raise_error: its function failed: ValueError: oh; correct the function"),
]


@pytest.mark.parametrize(("function", "says"), BEHAVIORS)
def test_a_behavior(function: Callable[[ReadingsView], Any], says: str) -> None:
    with pytest.raises(UnderstudyError, match=says):
        tick(behavior(function))


def test_a_number_is_for_all_agents() -> None:
    tick(behavior(make_constant({"drive": 1.0})))


FEATURES: list[tuple[Callable[[ReadingsView], Any], Kind, str]] = [
    (make_constant("far"), Continuous(), "feature 'read_value': it returned 'far'"),
    (make_constant(1.0), Continuous(), "feature 'read_value': it returned shape \\(\\)"),
    (
        make_constant(np.array([0.0, 0.5])),
        BOOLEAN,
        "feature 'read_value' of agent 1: 0.5 is not the index of a label",
    ),
    (
        make_constant(np.array([np.nan, 2.0])),
        BOOLEAN,
        "feature 'read_value' of agent 1: 2.0 is not the index of a label",
    ),
    (odd, Continuous(), "feature 'odd': its function failed: AttributeError: the body has no reading"),
    (raise_error, Continuous(), "feature 'raise_error': its function failed: ValueError: oh"),
]


@pytest.mark.parametrize(("function", "kind", "says"), FEATURES)
def test_a_feature(function: Callable[[ReadingsView], Any], kind: Kind, says: str) -> None:
    with pytest.raises(UnderstudyError, match=says):
        tick(feature(kind)(function))


def test_absent_values_and_truth_values_are_within_a_kind() -> None:
    tick(feature(BOOLEAN)(make_constant(np.array([np.nan, 1.0]))))
    tick(feature(BOOLEAN)(make_constant(np.array([True, False]))))


def test_what_is_no_kind_and_what_is_no_part() -> None:
    with pytest.raises(DefinitionError, match=r"its kind is 'continuous'; give Continuous\(\)"):
        Feature("x", "continuous", reading="range")  # type: ignore[arg-type]
    with pytest.raises(DefinitionError, match="kit: 3 is not part of it"):
        Kit.from_parts(3)  # type: ignore[arg-type]
    with pytest.raises(KindError, match="its labels are 'no'; give them as a tuple"):
        Categorical("no")  # type: ignore[arg-type]
