"""What the last press or edit of a session changed, as tables: what was done, and what is said of it.

The ball is 100 m away at first, and one meter nearer each tick of 0.1 s. `forward` is left at 95 m for `left`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.bodies import Scripted
from tests.make.sessions import ROBOT, make_session, play, ticks

from understudy.errors import UnknownName
from understudy.learning.lesson_change import LessonStep, list_new_presses
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.training.session import Session


def make_turning_session(*, live: bool = True) -> Session:
    """Forward from the start, left at 95 m; 94 m now."""
    taught = make_session(flags=["done"], options=LearnerOptions(live=live))
    return play(taught, "forward", 5, "left", 2)


def turn_once() -> Session:
    """It has turned left by itself a moment ago, at 95 m."""
    taught = make_turning_session()
    taught.reset(1)
    ticks(taught, 7)
    assert taught.view().state == "left"
    return taught


def say(taught: Session) -> str | None:
    return None if taught.last_change is None else str(taught.last_change)


GONE = "forward no longer goes to left"
STEPS: list[tuple[str, Callable[[Session], object], str | None]] = [
    ("nothing", lambda taught: None, None),
    ("a switch for the first time", lambda taught: play(taught, 25, "right", 1), None),
    ("taken back at once, where it was shown", lambda taught: play(taught, 1, "forward", 1), GONE),
    ("taken back, and undone", lambda taught: (play(taught, 1, "forward", 1), taught.undo()), None),
    (
        "taken back, undone, and redone",
        lambda taught: (play(taught, 1, "forward", 1), taught.undo(), taught.redo()),
        None,
    ),
    (
        "taken back, and a press that waits is undone",
        lambda taught: (play(taught, 1, "forward", 1, "left"), taught.undo()),
        None,
    ),
    ("taken back, and time passes", lambda taught: play(taught, 1, "forward", 9), GONE),
    (
        "another one at the same place",
        lambda taught: play(taught, 1, "right", 1),
        "forward still goes to left where right was pressed",
    ),
    ("a slip", lambda taught: play(taught, 25, "done", 2, "right", 1), None),
    ("deleted", lambda taught: taught.delete(3), GONE),
    ("in quarantine", lambda taught: taught.quarantine({3: "bad"}), GONE),
    ("edited", lambda taught: taught.edit(3, next="right"), GONE),  # to the right is what the edit says
    ("other features", lambda taught: taught.change_design(features=["load"]), None),
]


@pytest.mark.parametrize("step", [row[1:] for row in STEPS], ids=[row[0] for row in STEPS])
def test_what_is_said(step: tuple[Callable[[Session], object], str | None]) -> None:
    taught = turn_once()
    step[0](taught)
    assert say(taught) == step[1]


def test_what_is_refused_changes_nothing() -> None:
    taught = turn_once()
    taught.delete(3)
    with pytest.raises(UnknownName):
        taught.direct("fly")
    assert say(taught) == GONE


def test_a_press_that_records_nothing_says_nothing() -> None:
    taught = turn_once()
    play(taught, 25, "done", 1)
    taught.delete(1)
    assert say(taught) is not None
    play(taught, 25, "forward", 1)  # from a flag that a press led to, long ago
    assert len(taught.examples) == 4
    assert say(taught) is None


def test_training_as_in_the_paper_says_it_too() -> None:
    taught = make_turning_session(live=False)
    assert say(taught) is None
    taught.delete(3)
    assert say(taught) == GONE


def test_a_resumed_session_has_nothing_to_say(tmp_path: Path) -> None:
    journal = tmp_path / "taught.journal"
    taught = play(make_session(journal=journal), "forward", 5, "left", 2)
    taught.delete(3)
    assert say(taught) == GONE
    taught.close()
    resumed = Session.resume(journal, Scripted(), ROBOT)
    assert say(resumed) is None
    resumed.close()


def test_classifiers_are_not_compared() -> None:
    options = LearnerOptions(learner=SklearnOptions("DecisionTreeClassifier"))
    taught = play(make_session(options=options), "forward", 5, "left", 2)
    taught.delete(3)
    assert say(taught) is None


def test_a_step_is_learned_only_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    before = make_turning_session(live=False).lesson
    learned: list[object] = []

    def learn(lesson: object) -> object:
        learned.append(lesson)
        raise AssertionError("it is not asked for")

    monkeypatch.setattr("understudy.learning.lesson_change.learn_automaton", learn)
    LessonStep(before, before)
    assert not learned


def test_only_presses_that_are_new_or_edited_count() -> None:
    taught = make_turning_session()
    before = taught.lesson
    taught.edit(3, next="right")
    taught.delete(2)
    play(taught, "right", 1)
    assert [example.number for example in list_new_presses(before, taught.lesson)] == [3, 5, 6]
    assert list_new_presses(before, before) == []
