"""Who is behind a change, as tables: what was shown before and after, what moved, and which examples did it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from understudy.learning import change_attribution
from understudy.learning.change_attribution import attribute_condition_changes
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.learner_options import LearnerOptions, SklearnOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import TrainedAutomaton
from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal

FAR = BoundFeature(Feature("far", Continuous(), reading="range"))
AIM = BoundFeature(Feature("aim", Toroidal(360.0), reading="bearing"))
FULL = BoundFeature(Feature("full", BOOLEAN, reading="full"))
GAIN_FIRST = LearnerOptions(learner=TreeOptions(order="gain first"))
KINDS = {"go": ExampleKind.DEFAULT, "keep": ExampleKind.CONFIRMATION}

Shown = dict[int, tuple[float, str]]
"""By number: a value, and the next state; "go" is an automatic default, "keep" a confirmation of it."""


def teach(
    shown: Shown, *, quarantined: tuple[int, ...] = (), feature: BoundFeature = FAR
) -> TrainedAutomaton:
    bare = Automaton(
        "walk", (START, State("go", "forward"), State("turn", "left"), State("done", flag="done")), (feature,)
    )
    examples = [
        Example(
            number,
            "go",
            (value,),
            "go" if following in KINDS else following,
            KINDS.get(following, ExampleKind.DIRECTIVE),
            quarantined="bad" if number in quarantined else "",
        )
        for number, (value, following) in shown.items()
    ]
    lesson = Lesson(bare, tuple(examples))
    return TrainedAutomaton(learn_automaton(lesson), lesson)


BASE: Shown = {1: (9.0, "go"), 2: (6.0, "go"), 3: (2.0, "done")}

CASES: list[tuple[Shown, Shown, list[tuple[str, str, list[tuple[int, str, str]]]]]] = [
    (BASE, BASE, []),
    (BASE, {**BASE, 4: (1.0, "done")}, []),  # it is within what was learned
    (BASE, {**BASE, 4: (3.0, "done")}, [("done", "moved", [(4, "new", "shows it")])]),
    (  # the directive at 2 no longer holds up the cut
        {**BASE, 4: (3.0, "done")},
        BASE,
        [("done", "moved", [(4, "gone", "showed it")])],
    ),
    (BASE, {**BASE, 3: (4.0, "done")}, [("done", "moved", [(3, "read anew", "shows it")])]),
    (  # said to be turning from now on
        BASE,
        {**BASE, 3: (2.0, "turn")},
        [
            ("done", "vanished", [(3, "edited", "showed it")]),
            ("turn", "appeared", [(3, "edited", "shows it")]),
        ],
    ),
    (  # a second way out
        BASE,
        {**BASE, 4: (1.0, "turn")},
        [
            ("done", "moved", [(4, "new", "contradicts it there")]),
            ("turn", "appeared", [(4, "new", "shows it")]),
        ],
    ),
    (  # "keep going" at 3 is told, so the cut between 2 and 3 is in the middle: it bounds it
        BASE,
        {**BASE, 4: (3.0, "keep")},
        [("done", "moved", [(4, "new", "bounds it")])],
    ),
    (  # what is outvoted where it is done has no part in it
        {**BASE, 4: (2.0, "done")},
        {**BASE, 4: (2.0, "done"), 5: (2.0, "turn"), 6: (3.0, "done")},
        [("done", "moved", [(6, "new", "shows it")])],
    ),
    (  # an example at the cut to turning, which stays where it was, has no part in where it is done
        {1: (5.0, "keep"), 2: (1.0, "done"), 3: (9.0, "turn")},
        {1: (5.0, "keep"), 2: (1.0, "done"), 3: (9.0, "turn"), 4: (9.0, "turn"), 5: (2.0, "done")},
        [("done", "moved", [(5, "new", "shows it")])],
    ),
    (  # nor the other way round
        {1: (5.0, "keep"), 2: (1.0, "done"), 3: (9.0, "turn")},
        {1: (5.0, "keep"), 2: (1.0, "done"), 3: (9.0, "turn"), 4: (1.0, "done"), 5: (8.0, "turn")},
        [("turn", "moved", [(5, "new", "shows it")])],
    ),
    (  # turning ends at the same place as ever, and begins farther on
        {1: (1.0, "keep"), 2: (5.0, "turn"), 3: (9.0, "keep")},
        {1: (1.0, "keep"), 2: (5.0, "turn"), 3: (9.0, "keep"), 4: (9.0, "keep"), 5: (2.0, "keep")},
        [("turn", "moved", [(5, "new", "bounds it")])],
    ),
    ({**BASE, 4: (3.0, "keep")}, BASE, [("done", "moved", [(4, "gone", "bounded it")])]),
]


@pytest.mark.parametrize(("before", "after", "expected"), CASES)
def test_one_feature(
    before: Shown, after: Shown, expected: list[tuple[str, str, list[tuple[int, str, str]]]]
) -> None:
    found = attribute_condition_changes(teach(before), teach(after))
    assert [
        (each.next, each.what, [(who.number, who.happened, who.how) for who in each.examples])
        for each in found
    ] == expected


def teach_recorded(shown: Shown, *, began_s: float) -> TrainedAutomaton:
    """As `teach`, by presses of which there is a record, one each second."""
    bare = teach(shown)
    assert bare.lesson is not None
    pairs = enumerate(bare.lesson.examples)
    examples = tuple(replace(example, moment=row) for row, example in pairs)
    seconds = began_s + np.arange(len(examples), dtype=np.float64)
    log = ReadingLog((("range", ""),), np.array([example.values for example in examples]), seconds)
    return TrainedAutomaton(bare.automaton, replace(bare.lesson, examples=examples, record=log))


def test_examples_of_a_lesson_begun_anew_are_others() -> None:
    """They have the numbers of former ones, and nobody edited those."""
    anew = {1: (8.0, "go"), 2: (5.0, "turn"), 3: (4.0, "done")}
    first, second = teach_recorded(BASE, began_s=0.0), teach_recorded(anew, began_s=70.0)
    for before, after in ((first, second), (second, first)):
        found = attribute_condition_changes(before, after)
        assert {who.happened for each in found for who in each.examples} == {"shown anew"}
    corrected = teach_recorded({**BASE, 3: (2.0, "turn")}, began_s=0.0)
    found = attribute_condition_changes(first, corrected)
    assert {who.happened for each in found for who in each.examples} == {"edited"}


def test_into_quarantine_and_out_again() -> None:
    all_teach, not_all = (
        teach({**BASE, 4: (3.0, "done")}),
        teach({**BASE, 4: (3.0, "done")}, quarantined=(4,)),
    )
    (there,), (back,) = (
        attribute_condition_changes(all_teach, not_all),
        attribute_condition_changes(not_all, all_teach),
    )
    assert [(who.number, who.happened, who.how) for who in there.examples] == [
        (4, "in quarantine", "showed it")
    ]
    assert [(who.number, who.happened, who.how) for who in back.examples] == [(4, "let out", "shows it")]
    assert (there.gone, there.new) == (back.new, back.gone) == (("far is at most 3",), ("far is at most 2",))


def test_an_arc_is_bounded_across_the_seam() -> None:
    """Turn at 10; go on at 300 and at 60. Then go on at 320, too: the end of the arc across the seam moves."""
    before = teach({1: (300.0, "keep"), 2: (10.0, "turn"), 3: (60.0, "keep")}, feature=AIM)
    after = teach({1: (300.0, "keep"), 2: (10.0, "turn"), 3: (60.0, "keep"), 4: (320.0, "keep")}, feature=AIM)
    (turn,) = attribute_condition_changes(before, after)
    assert [(who.number, who.how) for who in turn.examples] == [(4, "bounds it")]


def test_labels_and_absence() -> None:
    before = teach({1: (0.0, "go"), 2: (1.0, "done")}, feature=FULL)
    after = teach({1: (0.0, "go"), 2: (1.0, "done"), 3: (nan, "turn")}, feature=FULL)
    (turn,) = (each for each in attribute_condition_changes(before, after) if each.next == "turn")
    assert (turn.what, [(who.number, who.how) for who in turn.examples]) == ("appeared", [(3, "shows it")])


def test_a_change_that_came_about_elsewhere() -> None:
    """It was done where it is not full, by distance first; a fourth example, full and far, makes that the only question
    asked. It has nothing to do with being done, nor has the fifth, which says again what the second does."""
    bare = Automaton("walk", (START, *teach(BASE).automaton.states[1:]), (FAR, FULL))
    rows = {
        1: ((4.0, 1.0), "turn", ExampleKind.DIRECTIVE),
        2: ((2.0, 1.0), "go", ExampleKind.CONFIRMATION),
        3: ((2.0, 0.0), "done", ExampleKind.DIRECTIVE),
    }

    def teach_more(more: Mapping[int, tuple[tuple[float, ...], str, ExampleKind]]) -> TrainedAutomaton:
        examples = [
            Example(number, "go", values, following, kind)
            for number, (values, following, kind) in {**rows, **more}.items()
        ]
        lesson = Lesson(bare, tuple(examples), GAIN_FIRST)
        return TrainedAutomaton(learn_automaton(lesson), lesson)

    far, again = ((6.0, 1.0), "go", ExampleKind.CONFIRMATION), rows[2]
    for more in ({4: far}, {4: far, 5: again}):
        (done,) = (
            each
            for each in attribute_condition_changes(teach_more({}), teach_more(more))
            if each.next == "done"
        )
        assert (done.gone, done.new) == (("far is below 3 and full is no",), ("full is no",))
        assert [(who.number, who.how) for who in done.examples] == [
            (4, "elsewhere, without it this would not be")
        ]


def test_another_feature_is_behind_it_where_no_example_is() -> None:
    before = teach(BASE)
    assert before.lesson is not None
    bare = replace(before.lesson.automaton, features=(FULL,))
    examples = tuple(
        replace(each, values=(1.0 if each.next == "done" else 0.0,)) for each in before.lesson.examples
    )
    lesson = Lesson(bare, examples)
    (done,) = attribute_condition_changes(before, TrainedAutomaton(learn_automaton(lesson), lesson))
    assert {who.happened for who in done.examples} == {"read anew"}


def test_by_hand_and_by_classifier_nobody_is() -> None:
    before = teach(BASE)
    assert attribute_condition_changes(before, TrainedAutomaton(before.automaton)) == ()
    assert before.lesson is not None
    lesson = replace(
        before.lesson,
        options=LearnerOptions(learner=SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1})),
    )
    (done,) = attribute_condition_changes(before, TrainedAutomaton(learn_automaton(lesson), lesson))
    assert (done.what, done.examples) == ("vanished", ())


def test_without_features_it_is_who_has_the_majority() -> None:
    """Nothing is asked, so nothing can bound a condition: the state is left always, or never."""
    examples = [
        Example(number, "go", (), following, ExampleKind.DIRECTIVE)
        for number, following in enumerate(("turn", "done", "done"), 1)
    ]
    before, after = (
        TrainedAutomaton(learn_automaton(lesson), lesson)
        for lesson in (
            Lesson(
                Automaton("walk", (START, State("go", "forward"), State("turn", "left"), State("done"))),
                shown,
            )
            for shown in (tuple(examples[:1]), tuple(examples))
        )
    )
    assert [(each.next, each.what) for each in attribute_condition_changes(before, after)] == [
        ("turn", "vanished"),
        ("done", "appeared"),
    ]
    assert [[who.number for who in each.examples] for each in attribute_condition_changes(before, after)] == [
        [2, 3],
        [2, 3],
    ]


def test_where_no_single_example_is_it_is_all_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of many that changed none is tried as it was; of two that each would do, neither alone."""
    bare = Automaton("walk", (START, *teach(BASE).automaton.states[1:]), (FAR, FULL))
    rows = [
        ((4.0, 1.0), "turn", ExampleKind.DIRECTIVE),
        ((2.0, 1.0), "go", ExampleKind.CONFIRMATION),
        ((2.0, 0.0), "done", ExampleKind.DIRECTIVE),
        ((6.0, 1.0), "go", ExampleKind.CONFIRMATION),
    ]

    def teach_longer(more: int) -> TrainedAutomaton:
        examples = tuple(
            Example(number, "go", *row) for number, row in enumerate([*rows[:3], *rows[3:] * more], 1)
        )
        lesson = Lesson(bare, examples, GAIN_FIRST)
        return TrainedAutomaton(learn_automaton(lesson), lesson)

    def who(more: int) -> list[tuple[int, str]]:
        (done,) = (
            each
            for each in attribute_condition_changes(teach_longer(0), teach_longer(more))
            if each.next == "done"
        )
        return [(each.number, each.how) for each in done.examples]

    assert who(1) == [(4, "elsewhere, without it this would not be")]
    assert who(2) == [(4, "elsewhere, with the others"), (5, "elsewhere, with the others")]
    monkeypatch.setattr(change_attribution, "MOST_TRIED", 0)
    assert who(1) == [(4, "elsewhere, with the others")]
