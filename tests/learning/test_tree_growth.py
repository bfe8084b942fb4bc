"""The learner equals the plain reference on every random case, and keeps its laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.learning.reference import DEFAULT, SHOWN, Learner, Row, nest_tree
from tests.make.lessons import (
    ABSENT,
    ROBOCUP_FOLDER,
    draw_tables,
    learn_tree,
    read_robocup,
    robocup_folder,
)

from understudy.errors import DefinitionError
from understudy.learning.tree_growth import MOST_WEIGHT, grow_tree
from understudy.model.tree import STAY, TestKind, Tree
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

MANY = settings(max_examples=400)
FLAGS = st.lists(st.integers(0, 2), max_size=2, unique=True)
"""The outcomes that are flags, to be told apart first."""


WITHIN_AN_OUTCOME = [  # value, outcome, group: of 0, the flag, a press at 1 and a default at 1.5 are parted by the cut
    *[(0.0, outcome, DEFAULT) for outcome in (0, 0, 0, 1, 2, 2)],
    (1.0, 0, SHOWN),
    (1.5, 0, DEFAULT),
    *[(2.0, outcome, group) for outcome, group in ((0, DEFAULT), (0, DEFAULT), (2, SHOWN))],
]


@MANY
@example(([Row((at,), *what) for at, *what in WITHIN_AN_OUTCOME], [Continuous()]), 0, False, [0])
@given(draw_tables(), st.integers(-1, 2), st.booleans(), FLAGS)
def test_equals_brute_force(
    table: tuple[list[Row], list[Kind]], current: int, midpoints: bool, flags: list[int]
) -> None:
    rows, kinds = table
    tree = learn_tree(rows, kinds, current=current, midpoints=midpoints, flags=flags)
    assert nest_tree(tree) == Learner(rows, kinds, current, midpoints, flags).tree


@MANY
@given(draw_tables(watched=True), st.integers(-1, 2), FLAGS)
def test_equals_brute_force_with_watched_examples(
    table: tuple[list[Row], list[Kind]], current: int, flags: list[int]
) -> None:
    rows, kinds = table
    tree = learn_tree(rows, kinds, current=current, flags=flags)
    assert nest_tree(tree) == Learner(rows, kinds, current, flags=flags).tree


@MANY
@given(draw_tables(watched=True, stays=12), FLAGS)
def test_equals_brute_force_where_silence_limits_decisions(
    table: tuple[list[Row], list[Kind]], flags: list[int]
) -> None:
    rows, kinds = table
    tree = learn_tree(rows, kinds, current=0, flags=flags, silence=True)
    assert nest_tree(tree) == Learner(rows, kinds, 0, flags=flags, silence=True).tree


STAYS = [1.3, 1.6, 2.0, 2.4]
LIMITS = [  # watched stays -> the values from which on, and up to which, it leaves
    ([], (0.97, None)),  # without watched examples the gap belongs to the default
    (STAYS[1:], (0.5, None)),  # three are too few
    (STAYS, (0.5, 1.15)),
    ([1.0, *STAYS], (0.5, 1.15)),  # one where a press says leave: the press decides
    ([0.6, 0.7, 0.8, 0.9], (0.92, None)),  # a test by which presses are told apart comes first
]


@pytest.mark.parametrize(("stays", "leaves"), LIMITS)
def test_watched_stays_beyond_all_presses_limit_a_decision(
    stays: list[float], leaves: tuple[float, float | None]
) -> None:
    """It was told to leave at 0.97 and 1.0 m, and not at 0 m; then it was watched, and not told so, further away."""
    rows = [Row((0.0,), 0, 0), Row((0.97,), 1, 1), Row((1.0,), 1, 1)]
    rows += [Row((value,), 0, 2) for value in stays]
    tree = learn_tree(rows, [Continuous()], current=0, silence=True)
    first = next(value for value in np.arange(0.0, 3.0, 0.005) if tree.decide([value]) == 1)
    last = max(value for value in np.arange(0.0, 3.0, 0.005) if tree.decide([value]) == 1)
    assert first == pytest.approx(leaves[0], abs=0.03)
    assert last == pytest.approx(2.995 if leaves[1] is None else leaves[1], abs=0.01)


def test_what_silence_limits_was_shown() -> None:
    """It ends at a leaf: it does not stay there because nothing was shown."""
    rows = [Row((0.0,), 0, 0), Row((0.97,), 1, 1), *(Row((value,), 0, 2) for value in STAYS)]
    tree = learn_tree(rows, [Continuous()], current=0, silence=True)
    assert tree.path([2.0])[1] != STAY
    assert tree.decide([2.0]) == 0


def test_silence_brings_no_other_feature_in() -> None:
    """It stays by the first feature only; watched stays differ in the second one, too, and limit nothing there."""
    rows = [Row((0.0, 5.0), 0, 1), Row((2.0, 5.0), 1, 1), *(Row((2.0, 9.0 + k), 0, 2) for k in range(6))]
    tree = learn_tree(rows, [Continuous(), Continuous()], current=0, silence=True)
    assert tree.decide([2.0, 12.0]) == 1
    assert {node.feature for node in tree.nodes if node.test != TestKind.LEAF} == {0}


@MANY
@given(draw_tables(watched=True), st.randoms())
def test_order_of_examples_makes_no_difference(table: tuple[list[Row], list[Kind]], random: object) -> None:
    rows, kinds = table
    shuffled = list(rows)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert repr(learn_tree(shuffled, kinds)) == repr(learn_tree(rows, kinds))


@MANY
@given(draw_tables(watched=True), st.integers(-1, 2))
def test_what_contradicts_nothing_is_decided_as_shown(
    table: tuple[list[Row], list[Kind]], current: int
) -> None:
    rows, kinds = table
    assert misses(learn_tree(rows, kinds, current=current), rows) == []


def misses(tree: Tree, rows: list[Row]) -> list[Row]:
    """The press-made examples that contradict no other and yet are decided otherwise than shown."""

    def place(row: Row) -> tuple[float | None, ...]:
        return tuple(None if value != value else value for value in row.values)

    shown: dict[tuple[float | None, ...], set[int]] = {}
    for row in rows:
        if row.group != 2:
            shown.setdefault(place(row), set()).add(row.outcome)
    return [
        row
        for row in rows
        if row.group != 2 and len(shown[place(row)]) == 1 and tree.decide(row.values) != row.outcome
    ]


def test_the_robocup_lessons_are_where_they_are_said_to_be(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A folder called shared beside a checkout may hold anything."""
    monkeypatch.delenv(ROBOCUP_FOLDER, raising=False)
    assert robocup_folder() is None
    monkeypatch.setenv(ROBOCUP_FOLDER, str(tmp_path))
    assert robocup_folder() == tmp_path


