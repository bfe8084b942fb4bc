"""Trees in words: the words read well, and what they say is what the tree decides."""

from __future__ import annotations

from math import degrees, inf, nan, nextafter, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.learning.reference import Row
from tests.make.lessons import draw_tables, learn_tree

from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, FlagFeature
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.tree_regions import ABSENT_ONLY, ValueSet, list_leaf_boxes
from understudy.model.tree_text import (
    FeatureText,
    describe_exits,
    describe_path,
    describe_tree_outcomes,
    simplify_outcome_boxes,
)
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

DISTANCE = BoundFeature(
    Feature("distance_to", Continuous(), reading="range", of="A", unit="m"), Binding(A="A")
)
ANGLE = BoundFeature(Feature("angle_to", Toroidal(), reading="bearing", of="A", unit="rad"), Binding(A="A"))
AMOUNT = BoundFeature(Feature("amount", Continuous(), reading="amount"))
DONE = BoundFeature(FlagFeature("done"))
STATUS = BoundFeature(Feature("status", Categorical(("idle", "busy", "lost", "home")), reading="status"))
FEATURES = (DISTANCE, ANGLE, DONE, STATUS)


def below(feature: int, cut: float, yes: int, no: int, absent: int = STAY) -> Node:
    return Node(TestKind.BELOW, feature, high=cut, yes=yes, no=no, absent=absent)


def describe(*nodes: Node) -> dict[int, tuple[str, ...]]:
    return dict(describe_tree_outcomes(Tree(nodes), FEATURES))


def test_a_single_leaf() -> None:
    assert describe(make_leaf(1)) == {1: ("always",)}


def test_thresholds() -> None:
    assert describe(below(0, 0.3784, 1, 2), make_leaf(1), make_leaf(0)) == {
        0: ("distance_to(A) is at least 0.38 m",),
        1: ("distance_to(A) is below 0.38 m",),
    }
    assert describe(below(0, nextafter(3.0, inf), 1, 2), make_leaf(1), make_leaf(0)) == {
        0: ("distance_to(A) is above 3 m",),
        1: ("distance_to(A) is at most 3 m",),
    }
    assert describe(below(0, nextafter(0.0, inf), 1, 2), make_leaf(1), make_leaf(0)) == {
        0: ("distance_to(A) is above 0 m",),
        1: ("distance_to(A) is at most 0 m",),
    }


def test_tests_of_one_feature_become_one_statement() -> None:
    nodes = (below(0, 5.0, 1, 4), below(0, 2.0, 2, 3), make_leaf(0), make_leaf(1), make_leaf(2))
    assert describe(*nodes)[1] == ("distance_to(A) is between 2 m and 5 m",)
    nodes = (below(0, 5.0, 1, 4), below(0, 2.0, 2, 3), make_leaf(0), make_leaf(1), make_leaf(0))
    assert describe(*nodes)[0] == ("distance_to(A) is below 2 m or at least 5 m",)


ARCS = [  # where the arc begins and ends going left, °; the angles of the arc in words, and those of the rest
    (10, 30, "between 10° and 30°", "at least 30° or below 10°"),
    (350, 10, "between −10° and 10°", "at least 10° or below −10°"),
    (330, 0, "between −30° and 0°", "at least 0° or below −30°"),
    (0, 200, "at least 0° or below −160°", "between −160° and 0°"),
    (175, 182, "at least 175° or below −178°", "between −178° and 175°"),
    (175, 2, "at least 175° or below 2°", "between 2° and 175°"),
    (90, 180, "between 90° and 180°", "between −180° and 90°"),
    (180, 270, "between −180° and −90°", "between −90° and 180°"),
    (267, 195, "at least −93° or below −165°", "between −165° and −93°"),
    (354.98, 12.5, "between −5° and 12°", "at least 12° or below −5°"),
]


@pytest.mark.parametrize(("low", "high", "inside", "outside"), ARCS)
def test_arcs_in_degrees(low: float, high: float, inside: str, outside: str) -> None:
    node = Node(TestKind.ARC, 1, low=radians(low), high=radians(high), yes=1, no=2)
    assert describe(node, make_leaf(1), make_leaf(0)) == {
        0: (f"angle_to(A) is {outside}",),
        1: (f"angle_to(A) is {inside}",),
    }


def test_arcs_of_other_circles_run_from_0() -> None:
    hour = BoundFeature(Feature("hour", Toroidal(24.0), reading="hour", unit="h"))
    words = FeatureText(hour, [6.0, 20.0], known_absent=False)
    assert words.statement(ValueSet(((6.0, 20.0),), False)) == "hour is between 6 h and 20 h"
    assert words.statement(ValueSet(((0.0, 6.0), (20.0, 24.0)), True)) == (
        "hour is at least 20 h or below 6 h or absent"
    )


