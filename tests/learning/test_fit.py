"""From lessons to automata: which states learn from what, reports and explanations."""

from __future__ import annotations

from dataclasses import replace
from math import nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.make.automata import draw_automaton
from tests.make.lessons import make_lesson

from understudy.errors import DefinitionError, UnknownName
from understudy.learning.explain import explain
from understudy.learning.fit import learn, learn_automaton
from understudy.learning.report import find_contradictions, find_disagreements, learn_and_report
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import State
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind, Toroidal

APPROACH = make_lesson(
    [
        ("start", [9], "forward", "directive"),
        ("forward", [9], "forward", "default"),
        ("forward", [2], "load", "directive"),
        ("load", [2], "load", "default"),
    ]
)


def test_states_without_press_made_examples_have_no_transition_function() -> None:
    watched = make_lesson([("forward", [1], "load", "watched"), ("start", [1], "forward", "directive")])
    assert set(learn(watched)) == {"start"}
    assert set(learn(APPROACH)) == {"start", "forward", "load"}


def test_flag_states_learn_nothing() -> None:
    shown = make_lesson([("forward", [1], "done", "directive"), ("done", [1], "forward", "directive")])
    start, forward, _ = shown.automaton.states
    flagged = replace(
        shown, automaton=replace(shown.automaton, states=(start, forward, State("done", flag="done")))
    )
    assert set(learn_automaton(flagged).transitions) == {"forward"}


def test_boundaries_follow_the_options() -> None:
    def find_cut(options: LearnerOptions) -> float:
        function = learn(replace(APPROACH, options=options))["forward"]
        return function.nodes[0].high if isinstance(function, Tree) else nan

    assert find_cut(LearnerOptions()) == pytest.approx(2, abs=1e-9)
    assert find_cut(LearnerOptions(learner=TreeOptions(boundary="midpoint"))) == 5.5
    assert find_cut(LearnerOptions(watched=True)) == 5.5


def test_a_lesson_may_leave_automatic_defaults_out() -> None:
    alone = learn(replace(APPROACH, options=LearnerOptions(learner=TreeOptions(defaults=False))))
    assert set(alone) == {"start", "forward"}
    forward = alone["forward"]
    assert isinstance(forward, Tree)
    assert forward.nodes == (make_leaf(APPROACH.automaton.index("load")),)
    assert (
        learn_and_report(replace(APPROACH, options=LearnerOptions(learner=TreeOptions(defaults=False))))
        .states["forward"]
        .disagreements
        == 0
    )


def test_watched_examples_of_any_state_make_midpoints_everywhere() -> None:
    mixed = make_lesson(
        [
            ("forward", [9], "forward", "default"),
            ("forward", [2], "load", "directive"),
            ("load", [2], "load", "watched"),
        ]
    )
    function = learn(mixed)["forward"]
    assert isinstance(function, Tree)
    assert function.nodes[0].high == 5.5


STATELESS = make_lesson(
    [
        ("start", [9], "forward", "directive"),
        ("forward", [9], "forward", "default"),
        ("forward", [2], "load", "directive"),
        ("load", [2], "load", "default"),
        ("load", [8], "forward", "directive"),
        ("load", [3], "load", "confirmation"),
    ],
    stateless=True,
)


def test_stateless_lessons_share_one_function_of_what_was_said() -> None:
    functions = learn(STATELESS)
    assert list(functions) == ["start", "forward", "load"]
    assert len({id(function) for function in functions.values()}) == 1
    tree = functions["start"]
    assert isinstance(tree, Tree)
    assert tree.nodes[0].high == 5.5  # between 3 and 8, both said
    assert learn(make_lesson([("forward", [1], "forward", "default")], stateless=True)) == {}


def test_order_of_examples_makes_no_difference_to_a_lesson() -> None:
    turned = replace(APPROACH, examples=tuple(reversed(APPROACH.examples)))
    assert learn_automaton(turned) == learn_automaton(APPROACH)