def test_robocup_lessons() -> None:
    """Every example that contradicts no other is decided as shown, in the lessons of the folder that is named."""
    folder = robocup_folder()
    if folder is None:
        pytest.skip(f"{ROBOCUP_FOLDER} names no folder: the lessons are other people's and stay outside")
    states = [state for path in sorted(folder.glob("*.json")) for state in read_robocup(path)]
    taught = [(kinds, rows, current) for _, kinds, rows, current in states if rows]
    assert sum(len(rows) for _, rows, _ in taught) == 385
    wrong, nodes = [], 0
    for kinds, rows, current in taught:
        tree = grow_tree(
            np.array([row.values for row in rows], np.float64).reshape(len(rows), len(kinds)),
            np.array([row.outcome for row in rows], np.int64),
            np.array([row.group for row in rows], np.int64),
            kinds,
            states=64,
            current=current,
        )
        nodes += len(tree.nodes)
        wrong += misses(tree, rows)
        assert nest_tree(tree) == Learner(rows, kinds, current).tree
    assert wrong == []
    assert nodes <= 366  # the original's trees have 364


@pytest.mark.long
def test_large_noisy_lesson_repeats_and_is_pure() -> None:
    random = np.random.default_rng(3)
    values = random.random((1500, 3))
    values[random.random((1500, 3)) < 0.05] = ABSENT
    outcomes = random.integers(0, 3, 1500)
    kinds: list[Kind] = [Continuous(), Toroidal(1.0), Continuous()]
    groups = random.integers(0, 2, 1500)
    tree = grow_tree(values, outcomes, groups, kinds, states=3)
    order = random.permutation(1500)
    again = grow_tree(values[order], outcomes[order], groups[order], kinds, states=3)
    assert repr(tree) == repr(again)
    rows = [
        Row(tuple(row), outcome, 1) for row, outcome in zip(values.tolist(), outcomes.tolist(), strict=True)
    ]
    assert misses(tree, rows) == []


def test_inputs_are_left_alone() -> None:
    values = np.array([[3.0], [-0.0], [ABSENT]])
    before = values.copy()
    values.setflags(write=False)
    grow_tree(values, np.array([0, 1, 2]), np.array([1, 1, 1]), [Continuous()], states=3)
    assert np.array_equal(values, before, equal_nan=True)


@pytest.mark.parametrize("scale", [5e-324, 1e-300, 1e300, 1.7e308])
def test_extreme_values(scale: float) -> None:
    tree = learn_tree([Row((-scale,), 0, 1), (Row((scale,), 1, 1))], [Continuous()])
    assert (tree.decide((-scale,)), tree.decide((scale,))) == (0, 1)


def test_no_features_is_one_leaf() -> None:
    tree = learn_tree([Row((), 1, 1), Row((), 2, 1), Row((), 2, 1)], [])
    assert nest_tree(tree) == 2


def test_many_labels_branch_in_order() -> None:
    labels = tuple(f"l{index}" for index in range(40))
    rows = [Row((float(index),), index % 3, 1) for index in range(0, 40, 2)]
    tree = learn_tree(rows, [Categorical(labels)])
    assert tree.nodes[0].test == TestKind.LABEL
    assert [tree.decide((float(index),)) for index in range(4)] == [0, -1, 2, -1]


def test_too_many_examples_are_refused() -> None:
    count = MOST_WEIGHT + 1
    with pytest.raises(DefinitionError, match="keep at most"):
        grow_tree(
            np.zeros((count, 1)),
            np.zeros(count, np.int64),
            np.ones(count, np.int64),
            [Continuous()],
            states=1,
        )
