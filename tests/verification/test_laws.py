"""Laws of the check on random automata: what it says is what the interpreter does."""

from __future__ import annotations

import random
from collections.abc import Sequence
from math import isinf, nan

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.verification.automata import AHEAD, ANGLE, BACK, DISTANCE, KIT, LIGHT

from understudy.addons.checks.verification.cells import Axis, choose_vector
from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.cycles import CycleFinder
from understudy.addons.checks.verification.finding import FindingKind
from understudy.addons.checks.verification.levels import build_hierarchy
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, FlagFeature
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link

STATES = (START, AHEAD, BACK, State("wait", "wait"), State("done", flag="done"))
FEATURES = (DISTANCE, ANGLE, LIGHT)
DISTANCES, ANGLES = (-1.0, 0.5, 2.0, 7.0), (0.0, 10.0, 200.0, 350.0)
CYCLES = (FindingKind.CHATTER, FindingKind.CYCLE)


@st.composite
def trees(draw: st.DrawFn, depth: int = 3) -> Tree:
    """Small trees over a distance, an angle and a light, with places where nothing was shown."""
    nodes: list[Node] = []

    def grow(left: int) -> int:
        at = len(nodes)
        nodes.append(make_leaf(0))
        what = draw(st.integers(0, 4)) if left else 0
        if what == 0:
            nodes[at] = make_leaf(draw(st.integers(STAY, 4)))
            return at
        if what == 1:
            yes, no = grow(left - 1), grow(left - 1)
            absent = draw(st.sampled_from((STAY, yes, no)))
            cut = draw(st.sampled_from(DISTANCES))
            nodes[at] = Node(TestKind.BELOW, 0, high=cut, yes=yes, no=no, absent=absent)
        elif what == 2:
            low, high = draw(st.permutations(ANGLES))[:2]
            yes, no = grow(left - 1), grow(left - 1)
            nodes[at] = Node(
                TestKind.ARC, 1, low, high, yes=yes, no=no, absent=draw(st.sampled_from((STAY, no)))
            )
        elif what == 3:
            feature = draw(st.integers(0, 2))
            nodes[at] = Node(TestKind.ABSENT, feature, yes=grow(left - 1), no=grow(left - 1))
        else:
            branches = tuple(grow(left - 1) if draw(st.booleans()) else STAY for _ in range(3))
            nodes[at] = Node(TestKind.LABEL, 2, absent=STAY, branches=branches)
        return at

    grow(depth)
    return Tree(tuple(nodes))


@st.composite
def automata(draw: st.DrawFn) -> Automaton:
    taught = {state.name: draw(trees()) for state in STATES[:4] if draw(st.integers(0, 9))}
    return Automaton("go", STATES, FEATURES, transitions=taught)


vectors = st.tuples(
    st.one_of(st.just(nan), st.floats(-10, 10)),
    st.one_of(st.just(nan), st.floats(0, 359.9), st.sampled_from(ANGLES)),
    st.one_of(st.just(nan), st.sampled_from((0.0, 1.0, 2.0))),
)


@given(automata(), st.lists(vectors, min_size=1, max_size=20))
def test_leaves_partition_the_space_as_the_tree_decides(
    automaton: Automaton, rows: list[tuple[float, ...]]
) -> None:
    level = build_hierarchy(Library.from_automata(KIT, automaton), "go")
    for index, state in enumerate(STATES[:4]):
        tree, leaves = automaton.transitions.get(state.name), level.leaves[index]
        for row in rows if tree is not None else ():
            cell = locate_vector(row, level.axes)
            inside = [leaf for leaf in leaves or () if leaf.box & cell == cell]
            assert cell
            assert [leaf.outcome for leaf in inside] == [tree.decide(row)]  # type: ignore[union-attr]


def locate_vector(values: Sequence[float], axes: Sequence[Axis]) -> int:
    """The box of the cell that contains a feature vector; 0 if it is outside the domain."""
    bits = [axis.find_bit(value) for value, axis in zip(values, axes, strict=True)]
    return sum(bits) if all(bits) else 0


