"""The coach in the trainer: the next situation on a key, and a robot that asks where it is unsure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tests.ui.terminal.desks import GOTO, make_plan, make_trainer
from tests.ui.terminal.test_main_screen import run

from understudy.training.trainee import Mode
from understudy.ui.terminal.advice_screen import AdviceScreen, render_advice


@run
async def test_the_coach_sets_up_what_it_wants_to_be_shown(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("C")
        assert "there is no situation to set up" in hand.status_text
        await hand.show(worlds=1)
        shown = len(hand.trainer.session.examples)
        await hand.press("C")
        first = hand.status_text
        assert first.startswith(("Show me", "Only example"))
        assert first.endswith("; nothing recorded")
        await hand.press("C")
        assert hand.status_text != first
        assert len(hand.trainer.session.examples) == shown


@run
async def test_it_asks_where_it_is_unsure_and_waits(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t", "A")
        assert hand.status_text == "It pauses and asks where it is unsure"
        await hand.wait(0.3)
        assert hand.status_text.startswith("I am not sure: I would ")
        assert hand.trainer.paused
        before = hand.trainer.body.time_s
        await hand.wait(0.5)
        assert hand.trainer.body.time_s == before
        await hand.press("space")
        await hand.wait(0.2)
        assert hand.trainer.body.time_s > before
        assert hand.trainer.session_view.mode is Mode.TESTING


@run
async def test_it_marks_and_goes_on(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t", "A", "A")
        before = hand.trainer.body.time_s
        await hand.wait(0.5)
        assert hand.trainer.body.time_s > before
        assert hand.trainer.coach.asking.marked


@run
async def test_it_skips_to_where_it_needs_somebody(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("F")
        assert "nothing happens without you" in hand.status_text
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t")
        before = hand.trainer.body.time_s
        await hand.press("F")
        assert "s later. " in hand.status_text
        assert hand.trainer.paused
        assert hand.trainer.body.time_s >= before


@run
async def test_it_goes_to_where_an_answer_matters_most(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("up")
        await hand.wait(0.5)
        await hand.press("t", "G")
        assert "an answer here matters most. I am not sure: " in hand.status_text
        assert hand.trainer.paused
        assert hand.trainer.seed is not None
        assert hand.trainer.seed > 6


@run
async def test_a_switch_that_is_undone_at_once_is_listed_beside_the_advice(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, seed=6)) as hand:
        await hand.press("space")
        for key in ("left", "up", "left"):
            await hand.press(key, ".")
        await hand.press("K")
        assert isinstance(hand.app.screen, AdviceScreen)
        report = hand.trainer.coach.last_report
        assert report is not None
        text = render_advice(report).plain
        assert "warning: forward and turn left" in text
        await hand.press("C")
        assert hand.status_text.startswith(("Show me", "Only example"))


@run
async def test_a_robot_that_turns_for_ever_says_so_while_it_is_watched(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, choices=replace(GOTO, live=True), seed=6)) as hand:
        await hand.press("left")
        said = set()
        for _ in range(40):
            await hand.wait(1.0)
            said.add(hand.status_text)
        assert any(
            "come back to where I was. Where in this round should I do something else?" in each
            for each in said
        )
        assert not hand.trainer.paused
        assert hand.trainer.session_view.state == "rotate_left"


@run
async def test_situations_in_a_row_without_a_press_are_counted(tmp_path: Path) -> None:
    async with make_trainer(make_plan(tmp_path, choices=replace(GOTO, live=True), seed=6)) as hand:
        await hand.press("up")
        said = []
        for _ in range(3):
            await hand.wait(11.0)
            await hand.press("n")
            said.append(hand.status_text)
        assert said == [
            "World 7; nothing recorded",
            "World 8; nothing recorded. 1 in a row without a press",
            "World 9; nothing recorded. 2 in a row without a press",
        ]
        await hand.press("left", "n")
        assert hand.status_text == "World 10; nothing recorded"
