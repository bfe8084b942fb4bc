"""What changed in one line, as tables: two trees, the press between them, and what is said of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import inf, nan, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.learning.reference import Row
from tests.make.lessons import draw_tables, learn_tree

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.change_summary import LITTLE, ChangeSummary, summarize_change
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.tree_overlay import OverlayCell, ReadingSpread, find_features_between, overlay_boxes
from understudy.model.tree_regions import ValueSet, find_known_absent, list_leaf_boxes
from understudy.model.value_kinds import TAU, Categorical, Continuous, Kind, Toroidal

FAR = BoundFeature(Feature("distance_to", Continuous(), reading="range", of="A", unit="m"), Binding(A="A"))
AIM = BoundFeature(Feature("angle_to", Toroidal(), reading="bearing", of="A", unit="rad"), Binding(A="A"))
STATES = (START, State("forward", "forward"), State("turn", "left"), State("done", flag="done"))
AHEAD, TURN, DONE = map(make_leaf, (1, 2, 3))
SEEN = [(4.0, 5, "forward"), (0.3, 10, "done"), (2.0, 40, "turn"), (3.0, -10, "forward"), (0.0, 0, "done")]
"""Distance in m, angle in °, next state: examples in state forward, at 0 to 4 m."""


def example(far: float, aim: float, following: str, kind: str = "directive", number: int = 0) -> Example:
    return Example(number, "forward", (far, radians(aim) % TAU), following, ExampleKind(kind))


def make_goto(*nodes: Node, states: tuple[State, ...] = STATES) -> TrainedAutomaton:
    """An automaton that decides in forward with a tree."""
    bare = Automaton("goto", states, (FAR, AIM), ("A",))
    shown = tuple(example(*row, number=number) for number, row in enumerate(SEEN))
    transitions = {"forward": Tree(nodes)} if nodes else {}
    return TrainedAutomaton(replace(bare, transitions=transitions), Lesson(bare, shown))


def near(cut: float, yes: int, no: int) -> Node:
    return Node(TestKind.BELOW, 0, high=cut, yes=yes, no=no)


def ahead(low: float, high: float, yes: int, no: int) -> Node:
    return Node(TestKind.ARC, 1, low=radians(low), high=radians(high), yes=yes, no=no)


STAYS = make_goto(AHEAD)
STOPS = make_goto(near(0.4, 1, 2), DONE, AHEAD)
STOPS_AND_TURNS = make_goto(near(0.4, 1, 2), DONE, ahead(30, 180, 3, 4), TURN, AHEAD)
TURNS_FIRST = make_goto(ahead(30, 180, 1, 2), TURN, near(0.4, 3, 4), DONE, AHEAD)
PRESSED_DONE, PRESSED_TURN = example(0.37, 26, "done"), example(2.0, 35, "turn")
PRESSED_STAY = example(2.0, 35, "forward", "confirmation")

ROWS: list[tuple[str, TrainedAutomaton, TrainedAutomaton, list[Example], str | None]] = [
    ("the same", STOPS, STOPS, [], None),
    ("a switch that is pressed for the first time", STAYS, STOPS, [PRESSED_DONE], None),
    ("another one, beside it", STOPS, STOPS_AND_TURNS, [PRESSED_TURN], None),
    (
        "what the pressed switch takes from another",
        make_goto(ahead(30, 180, 1, 2), TURN, AHEAD),
        STOPS_AND_TURNS,
        [PRESSED_DONE],
        None,
    ),
    (
        "a narrow part, though there was a press",
        make_goto(near(0.29, 1, 2), DONE, AHEAD),
        make_goto(near(0.31, 1, 2), DONE, AHEAD),
        [],
        None,
    ),
    ("what was not pressed", STOPS, STOPS_AND_TURNS, [PRESSED_DONE], "forward now also goes to turn"),
    ("a flag", STAYS, STOPS, [PRESSED_STAY], "forward now also raises done"),
    ("a decision that is gone", STOPS_AND_TURNS, STOPS, [], "forward no longer goes to turn"),
    ("a flag that is gone", STOPS, STAYS, [], "forward no longer raises done"),
    ("a state that nothing decides in", STOPS, make_goto(), [], "forward no longer raises done"),
    ("a state in which nothing was decided", make_goto(), STOPS, [], None),
    (
        "staying is gone",
        STOPS,
        make_goto(near(0.4, 1, 2), DONE, TURN),
        [PRESSED_TURN],
        "forward is now always left",
    ),
    ("a little moved", STOPS, make_goto(near(0.5, 1, 2), DONE, AHEAD), [], None),
    (
        "much moved",
        STOPS,
        make_goto(near(2.4, 1, 2), DONE, AHEAD),
        [],
        "forward now also raises done where distance_to(A) is between 0.4 m and 2.4 m",
    ),
    (
        "much moved, where it was pressed",
        STOPS,
        make_goto(near(2.4, 1, 2), DONE, AHEAD),
        [example(2.3, 0, "done")],
        None,
    ),
    (
        "less than before",
        STOPS_AND_TURNS,
        make_goto(near(0.4, 1, 2), DONE, ahead(90, 180, 3, 4), TURN, AHEAD),
        [],
        "forward no longer goes to turn where angle_to(A) is between 30° and 90°",
    ),
    (  # a switch from turning to done is said once, of the flag
        "more and less than before",
        make_goto(near(1, 1, 2), ahead(350, 60, 3, 2), AHEAD, DONE),
        make_goto(near(3.5, 1, 2), ahead(0, 30, 3, 2), AHEAD, DONE),
        [],
        "forward now also raises done where distance_to(A) is between 1 m and 3.5 m, "
        "but no longer where angle_to(A) is between 30° and 60° or between −10° and 0°",
    ),
    (
        "what was another decision",
        make_goto(near(0.4, 1, 2), DONE, TURN),
        make_goto(near(2.4, 1, 2), DONE, TURN),
        [],
        "forward now also raises done where distance_to(A) is between 0.4 m and 2.4 m",
    ),
    (
        "half of a narrow part",
        make_goto(ahead(36, 42, 1, 2), TURN, AHEAD),
        make_goto(ahead(36, 39, 1, 2), TURN, AHEAD),
        [],
        "forward no longer goes to turn where angle_to(A) is between 39° and 42°",
    ),
    (
        "at other places only",
        make_goto(ahead(30, 90, 1, 2), TURN, AHEAD),
        make_goto(ahead(100, 180, 1, 2), TURN, AHEAD),
        [],
        "forward now goes to turn elsewhere than before",
    ),
    (  # spoils: done far away, wherever it is to the left
        "another feature beside",
        STOPS,
        make_goto(ahead(23, 186, 1, 2), DONE, near(0.4, 3, 4), DONE, AHEAD),
        [PRESSED_DONE],
        "in forward, done now also looks at angle_to(A)",
    ),
    (
        "another feature instead",
        STOPS,
        make_goto(ahead(23, 186, 1, 2), DONE, AHEAD),
        [],
        "in forward, done now looks at angle_to(A), no longer at distance_to(A)",
    ),
    (
        "a feature less",
        make_goto(ahead(23, 186, 1, 2), DONE, near(0.4, 3, 4), DONE, AHEAD),
        STOPS,
        [],
        "in forward, done no longer looks at angle_to(A)",
    ),
    (
        "the order of tests",
        STOPS_AND_TURNS,
        TURNS_FIRST,
        [],
        "in forward, done now also looks at angle_to(A); in forward, turn no longer looks at distance_to(A)",
    ),
    (
        "a press that is outvoted",
        STOPS,
        STOPS,
        [example(2.0, 0, "done")],
        "forward still stays where done was pressed",
    ),
    (
        "a press that is decided otherwise",
        STOPS,
        STOPS,
        [example(0.2, 0, "turn")],
        "forward still raises done where turn was pressed",
    ),
    (
        "a confirmation that is outvoted",
        STOPS_AND_TURNS,
        STOPS_AND_TURNS,
        [example(2.0, 40, "forward", "confirmation")],
        "forward still goes to turn where it was confirmed",
    ),
    (
        "a state that is left at once",
        STOPS_AND_TURNS,
        STOPS_AND_TURNS,
        [example(2.0, 40, "forward", "default")],
        "forward goes to turn at once",
    ),
    (
        "two changes",
        STOPS_AND_TURNS,
        make_goto(ahead(23, 186, 1, 2), DONE, near(0.4, 3, 4), DONE, AHEAD),
        [PRESSED_DONE],
        "forward no longer goes to turn; in forward, done now also looks at angle_to(A)",
    ),
]


@pytest.mark.parametrize(
    ("before", "after", "pressed", "said"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS]
)
def test_one_line(
    before: TrainedAutomaton, after: TrainedAutomaton, pressed: list[Example], said: str | None
) -> None:
    found = summarize_change(before, after, pressed)
    assert (None if found is None else str(found)) == said


def test_the_conditions_of_a_change() -> None:
    found = summarize_change(STOPS, make_goto(ahead(23, 186, 1, 2), DONE, AHEAD))
    assert found is not None
    (change,) = found.changes
    assert (change.state, change.next, change.how) == ("forward", "done", "features")
    assert change.was == ("distance_to(A) is below 0.4 m",)
    assert change.now == ("angle_to(A) is at least 23° or below −174°",)


def test_a_line_names_two_changes_and_counts_the_others() -> None:
    (change,) = summarize_change(STOPS, STAYS).changes  # type: ignore[union-attr]
    texts = [replace(change, said=said) for said in ("one", "two", "three", "four")]
    assert str(ChangeSummary(tuple(texts[:2]))) == "one; two"
    assert str(ChangeSummary(tuple(texts))) == "one; two; and 2 more"


def test_the_most_important_comes_first() -> None:
    before = make_goto(near(0.4, 1, 2), DONE, ahead(30, 180, 3, 4), TURN, AHEAD)
    after = make_goto(ahead(23, 186, 1, 2), DONE, near(0.4, 3, 4), DONE, AHEAD)
    found = summarize_change(before, after, [example(4.0, 0, "done")])
    assert found is not None
    assert [change.how for change in found.changes] == ["overruled", "gone"]


def test_of_large_trees_only_what_is_gone_or_new_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    spoiled = make_goto(ahead(23, 186, 1, 2), DONE, near(0.4, 3, 4), DONE, AHEAD)
    monkeypatch.setattr("understudy.model.change_summary.MOST_CELLS", 1)
    found = summarize_change(STOPS_AND_TURNS, spoiled)
    assert str(found) == "forward no longer goes to turn"
    assert found is not None
    assert found.changes[0].was == ()


SHARES = [  # the values of one feature, a set of values, the share of the values in it, and that of their range
    ((1.0, 2.0, 3.0, 5.0), ValueSet(((0.0, 2.0),), False), 0.25, 0.25),
    ((1.0, 2.0, 3.0, 5.0), ValueSet(((2.0, inf),), False), 0.75, 0.75),
    ((1.0, 1.0, 1.0, 5.0), ValueSet(((0.0, 2.0), (4.0, 9.0)), False), 1.0, 0.5),
    ((1.0, nan, 5.0, nan), ValueSet(((0.0, 2.0),), True), 0.75, 0.625),
    ((2.0, 2.0), ValueSet(((0.0, 2.0),), False), 0.0, 0.0),
    ((2.0, 2.0), ValueSet(((2.0, 3.0),), False), 1.0, 1.0),
    ((), ValueSet(((2.0, 3.0),), False), 0.0, 0.0),
]


@pytest.mark.parametrize(("values", "region", "counted", "covered"), SHARES)
def test_shares(values: tuple[float, ...], region: ValueSet, counted: float, covered: float) -> None:
    spread = ReadingSpread([(value,) for value in values], [Continuous()])
    assert (spread.count_values([(region,)]), spread.cover_range([(region,)])) == (counted, covered)


def test_the_shares_of_an_angle_and_of_a_label_are_those_of_all() -> None:
    spread = ReadingSpread([(0.0, 0.0), (1.0, 0.0)], [Toroidal(4.0), Categorical(("a", "b"))])
    assert spread.cover_range([(ValueSet(((0.0, 2.0),), False), ValueSet(((0.0, 1.0),), False))]) == 0.25


def test_other_features_cannot_be_compared() -> None:
    bare = Automaton("goto", STATES, (FAR,), ("A",))
    other = TrainedAutomaton(replace(bare, transitions={"forward": Tree((AHEAD,))}), Lesson(bare))
    assert summarize_change(STOPS, other) is None


def test_a_stateless_automaton_has_one_decision() -> None:
    def stateless(*nodes: Node) -> TrainedAutomaton:
        one = make_goto(*nodes)
        trees = {"start": Tree(nodes), "forward": Tree(nodes)}
        return TrainedAutomaton(replace(one.automaton, stateless=True, transitions=trees), one.lesson)

    before, after = stateless(near(0.4, 1, 2), DONE, AHEAD), stateless(ahead(23, 186, 1, 2), DONE, AHEAD)
    said = "done and forward now look at angle_to(A), no longer at distance_to(A)"
    assert str(summarize_change(before, after)) == said
    gone = str(summarize_change(before, stateless(AHEAD)))
    assert gone == "it no longer raises done; forward no longer looks at distance_to(A)"


# Laws


def vectors_of(rows: list[Row], trees: list[Tree], kinds: list[Kind]) -> list[list[float]]:
    """For each feature, all values of examples and all thresholds of trees: at least one in each cell.

    Absence is one of them if a tree knows it.
    """
    found = []
    for feature, kind in enumerate(kinds):
        cuts = {
            cut
            for tree in trees
            for node in tree.nodes
            if node.feature == feature
            for cut in (node.low, node.high)
            if cut == cut
        }
        values = {row.values[feature] for row in rows if row.values[feature] == row.values[feature]}
        least = [min([*values, *cuts], default=0.0) - 1.0] if isinstance(kind, Continuous) else [0.0]
        if isinstance(kind, Categorical):
            values = set(map(float, range(len(kind.labels))))
        absent = [nan] if any(find_known_absent(tree, len(kinds))[feature] for tree in trees) else []
        found.append([*sorted({*values, *cuts, *least}), *absent])
    return found


def cells_of(old: Tree, new: Tree, kinds: list[Kind]) -> list[OverlayCell]:
    """The cells of two trees, with outcomes in place of names."""
    known = list(map(max, *(find_known_absent(tree, len(kinds)) for tree in (old, new))))
    leaves = (
        [(str(outcome), box) for outcome, box in list_leaf_boxes(tree, kinds, known_absent=known)]
        for tree in (old, new)
    )
    return overlay_boxes(*leaves)


@st.composite
def pairs(draw: st.DrawFn) -> tuple[list[Row], list[Row], list[Kind]]:
    """The rows of two lessons with the same features, most of them in both."""
    rows, kinds = draw(draw_tables())
    kept = draw(st.lists(st.sampled_from(rows), min_size=1, unique_by=id))
    return rows, kept, kinds


@given(pairs())
@settings(max_examples=150, deadline=None)
def test_every_vector_is_in_one_cell_which_knows_both_decisions(
    case: tuple[list[Row], list[Row], list[Kind]],
) -> None:
    rows, kept, kinds = case
    old, new = learn_tree(kept, kinds), learn_tree(rows, kinds)
    cells = cells_of(old, new, kinds)
    for vector in product(*vectors_of(rows, [old, new], kinds)):
        inside = [
            cell
            for cell in cells
            if all(value in region for value, region in zip(vector, cell.box, strict=True))
        ]
        known = [
            cell
            for cell in inside
            if (cell.was, cell.now) == (str(old.decide(vector)), str(new.decide(vector)))
        ]
        assert len(inside) == len(known) == 1


@given(draw_tables())
@settings(max_examples=100, deadline=None)
def test_a_feature_decides_if_it_alone_can_change_the_decision(case: tuple[list[Row], list[Kind]]) -> None:
    rows, kinds = case
    tree = learn_tree(rows, kinds)
    values = vectors_of(rows, [tree], kinds)
    leaves = list_leaf_boxes(tree, kinds)
    for outcome in {outcome for outcome, _ in leaves}:
        found = find_features_between(
            [box for each, box in leaves if each == outcome], [box for each, box in leaves if each != outcome]
        )
        assert found == {
            feature
            for feature in range(len(kinds))
            for vector in product(*values)
            for other in values[feature]
            if (tree.decide(vector) == outcome)
            != (tree.decide((*vector[:feature], other, *vector[feature + 1 :])) == outcome)
        }


def learn_rows(rows: list[Row], kinds: list[Kind]) -> TrainedAutomaton:
    """An automaton whose second state decides with the tree of the rows."""
    features = tuple(BoundFeature(Feature(f"f{at}", kind, reading="f")) for at, kind in enumerate(kinds))
    names = (START, State("one", "one"), State("two", "two"))
    bare = Automaton("drawn", names, features)
    shown = [
        Example(number, "one", row.values, names[row.outcome].name, ExampleKind.DIRECTIVE)
        for number, row in enumerate(rows)
    ]
    automaton = replace(bare, transitions={"one": learn_tree(rows, kinds, current=1)})
    return TrainedAutomaton(automaton, Lesson(bare, tuple(shown)))


@given(pairs())
@settings(max_examples=150, deadline=None)
def test_what_is_said_is_new_or_gone_or_more_than_a_little(
    case: tuple[list[Row], list[Row], list[Kind]],
) -> None:
    """Without a press, next states that are new or gone are named, and others only if more than a little changed."""
    rows, kept, kinds = case
    before, after = learn_rows(kept, kinds), learn_rows(rows, kinds)
    old, new = (each.automaton.transitions["one"] for each in (before, after))
    assert isinstance(old, Tree)
    assert isinstance(new, Tree)
    spread = ReadingSpread([row.values for row in rows], kinds)
    must, may = set(), set()
    for index, name in enumerate(after.automaton.state_names):
        mine = {str(index), *({str(STAY)} if name == "one" else ())}
        changed = [cell.box for cell in cells_of(old, new, kinds) if (cell.was in mine) != (cell.now in mine)]
        before_and_now = [
            any(node.test == TestKind.LEAF and node.yes == index for node in tree.nodes)
            for tree in (old, new)
        ]
        if name == "one":
            continue  # staying: what is decided there is said of the others
        if before_and_now in ([True, False], [False, True]):
            must.add(name)
        elif max(spread.count_values(changed), spread.cover_range(changed)) >= LITTLE:
            may.add(name)
    found = summarize_change(before, after)
    named = set() if found is None else {change.next for change in found.changes} - {"one"}
    assert must <= named <= must | may