def follow(automaton: Automaton, state: int, rows: list[tuple[float, ...]]) -> list[int]:
    """The states of an agent that begins in one and reads these rows, tick by tick."""
    program = link(Library.from_automata(KIT, automaton), "go")
    order = [program.features.index(bound) for bound in FEATURES]
    agent = Interpreter(program)
    agent.root.switch(state, 0.0)  # type: ignore[union-attr]
    found = []
    for tick, row in enumerate(rows, start=1):
        placed = [nan] * len(order)
        for value, at in zip(row, order, strict=True):
            placed[at] = value
        agent.pulse(placed, 0.1 * tick)
        found.append(agent.active[0].state)
    return found


@given(automata(), st.lists(vectors, min_size=5, max_size=60))
def test_what_is_never_entered_or_left_is_not_by_the_interpreter(
    automaton: Automaton, rows: list[tuple[float, ...]]
) -> None:
    found = check_library(Library.from_automata(KIT, automaton)).findings
    entered = follow(automaton, 0, rows)
    never = {each.states[0] for each in found if each.kind is FindingKind.NEVER_ENTERED}
    assert not never & {STATES[state].name for state in entered}
    for each in found:
        if each.kind is FindingKind.NEVER_LEFT:
            state = automaton.index(each.states[0])
            assert set(follow(automaton, state, rows)) == {state}


@given(automata())
@settings(max_examples=200)
def test_a_cycle_that_is_reported_cycles(automaton: Automaton) -> None:
    level = build_hierarchy(Library.from_automata(KIT, automaton), "go")
    for cycle in CycleFinder(level).search().cycles:
        for box in cycle.boxes:
            row = choose_vector(box, level.axes)
            expected = [*cycle.states[1:], cycle.states[0]]
            assert follow(automaton, cycle.states[0], [row] * 3 * len(expected)) == expected * 3


@given(automata(), st.lists(vectors, min_size=1, max_size=10))
def test_every_cycle_is_reported(automaton: Automaton, rows: list[tuple[float, ...]]) -> None:
    """Held readings that make the interpreter come back to a state lie in the cell of a cycle through it."""
    level = build_hierarchy(Library.from_automata(KIT, automaton), "go")
    cycles = CycleFinder(level).search().cycles
    for row in rows:
        cell = locate_vector(row, level.axes)
        for start in level.reachable_states:
            states = follow(automaton, start, [row] * 6)
            if start in states and states[0] != start and STATES[start].flag is None:
                assert any(
                    start in each.states and any(box & cell == cell for box in each.boxes) for each in cycles
                )


PARENT_FEATURES = (DISTANCE, BoundFeature(FlagFeature("done")))
PARENT_STATES = (START, State("go", "go"), State("again", "go"), State("hold", "wait"))


@st.composite
def parents(draw: st.DrawFn) -> Automaton:
    """An automaton that runs the other in two of its states, and reads its flag."""

    def grow() -> Tree:
        answers = st.integers(STAY, 3)
        flag = Node(TestKind.LABEL, 1, branches=(1, 2))
        near = Node(TestKind.BELOW, 0, high=draw(st.sampled_from(DISTANCES)), yes=3, no=4)
        return Tree((flag, near, *(make_leaf(draw(answers)) for _ in range(3))))

    return Automaton(
        "parent", PARENT_STATES, PARENT_FEATURES, transitions={state.name: grow() for state in PARENT_STATES}
    )


@given(automata(), parents())
@settings(max_examples=200)
def test_a_cycle_through_levels_cycles(child: Automaton, parent: Automaton) -> None:
    library = Library.from_automata(KIT, child, parent)
    level = build_hierarchy(library, "parent")
    program = link(library, "parent")
    for cycle in CycleFinder(level).search().cycles:
        for box, ticks in zip(cycle.boxes, cycle.ticks, strict=True):
            known = {axis.bound: axis for axis in level.space.axes}
            row = [choose_vector(box, [known[bound]])[0] for bound in program.features]
            agent = Interpreter(program)
            agent.root.switch(cycle.states[0], 0.0)  # type: ignore[union-attr]
            if len(agent.active) > 1:
                agent.active[1].pulse(row, 0.0)
            found = []
            for tick in range(1, 3 * ticks + 1):
                agent.pulse(row, 0.1 * tick)
                found.append(agent.active[0].state)
            entered = [cycle.states[0], *found[:-1]]
            assert _squeeze(entered) == _squeeze([*cycle.states] * 3)
            assert found[-1] == cycle.states[0]


