"""Cells of one example, branches and absence never shown, features and parameters that decide nothing."""

from __future__ import annotations

from dataclasses import replace
from math import nan

import pytest
from tests.verification.automata import (
    AHEAD,
    BACK,
    DISTANCE,
    FULL,
    KIT,
    LIGHT,
    always,
    arc,
    below,
    find,
    labels,
    list_unused,
    make_automaton,
)

from understudy.addons.checks.verification.check_library import check_library
from understudy.addons.checks.verification.finding import Finding, FindingKind
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY
from understudy.model.value_kinds import Continuous

BARE = Automaton("go", (START, AHEAD, BACK), (DISTANCE, LIGHT))
SHOWN = (  # state, next, kind, distance, light
    ("start", "ahead", "directive", 5.0, 0),
    ("ahead", "ahead", "default", 5.0, 0),
    ("ahead", "ahead", "confirmation", 4.0, 0),
    ("ahead", "back", "directive", 1.0, 0),
    ("back", "back", "default", 1.0, 0),
    ("back", "back", "confirmation", 1.0, 1),
    ("back", "ahead", "directive", 3.0, 0),
    ("back", "ahead", "directive", 4.0, 1),
)


def check(rows: tuple[tuple[str, str, str, float, float], ...], kind: FindingKind) -> list[Finding]:
    """The findings of a kind on what is learned from examples."""
    examples = [
        Example(number, state, (distance, light), following, ExampleKind(how))
        for number, (state, following, how, distance, light) in enumerate(rows)
    ]
    lesson = Lesson(BARE, tuple(examples))
    library = Library(KIT).with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))
    return [each for each in check_library(library).findings if each.kind is kind]


def test_a_cell_that_one_press_decides() -> None:
    (found,) = check(SHOWN, FindingKind.ONE_EXAMPLE)
    assert (found.states, found.examples) == (("ahead",), (3,))
    assert "distance is below 2.5 m: only example 3" in found.sentence
    twice = (*SHOWN, ("ahead", "back", "directive", 0.5, 0))
    assert not check(twice, FindingKind.ONE_EXAMPLE)


def test_several_are_one_finding_with_the_weakest_first() -> None:
    """Watched stays speak against a leaf that leads elsewhere."""
    rows = (*SHOWN[:4], ("ahead", "back", "directive", 9.0, 0), *SHOWN[4:])
    (found,) = check(rows, FindingKind.ONE_EXAMPLE)
    assert found.examples == (3, 4)
    assert found.states == ("ahead", "ahead")
    assert found.sentence.startswith("2 decisions rest on one example each; in ahead, it goes to back when ")
    (against,) = check((*rows, *[("ahead", "ahead", "watched", 9.5, 0)] * 2), FindingKind.ONE_EXAMPLE)
    assert against.examples == (4, 3)
    assert [each.condition for each in against.cells] == [
        "distance is at least 7 m",
        "distance is below 2.5 m",
    ]


def test_a_label_without_examples() -> None:
    rows = (*SHOWN[:3], ("ahead", "back", "directive", 4.0, 2), *SHOWN[4:])
    (found,) = check(rows, FindingKind.NEVER_SHOWN)
    assert found.states == ("ahead",)
    assert "light is amber" in found.sentence
    shown = (*rows, ("ahead", "ahead", "confirmation", 4.0, 1))
    assert not check(shown, FindingKind.NEVER_SHOWN)


def test_where_silence_limits_a_decision_something_was_shown() -> None:
    rows = (
        SHOWN[0],
        ("ahead", "ahead", "default", 0.0, 0),
        ("ahead", "back", "directive", 1.0, 0),
        *(("ahead", "ahead", "watched", distance, 0) for distance in (1.3, 1.6, 2.0, 2.4)),
        *SHOWN[4:],
    )
    assert not check(rows, FindingKind.NEVER_SHOWN)


def test_absence_without_examples() -> None:
    (found,) = check(SHOWN, FindingKind.ABSENT_NEVER_SHOWN)
    assert found.states == ("ahead", "back")
    assert not found.is_certain  # whether the distance is ever absent is not decided
    shown = (*SHOWN, ("ahead", "back", "directive", nan, 0), ("back", "back", "confirmation", nan, 0))
    assert not check(shown, FindingKind.ABSENT_NEVER_SHOWN)


TREES = [  # the tree of ahead, and the features of which decisions depend
    (below(1.0, 1, 2), {"distance"}),
    (below(1.0, 1, 1), set()),
    (below(1.0, STAY, 1), set()),  # both stay
    (labels(2, 1, 2, 1), {"light"}),
    (labels(2, 1, 1, 1), set()),
    (arc(10.0, 20.0, 2, 1), {"angle"}),
]


@pytest.mark.parametrize(("tree", "deciding"), TREES)
def test_features_that_decide_nothing(tree: object, deciding: set[str]) -> None:
    automaton = make_automaton("go", (AHEAD, BACK), start=always(1), ahead=tree, back=always(1))  # type: ignore[arg-type]
    found = find(automaton, kind=FindingKind.UNUSED_FEATURE)
    unused = {name for each in found for name in list_unused(each)}
    assert unused == {str(bound) for bound in automaton.features} - deciding


