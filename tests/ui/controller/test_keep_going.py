"""Keep going: what is in training is tested in new worlds, and goes on where it goes wrong, until it holds."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.tui.desks import Wall, plan, right

from understudy.errors import SessionError
from understudy.falsification.holding_test import HoldingResult
from understudy.falsification.new_worlds import Mistake
from understudy.properties.run_property import Verdict
from understudy.training.trainee import Mode
from understudy.ui.controller import keep_going
from understudy.ui.controller.open_session import OpenSession, begin_session
from understudy.ui.controller.trainer import Trainer
from understudy.ui.controller.training_plan import make_session_start


@pytest.fixture
def opened(tmp_path: Path) -> OpenSession:
    chosen = plan(tmp_path / "library")
    start = make_session_start(chosen)
    assert start is not None
    return begin_session(chosen, start, Wall())


def show(trainer: Trainer, seeds: range) -> None:
    """Show GoTo as a person's eye would, from the start of some worlds."""
    for seed in seeds:
        trainer.load_world(seed)
        for _ in range(400):
            wanted = right(trainer.session_view)
            if wanted is not None and wanted != trainer.session_view.state:
                trainer.press(wanted)
            trainer.tick()


def test_it_ends_where_the_behavior_holds(opened: OpenSession) -> None:
    """Two worlds are not enough; a person presses where it stops, and it holds after some rounds."""
    trainer = opened.trainer
    show(trainer, range(3, 5))
    said = []
    for _ in range(12):
        said.append(trainer.keep_going().text)
        if " holds, " in said[-1]:
            break
        assert trainer.paused
        assert trainer.session.mode is Mode.TESTING
        trainer.pause()
        for _ in range(600):
            wanted = right(trainer.session_view)
            if wanted is not None and wanted != trainer.session_view.state:
                trainer.press(wanted)
            trainer.tick()
    assert " holds, " in said[-1], said
    assert "in at least 95 % of worlds (" in said[-1]
    opened.close()


def make_result(*mistakes: Mistake, verdict: Verdict = Verdict.FAILS) -> HoldingResult:
    return HoldingResult(verdict, 80, 121, (0.5, 0.8), mistakes)


def test_the_situation_is_three_seconds_before_the_mistake(opened: OpenSession) -> None:
    trainer = opened.trainer
    show(trainer, range(3, 6))
    examples = trainer.session.examples
    trainer.continuation.begin()
    mistake = Mistake(
        77, {"A": "nearest_food"}, 4.0, "done where distance_to(A) is 2.1 m, shown at 0.2 to 0.4 m"
    )
    said = trainer.continuation.finish(make_result(mistake)).text
    assert trainer.body.time_s == pytest.approx(1.0)
    assert trainer.seed == 77
    assert dict(trainer.session_view.targets) == {"A": "nearest_food"}
    assert trainer.session.examples == examples, "nothing is recorded from silence on the way"
    assert said == (
        "goto works in 80 of 121 new worlds. Here, in 3.0 s: done where distance_to(A) is 2.1 m, shown at 0.2 to "
        "0.4 m. Press what it should do, and resume"
    )
    opened.close()


def test_a_limit_of_presses_ends_it(opened: OpenSession, monkeypatch: pytest.MonkeyPatch) -> None:
    trainer = opened.trainer
    show(trainer, range(3, 4))
    trainer.continuation.begin()
    monkeypatch.setattr(keep_going, "MOST_PRESSES", 0)
    said = trainer.continuation.finish(make_result(Mistake(7, {"A": "station"}, 4.0, "")))
    assert said.text == "goto does not hold yet, as it is: it works in 80 of 121 new worlds"
    assert said.tone == "error"
    opened.close()


def test_what_cannot_be_tested_is_refused(opened: OpenSession, monkeypatch: pytest.MonkeyPatch) -> None:
    trainer = opened.trainer
    with pytest.raises(SessionError, match="nothing to test yet"):
        trainer.keep_going()
    monkeypatch.setattr(keep_going, "World", int)
    with pytest.raises(SessionError, match="no other worlds"):
        trainer.keep_going()
    opened.close()
