"""A session as a notebook's widget drives it: what views ask for is done, or refused in a sentence."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some
from tests.bodies import Scripted
from tests.ui.notebook.sessions import STATES, VIEW, Hand, make_goto_session

from understudy.errors import FileError, SessionError, SettingError, UnderstudyError
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import open_library
from understudy.training.session import Session
from understudy.training.trainee import Mode
from understudy.ui.controller.interrupted_sessions import is_same_lesson
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.notebook.session_driver import SILENT_S, SessionDriver
from understudy.ui.notebook.view_data import describe_panel


def test_a_press_is_answered_at_once_and_recorded_at_the_next_tick() -> None:
    hand = Hand(make_goto_session())
    assert hand.press("rotate_left") == "start → rotate_left"
    assert hand.driver.trainer.session_view.waiting == "rotate_left"
    hand.wait()
    assert hand.status[1] == "recorded"
    assert hand.status[0].startswith("start → rotate_left, distance_to(A) = ")
    assert [str(example.kind) for example in hand.session.lesson.examples] == ["directive", "default"]
    assert hand.session.view().state == "rotate_left"


BAD = [  # what a page sends, what the status says
    ({"action": "jump"}, "cannot be understood"),
    ({"action": "press", "state": 4}, "cannot be understood"),
    ({"action": "press", "state": "x" * 151}, "cannot be understood"),
    ({"action": "press", "state": "forward", "twice": True}, "cannot be understood"),
    ({}, "cannot be understood"),
    ("press", "cannot be understood"),
    (None, "cannot be understood"),
    ({"action": "press", "state": "fly"}, "automaton 'goto' has no state 'fly'; it has start, forward"),
    ({"action": "press"}, "automaton 'goto' has no state ''"),
    ({"action": "toggle_mode"}, "there is nothing to test yet"),
    ({"action": "undo"}, "there is nothing to undo"),
    ({"action": "redo"}, "there is nothing to redo"),
    ({"action": "save"}, "no folder to save in was given"),
]


@pytest.mark.parametrize(("content", "says"), BAD, ids=str)
def test_what_cannot_be_done_is_refused_in_a_sentence(content: Any, says: str) -> None:
    hand = Hand(make_goto_session())
    hand.wait()
    before = hand.session.view(), hand.session.examples
    hand.driver.receive(content)
    text, tone = hand.status
    assert says in text
    assert "\n" not in text
    assert tone == "error"
    assert repr((hand.session.view(), hand.session.examples)) == repr(before)
    hand.wait()
    assert not hand.session.paused


MOVES = some.lists(
    some.one_of(
        some.sampled_from([("press", state) for state in STATES]),
        some.sampled_from(
            [("confirm", ""), ("undo", ""), ("toggle_mode", ""), ("restart", ""), ("pause", "")]
        ),
        some.tuples(some.just("wait"), some.integers(1, 8)),
    ),
    max_size=25,
)


@settings(max_examples=25, deadline=None)
@given(moves=MOVES, live=some.booleans())
def test_a_session_in_a_notebook_is_that_of_a_program(moves: Sequence[tuple[str, Any]], live: bool) -> None:
    hand, other = Hand(make_goto_session(live=live)), make_goto_session(live=live)
    for action, what in moves:
        if action == "wait":
            hand.wait(what)
            if not other.paused:
                for _ in range(what):
                    other.tick()
        elif hand.ask(action=action, state=what) and hand.status[1] != "error":
            repeat(other, action, what)
        assert repr(hand.session.view()) == repr(other.view())
    assert is_same_lesson(hand.session.lesson, other.lesson)


def repeat(session: Session, action: str, state: str) -> None:
    """Do in a program what a button does."""
    if action == "press":
        session.direct(state)
    elif action == "confirm":
        session.confirm()
    elif action == "undo":
        session.undo()
    elif action == "restart":
        session.restart()
    elif action == "pause":
        session.paused = not session.paused
    elif session.mode is not Mode.TESTING:
        session.test()
    elif session.lesson.options.live:
        session.teach()
    else:
        session.train()


def test_the_world_stands_still_while_no_view_is_on_a_screen() -> None:
    hand = Hand(make_goto_session())
    hand.press("forward")
    hand.wait(5)
    assert hand.session.body.time_s == pytest.approx(0.5)
    hand.ask(action="hide", view="one")
    for _ in range(20):
        hand.now += 0.1
        hand.driver.beat()
    assert hand.session.body.time_s == pytest.approx(0.5)
    assert not hand.session.paused
    hand.ask(**VIEW)
    hand.wait(5)
    assert hand.session.body.time_s == pytest.approx(1.0)


def test_of_two_views_one_on_a_screen_is_enough() -> None:
    hand = Hand(make_goto_session())
    hand.ask(action="show", view="two")
    hand.ask(action="hide", view="two")
    hand.now += 0.1
    hand.driver.beat()
    assert hand.session.body.time_s == pytest.approx(0.1)


def test_a_view_that_is_silent_counts_as_hidden() -> None:
    """A browser that crashed, or a computer that sleeps."""
    hand = Hand(make_goto_session())
    for _ in range(round(2 * SILENT_S / 0.1)):
        hand.now += 0.1
        hand.driver.beat()
    assert hand.session.body.time_s == pytest.approx(SILENT_S, abs=0.11)
    assert not hand.driver.is_shown


def test_cells_may_use_the_session_meanwhile() -> None:
    hand = Hand(make_goto_session())
    hand.press("forward")
    hand.wait(2)
    hand.session.direct("done")  # a cell
    version = hand.driver.version
    hand.driver.beat()
    assert hand.driver.version > version
    assert hand.driver.trainer.session_view.waiting == "done"
    hand.session.reset(200)
    hand.session.paused = True
    hand.wait(3)
    assert hand.session.body.time_s == 0.0
    assert hand.driver.trainer.seed == 200
    hand.session.paused = False
    hand.driver.beat()
    hand.wait(3)
    assert hand.session.body.time_s == pytest.approx(0.3)


def test_it_asks_and_a_press_answers() -> None:
    hand = Hand(make_goto_session())
    for state, ticks in (
        ("rotate_left", 9),
        ("forward", 30),
        ("rotate_left", 5),
        ("forward", 5),
        ("done", 1),
    ):
        hand.press(state)
        hand.wait(ticks)
    assert hand.ask(action="ask") == "It pauses and asks where it is unsure"
    hand.ask(action="toggle_mode")
    for _ in range(20):
        hand.ask(action="new_world")
        hand.wait(60)
        if (question := hand.driver.trainer.coach.question) is not None:
            break
    else:
        raise AssertionError("it never asked")
    assert hand.session.paused
    assert hand.status[0] == f"{question.sentence} Space continues"
    before = len(hand.session.examples)
    hand.press(question.answers[0])
    assert len(hand.session.examples) > before
    assert not hand.session.paused
    assert hand.driver.trainer.coach.question is None
    assert hand.ask(action="ask") == "It never asks"


def test_save_keeps_the_automaton_in_the_library(tmp_path: Path) -> None:
    hand = Hand(make_goto_session(), folder=tmp_path)
    hand.press("forward")
    hand.wait()
    assert hand.ask(action="save").startswith("Saved in ")
    assert list(open_library(tmp_path, FORAGE_KIT).library.taught) == ["goto"]


def test_no_press_is_lost_when_the_kernel_ends(tmp_path: Path) -> None:
    """The journal has a press before its answer, so nothing has to be closed."""
    hand = Hand(make_goto_session(journal=tmp_path / "goto.journal"))
    for state in ("rotate_left", "forward", "done"):
        hand.press(state)
        hand.wait(3)
    hand.press("forward")
    with pytest.raises(FileError, match="another session is writing it; end that session first"):
        Session.resume(tmp_path / "goto.journal", Forage([42]), Library(FORAGE_KIT))
    before = hand.session.lesson, hand.session.view().waiting
    (tmp_path / "copy.journal").write_bytes(
        (tmp_path / "goto.journal").read_bytes()
    )  # as a killed process leaves it
    resumed = Session.resume(tmp_path / "copy.journal", Forage([42]), Library(FORAGE_KIT))
    assert is_same_lesson(resumed.lesson, before[0])
    assert resumed.view().waiting == before[1] == "forward"
    for session in (resumed, hand.session):
        session.close()


def test_a_session_that_is_closed_says_so(tmp_path: Path) -> None:
    hand = Hand(make_goto_session(journal=tmp_path / "goto.journal"))
    hand.session.close()
    assert "this journal is closed; continue it with Session.resume" in hand.press("forward")


class Faulty(Forage):
    """A world that breaks in its third tick."""

    problem: Exception = UnderstudyError("the left wheel is stuck")

    def act(self, commands: Any) -> None:
        if self.time_s > 0.15:
            raise self.problem
        super().act(commands)


class Broken(Faulty):
    problem = ZeroDivisionError("division by zero")


class Frozen(Forage):
    """A world that does not tick."""

    def act(self, commands: Any) -> None:
        pass


FAULTS = [
    (Faulty, "the left wheel is stuck"),
    (Broken, "internal error: ZeroDivisionError: division by zero"),
    (Frozen, "the body stands still at 0 s: its act must let time_s grow by tick_s, 0.1 s"),
]


@pytest.mark.parametrize(("body", "says"), FAULTS)
def test_a_body_that_fails_pauses_the_session(body: type[Forage], says: str) -> None:
    hand = Hand(make_goto_session(body=body([42])))
    hand.press("forward")
    hand.wait(5)
    assert hand.status == (says, "error")
    assert hand.session.paused
    assert " → rotate_left" in hand.press("rotate_left")


class Timeless(Forage):
    """A world whose ticks have no length."""

    @property
    def tick_s(self) -> float:
        return 0.0


def test_bodies_that_cannot_be_shown() -> None:
    def driver(session: Session) -> SessionDriver:
        return SessionDriver(session, speed=1.0, folder=None, wall=lambda: 0.0)

    with pytest.raises(
        SettingError, match=r"Timeless: tick_s is 0\.0; give the length of a tick in seconds, above 0"
    ):
        driver(make_goto_session(body=Timeless([42])))
    session = make_goto_session()
    session.body = Scripted(1)
    with pytest.raises(
        SessionError, match="there is no picture of a Scripted: give the session a body that is"
    ):
        driver(session)
    with pytest.raises(SettingError, match=r"show_session: speed is 3; give one of 0\.25, 0\.5, 1"):
        SessionDriver(make_goto_session(), speed=3.0, folder=None, wall=lambda: 0.0)


def test_views_report_as_often_as_the_page_does() -> None:
    page = Path(__file__).parents[3] / "src/understudy/ui/notebook/static/session.js"
    assert "const REPORT_MS = 2000;" in page.read_text(encoding="utf-8")
    assert VIEW["action"] == "show"


def test_what_a_change_says_beyond_itself_is_shown_until_it_is_undone(tmp_path: Path) -> None:
    hand = Hand(make_goto_session(live=True), folder=tmp_path)
    hand.press("forward")
    hand.wait(3)
    hand.press("rotate_left")
    hand.wait(3)

    def read_changes() -> object:
        return describe_panel(hand.driver.trainer, can_save=True)["changed"]

    assert read_changes() is None
    assert hand.ask(action="save") == f"Saved in {tmp_path / 'goto.json'}"
    hand.session.delete(3)
    said = "forward no longer goes to rotate_left"
    decision = {"said": said, "gone": ["distance_to(A) is below 1.94 m"], "new": []}
    assert read_changes() == {"line": said, "decisions": [decision]}
    hand.ask(action="undo")
    assert read_changes() is None
    hand.ask(action="redo")
    assert hand.ask(action="save").endswith(
        ". Since it was last saved: forward no longer goes to rotate_left"
    )


def test_a_score_is_shown_when_it_was_taken_and_turned_off_by_a_request() -> None:
    hand = Hand(make_goto_session(live=True))
    waiting: list[Callable[[], None]] = []
    hand.driver.trainer.score = LessonScoreKeeper(hand.session, begin=waiting.append, worlds=2)
    hand.press("forward")
    hand.wait(3)
    hand.ask(action="pause")
    hand.wait()
    before = hand.driver.version
    hand.driver.beat()
    assert hand.driver.version == before, "nothing is new"
    assert score_of(hand) == {"text": "", "trend": "", "on": True}
    waiting.pop()()
    hand.driver.beat()
    assert hand.driver.version == before + 1
    assert re.fullmatch(r"goto works in \d of 2 new worlds.*", score_of(hand)["text"])
    hand.ask(action="pause")
    for state in ("rotate_left", "forward"):
        hand.press(state)
        hand.wait(3)
        waiting.pop()()
        hand.driver.beat()
    assert hand.status[1] == "correction"
    assert hand.ask(action="toggle_score") == "Runs in new worlds after each press: off"
    assert score_of(hand) == {"text": "not measured: turned off", "trend": "", "on": False}
    hand.press("rotate_left")
    hand.wait(3)
    assert waiting == []


def score_of(hand: Hand) -> dict[str, Any]:
    """What the widget shows of the score in new worlds."""
    score = describe_panel(hand.driver.trainer, can_save=False)["score"]
    assert isinstance(score, dict)
    return score
