"""Lessons taught in the trainer by keys only, on a screen nobody sees and a clock that moves when told."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import replace
from functools import wraps
from math import dist
from pathlib import Path
from typing import Any

import pytest
from tests.ui.terminal.desks import GOTO, Hand, fail_by_presses, make_plan, make_trainer

from understudy.addons.robots.twin import find_drawn_world
from understudy.learning.fit import learn
from understudy.model.lesson import ExampleKind, Lesson
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.target_lookup import find_target_place
from understudy.storage.library_folder import list_versions, open_library
from understudy.training.trainee import Mode
from understudy.ui.controller.training_plan import LessonChoices
from understudy.ui.terminal.app import SessionEnd
from understudy.ui.terminal.dialogs import QuestionDialog
from understudy.ui.terminal.main_screen import TeachingScreen

Test = Callable[..., Coroutine[Any, Any, None]]


def run(test: Test) -> Callable[..., None]:
    """Run a test in an event loop."""

    @wraps(test)
    def sync(**fixtures: Any) -> None:
        asyncio.run(test(**fixtures))

    return sync


def save_lesson(folder: Path, name: str = "goto") -> Lesson:
    lesson = open_library(folder, FORAGE_KIT, learn).library.taught[name].lesson
    assert lesson is not None
    return lesson


def where(hand: Hand) -> tuple[float, float]:
    robots = hand.trainer.view.robots
    return float(robots.x[0]), float(robots.y[0])


def kinds(hand: Hand) -> list[str]:
    return [f"{each.kind}{' ◆' * each.correction}" for each in hand.trainer.session.examples]


@pytest.mark.long
@run
async def test_a_robot_is_taught_goto_by_keys_and_goes_there_in_worlds_it_never_saw(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path / "library", seed=6)) as hand:
        await hand.show(worlds=3)
        await hand.press("n", "t")
        assert hand.trainer.session_view.mode is Mode.TESTING
        assert "TESTING" in hand.read_part("header")
        for _ in range(2):
            await hand.guide()
            station = find_target_place(find_drawn_world(hand.trainer.body), "station")
            assert station is not None
            assert dist(where(hand), station) < 0.5
            assert hand.trainer.session_view.mode is Mode.TESTING, "it had to be corrected"
            await hand.press("n")
        await hand.press("s", "q")
    ended = hand.app.return_value
    assert isinstance(ended, SessionEnd)
    assert ended.saved
    assert len(save_lesson(tmp_path / "library").examples) == ended.examples
    assert ended.journal.exists()
    assert not list((tmp_path / "library" / ".journals").glob("*.journal"))


@run
async def test_a_press_is_recorded_with_its_default_and_said(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("left")
        assert hand.trainer.session_view.waiting == "rotate_left"
        await hand.wait(0.1)
        assert hand.status_text.startswith("start → rotate_left, distance_to(A) = ")
        assert hand.status_text.endswith("°, with its default")
        assert "▶  turn left" in hand.read_part("states")
        await hand.wait(0.5)
        await hand.press("1")
        await hand.wait(0.1)
        await hand.press("enter")
        await hand.wait(0.1)
        assert hand.status_text.startswith("forward confirmed")
        assert kinds(hand) == ["directive", "default", "directive", "default", "confirmation"]
        assert "5 shown" in hand.read_part("lower")


@run
async def test_directing_in_testing_visibly_becomes_a_correction(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("t")
        assert "nothing to test yet" in hand.status_text
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t")
        await hand.wait(0.3)
        assert hand.trainer.session_view.state == "forward"
        assert "press to correct" in hand.read_part("states")
        await hand.press("right")
        assert "CORRECTED" in hand.read_part("header")
        await hand.wait(0.1)
        assert hand.trainer.session_view.mode is Mode.TRAINING
        assert hand.status_text.startswith("correction: forward → rotate_right")
        assert kinds(hand)[-2:] == ["directive ◆", "default ◆"]
        assert "◆ forward → turn right" in hand.read_part("lower")


@run
async def test_a_flag_raised_too_early_is_corrected_where_it_was_raised(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("4")
        await hand.wait(0.2)
        await hand.press("t")
        await hand.wait(1)
        assert hand.trainer.session_view.flag == "done"
        assert hand.status_text.startswith("goto raised done")
        await hand.press("up")
        await hand.wait(0.1)
        last = hand.trainer.session.examples[-1]
        assert (last.state, last.next, last.kind, last.correction) == (
            "forward", "forward", ExampleKind.CONFIRMATION, True,
        )  # fmt: skip


@run
async def test_undo_and_redo(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("u")
        assert "nothing to undo" in hand.status_text
        assert hand.trainer.status.tone == "error"
        await hand.press("left")
        await hand.wait(0.2)
        await hand.press("up")
        await hand.wait(0.2)
        await hand.press("ctrl+z")
        assert hand.status_text == "Undone: rotate_left → forward"
        assert kinds(hand) == ["directive", "default"]
        assert hand.trainer.session_view.state == "rotate_left"
        await hand.press("U")
        assert hand.status_text == "Redone: rotate_left → forward"
        assert len(hand.trainer.session.examples) == 4


@run
async def test_time_stands_still_while_paused_and_a_press_then_is_marked(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("up")
        await hand.wait(1)
        await hand.press("space")
        before, clock = hand.trainer.session_view.time_s, hand.trainer.pace.time_s
        await hand.wait(5)
        assert (hand.trainer.session_view.time_s, hand.trainer.pace.time_s) == (before, clock)
        assert "PAUSED" in hand.read_part("header")
        await hand.press("left")
        assert hand.trainer.session_view.waiting == "rotate_left"
        await hand.press("full_stop")
        assert hand.trainer.session_view.time_s == pytest.approx(before + 0.1)
        assert hand.trainer.session_view.state == "rotate_left"
        assert hand.trainer.session.examples[-2].window == 0  # paused: never from before
        await hand.press("space", "plus")
        await hand.wait(1)
        assert hand.trainer.session_view.time_s == pytest.approx(before + 0.1 + 2.0)


@run
async def test_driving_into_position_records_nothing(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        start = where(hand)
        await hand.press("d")
        await hand.wait(1)
        assert where(hand) == start, "it stands still until a key is pressed"
        assert "DRIVING" in hand.read_part("header")
        await hand.press("up")
        await hand.wait(1)
        await hand.press("enter", "d")
        assert where(hand) != start
        assert not hand.trainer.session.examples
        assert hand.trainer.session_view.state == "start"


@run
async def test_what_is_saved_is_opened_again_and_goes_on(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=3)) as hand:
        await hand.press("left")
        await hand.wait(0.3)
        await hand.press("s", "q")
    async with make_trainer(make_plan(tmp_path, choices=LessonChoices())) as hand:
        assert "Opened " in hand.status_text
        assert hand.trainer.session_view.targets == {"A": "station"}
        assert not hand.trainer.has_unsaved_changes
        await hand.press("p", "right")
        await hand.wait(0.3)
        assert hand.trainer.has_unsaved_changes
        await hand.press("s", "q")
    lesson = save_lesson(tmp_path)
    assert [example.binding["A"] for example in lesson.examples] == ["station"] * 2 + ["nearest_food"] * 2
    assert len(list_versions(tmp_path, "goto")) == 1


@run
async def test_quitting_asks_about_what_is_not_saved(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("up")
        await hand.wait(0.2)
        await hand.press("q")
        assert not isinstance(hand.app.screen, TeachingScreen)
        await hand.press("escape")
        assert isinstance(hand.app.screen, TeachingScreen)
        before = hand.trainer.session_view.time_s
        await hand.wait(0.5)
        assert hand.trainer.session_view.time_s > before
        await hand.press("ctrl+q", "x")
    ended = hand.app.return_value
    assert isinstance(ended, SessionEnd)
    assert not ended.saved
    assert not (tmp_path / "goto.json").exists()


@run
async def test_what_changed_is_said_and_asked_before_it_is_saved(tmp_path: Path) -> None:
    live = replace(GOTO, live=True)
    async with make_trainer(make_plan(tmp_path / "library", choices=live), size=(100, 30)) as hand:
        await hand.press("1")
        await hand.wait(0.3)
        await hand.press("2")
        await hand.wait(0.3)
        await hand.press("s")
        assert hand.status_text.startswith("Saved in")
        assert "Changed:" not in hand.read_part("said")
        hand.trainer.delete(3)
        hand.teach_screen.draw()
        assert "± Changed: forward no longer goes to turn left  u undo  D show me" in hand.read_part("said")
        await hand.press("D")
        assert hand.read_part("lower").splitlines() == [
            "What changed  D shows the examples again",
            "forward no longer goes to turn left",
            "  − distance to A is at least 5.31 m",
        ]
        await hand.press("D")
        assert hand.read_part("lower").startswith("Examples")
        await hand.press("D", "u")
        assert "Changed:" not in hand.read_part("said")
        assert hand.read_part("lower").startswith("Examples"), "what is undone is not shown"
        await hand.press("D")
        assert hand.status_text == "Nothing changed beyond what the last press or edit says itself"
        await hand.press("U")
        hand.trainer.delete(1)
        await hand.press("s")
        assert isinstance(hand.app.screen, QuestionDialog)
        await hand.press("escape")
        assert hand.trainer.has_unsaved_changes
        await hand.press("s", "s")
        assert "Since it was last saved: start no longer goes to forward" in hand.status_text
        assert not hand.trainer.has_unsaved_changes


@run
async def test_a_killed_session_is_offered_and_nothing_shown_is_lost(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("left")
        await hand.wait(0.5)
        await hand.press("up")
        await hand.wait(0.2)
        shown, there = hand.trainer.session.examples, where(hand)
        await hand.press("right")  # acknowledged, but no tick came before the end
        (journal,) = (tmp_path / ".journals").iterdir()
        killed = journal.read_bytes()
    journal.write_bytes(killed)  # as a kill at that moment would have left it
    async with make_trainer(make_plan(tmp_path), offer=True) as hand:
        assert hand.app.unfinished is not None
        assert hand.app.unfinished.examples == 4
        await hand.press("enter")
        assert hand.trainer.session.examples == shown
        assert hand.trainer.session_view.waiting == "rotate_right"
        assert hand.trainer.paused
        assert dist(where(hand), there) < 0.2
        await hand.press("space")
        await hand.wait(0.2)
        assert len(hand.trainer.session.examples) == 6
        await hand.press("s", "q")
    assert len(save_lesson(tmp_path).examples) == 6
    async with make_trainer(make_plan(tmp_path), offer=True) as hand:
        assert hand.app.unfinished is None


@pytest.mark.long
@run
async def test_everything_is_chosen_on_the_first_page(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, choices=LessonChoices())) as hand:
        await hand.press("ctrl+g")
        told = hand.app.screen.query_one("#told").render()
        assert "No states yet" in str(told)
        await hand.press("down", "space", "down", "space", "down", "space")
        await hand.press("tab", "tab", "A", "enter", "A", "=", *"station", "enter", *"done")
        await hand.press(
            "shift+tab", "shift+tab", "shift+tab", "home", "space", "down", "down", "down", "space"
        )
        await hand.press("ctrl+g")
        automaton = hand.trainer.session.automaton
        assert automaton.parameters == ("A",)
        assert len(automaton.state_names) == 5
        assert automaton.state_names[-1] == "done"
        assert [str(bound) for bound in automaton.features] == ["distance_to(A)", "angle_to(A)"]
        assert hand.trainer.session_view.targets == {"A": "station"}


@run
async def test_features_are_chosen_anew_and_examples_stay(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path)) as hand:
        await hand.press("up")
        await hand.wait(0.2)
        await hand.press("c", "tab", "end", *["up"] * 3, "space", "ctrl+g")
        assert [str(bound) for bound in hand.trainer.features][-1] == "at_station"
        assert len(hand.trainer.session.examples) == 2
        assert all(len(example.values) == 3 for example in hand.trainer.session.examples)
        await hand.press("u")
        assert len(hand.trainer.features) == 2


@run
async def test_why_and_the_page_of_the_lesson(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=3), size=(120, 40)) as hand:
        await hand.press("left")
        await hand.wait(0.5)
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t")
        await hand.wait(1.5)
        await hand.press("question_mark")
        assert "ago it went from turn left to forward because" in hand.read_part("lower")
        assert "(shown by " in hand.read_part("lower")
        await hand.press("l")
        await hand.press("x", "u", "x", "escape")
        assert len(hand.trainer.session.examples) == 3
        await hand.press("h", "escape")
        assert isinstance(hand.app.screen, TeachingScreen)


@run
async def test_watched_examples_can_be_switched_off(tmp_path: Path) -> None:
    watched = replace(GOTO, watched=True)
    async with make_trainer(make_plan(tmp_path, choices=watched)) as hand:
        await hand.press("w")
        assert hand.status_text == "Learning from silence: off"
        await hand.press("w", "up")
        await hand.wait(2)
        await hand.press("left")
        await hand.wait(0.1)
        assert "watched" in kinds(hand)
        assert "watched" in hand.read_part("lower")


@run
async def test_what_made_it_worse_is_undone_by_a_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fail_by_presses(monkeypatch, {1: 0.2, 2: 0.5, 3: 0.5})
    async with make_trainer(make_plan(tmp_path / "library", seed=3)) as hand:
        hand.trainer.pause()
        await hand.press("up", "full_stop", "T")
        assert "goto works in 97 of 121 new worlds. Here, in " in hand.read_part("said")
        assert "undo the last" not in hand.read_part("said")
        await hand.press("left", "full_stop", "up", "full_stop", "T")
        said = " ".join(hand.read_part("said").split())
        assert (
            "goto works in 73 of 146 new worlds: 97 of 121 after press 1, before the last 2 presses." in said
        )
        assert "B undo the last 2 presses" in said
        await hand.press("B")
        said = " ".join(hand.read_part("said").split())
        assert "goto is as after press 1 again; redo brings back the last 2 presses. Here, in" in said
        assert hand.trainer.session_view.examples == 2, "a press and its default"
