"""What the coach says of lessons written by hand."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given
from tests.make.automata import make_goto as recorded
from tests.make.goto_sessions import DISTANCE, DONE, GOTO, Row, make_goto_session
from tests.make.lessons import draw_tables
from tests.make.lessons import make_lesson as lesson_of

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.give_advice import UNSURE, give_advice
from understudy.learning.fit import learn
from understudy.learning.sklearn_adapter import ALLOWED
from understudy.model.learner_options import LearnerOptions, SklearnOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.value_kinds import Categorical, Kind
from understudy.sim.forage import FORAGE_KIT


def list_advice(lesson: Lesson, kind: AdviceKind | None = None) -> list[Advice]:
    return [each for each in give_advice(lesson, learn(lesson), kit=FORAGE_KIT) if kind in (None, each.kind)]


def test_most_useful_first_and_each_weight_is_a_share() -> None:
    weights = [each.weight for each in list_advice(make_goto_session())]
    assert weights == sorted(weights, reverse=True)
    assert all(0 <= weight <= 1 for weight in weights)


def test_what_was_never_shown_is_asked_for_in_words() -> None:
    sentences = [each.sentence for each in list_advice(make_goto_session(), AdviceKind.GAP)]
    assert "Show me what to do in state forward when A is behind you: I was never shown that." in sentences


@given(draw_tables())
def test_no_example_of_the_state_lies_in_a_gap(
    table: tuple[list[tuple[tuple[float, ...], int, int]], list[Kind]],
) -> None:
    drawn, kinds = table
    names = ("a", "b", "c")
    kind = {0: "default", 1: "directive"}
    rows = [("a", row[0], "a" if not row[2] else names[row[1]], kind[row[2]]) for row in drawn]
    found = lesson_of(rows, kinds)
    for each in list_advice(found, AdviceKind.GAP):
        assert each.region is not None
        for example in found.examples:
            assert not all(value in part for value, part in zip(example.values, each.region, strict=True))


def test_what_is_in_quarantine_was_shown_all_the_same() -> None:
    shown = make_goto_session()
    held = replace(shown, examples=tuple(replace(each, quarantined="slipped") for each in shown.examples))
    said = "{}: show me more, and then I can tell you what is missing."
    for lesson, begins in (
        (make_goto_session(()), "You showed me nothing yet"),
        (make_goto_session(GOTO[:2]), "You pressed once so far"),
        (held, "You showed me nothing, beside what is in quarantine"),
        (
            replace(held, examples=(*shown.examples[:1], *held.examples[1:])),
            "You pressed once, beside what is in quarantine",
        ),
    ):
        assert [each.sentence for each in list_advice(lesson, AdviceKind.FEW)] == [said.format(begins)]


def test_a_boundary_held_by_one_example_names_it() -> None:
    (first, *_) = [
        each for each in list_advice(make_goto_session(), AdviceKind.SINGLE) if each.state == "forward"
    ]
    assert first.examples == (2,)
    assert first.sentence.startswith("Only example 2 tells me to go from forward to done when A is ")
    assert first.region is not None
    assert 0.3 in first.region[0]


def test_an_example_shown_twice_holds_no_boundary_alone() -> None:
    again: Row = ("forward", "done", "directive", 0.31, 349)
    lesson = make_goto_session((*GOTO, again))
    assert not [each for each in list_advice(lesson, AdviceKind.SINGLE) if each.state == "forward"]


def test_a_press_that_the_others_would_have_foretold_holds_no_boundary() -> None:
    lesson = make_goto_session(
        (*GOTO[:3], ("forward", "done", "directive", 0.2, 90), ("forward", "done", "directive", 0.1, 200))
    )
    told = [each.examples for each in list_advice(lesson, AdviceKind.SINGLE) if each.state == "forward"]
    assert told == [(2,)]  # the farthest out: without it, 0.3 m would be farther than any


def test_a_leaf_that_reaches_far_beyond_its_examples_is_asked_about() -> None:
    """Learned by the highest gain, done is told from forward by the angle, which fits as well as the distance does."""
    rows: tuple[Row, ...] = (
        ("forward", "forward", "confirmation", 6.0, 10),
        ("forward", "forward", "confirmation", 5.0, 60),
        ("forward", "done", "directive", 0.3, 100),
        ("forward", "done", "directive", 0.2, 110),
    )
    gain_first = LearnerOptions(learner=TreeOptions(order="gain first"))
    lesson = replace(
        make_goto_session((*rows, ("forward", "forward", "confirmation", 0.5, 200))), options=gain_first
    )
    (first,) = list_advice(lesson, AdviceKind.STRETCHED)
    assert "go from forward to done when A is far" in first.sentence
    assert lesson.examples[first.examples[0]].next == "forward"
    assert first.at is not None
    names = lesson.automaton.state_names
    assert names[learn(lesson)["forward"].decide(first.at)] == "done"
    assert first.region is not None
    assert all(value in part for value, part in zip(first.at, first.region, strict=True))
    told_by_distance = make_goto_session((*rows, ("forward", "forward", "confirmation", 5.5, 105)))
    assert not list_advice(told_by_distance, AdviceKind.STRETCHED)


def test_a_usual_flag_goes_without_saying() -> None:
    """Nearly always nothing is done when it drives: only what is out of the ordinary there is said."""
    lesson = make_goto_session()
    automaton = replace(lesson.automaton, features=(*lesson.automaton.features, DONE))
    shown = [replace(each, values=(*each.values, 0.0)) for each in lesson.examples * 2]
    raised = replace(lesson.examples[2], values=(0.3, 0.0, 1.0), next="left")
    examples = [replace(each, number=number) for number, each in enumerate([*shown, raised])]
    found = [
        each.sentence for each in list_advice(replace(lesson, automaton=automaton, examples=tuple(examples)))
    ]
    assert any("done is raised" in sentence for sentence in found)
    assert not any("done is not raised" in sentence for sentence in found)


def test_contradicting_examples_are_named() -> None:
    lesson = make_goto_session((*GOTO, ("forward", "left", "directive", 0.3, 350)))
    (first,) = list_advice(lesson, AdviceKind.CONTRADICTION)
    assert first == list_advice(lesson)[0]
    assert first.examples == (2, 7)
    assert "example 2 says done and example 7 says left" in first.sentence
    again = make_goto_session((*GOTO, *[("forward", "left", "directive", 0.3, 350)] * 2))
    (first,) = list_advice(again, AdviceKind.CONTRADICTION)
    assert "example 2 says done and examples 7 and 8 say left; delete" in first.sentence


def test_one_in_quarantine_contradicts_nobody() -> None:
    lesson = make_goto_session((*GOTO, ("forward", "left", "directive", 0.3, 350)))
    last = replace(lesson.examples[-1], quarantined="a slip")
    assert not list_advice(replace(lesson, examples=(*lesson.examples[:-1], last)), AdviceKind.CONTRADICTION)


def test_a_directive_and_a_default_of_one_situation_are_named() -> None:
    lesson = make_goto_session((*GOTO, ("left", "forward", "directive", 5.0, 90)))
    (first,) = list_advice(lesson, AdviceKind.DISAGREEMENT)
    assert (first.state, first.examples) == ("left", (7, 4))
    assert "leave left for forward at once" in first.sentence


def test_states_never_left_or_entered() -> None:
    lesson = make_goto_session(
        (*GOTO[:3], ("forward", "left", "directive", 3.0, 60), ("left", "left", "default", 3.0, 60))
    )
    assert [each.state for each in list_advice(lesson, AdviceKind.NEVER_LEFT)] == ["left"]
    without = make_goto_session(tuple(row for row in GOTO if "left" not in row[:2]))
    assert [each.state for each in list_advice(without, AdviceKind.NEVER_ENTERED)] == ["left"]
    begins = make_goto_session(tuple(row for row in GOTO if row[0] != "start"))
    (first,) = list_advice(begins, AdviceKind.NEVER_LEFT)
    assert first.sentence == "Show me what to do first: nothing leads from start to any other state."


def test_a_feature_that_decides_nothing() -> None:
    rows = [
        ("go", (1, 0), "stop", "directive"),
        ("go", (5, 0), "go", "default"),
        ("go", (2, 0), "stop", "directive"),
        ("go", (1.5, 0), "stop", "directive"),
    ]
    (first,) = list_advice(lesson_of(rows, [DISTANCE.kind, Categorical(("no", "yes"))]), AdviceKind.IDLE)
    assert first.sentence == "Leave out f1, or show me where it matters: so far it decides nothing."


def test_a_feature_left_out_that_would_tell_a_contradiction_apart() -> None:
    taught = recorded().lesson
    assert taught is not None
    both = _two_wishes_of_one_vector(taught)
    (first,) = list_advice(both, AdviceKind.SEPARATING)
    assert "food_left" in first.sentence
    assert not [
        each for each in give_advice(both, learn(both)) if each.kind is AdviceKind.SEPARATING
    ]  # there is no kit to look in


def _two_wishes_of_one_vector(taught: Lesson) -> Lesson:
    """GoTo without features: two presses that differ in what was recorded of `food_left` alone."""
    from understudy.model.lesson import ReadingLog

    automaton = replace(taught.automaton, features=())
    keys = (("food_left", None), ("food_stored", None))
    record = ReadingLog(keys, np.array([[0.0, 4.0], [1.0, 4.0]]), np.array([0.0, 1.0]))
    wishes = ("done", "start")
    examples = tuple(
        Example(number, "forward", (), wish, ExampleKind.DIRECTIVE, moment=number)
        for number, wish in enumerate(wishes)
    )
    return Lesson(automaton, examples, record=record)


TINY = [
    (),
    GOTO[:1],
    GOTO[:2],
    (("start", "forward", "directive", 6.0, 10.0), ("start", "left", "directive", 6.0, 10.0)),
]


@pytest.mark.parametrize("rows", TINY)
def test_a_lesson_of_two_examples_gets_no_confident_advice(rows: tuple[Row, ...]) -> None:
    found = list_advice(make_goto_session(rows))
    assert found[0].kind is AdviceKind.FEW
    assert all(each.weight <= UNSURE for each in found)
    assert not {each.kind for each in found} & {AdviceKind.GAP, AdviceKind.SINGLE, AdviceKind.OUTLOOK}


def test_whether_more_examples_are_likely_to_help() -> None:
    assert not list_advice(make_goto_session(), AdviceKind.OUTLOOK)  # too few to say
    (known,) = list_advice(_many(24, noisy=False), AdviceKind.OUTLOOK)
    assert known.sentence.startswith("I have seen enough")
    (lost,) = list_advice(_many(40, noisy=True), AdviceKind.OUTLOOK)
    assert lost.sentence.startswith("More of the same may not help")


def _many(count: int, *, noisy: bool) -> Lesson:
    """Drives on while farther than 3 m, else done; or by the toss of a coin."""
    draws = np.random.default_rng(5)
    rows: list[Row] = []
    for _ in range(count):
        distance, angle = float(draws.random()) * 6.0, float(draws.random()) * 360.0
        done = draws.random() < 0.5 if noisy else distance < 3.0
        wish, kind = ("done", "directive") if done else ("forward", "confirmation")
        rows.append(("forward", wish, kind, distance, angle))
    return make_goto_session(tuple(rows))


def test_advice_on_a_stateless_lesson_is_about_no_state() -> None:
    lesson = make_goto_session(tuple(row for row in GOTO if row[2] == "directive"), stateless=True)
    assert {each.state for each in list_advice(lesson, AdviceKind.GAP)} == {""}


def test_a_classifier_is_advised_on_as_trees_are() -> None:
    lesson = replace(
        make_goto_session(),
        options=LearnerOptions(learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1})),
    )
    assert AdviceKind.GAP in {each.kind for each in list_advice(lesson)}


def test_a_classifier_that_has_just_enough_to_learn_from_is_advised_on() -> None:
    """Without one of the three examples of a state, three neighbors cannot be found."""
    rows = (*GOTO, ("forward", "left", "directive", 3.0, 90), ("start", "left", "directive", 2.0, 200))
    rows += (("left", "forward", "directive", 1.0, 10),)
    knn = SklearnOptions("KNeighborsClassifier", {"n_neighbors": 3})
    assert list_advice(replace(make_goto_session(rows), options=LearnerOptions(learner=knn)))


@pytest.mark.parametrize("classifier", ALLOWED)
def test_only_of_classifiers_that_learn_soon_it_says_whether_more_would_help(classifier: str) -> None:
    rows = [("forward", "forward", "confirmation", 2.0, float(angle)) for angle in range(0, 40, 8)]
    rows += [("forward", "left", "directive", 2.0, float(angle)) for angle in range(50, 90, 8)]
    parameters = {"n_neighbors": 1} if classifier == "KNeighborsClassifier" else {}
    lesson = replace(
        make_goto_session((*GOTO, *rows)),
        options=LearnerOptions(learner=SklearnOptions(classifier, parameters)),
    )
    slow = classifier in ("LogisticRegression", "MLPClassifier", "RandomForestClassifier")
    assert bool(list_advice(lesson, AdviceKind.OUTLOOK)) is not slow


def test_situations_that_a_robot_came_into_take_the_place_of_imagined_ones() -> None:
    lesson = make_goto_session()
    behind = np.array([[2.0, radians(degrees)] for degrees in range(160, 200)])
    found = give_advice(lesson, learn(lesson), situations=behind)
    assert {each.sentence for each in found if each.kind is AdviceKind.GAP and each.state == "left"} == {
        "Show me what to do in state left when A is behind you: I was never shown that."
    }