FAR = tuple(("ahead", "ahead", "confirmation", float(distance), 0) for distance in range(2, 13))
OUTLIERS = [  # another press, and whether it is an outlier among 1 to 12
    (("ahead", "back", "directive", 24.1, 0), True),  # 12.1 from the next, which are 11 apart
    (("ahead", "back", "directive", 22.0, 0), False),
    (("ahead", "back", "directive", -12.0, 0), True),
    (("ahead", "ahead", "watched", 90.0, 0), False),  # no press
    (("ahead", "back", "directive", nan, 0), False),
]


@pytest.mark.parametrize(("row", "is_outlier"), OUTLIERS)
def test_an_example_far_outside_all_others(row: tuple[str, str, str, float, float], is_outlier: bool) -> None:
    found = check((*SHOWN, *FAR, row), FindingKind.OUTLIER)
    assert [each.examples for each in found] == ([(len(SHOWN) + len(FAR),)] if is_outlier else [])
    if is_outlier:
        assert "1 m to 12 m" in found[0].sentence


def test_few_examples_have_no_outlier() -> None:
    few = (*SHOWN, *FAR[:5], ("ahead", "back", "directive", 900.0, 0))
    assert not check(few, FindingKind.OUTLIER)
    there_twice = (*SHOWN, *FAR, *[("ahead", "back", "directive", 90.0, label) for label in (0, 1)])
    assert not check(there_twice, FindingKind.OUTLIER)  # two presses say so


RANGE = Feature("range", Continuous(), "range", of="A")


def find_unused(*, tested: bool = False, passed: str | None = None, child_uses: bool = True) -> list[Finding]:
    """The unused parameters of an automaton that tests its parameter A, or passes it on to another automaton."""
    near = BoundFeature(RANGE, Binding(A="A"))
    inner = Automaton(
        "inner",
        (START, AHEAD, BACK),
        (near,),
        ("A",),
        transitions={"start": below(1.0, 1, 2) if child_uses else always(1)},
    )
    state = State("run", "inner", Binding(A=passed)) if passed else AHEAD
    outer = Automaton(
        "outer",
        (START, state),
        (near, FULL),
        ("A",),
        transitions={"start": below(1.0, 0, 1) if tested else labels(1, 0, 1)},
    )
    library = Library.from_automata(KIT, inner, outer)
    report = check_library(library, ["outer"])
    return [each for each in report.findings if each.kind is FindingKind.UNUSED_PARAMETER]


def test_parameters_that_decide_nothing() -> None:
    assert find_unused()
    assert not find_unused(tested=True)
    assert not find_unused(passed="A")
    assert find_unused(passed="station")
    assert find_unused(passed="A", child_uses=False)


TARGETS = [  # what go runs, what the tree of go tests, another state, whether it is reported
    ("A", "A", None, False),
    ("station", "A", None, True),
    ("station", None, None, True),  # nothing follows A
    ("station", None, "A", False),  # first to A, then to the station
    ("station", "A", "A", True),  # on the way to the station it looks at A
    ("ball", "A", "A", False),  # the ball is looked at, too
]


@pytest.mark.parametrize(("target", "tested", "other", "reported"), TARGETS)
def test_a_fixed_target_beside_a_parameter(
    target: str, tested: str | None, other: str | None, reported: bool
) -> None:
    near, ball = BoundFeature(RANGE, Binding(A="A")), BoundFeature(RANGE, Binding(A="ball"))
    inner = Automaton("inner", (START, AHEAD), (near,), ("A",), transitions={"start": below(1.0, 1, 0)})
    second = State("other", "inner", Binding(A=other)) if other else State("other", "wait")
    features = (near, FULL, *([ball] if target == "ball" else []))
    outer = Automaton(
        "outer",
        (START, State("go", "inner", Binding(A=target)), second),
        features,
        ("A",),
        transitions={
            "start": always(1),
            "go": below(1.0, 2, 1) if tested else labels(1, 1, 2),
            "other": below(1.0, 1, 2),
        },
    )
    library = Library.from_automata(KIT, inner, outer)
    found = [
        each
        for each in check_library(library, ["outer"]).findings
        if each.kind is FindingKind.CONSTANT_TARGET
    ]
    assert [each.states for each in found] == ([("go",)] if reported else [])


def test_what_is_left_out_of_a_lesson_is_no_example() -> None:
    """A quarantined example does not support a cell."""
    rows = (*SHOWN, ("ahead", "back", "directive", 0.5, 0))
    examples = [
        Example(number, state, (distance, light), following, ExampleKind(how))
        for number, (state, following, how, distance, light) in enumerate(rows)
    ]
    examples[-1] = replace(examples[-1], quarantined="a slip")
    lesson = Lesson(BARE, tuple(examples))
    library = Library(KIT).with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))
    kinds = [each.kind for each in check_library(library).findings]
    assert FindingKind.ONE_EXAMPLE in kinds