BAD = [
    (make_lesson([("start", [1, 2], "go", "directive")], [Continuous()]), "it has 2 values"),
    (make_lesson([("start", [float("inf")], "go", "directive")], [Continuous()]), "f0 is inf"),
    (make_lesson([("start", [7.0], "go", "directive")], [Toroidal(6.0)]), "from 0 up to 6.0"),
    (make_lesson([("start", [2], "go", "directive")], [BOOLEAN]), "the index of one of its labels no, yes"),
    (make_lesson([("start", [0.5], "go", "directive")], [BOOLEAN]), "example 0 of lesson 'lesson'"),
]


@pytest.mark.parametrize(("bad", "says"), BAD)
def test_values_outside_their_kind_are_refused(bad: Lesson, says: str) -> None:
    with pytest.raises(DefinitionError, match=says):
        learn(bad)


def test_unknown_states_are_refused() -> None:
    (first, *rest) = APPROACH.examples
    for wrong in (replace(first, state="fly"), replace(first, next="fly")):
        with pytest.raises(UnknownName, match="fly"):
            learn(replace(APPROACH, examples=(wrong, *rest)))


def test_report_in_numbers() -> None:
    shown = make_lesson(
        [
            ("forward", [2], "load", "directive"),
            ("forward", [2], "forward", "default"),
            ("forward", [9], "forward", "confirmation"),
            ("forward", [9], "stop", "directive"),
            ("forward", [9], "stop", "directive"),
        ]
    )
    result = learn_and_report(shown)
    forward = result.states["forward"]
    assert (forward.nodes, forward.depth) == (3, 1)
    assert forward.contradictions == 1  # at 9
    assert forward.disagreements == 2  # the default at 2, the confirmation at 9
    assert forward.fit_ms > 0
    assert forward.conditions == ("load when f0 is below 5.5", "stop when f0 is at least 5.5")
    assert [len(group) for group in find_contradictions(shown, "forward")] == [3]
    found = find_disagreements(shown, "forward", result.transitions["forward"])
    assert [example.number for example in found] == [1, 2]


def test_absent_readings_are_alike_when_they_contradict() -> None:
    shown = make_lesson([("start", [nan], "a", "directive"), ("start", [nan], "b", "directive")])
    assert learn_and_report(shown).states["start"].contradictions == 1


def test_explanations() -> None:
    functions = learn(APPROACH)
    explained = explain(APPROACH, "forward", (1.5,), functions["forward"])
    assert str(explained) == "goes to load because f0 is at most 2"
    assert [example.number for example in explained.examples] == [2]
    staying = explain(APPROACH, "forward", (7.0,), functions["forward"])
    assert str(staying) == "stays in forward because f0 is above 2"
    unseen = explain(APPROACH, "forward", (nan,), functions["forward"])
    assert not unseen.shown
    assert str(unseen) == "stays in forward because f0 is absent; there are no examples there"
    untaught = explain(APPROACH, "forward", (1.0,), None)
    assert (untaught.next, untaught.shown) == ("forward", False)


def test_explanations_count_watched_examples_of_the_leaf() -> None:
    kinds: list[Kind] = [Continuous()]
    shown = make_lesson(
        [("a", [1], "b", "directive"), ("a", [9], "a", "default"), ("a", [2], "b", "watched")], kinds
    )
    explained = explain(shown, "a", (0.0,), learn(shown)["a"])
    assert [example.number for example in explained.examples] == [0, 2]


@given(draw_automaton(), st.booleans())
@settings(max_examples=100)
def test_a_lesson_knows_whether_it_teaches(original: TrainedAutomaton, defaults: bool) -> None:
    assert original.lesson is not None
    options = LearnerOptions(learner=TreeOptions(defaults=defaults))
    for each in (original.lesson, replace(original.lesson, options=options)):
        assert each.teaches == bool(group_examples_by_state(each))
