"""Unlearning in a session: a correction and the quarantine it brings are one step; without it, only advice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.bodies import Scripted, kit
from tests.training.lessons import play, session

from understudy.learning.unlearning import Verdict
from understudy.model.document import decode, encode
from understudy.model.lesson import Options
from understudy.model.library import Library
from understudy.training import unlearning
from understudy.training.session import Session

WRONG = 6
"""The number of the example that the wrong button made: left, at 84 m."""


def misled(options: Options = Options(unlearning=True), *, journal: Path | None = None) -> Session:
    """A robot that is to go on, was told so from 100 m to 70 m, and once, by mistake, to turn left."""
    taught = session(["forward", "left"], options=options, journal=journal)
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


def corrected(taught: Session) -> Session:
    """Tested, stopped just before it turns left, and told to go on."""
    taught.reset(0)
    taught.test()
    while taught.screen().path == ("start",) or taught.screen().features["range_of(ball)"] > 84:
        taught.tick()
    return play(taught, "confirm", 1)


def test_a_correction_and_its_quarantine_are_one_step() -> None:
    taught = misled()
    before = taught.examples
    corrected(taught)
    assert [each.number for each in taught.examples if each.quarantined] == [WRONG]
    assert "most like it, say forward" in taught.examples[WRONG - 1].quarantined
    assert taught.screen().undoable == "forward → forward, quarantine 1 example"
    after = taught.examples
    taught.undo()
    assert (taught.examples, taught.judgement) == (before, None)
    taught.redo()
    assert taught.examples == after
    assert taught.judgement is not None


def taken_back(taught: Session) -> Session:
    """Tested until it has turned left, and sent back."""
    taught.reset(0)
    taught.test()
    while taught.screen().path != ("left",):
        taught.tick()
    return play(taught, "forward", 1)


def test_sent_back_soon_after_it_switched_the_switch_is_judged() -> None:
    """The correction is recorded where the robot is now; what was wrong is what it decided before."""
    taught = taken_back(misled())
    assert [each.number for each in taught.examples if each.quarantined] == [WRONG]
    correction = taught.examples[-2]
    assert (correction.state, correction.next, correction.correction) == ("left", "forward", True)
    assert taught.judgement is not None
    assert taught.judgement.verdict is Verdict.BAD


def test_sent_back_late_nothing_is_held_against_the_switch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unlearning, "SOON_S", -1.0)
    assert not any(each.quarantined for each in taken_back(misled()).examples)


def test_afterwards_the_robot_is_right() -> None:
    taught = corrected(misled())
    taught.reset(0)
    taught.test()
    assert {play(taught, 1).screen().path for _ in range(30)} == {("forward",)}


def test_without_the_option_nothing_happens_but_there_is_advice() -> None:
    taught = corrected(misled(Options()))
    assert not any(each.quarantined for each in taught.examples)
    assert taught.screen().undoable == "forward → forward"
    assert taught.judgement is not None
    assert taught.judgement.verdict is Verdict.BAD
    taught.quarantine(taught.judgement.reasons)
    assert taught.examples == corrected(misled()).examples


def test_only_corrections_of_wrong_decisions_are_judged() -> None:
    taught = misled()
    assert taught.judgement is None
    taught.reset(0)
    taught.test()
    play(taught, 5, "confirm", 1)  # at 95 m it goes on by itself
    assert taught.judgement is None
    corrected(taught)
    assert taught.judgement is not None


@pytest.mark.parametrize("options", [Options(unlearning=True), Options()])
@pytest.mark.parametrize("went_wrong", [corrected, taken_back])
def test_a_resumed_session_has_the_same_in_quarantine(
    went_wrong: Callable[[Session], Session], options: Options, tmp_path: Path
) -> None:
    """And it knows who is to blame: what it was told before it was cut off can still be acted on."""
    journal = tmp_path / "session.journal"
    taught = went_wrong(misled(options, journal=journal))
    taught.close()
    resumed = Session.resume(journal, Scripted(), Library(kit))
    assert resumed.examples == taught.examples
    assert resumed.lesson.options == options
    assert resumed.judgement == taught.judgement
    assert resumed.judgement is not None
    assert list(resumed.judgement.reasons) == [WRONG]
    play(resumed, "train", "confirm", 1)  # a press that corrects nothing leaves it as it is
    resumed.close()
    again = Session.resume(journal, Scripted(), Library(kit))
    assert again.judgement == taught.judgement
    again.undo()
    assert again.undo() == taught.screen().undoable
    assert again.judgement is None
    again.redo()
    assert again.judgement == taught.judgement
    again.close()


@pytest.mark.parametrize("unlearning", [True, False])
def test_documents_say_so(unlearning: bool, tmp_path: Path) -> None:
    taught = misled(Options(unlearning=unlearning)).taught()
    data = encode(taught)
    assert (b'"unlearning"' in data) == unlearning
    opened = decode(data, kit, path=tmp_path / "taught.json", learn=lambda lesson: {})
    assert opened.taught.lesson is not None
    assert opened.taught.lesson.options == Options(unlearning=unlearning)