def test_absence_is_said_only_where_it_matters() -> None:
    assert describe(Node(TestKind.ABSENT, 0, yes=1, no=2), make_leaf(1), make_leaf(0)) == {
        0: ("distance_to(A) is not absent",),
        1: ("distance_to(A) is absent",),
    }
    assert describe(below(0, 2.0, 1, 2, absent=2), make_leaf(1), make_leaf(0)) == {
        0: ("distance_to(A) is at least 2 m or absent",),
        1: ("distance_to(A) is below 2 m",),
    }


def test_labels() -> None:
    flag = Node(TestKind.LABEL, 2, branches=(1, 2))
    assert describe(flag, make_leaf(0), make_leaf(1)) == {0: ("done is no",), 1: ("done is yes",)}
    status = Node(TestKind.LABEL, 3, branches=(1, 2, 3, STAY))
    assert describe(status, make_leaf(0), make_leaf(1), make_leaf(1)) == {
        0: ("status is idle",),
        1: ("status is busy or lost",),
    }
    every = Node(TestKind.LABEL, 3, branches=(1, 2, 3, 4))
    assert describe(every, make_leaf(0), make_leaf(1), make_leaf(1), make_leaf(1))[1] == (
        "status is not idle",
    )


def test_what_makes_no_difference_is_left_out() -> None:
    """done is asked on both sides of a cut, but only one side needs the cut."""
    nodes = (
        below(0, 2.0, 1, 2),
        make_leaf(1),
        Node(TestKind.LABEL, 2, branches=(3, 4)),
        make_leaf(0),
        make_leaf(1),
    )
    assert describe(*nodes) == {
        0: ("distance_to(A) is at least 2 m and done is no",),
        1: ("distance_to(A) is below 2 m", "done is yes"),
    }


NUMBERS: list[
    tuple[BoundFeature, list[float], list[float], list[str]]
] = [  # feature, cuts, values shown, said
    (DISTANCE, [0.123456], [], ["0.12 m"]),
    (DISTANCE, [1.2341, 1.2344], [], ["1.23 m", "1.234 m"]),
    (DISTANCE, [12345.5], [], ["12345.5 m"]),
    (DISTANCE, [0.000012345], [], ["0.00001 m"]),
    (DISTANCE, [2.3456], [2.3412, 2.3456], ["2.345 m"]),
    (DISTANCE, [nextafter(2.3412, inf)], [2.3412, 9.0], ["2.35 m"]),
    (DISTANCE, [nextafter(3.0, inf)], [3.0, 28.0], ["3 m"]),
    (DISTANCE, [3.0, nextafter(3.0, inf)], [2.0, 3.0, 4.0], ["3 m", "3 m"]),
    (AMOUNT, [1234.56], [], ["1235"]),
    (AMOUNT, [0.123456, 0.5], [0.12345, 0.4], ["0.1235", "0.5"]),
    (ANGLE, [0.0004, 90.0], [], ["0°", "90°"]),
    (ANGLE, [0.0004, 34.4564], [20.0, 40.0], ["0°", "34°"]),
    (ANGLE, [34.4564], [34.4, 34.4564], ["34.45°"]),
    (ANGLE, [34.4564], [34.4564, 20.0], ["34°"]),
    (ANGLE, [34.4564001], [34.4564, 40.0], ["35°"]),
    (ANGLE, [0.3, 359.8], [], ["0°", "−0.2°"]),
    (ANGLE, [350.0, 359.8], [], ["−10°", "0°"]),
]


@pytest.mark.parametrize(("feature", "cuts", "values", "said"), NUMBERS)
def test_numbers_are_as_short_as_they_can_be(
    feature: BoundFeature, cuts: list[float], values: list[float], said: list[str]
) -> None:
    """They are told apart, and what was shown stays on its side of them."""
    unit = radians if feature is ANGLE else float
    words = FeatureText(feature, map(unit, cuts), known_absent=False, values=map(unit, values))
    assert [words.number(unit(cut)) for cut in cuts] == said


@settings(max_examples=300)
@given(
    # No tree cuts between values that differ by rounding alone.
    st.lists(st.floats(0.01, 6.28), min_size=2, max_size=12, unique_by=lambda value: round(value, 7)),
    st.sampled_from(["m", "rad", "units"]),
)
def test_no_example_changes_sides(values: list[float], unit: str) -> None:
    """Cuts at every second value: what is said of them divides the values as they do."""
    kind = Toroidal() if unit == "rad" else Continuous()
    feature = BoundFeature(Feature("f", kind, reading="f", unit=unit))
    cuts = sorted(values)[1::2]
    words = FeatureText(feature, cuts, known_absent=False, values=values)
    numbers = [float(words.number(cut).split()[0].rstrip("°").replace("−", "-")) for cut in cuts]
    shown = [degrees(value) if unit == "rad" else value for value in values]
    for cut, number in zip(cuts, numbers, strict=True):
        exact = degrees(cut) if unit == "rad" else cut
        at_most = words.statement(ValueSet(((-inf, cut),), False)).split()[2:4] == ["at", "most"]
        if unit == "rad" and (number < 0.0 or (number == 0.0 and exact > 180.0)):
            number += 360.0
        assert [each <= number if at_most else each < number for each in shown] == [
            each < exact for each in shown
        ]


