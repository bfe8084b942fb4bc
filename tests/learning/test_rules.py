"""The rules of ARCHITECTURE section 3, each as a table to check by hand."""

from __future__ import annotations

from math import inf, nextafter
from typing import Any

import pytest
from tests.learning.reference import Row
from tests.make.lessons import ABSENT, KINDS, learn_tree

from understudy.learning.fit import learn
from understudy.learning.thresholds import Gap, compute_arc, compute_threshold, vote
from understudy.model.tree import STAY, Node, TestKind, Tree
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Kind, Toroidal

CIRCLE = Toroidal(360.0)
STAYS, GOES, ELSE = 0, 1, 2


def above(value: float) -> float:
    return nextafter(value, inf)


def tree(*shown: tuple[Any, ...], kinds: list[Kind] | None = None, midpoints: bool = False) -> Tree:
    """Examples (kind, outcome, values…) of state 0."""
    rows = [Row(tuple(map(float, values)), outcome, KINDS[kind]) for kind, outcome, *values in shown]
    return learn_tree(rows, kinds or [Continuous()] * len(rows[0].values), current=STAYS, midpoints=midpoints)


THRESHOLDS = [  # (kind, outcome, value)…, where the cut goes
    ("102 100 60 53 | 3: the gap is the default's",
     [("default", 0, 102), ("default", 0, 100), ("default", 0, 60), ("default", 0, 53), ("directive", 1, 3)],
     above(3)),
    ("the directive above", [("default", 0, 3), ("directive", 1, 53)], 53),
    ("two directives: the middle", [("directive", 1, 3), ("directive", 2, 53)], 28),
    ("two defaults: the middle", [("default", 0, 3), ("default", 2, 53)], 28),
    ("a confirmation counts as a directive", [("confirmation", 0, 53), ("directive", 1, 3)], 28),
    ("a value with a default and a confirmation is not default",
     [("default", 0, 53), ("confirmation", 0, 53), ("directive", 1, 3)], 28),
    ("watched examples: the middle", [("default", 0, 53), ("directive", 1, 3), ("watched", 0, 90)], 28),
    ("watched examples place the cut", [("default", 0, 53), ("directive", 1, 3), ("watched", 0, 5)], 4),
    ("halfway between neighboring floats", [("directive", 0, above(1)), ("directive", 1, 1)], above(1)),
    ("a default just above a directive", [("default", 0, above(1)), ("directive", 1, 1)], above(1)),
    ("zero has no sign", [("default", 0, 1), ("directive", 1, -0.0), ("directive", 1, 0.0)], above(0)),
]  # fmt: skip


@pytest.mark.parametrize(("what", "shown", "cut"), THRESHOLDS, ids=[row[0] for row in THRESHOLDS])
def test_where_a_threshold_goes(what: str, shown: list[tuple[Any, ...]], cut: float) -> None:
    root = tree(*shown).nodes[0]
    assert (root.test, root.high) == (TestKind.BELOW, cut)


def test_midpoints_everywhere_where_the_lesson_says_so() -> None:
    assert tree(("default", 0, 53), ("directive", 1, 3), midpoints=True).nodes[0].high == 28


PERIOD_EDGE = nextafter(360.0, 0)

ARCS = [
    ("one directive between two defaults, equally far: the first end",
     [("default", 0, 90), ("directive", 1, 180), ("default", 0, 270)], (180, 225)),
    ("the narrower end follows the directive, the other is halved",
     [("default", 0, 90), ("directive", 1, 180), ("default", 0, 200)], (135, above(180))),
    ("one directive across the seam",
     [("default", 0, 350), ("directive", 1, 2), ("default", 0, 20)], (2, 11)),
    ("two directives: both ends halved",
     [("directive", 0, 90), ("directive", 1, 180), ("directive", 0, 270)], (135, 225)),
    ("an end at the last float before the period goes round to 0",
     [("directive", 1, PERIOD_EDGE), ("default", 0, 1), ("default", 0, 300)], (330, 0)),
    ("a middle beyond the period goes round",
     [("directive", 1, 340), ("directive", 0, 40), ("directive", 0, 300)], (320, 10)),
]  # fmt: skip


