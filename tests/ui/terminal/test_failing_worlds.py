"""Failing worlds in the trainer: a key lists them, Enter opens one where it goes wrong, a press corrects it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.falsification.team_kept import keep_team
from tests.falsification.test_team_failure import teach_lead
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.terminal.desks import Hand, make_plan, make_trainer
from tests.ui.terminal.test_main_screen import run
from tests.ui.web.test_failing_worlds import MENDED
from textual.widgets import DataTable, Static

from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan
from understudy.ui.terminal.failures_screen import FailuresScreen


async def list_failing_worlds(hand: Hand) -> tuple[dict[str, str], str]:
    """The marks of the failing worlds, once they have been run, and what stands above them."""
    await hand.press("W")
    screen = hand.app.screen
    assert isinstance(screen, FailuresScreen), screen
    while screen.result is None or "pass now" not in str(screen.query_one("#head", Static).render()):
        await hand.pilot.pause(0.01)
    table = screen.query_one(DataTable)
    rows = [table.get_row_at(row) for row in range(table.row_count)]
    return {str(row[1]): str(row[0]) for row in rows}, str(screen.query_one("#head", Static).render())


@run
async def test_one_is_opened_corrected_and_ticked_off(
    library_with_failures: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = library_with_failures
    monkeypatch.chdir(library.parent)  # where the folder of failing worlds is
    async with make_trainer(make_plan(library, "goto", LessonChoices())) as hand:
        marks, head = await list_failing_worlds(hand)
        assert marks == dict.fromkeys(MENDED, "✗")
        assert "0 of 4 pass now" in head
        table = hand.app.screen.query_one(DataTable)
        table.move_cursor(row=[*marks].index("forage-2"))
        await hand.press("enter")
        assert (
            hand.status_text
            == "Paused in forage-2, where it goes wrong. Press what goto should do, and resume"
        )
        assert hand.trainer.paused
        assert hand.trainer.session_view.features["distance_to(A)"] == pytest.approx(9.66, abs=0.01)
        assert hand.teach_screen.trainer is hand.trainer
        await hand.press(hand.trainer.keys.plain["left"], "full_stop")
        assert hand.trainer.session_view.state == "left"
        marks, head = await list_failing_worlds(hand)
        assert marks == {name: {"passes": "✓", "fails": "✗"}[state] for name, state in MENDED.items()}
        assert "3 of 4 pass now" in head
        await hand.press("escape", "s", "s")  # it changed more than was pressed
        assert not hand.trainer.has_unsaved_changes
        await hand.press("q")
    assert hand.app.return_value is not None
    assert hand.app.return_value.saved  # type: ignore[union-attr]  # no error was returned


@run
async def test_an_empty_list_says_where_failing_worlds_come_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    async with make_trainer(make_plan(tmp_path / "library")) as hand:
        await hand.press("W")
        await hand.pilot.pause(0.2)
        assert "understudy falsify" in str(hand.app.screen.query_one("#head", Static).render())
        await hand.press("escape")
        assert hand.teach_screen.trainer is hand.trainer


@run
async def test_what_is_unsaved_and_does_not_run_there_is_not_lost(
    library_with_failures: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = library_with_failures
    monkeypatch.chdir(library.parent)
    other = LessonChoices(states=["forward"], features=["food_left"])
    async with make_trainer(make_plan(library, "other", other)) as hand:
        await hand.press("up", "full_stop")
        marks, _ = await list_failing_worlds(hand)
        hand.app.screen.query_one(DataTable).move_cursor(row=[*marks].index("forage-2"))
        await hand.press("enter")
        assert "other has unsaved changes" in hand.status_text
        assert hand.trainer.name == "other"


@run
async def test_the_coordinator_of_a_team_is_opened_and_corrected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = keep_team(tmp_path, teach_lead())
    monkeypatch.chdir(tmp_path)
    choices = LessonChoices(states=["forwards"], features=["stuck"])
    async with make_trainer(TrainingPlan("other", library, SCENARIO, ROBOTS, choices, 1)) as hand:
        await hand.press("W")
        await hand.pilot.pause(0.2)
        await hand.press("enter")
        assert (hand.trainer.name, hand.trainer.paused) == ("lead", True), hand.status_text
        assert "3.0 s before it goes wrong" in hand.status_text
        other = "home" if hand.trainer.session_view.state != "home" else "out"
        await hand.press(hand.trainer.keys.plain[other], "full_stop")
        assert hand.trainer.session_view.state == other
        await hand.press("s", "s")  # it changed more than was pressed
        assert not hand.trainer.has_unsaved_changes
        assert (library / "patrol" / "lead.json").exists()
        await hand.press("q")
