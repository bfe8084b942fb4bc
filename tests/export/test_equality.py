"""Exported code decides as the interpreter, tick by tick, on random libraries."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.export.exports import (
    LIVELY,
    count_mismatches,
    draw_job,
    load_python,
    write_job,
)
from tests.export.recorded_answers import Ask
from tests.runtime.random_libraries import draw_library, kit

from understudy.addons.export.decisions import (
    DEEPEST,
    Answer,
    Branch,
    Continuation,
    Step,
    ValueCondition,
    make_routines,
)
from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, Node, TestKind, Tree, is_in_arc, make_leaf
from understudy.model.value_kinds import Categorical

SEEDS = st.integers(0, 2**32)


def holds(condition: ValueCondition, x: float) -> bool:
    """Whether a question holds for a value, straight from its definition."""
    low, high = condition.low, condition.high
    return {
        "absent": x != x,
        "below": x < high,
        "from": x >= low,
        "inside": x == x and low <= high and is_in_arc(x, low, high),
        "outside": x == x and not is_in_arc(x, low, high),
        "across": x == x and is_in_arc(x, low, high),
        "between": x == x and not is_in_arc(x, low, high),
        "label": x == low,
    }[condition.comparison]


def follow(routines: tuple[Step, ...], values: list[float]) -> Answer:
    """Follow routines to their answer."""
    step = routines[0]
    while not isinstance(step, Answer):
        if isinstance(step, Continuation):
            step = routines[step.routine]
        else:
            step = step.yes if holds(step.condition, values[step.condition.feature]) else step.no
    return step


def count_nested(step: Step) -> int:
    """How deep blocks are nested; a chain of else-if counts once."""
    deepest = 0
    while isinstance(step, Branch):
        deepest = max(deepest, 1 + count_nested(step.yes))
        step = step.no
    return deepest


NUMBERS = (0.0, 0.1, 0.3, 1.0, 2.0, 3.0, 6.0)


def draw_value(random: Random, bound: BoundFeature, *, can_be_absent: bool) -> float:
    """Draw a value of a feature, absent in some draws."""
    kind = bound.kind
    values = tuple(map(float, range(len(kind.labels)))) if isinstance(kind, Categorical) else NUMBERS
    return random.choice((*values, nan) if can_be_absent else values)


@settings(max_examples=100)
@given(SEEDS, st.integers(0, 4))
def test_two_way_branches_decide_as_the_tree(seed: int, depth: int) -> None:
    random = Random(seed)
    automaton = draw_library(random, automata=1, depth=depth).automaton("a0")
    absent = [not bound.is_own or bound.feature.name in ("watch", "bell") for bound in automaton.features]
    for tree in automaton.transitions.values():
        assert isinstance(tree, Tree)
        check_routines(tree, random, automaton.features, absent)


def check_routines(
    tree: Tree, random: Random, features: Sequence[BoundFeature], absent: Sequence[bool]
) -> tuple[Step, ...]:
    """Check that the routines of a tree decide as it does, with no deep nesting."""
    routines = make_routines(tree, absent.__getitem__)
    assert all(count_nested(each) <= DEEPEST + 1 for each in routines)
    for _ in range(30):
        drawn = zip(features, absent, strict=True)
        values = [draw_value(random, bound, can_be_absent=can_be) for bound, can_be in drawn]
        leaf = tree.path(values)[1]
        assert follow(routines, values) == Answer(tree.decide(values), leaf if leaf != STAY else -1)
    return routines


def test_a_deep_tree_is_several_routines() -> None:
    """A chain of cuts, each below the yes side of the one before."""
    nodes: list[Node] = []
    for index in range(100):
        nodes += [
            Node(TestKind.BELOW, 0, high=3.0 - index / 50, yes=2 * index + 2, no=2 * index + 1),
            make_leaf(index),
        ]
    tree = Tree((*nodes, make_leaf(100)))
    bound = BoundFeature(kit.features["load"])
    assert len(check_routines(tree, Random(0), [bound], [True])) > 5


@pytest.mark.long
@settings(max_examples=20)
@given(SEEDS)
def test_python_decides_as_the_interpreter(seed: int) -> None:
    job = draw_job(seed, to="python")
    ticks, mismatches = count_mismatches(load_python(job), job)
    assert ticks > 1000
    assert mismatches == 0


@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
@pytest.mark.parametrize("seed", range(4))
def test_c_decides_as_the_interpreter(seed: int, single: bool, ask: Ask, tmp_path: Path) -> None:
    job = draw_job(seed, to="c99", single=single)
    ticks, mismatches = ask("gcc", write_job(tmp_path, job, to="c99")).counts
    assert ticks == len(job.conformance.ticks)
    assert mismatches == 0


def test_random_exports_have_what_there_is_to_get_wrong() -> None:
    """Else the tests above would say little."""
    levels, sorts, counted, stateless, fresh, reached = set(), set(), 0, 0, 0, 0
    for seed in range(12):
        job = draw_job(seed, to="python")
        hierarchy = job.hierarchy
        reached += job.conformance.leaves[0]
        fresh += sum(source.fresh is not None for each in hierarchy.automata for source in each.features)
        levels.add(hierarchy.depth)
        sorts |= {source.sort for each in hierarchy.automata for source in each.features}
        counted += sum(len(state.effects) for each in hierarchy.automata for state in each.states)
        stateless += sum(each.stateless for each in hierarchy.automata)
    assert max(levels) >= 5
    assert sorts == {"reading", "flag", "counter", "timer", "time in state"}
    assert counted > 20
    assert stateless > 3
    assert fresh > 5
    assert reached > 12 * LIVELY


@pytest.mark.parametrize("seed", range(8))
def test_the_reader_of_documents_decides_as_the_interpreter(seed: int, ask: Ask, tmp_path: Path) -> None:
    job = draw_job(seed, to="json")
    ticks, mismatches = ask("node", write_job(tmp_path, job, to="json")).counts
    assert ticks == len(job.conformance.ticks)
    assert mismatches == 0