def _squeeze(states: list[int]) -> list[int]:
    """States without those that repeat the one before."""
    return [state for at, state in enumerate(states) if at == 0 or state != states[at - 1]]


@given(automata(), st.integers(0, 2**32))
def test_cells_of_findings_contain_their_vectors(automaton: Automaton, seed: int) -> None:
    rng = random.Random(seed)
    for each in check_library(Library.from_automata(KIT, automaton)).findings:
        for cell in each.cells:
            assert all(value in region for value, region in zip(cell.at, cell.box, strict=True))
            assert len(cell.features) == len(cell.box)
            for region in cell.box:
                low, high = rng.choice(region.parts) if region.parts else (nan, nan)
                assert low != low or isinf(low) or low < high


def run_below(child: Automaton, parent: Automaton, at: int, row: tuple[float, ...]) -> tuple[list[int], bool]:
    """The parent's states while readings are held, from its state go with the child in a state; is its flag raised."""
    program = link(Library.from_automata(KIT, child, parent), "parent")
    placed = [dict(zip(FEATURES, row, strict=True))[bound] for bound in program.features]
    agent = Interpreter(program)
    agent.root.switch(1, 0.0)  # type: ignore[union-attr]
    agent.active[1].switch(at, 0.0)
    if at == 0:  # as in the tick in which the parent enters go
        agent.active[1].pulse(placed, 0.0)
    found = []
    for tick in range(1, 12):
        agent.pulse(placed, 0.1 * tick)
        found.append(agent.active[0].state)
    return found, len(agent.active) > 1 and agent.active[1].flag is not None


@given(automata(), parents(), st.lists(vectors, min_size=1, max_size=8))
@settings(max_examples=150)
def test_every_dead_end_is_reported(
    child: Automaton, parent: Automaton, rows: list[tuple[float, ...]]
) -> None:
    """Where held readings make the child raise its flag and the parent stay, the cell of a finding has them."""
    library = Library.from_automata(KIT, child, parent)
    level = build_hierarchy(library, "parent")
    found = [
        each for each in check_library(library, ["parent"]).findings if each.kind is FindingKind.DEAD_END
    ]
    below = build_hierarchy(library, "go")
    for row in rows if level.exits[1] and 1 in level.reachable_states else ():
        for at in below.reachable_states:
            if STATES[at].flag is None and at in (0, 1, 2, 3):
                states, raised = run_below(child, parent, at, row)
                known = dict(zip(FEATURES, row, strict=True))
                if raised and set(states) == {1}:
                    assert any(
                        "go" in each.states
                        and all(
                            known[bound] in region
                            for bound, region in zip(cell.features, cell.box, strict=True)
                            if bound in known
                        )
                        for each in found
                        for cell in each.cells
                    ), (row, at)


@given(automata(), parents())
@settings(max_examples=150)
def test_a_dead_end_that_is_reported_waits(child: Automaton, parent: Automaton) -> None:
    """With the readings of its cell, the child raises its flag from some state, and the parent stays."""
    library = Library.from_automata(KIT, child, parent)
    below = build_hierarchy(library, "go")
    for each in check_library(library, ["parent"]).findings:
        if each.kind is not FindingKind.DEAD_END or each.states != ("go",):
            continue
        for cell in each.cells:
            known = dict(zip(cell.features, cell.at, strict=True))
            row = tuple(known.get(bound, 0.0) for bound in FEATURES)
            runs = [run_below(child, parent, at, row) for at in below.reachable_states - {4}]
            assert any(raised and set(states) == {1} for states, raised in runs)