@pytest.mark.parametrize(("what", "shown", "ends"), ARCS, ids=[row[0] for row in ARCS])
def test_where_an_arc_ends(what: str, shown: list[tuple[Any, ...]], ends: tuple[float, float]) -> None:
    grown = tree(*shown, kinds=[CIRCLE])
    root = grown.nodes[0]
    assert (root.test, root.low, root.high) == (TestKind.ARC, *ends)
    for _, outcome, value in shown:
        assert grown.decide((value,)) == outcome


def test_an_arc_across_the_seam_needs_one_question() -> None:
    shown = [("directive", int(20 < angle < 340), angle) for angle in range(0, 360, 10)]
    assert len(tree(*shown, kinds=[CIRCLE]).nodes) == 3


def test_shell_rules_alone() -> None:
    assert compute_threshold(Gap(3.0, 53.0, 1), midpoints=False) == above(3)
    assert compute_threshold(Gap(3.0, 53.0, 1), midpoints=True) == 28
    assert compute_threshold(Gap(-1.7e308, 1.7e308, 0), midpoints=True) == 0
    assert compute_arc(Gap(350.0, 10.0, -1), Gap(20.0, 40.0, 0), 360.0, midpoints=False) == (10, 30)


VOTES = [  # (outcome, kind)…, current state, answer
    ("majority", [(1, "directive"), (2, "directive"), (2, "directive")], 0, 2),
    ("a confirmation weighs as much as a directive", [(1, "directive"), (0, "confirmation")], 0, 0),
    ("defaults are heard only where nobody spoke", [(0, "default"), (0, "default"), (1, "directive")], 0, 1),
    ("defaults alone decide", [(0, "default"), (0, "default")], 0, 0),
    ("a tie without the current state: declared first", [(2, "directive"), (1, "directive")], 0, 1),
    ("watched ones never vote", [(2, "watched"), (2, "watched"), (1, "directive")], 0, 1),
    ("in stateless mode no state is current", [(1, "directive"), (0, "directive")], STAY, 0),
]


@pytest.mark.parametrize(("what", "votes", "current", "answer"), VOTES, ids=[row[0] for row in VOTES])
def test_votes_at_one_vector(what: str, votes: list[tuple[int, str]], current: int, answer: int) -> None:
    assert vote([(outcome, KINDS[kind]) for outcome, kind in votes], current=current) == answer
    grown = learn_tree(
        [Row((1.0,), outcome, KINDS[kind]) for outcome, kind in votes], [Continuous()], current=current
    )
    assert grown.decide((1.0,)) == answer


def test_examples_that_agree_are_one_leaf() -> None:
    assert tree(("default", 0, 1), ("confirmation", 0, 5)).nodes == (Node(TestKind.LEAF, yes=0),)


def test_exclusive_or_is_split_at_zero_gain() -> None:
    shown = [("directive", x ^ y, x, y) for x in (0, 1) for y in (0, 1)]
    grown = tree(*shown)
    assert all(grown.decide((x, y)) == outcome for _, outcome, x, y in shown)
    assert grown.nodes[0].feature == 0
    assert grown.nodes[0].high == 0.5


def test_absence_alone_tells_apart() -> None:
    root = tree(("directive", 1, ABSENT), ("default", 0, 4)).nodes[0]
    assert (root.test, root.yes, root.no) == (TestKind.ABSENT, 1, 2)


def test_absent_values_join_the_side_that_fits() -> None:
    grown = tree(("directive", 1, 1), ("directive", 2, 5), ("directive", 2, ABSENT))
    root = grown.nodes[0]
    assert (root.test, root.absent) == (TestKind.BELOW, root.no)
    assert grown.decide((ABSENT,)) == 2


def test_absent_values_join_a_label() -> None:
    shown = [("directive", 1, 0), ("directive", 0, 1), ("directive", 0, ABSENT), ("directive", 2, 2)]
    root = tree(*shown, kinds=[Categorical(("a", "b", "c"))]).nodes[0]
    assert (root.test, root.absent) == (TestKind.LABEL, root.branches[1])


def test_what_was_never_shown_stays() -> None:
    grown = tree(("directive", 1, 1), ("directive", 0, 5))
    assert grown.decide((ABSENT,)) == STAY
    labels = tree(("directive", 1, 0), ("directive", 0, 1), kinds=[Categorical(("a", "b", "c"))])
    assert labels.decide((2.0,)) == labels.decide((ABSENT,)) == STAY


