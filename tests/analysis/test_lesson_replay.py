"""Lessons replayed, as tables: what is decided otherwise than shown, and than a former version decided."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np
import pytest

from understudy.judging.lesson_replay import DecisionChange, replay_lesson
from understudy.judging.properties.lesson_tests import (
    LessonTestResult,
    describe_lost_decisions,
    describe_test_result,
)
from understudy.learning.csv_table import read_lesson_table
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature, FlagFeature, TimeInState
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import TrainedAutomaton
from understudy.model.value_kinds import Continuous

NEAR = Feature("near", Continuous(), reading="range", unit="m")
BARE = Automaton(
    "goto",
    (START, State("go", "forward"), State("turn", "left"), State("done", flag="done")),
    (BoundFeature(NEAR),),
)
KINDS = {"directive": ExampleKind.DIRECTIVE, "default": ExampleKind.DEFAULT, "keep": ExampleKind.CONFIRMATION}

Row = tuple[str, float, str, str]


def lesson(*rows: Row, quarantined: tuple[int, ...] = ()) -> Lesson:
    shown = [
        Example(
            number,
            state,
            (value,),
            following,
            KINDS[kind],
            quarantined="bad" if number in quarantined else "",
        )
        for number, (state, value, following, kind) in enumerate(rows, 1)
    ]
    return Lesson(BARE, tuple(shown))


def teach(*rows: Row, quarantined: tuple[int, ...] = ()) -> TrainedAutomaton:
    made = lesson(*rows, quarantined=quarantined)
    return TrainedAutomaton(learn_automaton(made), made)


STOPS: tuple[Row, ...] = (("go", 9.0, "go", "default"), ("go", 1.0, "done", "directive"))

# The lesson now, beside the former one: (number, shown, now, formerly) of what is different, and which are lost.
CASES = [
    (STOPS, STOPS, [], []),
    ((*STOPS, ("go", 5.0, "done", "directive")), STOPS, [(3, "done", "done", "go")], []),  # learned since
    (  # two against one
        (*STOPS, ("go", 1.0, "turn", "directive"), ("go", 1.0, "turn", "directive")),
        STOPS,
        [(2, "done", "turn", "done"), (3, "turn", "turn", "done"), (4, "turn", "turn", "done")],
        [2],
    ),
    (  # decided otherwise than shown, and always was
        (
            *STOPS,
            ("go", 1.0, "turn", "directive"),
            ("go", 1.0, "turn", "directive"),
            ("go", 1.0, "go", "keep"),
        ),
        STOPS,
        [
            (2, "done", "turn", "done"),
            (3, "turn", "turn", "done"),
            (4, "turn", "turn", "done"),
            (5, "go", "turn", "done"),
        ],
        [2],
    ),
    (  # a default gives way to what is said with the very same vector: nothing is lost
        (*STOPS, ("go", 9.0, "turn", "directive")),
        STOPS,
        [(3, "turn", "turn", "go")],
        [],
    ),
]


@pytest.mark.parametrize(("now", "former", "different", "lost"), CASES)
def test_presses(
    now: tuple[Row, ...], former: tuple[Row, ...], different: list[tuple[int, str, str, str]], lost: list[int]
) -> None:
    found = replay_lesson(teach(*now), teach(*former))
    assert [(each.number, each.shown, each.now, each.formerly) for each in found.different] == different
    assert [each.number for each in found.regressions] == lost


def test_what_is_in_quarantine_says_nothing() -> None:
    now = teach(*STOPS, quarantined=(2,))
    found = replay_lesson(now, teach(*STOPS))
    assert (found.examples, found.different) == (1, ())


def test_what_is_lost_in_words() -> None:
    turned: Row = ("go", 1.0, "turn", "directive")
    found = replay_lesson(teach(*STOPS, turned, turned), teach(*STOPS))
    assert list(describe_lost_decisions(found)) == [
        "where it went from go to done as shown (example 2), it now goes to turn"
    ]


def test_without_a_former_version_or_a_lesson() -> None:
    found = replay_lesson(teach(*STOPS))
    assert (found.examples, found.different, found.changes) == (2, (), ())
    assert replay_lesson(TrainedAutomaton(learn_automaton(lesson(*STOPS)))).examples == 0


# The robot drives from 6 m to 3 m in three tenths of a second, and is told to stop at 3 m; it had begun to go at 5 m.
RECORD = ReadingLog(
    (("range", None),), np.array([[6.0], [5.0], [4.0], [3.0]]), np.array([0.0, 0.1, 0.2, 0.3])
)
PRESSED = Example(2, "go", (3.0,), "done", KINDS["directive"], moment=3, window=3, own={"time_in_state": 0.2})
KEPT = Example(1, "go", (5.0,), "go", KINDS["default"], moment=1, window=0)


def teach_recorded(
    *more: Example, features: tuple[BoundFeature, ...] = BARE.features, pressed: Example = PRESSED
) -> TrainedAutomaton:
    bare = replace(BARE, features=features)
    made = Lesson(bare, (KEPT, pressed, *more), record=RECORD)
    return TrainedAutomaton(learn_automaton(made), made)


def test_the_second_before_a_press() -> None:
    """Only since it was in that state: at 5 m and at 4 m, where it had learned to stop at 3."""
    earlier = teach_recorded(Example(3, "go", (4.5,), "done", KINDS["directive"]))
    found = replay_lesson(earlier, teach_recorded())
    assert found.before == 2
    assert found.changes == (DecisionChange("go", "go", "done", 1),)
    assert replay_lesson(earlier).changes == ()
    assert found.regressions == ()


def test_features_of_a_former_version_are_read_from_the_record() -> None:
    """Formerly it looked at the time: at the press it had been going for 0.2 s, so it stopped."""
    timed = (BoundFeature(TimeInState()),)
    kept = replace(KEPT, values=(0.0,))
    bare = replace(BARE, features=timed)
    former = Lesson(bare, (kept, replace(PRESSED, values=(0.2,))), record=RECORD)
    found = replay_lesson(teach_recorded(), TrainedAutomaton(learn_automaton(former), former))
    assert found.different == ()
    assert found.changes == ()
    late = Lesson(bare, (kept, replace(PRESSED, values=(0.1,))), record=RECORD)
    found = replay_lesson(teach_recorded(), TrainedAutomaton(learn_automaton(late), late))
    assert found.changes == (DecisionChange("go", "done", "go", 1),), "it would have stopped 0.1 s earlier"


def test_before_a_press_with_a_flag_nobody_knows() -> None:
    flagged = (*BARE.features, BoundFeature(FlagFeature("done")))
    kept = replace(KEPT, values=(5.0, 0.0))
    up = replace(PRESSED, values=(3.0, 1.0), own={"time_in_state": 0.2, "flag done": 1.0})
    made = Lesson(replace(BARE, features=flagged), (kept, up), record=RECORD)
    assert replay_lesson(TrainedAutomaton(learn_automaton(made), made)).before == 0


def test_what_was_not_recorded_is_left_out() -> None:
    other = BoundFeature(Feature("battery", Continuous(), reading="battery"))
    bare = replace(BARE, features=(other,))
    former = Lesson(bare, (replace(KEPT, values=(9.0,)), replace(PRESSED, values=(nan,))), record=RECORD)
    found = replay_lesson(teach_recorded(), TrainedAutomaton(learn_automaton(former), former))
    assert (found.different, found.changes) == ((), ())


WATCHED = """state,next,kind,front:continuous
forward,forward,default,0
forward,forward,watched,2.4
forward,forward,watched,1.6
forward,forward,watched,0.2
forward,back,directive,1.0
"""


def test_watched_examples_that_are_decided_otherwise_are_counted(tmp_path: Path) -> None:
    """It goes back from 0.6 m on: at two of three moments in which it drove on and was watched."""
    path = tmp_path / "lesson.csv"
    path.write_text(WATCHED)
    lesson = read_lesson_table(path)
    replay = replay_lesson(TrainedAutomaton(learn_automaton(lesson), lesson))
    assert (replay.overruled, replay.watched, replay.mismatches) == (2, 3, ())
    tested = LessonTestResult("lesson", replay, (), (), changed=False, affected=())
    assert list(describe_test_result(tested, "version 1")) == [
        "2 of 3 moments in which you watched: it decides otherwise than it did"
    ]