def test_sentences() -> None:
    tree = Tree((below(0, 2.0, 1, 2), make_leaf(1), make_leaf(0)))
    names = ("start", "load")
    assert describe_exits(tree, FEATURES, names, "start") == (
        "load when distance_to(A) is below 2 m",
        "stays otherwise",
    )
    assert describe_exits(Tree((make_leaf(1),)), FEATURES, names, "start") == ("load always",)
    assert describe_exits(Tree((make_leaf(0),)), FEATURES, names, "start") == ("stays always",)


def test_the_path_of_one_decision() -> None:
    tree = Tree(
        (below(0, 5.0, 1, 4, absent=4), below(0, 2.0, 2, 3), make_leaf(0), make_leaf(1), make_leaf(2))
    )
    steps, _ = tree.path((3.0, 0, 0, 0))
    assert describe_path(tree, steps, FEATURES) == ("distance_to(A) is between 2 m and 5 m",)
    steps, _ = tree.path((nan, 0, 0, 0))
    assert describe_path(tree, steps, FEATURES) == ("distance_to(A) is absent",)


@settings(max_examples=300)
@given(draw_tables(), st.data())
def test_what_is_said_is_what_is_decided(table: tuple[list[Row], list[Kind]], data: st.DataObject) -> None:
    """Each vector is in a box of exactly the outcome decided for it, or in none where nothing was shown."""
    rows, kinds = table
    tree = learn_tree(rows, kinds)
    features = [BoundFeature(Feature(f"f{index}", kind, reading="f")) for index, kind in enumerate(kinds)]
    found = simplify_outcome_boxes(tree, features)
    cuts = [cut for node in tree.nodes for cut in (node.low, node.high) if cut == cut]
    interesting = sorted({0.0, 1.0, 2.0, *cuts, *(nextafter(cut, 0) for cut in cuts)})
    for _ in range(10):
        vector = []
        for kind in kinds:
            values = [value for value in interesting if within(value, kind)]
            vector.append(data.draw(st.sampled_from([*values, nan])))
        outcome = tree.decide(vector)
        mine = {
            index
            for index, places in found.items()
            if any(all(x in region for x, region in zip(vector, box, strict=True)) for box in places)
        }
        if nan_is_unknown(tree, vector):
            continue  # the words do not mention absence where it was never shown
        assert mine == ({outcome} if outcome != STAY else set())


def within(value: float, kind: Kind) -> bool:
    if isinstance(kind, Categorical):
        return value == int(value) < len(kind.labels)
    return not isinstance(kind, Toroidal) or 0 <= value < kind.period


def nan_is_unknown(tree: Tree, vector: list[float]) -> bool:
    known = {
        node.feature
        for node in tree.nodes
        if node.test == TestKind.ABSENT or (node.test != TestKind.LEAF and node.absent != STAY)
    }
    return any(x != x and feature not in known for feature, x in enumerate(vector))


def test_regions() -> None:
    line = ValueSet(((-inf, 2.0), (5.0, inf)), False)
    assert (line & ValueSet(((1.0, 6.0),), True)) == ValueSet(((1.0, 2.0), (5.0, 6.0)), False)
    assert (line | ValueSet(((2.0, 5.0),), True)) == ValueSet(((-inf, inf),), True)
    assert nan in ABSENT_ONLY
    assert 5.0 in line
    assert 2.0 not in line


def test_boxes_cover_deep_trees() -> None:
    """A tree deeper than Python's stack, as noise grows them."""
    depth = 3000
    nodes = [below(0, float(level), 2 * level + 1, 2 * level + 2) for level in range(depth)]
    flat = [each for level, node in enumerate(nodes) for each in (node, make_leaf(level % 2))]
    tree = Tree((*flat, make_leaf(0)))
    assert len(list_leaf_boxes(tree, [Continuous()])) == depth + 1


@pytest.mark.parametrize(
    "texts", [describe_tree_outcomes, lambda tree, features: list_leaf_boxes(tree, [Continuous()])]
)
def test_same_tree_same_words(texts: object) -> None:
    tree = Tree((below(0, 2.0, 1, 2), make_leaf(1), make_leaf(0)))
    assert callable(texts)
    assert texts(tree, (DISTANCE,)) == texts(tree, (DISTANCE,))
