"""Pruning, as tables that can be counted by hand, and laws for every tree."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from tests.learning.reference import Row
from tests.make.lessons import draw_tables, learn_tree, make_lesson

from understudy.errors import DefinitionError
from understudy.learning import pruning_suggestions
from understudy.learning.fit import learn
from understudy.learning.pruning import list_pruning_steps, prune_tree
from understudy.learning.pruning_suggestions import ENOUGH, replace_pruning, suggest_pruning
from understudy.learning.training_set import TrainingSet, group_examples_by_state, make_training_set
from understudy.model.learner_options import LearnerOptions, SklearnOptions, TreeOptions
from understudy.model.lesson import ExampleKind, Lesson
from understudy.model.tree import TestKind, Tree
from understudy.model.value_kinds import Categorical, Kind


def go(*rows: tuple[float, str]) -> Lesson:
    """Confirmed to go, or told to turn or stop, at distances."""
    kinds = {"go": "confirmation", "turn": "directive", "stop": "directive"}
    return make_lesson([("go", (value,), following, kinds[following]) for value, following in rows])


def decide_each(made: Lesson, pruning: float, values: list[float]) -> list[str]:
    function = learn(replace_pruning(made, pruning))["go"]
    names = made.automaton.state_names
    return [names[function.decide([value])] for value in values]


# Four times it went on, three times it stopped near by, once it turned farther off: two questions. That for turning
# sets one example right with one leaf more, that for stopping three.
THREE = go(
    (9.0, "go"), (8.0, "go"), (7.0, "go"), (6.0, "go"),
    (20.0, "turn"),
    (1.0, "stop"), (2.0, "stop"), (3.0, "stop"),
)  # fmt: skip


@pytest.mark.parametrize(
    ("pruning", "expected"),
    [
        (0.0, ["stop", "go", "turn"]),
        (0.9, ["stop", "go", "turn"]),
        (1.0, ["stop", "go", "go"]),
        (2.9, ["stop", "go", "go"]),
        (3.0, ["go", "go", "go"]),
    ],
)
def test_the_weakest_question_goes_first(pruning: float, expected: list[str]) -> None:
    assert decide_each(THREE, pruning, [2.0, 7.0, 20.0]) == expected


def test_watched_examples_count_a_tenth() -> None:
    rows: list[tuple[Any, ...]] = [
        ("go", (9.0,), "go", "confirmation"),
        ("go", (8.0,), "go", "confirmation"),
        ("go", (1.0,), "stop", "directive"),
    ]
    watched = [("go", (value,), "stop", "watched") for value in (1.5, 1.7, 1.9)]
    made = make_lesson([*rows, *watched])
    assert decide_each(made, 1.2, [1.0]) == ["stop"]
    assert decide_each(made, 1.3, [1.0]) == ["go"]


def test_what_counts_is_how_much_for_each_leaf() -> None:
    """To turn between two places where it goes on takes two questions: half an example for each."""
    made = go((1.0, "go"), (2.0, "go"), (5.0, "turn"), (8.0, "go"), (9.0, "go"))
    assert decide_each(made, 0.4, [5.0]) == ["turn"]
    assert decide_each(made, 0.5, [5.0]) == ["go"]


def test_of_equally_weak_questions_the_topmost_goes_first() -> None:
    """Turning sets one right with one leaf more, both together two with two: all goes in one step."""
    made = go((1.0, "stop"), (5.0, "go"), (5.5, "go"), (6.0, "go"), (9.0, "turn"))
    shown = make_training_set(made, group_examples_by_state(made)["go"], "go")
    assert [worth for worth, _ in list_pruning_steps(tree_in(made), shown)] == [1.0]


def test_a_tie_stays() -> None:
    made = go((9.0, "go"), (1.0, "stop"))
    assert decide_each(made, 1.0, [1.0, 9.0]) == ["go", "go"]
    first = ("stop", (5.0,), "go", "directive")  # so that stop is declared before go
    rows: list[tuple[Any, ...]] = [
        first,
        ("go", (9.0,), "go", "confirmation"),
        ("go", (1.0,), "stop", "directive"),
    ]
    assert decide_each(make_lesson(rows), 1.0, [1.0, 9.0]) == ["go", "go"]


def test_what_makes_no_sense_is_refused() -> None:
    for pruning in (-1.0, float("nan"), float("inf")):
        with pytest.raises(DefinitionError, match="0 prunes nothing"):
            TreeOptions(pruning=pruning)


def tree_in(made: Lesson) -> Tree:
    tree = learn(made)["go"]
    assert isinstance(tree, Tree)
    return tree


def collect_training_set(rows: list[Row], kinds: list[Kind]) -> TrainingSet:
    return TrainingSet(
        (),
        np.array([row.values for row in rows], np.float64).reshape(len(rows), len(kinds)),
        np.array([row.outcome for row in rows], np.int64),
        np.array([row.group for row in rows], np.int64),
        0,
    )


def answers(tree: Tree) -> int:
    return sum(node.test == TestKind.LEAF for node in tree.nodes)


def wrong(tree: Tree, rows: list[Row]) -> float:
    return sum(
        (0.1 if row.group == 2 else 1.0) for row in rows if tree.decide(row.values) not in (row.outcome, -1)
    )


@given(draw_tables(watched=True))
def test_step_by_step_it_gets_simpler_down_to_one_answer(drawn: tuple[list[Row], list[Kind]]) -> None:
    """Each step is worth what it says in examples for each answer that went, and never less than the one before."""
    rows, kinds = drawn
    tree = learn_tree(rows, kinds, current=0, midpoints=True)
    worth = 0.0
    for step, simpler in list_pruning_steps(tree, collect_training_set(rows, kinds)):
        assert step >= worth
        assert len(simpler.nodes) < len(tree.nodes)
        gone = answers(tree) - answers(simpler)
        assert wrong(simpler, rows) - wrong(tree, rows) <= step * max(1, gone) + 1e-6
        tree, worth = simpler, step
    assert answers(tree) == 1


@given(draw_tables())
def test_pruned_by_nothing_only_idle_questions_go(drawn: tuple[list[Row], list[Kind]]) -> None:
    rows, kinds = drawn
    tree = learn_tree(rows, kinds, current=0)
    simpler = prune_tree(tree, collect_training_set(rows, kinds), 0.0)
    assert wrong(simpler, rows) <= wrong(tree, rows)


def noisy(row: tuple[int, ...] = ()) -> Lesson:
    """It stops below 5; two of forty were pressed wrong, and where `row` says."""
    wrong = (6, 33, *row)
    return go(*((number / 4, "stop" if (number < 20) != (number in wrong) else "go") for number in range(40)))


def test_a_suggestion_takes_what_costs_nothing() -> None:
    """Left out in turn, the neighbors of the wrong presses are decided wrong, unless these are pruned away."""
    found = suggest_pruning(noisy())
    assert found is not None
    assert found.left_out == 40
    assert (found.wrong, found.wrong_pruned) == (5, 3), "the two themselves, and one at the boundary"
    assert decide_each(noisy(), found.pruning, [1.5, 8.25, 1.0, 9.0]) == ["stop", "go", "stop", "go"]


def test_watched_examples_are_not_left_out() -> None:
    made = noisy()
    watched = tuple(
        replace(each, number=100 + each.number, kind=ExampleKind.WATCHED) for each in made.examples
    )
    found = suggest_pruning(replace(made, examples=made.examples + watched))
    assert found is not None
    assert found.left_out == 40


def test_of_several_that_are_as_good_the_simplest_is_suggested() -> None:
    """A wrong press at either end costs nothing, whether it goes or not."""
    found = suggest_pruning(noisy())
    assert found is not None
    worths = [
        worth
        for worth, _ in list_pruning_steps(
            tree_in(noisy()), make_training_set(noisy(), group_examples_by_state(noisy())["go"], "go")
        )
    ]
    assert found.pruning == max(worth for worth in worths if worth < 5)


def test_a_suggestion_gives_nothing_up_for_simplicity() -> None:
    """Three in a row that go on where it stops are no mistake: without them it would still be less wrong (6) than
    without any pruning (7), but not as right as it can be (5)."""
    found = suggest_pruning(noisy(row=(10, 11, 12)))
    assert found is not None
    assert (found.pruning, found.wrong, found.wrong_pruned) == (0.5, 7, 5)


def test_nothing_is_suggested_where_all_is_needed() -> None:
    rows = [(float(number), "stop" if number < 20 else "go") for number in range(40)]
    found = suggest_pruning(go(*rows))
    assert found is not None
    assert decide_each(go(*rows), found.pruning, [3.0, 30.0]) == ["stop", "go"]


def test_too_few_examples_and_classifiers_get_no_advice() -> None:
    assert suggest_pruning(go(*((float(number), "go") for number in range(ENOUGH - 1)))) is None
    assert suggest_pruning(go(*((float(number), "go") for number in range(ENOUGH)))) is not None
    assert suggest_pruning(THREE) is None
    classified = replace(noisy(), options=LearnerOptions(learner=SklearnOptions("SVC")))
    assert suggest_pruning(classified) is None
    assert replace_pruning(classified, 1.0) == classified


def test_never_on_by_default() -> None:
    assert TreeOptions().pruning == 0.0
    assert LearnerOptions().learner == TreeOptions()


def test_of_a_larger_lesson_several_are_left_out_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is left out just once, whoever is left out with it."""
    for most in (1, 7, 40):
        monkeypatch.setattr(pruning_suggestions, "MOST_TRIALS", most)
        found = suggest_pruning(noisy())
        assert found is not None
        assert found.left_out == 40
        assert (found.wrong_pruned == 3) == (most > 1), "of all at once nothing is left to learn from"


def test_in_a_stateless_lesson_what_was_never_shown_is_told_by_each_state() -> None:
    """A label that only one example has leads nowhere without it: whoever is there stays."""
    rows: list[tuple[Any, ...]] = [("go", (0,), "stop", "directive"), ("stop", (1,), "go", "directive")] * 15
    kinds: list[Kind] = [Categorical(("a", "b", "c"))]
    for state, wrong in (("go", 1), ("stop", 0)):
        found = suggest_pruning(
            make_lesson([*rows, (state, (2,), "stop", "directive")], kinds, stateless=True)
        )
        assert found is not None
        assert (found.left_out, found.wrong) == (31, wrong)