def test_ties_go_to_the_widest_gap_then_to_the_feature_declared_first() -> None:
    wider = tree(("directive", 0, 0, 1), ("directive", 0, 5, 2), ("directive", 1, 6, 9))
    assert wider.nodes[0].feature == 1
    equal = tree(("directive", 0, 0, 0), ("directive", 1, 6, 9))
    assert equal.nodes[0].feature == 0
    label = tree(
        ("directive", 0, 0, 0), ("directive", 0, 5, 0), ("directive", 1, 6, 1), kinds=[Continuous(), BOOLEAN]
    )
    assert label.nodes[0].feature == 1


def test_what_differs_by_rounding_alone_has_no_wide_gap() -> None:
    """Two presses at the same distance: the angle tells them apart."""
    shown = [("directive", 0, 1.5, 0.9), ("directive", 1, nextafter(1.5, 2.0), 5.4)]
    assert tree(*shown, kinds=[Continuous(), Toroidal()]).nodes[0].feature == 1


def test_ties_within_a_feature_go_to_the_lowest_cut() -> None:
    shown = [("directive", 0, 1), ("directive", 1, 2), ("directive", 0, 3)]
    assert tree(*shown).nodes[0].high == 1.5


def test_watched_examples_make_no_question_of_their_own() -> None:
    """Feature 0 would separate the watched ones; no press-made example needs it."""
    shown = [("directive", 1, 0, 0), ("default", 0, 0, 9), *[("watched", 0, 5, 0)] * 20]
    grown = tree(*shown)
    assert [node.feature for node in grown.nodes if node.test != TestKind.LEAF] == [1]
    assert grown.decide((5, 0)) == 1


def test_a_branch_that_was_only_watched_stays() -> None:
    kind = Categorical(("a", "b", "c"))
    grown = tree(("directive", 1, 0), ("default", 0, 1), ("watched", 0, 2), kinds=[kind])
    assert grown.decide((2.0,)) == STAY


@pytest.mark.parametrize("kind", [Continuous(), CIRCLE, Categorical(("x", "y", "z"))])
def test_absence_that_was_only_watched_stays(kind: Kind) -> None:
    """Silence while nothing was sensed does not say what to do then; a press at such a moment does."""
    shown = [("directive", 1, 1), ("directive", 2, 2), *[("watched", 0, ABSENT)] * 3]
    assert tree(*shown, kinds=[kind]).decide([ABSENT]) == STAY
    assert tree(*shown, ("confirmation", 0, ABSENT), kinds=[kind]).decide([ABSENT]) == 0
    assert tree(*shown, ("directive", 1, ABSENT), kinds=[kind]).decide([ABSENT]) == 1


def test_watched_examples_weigh_a_tenth() -> None:
    """Two useful questions for the press-made ones; watched ones against the first choose the second."""
    pressed = [("directive", 1, 0, 0), ("directive", 1, 0, 0), ("default", 0, 1, 1), ("default", 0, 1, 1)]
    kinds: list[Kind] = [BOOLEAN, BOOLEAN]
    few, many = [("watched", 0, 0, 1)], [("watched", 0, 0, 1)] * 30
    assert tree(*pressed, kinds=kinds).nodes[0].feature == 0
    assert tree(*pressed, *few, kinds=kinds).nodes[0].feature == 1
    assert tree(*pressed, *many, kinds=kinds).nodes[0].feature == 1


def test_learn_is_imported_without_scikit_learn() -> None:
    assert learn.__module__ == "understudy.learning.fit"


def test_absent_values_that_fit_either_side_as_well_join_the_heavier_then_the_lower_or_inner() -> None:
    unsure = [("directive", 0, ABSENT), ("directive", 1, ABSENT)]
    low, high = [("directive", 0, 1)], [("directive", 1, 9)]
    for shown, side in ((low + high, "yes"), (low * 2 + high * 2, "yes")):
        root = tree(*shown, *unsure).nodes[0]
        assert (root.test, root.absent) == (TestKind.BELOW, getattr(root, side))
    across = [("directive", 0, 5), ("directive", 0, 5), ("directive", 1, 100), ("directive", 1, 300)]
    root = tree(*across, *unsure, kinds=[CIRCLE]).nodes[0]
    assert (root.test, root.low, root.high, root.absent) == (TestKind.ARC, 332.5, 52.5, root.yes)
