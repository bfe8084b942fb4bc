"""Unlearning in a session: a correction and the quarantine it brings are one step; without it, only advice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from tests.bodies import Scripted, kit
from tests.make.sessions import make_session, play

from understudy.learning.mislabels import MistakeCause
from understudy.model.binding import Binding
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Library
from understudy.storage.document import decode_document, encode_document
from understudy.training import corrections
from understudy.training.corrections import LastSwitch
from understudy.training.sample_buffer import Sample
from understudy.training.session import Session
from understudy.training.trainee import TickResult

WRONG = 6
"""The number of the example that the wrong button made: left, at 84 m."""


def mislead(
    options: LearnerOptions = LearnerOptions(unlearning=True),
    *,
    states: Sequence[str] = ("forward", "left"),
    features: Sequence[str] = ("range_of(ball)",),
    journal: Path | None = None,
) -> Session:
    """A robot that is to go on, was told so from 100 m to 70 m, and once, by mistake, to turn left."""
    taught = make_session(states, features, options=options, journal=journal)
    play(
        taught,
        "forward",
        5,
        "confirm",
        5,
        "confirm",
        5,
        "confirm",
        1,
        "left",
        1,
        "forward",
        5,
        "confirm",
        5,
        "confirm",
        1,
    )
    return taught


def correct(taught: Session) -> Session:
    """Tested, stopped just before it turns left, and told to go on."""
    taught.reset(0)
    taught.test()
    while taught.view().path == ("start",) or taught.view().features["range_of(ball)"] > 84:
        taught.tick()
    return play(taught, "confirm", 1)


def test_a_correction_and_its_quarantine_are_one_step() -> None:
    taught = mislead()
    before = taught.examples
    correct(taught)
    assert [each.number for each in taught.examples if each.quarantined] == [WRONG]
    assert "most like it, say forward" in taught.examples[WRONG - 1].quarantined
    assert taught.view().undoable == "forward → forward, quarantine 1 example"
    after = taught.examples
    taught.undo()
    assert (taught.examples, taught.correction_diagnosis) == (before, None)
    taught.redo()
    assert taught.examples == after
    assert taught.correction_diagnosis is not None


def run_until_turn(taught: Session) -> Session:
    """Tested until it has turned left."""
    taught.reset(0)
    taught.test()
    while taught.view().path != ("left",):
        taught.tick()
    return taught


def send_back(taught: Session) -> Session:
    """Tested until it has turned left, and sent back."""
    return play(run_until_turn(taught), "forward", 1)


def test_sent_back_soon_after_it_switched_the_switch_is_judged() -> None:
    """The correction is recorded where the robot is now; what was wrong is what it decided before."""
    taught = send_back(mislead())
    assert [each.number for each in taught.examples if each.quarantined] == [WRONG]
    correction = taught.examples[-2]
    assert (correction.state, correction.next, correction.correction) == ("left", "forward", True)
    assert taught.correction_diagnosis is not None
    assert taught.correction_diagnosis.verdict is MistakeCause.BAD


def test_sent_back_a_second_later_the_switch_is_judged_all_the_same() -> None:
    taught = mislead()
    taught.delete(WRONG + 2)  # that it is to go on again: now it turns until somebody sends it back
    play(run_until_turn(taught), 10, "forward", 1)
    assert [each.number for each in taught.examples if each.quarantined] == [WRONG]


def test_sent_elsewhere_the_switch_is_not_judged() -> None:
    """Who turns it right now does not say that it should have gone on; nor who restarts it, or sends it back from where
    somebody put it."""
    for steps in (("right", 1), ("restart", "forward", 1), ("note_moved", "forward", 1)):
        taught = play(run_until_turn(mislead(states=("forward", "left", "right"))), *steps)
        assert not any(each.quarantined for each in taught.examples)


def test_of_too_few_examples_it_is_the_correction_that_is_judged() -> None:
    taught = make_session(["forward", "left"])
    play(taught, "forward", 16, "left", 1)
    play(run_until_turn(taught), "forward", 1)
    assert taught.correction_diagnosis is not None
    assert (taught.correction_diagnosis.verdict, taught.correction_diagnosis.suspects) == (
        MistakeCause.UNSURE,
        (),
    )
    assert taught.correction_diagnosis.correction.state == "left"


def test_what_belongs_to_the_automaton_is_as_it_was_then() -> None:
    """At 84 m it had been going on for 1.6 s, whatever the time is when it is sent back."""
    lesson = mislead(features=("range_of(ball)", "time_in_state")).lesson
    switched = LastSwitch((("range", "ball"),), frozenset())
    switched.note_tick(
        TickResult("forward", "left", {"time_in_state": 1.6}), Sample(7.0, (84.0,)), Binding(), first="start"
    )
    switched.note_tick(
        TickResult("left", "left", {"time_in_state": 0.1}), Sample(7.1, (83.0,)), Binding(), first="start"
    )
    correction = Example(12, "left", (82.0, 0.2), "forward", ExampleKind.DIRECTIVE, correction=True)
    stay = switched.find_undone_stay(correction, lesson, 7.2)
    assert stay is not None
    assert (stay.state, stay.values, stay.next) == ("forward", (84.0, 1.6), "forward")
    assert switched.find_undone_stay(correction, lesson, 9.1) is None


def test_sent_back_late_nothing_is_held_against_the_switch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(corrections, "SOON_S", -1.0)
    assert not any(each.quarantined for each in send_back(mislead()).examples)


def test_afterwards_the_robot_is_right() -> None:
    taught = correct(mislead())
    taught.reset(0)
    taught.test()
    assert {play(taught, 1).view().path for _ in range(30)} == {("forward",)}


def test_without_the_option_nothing_happens_but_there_is_advice() -> None:
    taught = correct(mislead(LearnerOptions()))
    assert not any(each.quarantined for each in taught.examples)
    assert taught.view().undoable == "forward → forward"
    assert taught.correction_diagnosis is not None
    assert taught.correction_diagnosis.verdict is MistakeCause.BAD
    taught.quarantine(taught.correction_diagnosis.reasons)
    assert taught.examples == correct(mislead()).examples


def test_only_corrections_of_wrong_decisions_are_judged() -> None:
    taught = mislead()
    assert taught.correction_diagnosis is None
    taught.reset(0)
    taught.test()
    play(taught, 5, "confirm", 1)  # at 95 m it goes on by itself
    assert taught.correction_diagnosis is None
    correct(taught)
    assert taught.correction_diagnosis is not None


@pytest.mark.parametrize("options", [LearnerOptions(unlearning=True), LearnerOptions()])
@pytest.mark.parametrize("went_wrong", [correct, send_back])
def test_a_resumed_session_has_the_same_in_quarantine(
    went_wrong: Callable[[Session], Session], options: LearnerOptions, tmp_path: Path
) -> None:
    """And it knows who is to blame: what it was told before it was cut off can still be acted on."""
    journal = tmp_path / "session.journal"
    taught = went_wrong(mislead(options, journal=journal))
    taught.close()
    resumed = Session.resume(journal, Scripted(), Library(kit))
    assert resumed.examples == taught.examples
    assert resumed.lesson.options == options
    assert resumed.correction_diagnosis == taught.correction_diagnosis
    assert resumed.correction_diagnosis is not None
    assert list(resumed.correction_diagnosis.reasons) == [WRONG]
    play(resumed, "train", "confirm", 1)  # a press that corrects nothing leaves it as it is
    resumed.close()
    again = Session.resume(journal, Scripted(), Library(kit))
    assert again.correction_diagnosis == taught.correction_diagnosis
    again.undo()
    assert again.undo() == taught.view().undoable
    assert again.correction_diagnosis is None
    again.redo()
    assert again.correction_diagnosis == taught.correction_diagnosis
    again.close()


@pytest.mark.parametrize("unlearning", [True, False])
def test_documents_say_so(unlearning: bool, tmp_path: Path) -> None:
    taught = mislead(LearnerOptions(unlearning=unlearning)).make_trained_automaton()
    data = encode_document(taught)
    assert (b'"unlearning"' in data) == unlearning
    opened = decode_document(data, kit, path=tmp_path / "taught.json", learn=lambda lesson: {})
    assert opened.taught.lesson is not None
    assert opened.taught.lesson.options == LearnerOptions(unlearning=unlearning)
