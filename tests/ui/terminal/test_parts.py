"""The parts of the trainer: time, keys, words, the picture, what a plan refuses, journals."""

from __future__ import annotations

import re
from datetime import datetime
from importlib import import_module
from math import nan, radians
from pathlib import Path
from typing import Any

import pytest
from tests.make.run_frames import make_crossing
from tests.ui.terminal.desks import GOTO, Wall, make_plan
from textual.screen import Screen

from understudy.errors import KindError, UnderstudyError
from understudy.model.automaton import START, State
from understudy.model.binding import Binding
from understudy.model.describe import format_value
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.target_lookup import find_target_place
from understudy.ui.controller import interrupted_sessions, key_bindings
from understudy.ui.controller.clock import BUSY_S, FASTEST, RealTimeClock
from understudy.ui.controller.formatting import format_minutes, format_sparkline, parse_displayed_value
from understudy.ui.controller.training_plan import LessonChoices, make_session_start
from understudy.ui.terminal import main_screen
from understudy.ui.terminal.dialogs import HelpScreen, QuestionDialog
from understudy.ui.terminal.lesson_form import LessonForm
from understudy.ui.terminal.lesson_screen import LessonScreen
from understudy.ui.terminal.main_screen import TeachingScreen
from understudy.ui.terminal.world_view import ARROWS, describe_followed_robot, fit_arena, render_world

ANGLE = BoundFeature(FORAGE_KIT.features["angle_to"], Binding(A="A"))
DISTANCE = BoundFeature(FORAGE_KIT.features["distance_to"], Binding(A="A"))
FOOD = BoundFeature(FORAGE_KIT.features["food_stored"])
LEFT = BoundFeature(FORAGE_KIT.features["food_left"])


def test_ticks_are_due_in_real_time_and_time_stops_while_it_stands() -> None:
    wall = Wall()
    pace = RealTimeClock(wall, tick_s=0.1)
    wall.now = 5.0
    assert (pace.count_due_ticks(), pace.time_s) == (0, 0.0)
    pace.resume()
    wall.now = 5.25
    assert pace.count_due_ticks() == 2
    wall.now = 5.3
    assert pace.count_due_ticks() == 1
    pace.faster()
    wall.now = 5.4
    assert pace.count_due_ticks() == 2
    pace.stop()
    wall.now = 60.0
    pace.resume()
    wall.now = 90.0
    assert pace.count_due_ticks() == 5, "a long stall is not made up for"
    assert pace.time_s == pytest.approx(30.4)


def test_speeds_end_somewhere() -> None:
    pace = RealTimeClock(Wall(), tick_s=0.1)
    for _ in range(20):
        pace.faster()
    assert pace.speed == FASTEST
    pace.slower()
    assert pace.speed == 16
    for _ in range(20):
        pace.slower()
    assert pace.speed == 0.25


def test_as_fast_as_it_goes_takes_what_fits_into_a_beat() -> None:
    wall = Wall()
    pace = RealTimeClock(wall, tick_s=0.1)
    pace.speed = FASTEST
    assert list(pace.ticks()) == [], "time stands still"
    pace.resume()
    wall.now = 1000.0
    taken = 0
    for _ in pace.ticks():
        taken += 1
        wall.now += BUSY_S / 3
    assert taken == 3
    assert pace.time_s == pytest.approx(1000.0 + BUSY_S)
    for _ in pace.ticks():
        taken += 1
        wall.now += 5.0
    assert taken == 4, "one at least, however long it takes"
    for _ in pace.ticks():
        taken += 1
        pace.stop()
    assert taken == 5, "what stops it is obeyed at once"
    pace.resume()
    pace.speed = 1.0
    assert pace.count_due_ticks() == 0, "nothing is owed"


def test_no_key_of_a_state_is_a_key_of_a_command() -> None:
    commands = {key for binding in main_screen.TeachingScreen.BINDINGS for key in binding.key.split(",")}  # type: ignore[union-attr]
    assert not commands & set(key_bindings.LETTERS + key_bindings.DIGITS + "0")
    assert not commands & set(key_bindings.ARROWS)
    assert len(set(key_bindings.LETTERS)) == len(key_bindings.LETTERS)


def test_keys_of_states() -> None:
    library = Library(FORAGE_KIT)
    states = (
        START,
        State("ahead", "forward"),
        State("rotate_right", "rotate_right"),
        State("ahead_too", "forward"),
        *(State(f"load{number}", "load_food") for number in range(8)),
    )
    found = key_bindings.bind_state_keys(library, states)
    assert found.leads["up"] == found.leads["1"] == "ahead"
    assert found.leads["right"] == found.leads["2"] == "rotate_right"
    assert found.leads["0"] == "start"
    assert found.leads["a"] == "load6"
    assert (found.label("ahead"), found.label("ahead_too")) == ("↑1", " 3")


VALUES = [
    (DISTANCE, 3.4213, "3.42 m"),
    (DISTANCE, nan, "–"),
    (ANGLE, radians(31), "31°"),
    (ANGLE, radians(329), "−31°"),
    (ANGLE, radians(180), "180°"),
    (ANGLE, radians(359.9), "0°"),
    (FOOD, 12.0, "12 units"),
    (LEFT, 1.0, "yes"),
]


@pytest.mark.parametrize(("bound", "number", "text"), VALUES)
def test_values_are_said_with_their_units(bound: BoundFeature, number: float, text: str) -> None:
    assert format_value(bound, number) == text


SAID = [
    (DISTANCE, "3.42 m", 3.42),
    (DISTANCE, " 3.42", 3.42),
    (DISTANCE, "", nan),
    (ANGLE, "–", nan),
    (ANGLE, "−31°", radians(-31)),
    (ANGLE, "-31", radians(-31)),
    (FOOD, "12 units", 12.0),
    (LEFT, "yes", 1.0),
]


@pytest.mark.parametrize(("bound", "text", "read"), SAID)
def test_values_are_read_as_they_are_said(bound: BoundFeature, text: str, read: float) -> None:
    assert parse_displayed_value(bound, text) == pytest.approx(read, nan_ok=True)


@pytest.mark.parametrize(
    ("bound", "text", "problem"),
    [(DISTANCE, "far", "'far' is not a number"), (LEFT, "1", "give no or yes")],
)
def test_what_is_no_value_is_refused(bound: BoundFeature, text: str, problem: str) -> None:
    with pytest.raises(KindError, match=problem):
        parse_displayed_value(bound, text)


def test_bars() -> None:
    assert format_sparkline(DISTANCE, [0.0, 7.0, nan], 4) == " ▁█ "
    assert format_sparkline(ANGLE, [radians(181), 0.0, radians(179)], 3) == "▁▅█"
    assert format_sparkline(LEFT, [0.0, 1.0], 2) == "▁█"
    assert format_minutes(128.34) == "2:08.3"


@pytest.mark.parametrize(("columns", "lines"), [(80, 20), (20, 40), (1, 1)])
def test_the_picture_keeps_its_size_and_shows_what_there_is(columns: int, lines: int) -> None:
    world = Forage([5])
    view, station = world.view(), find_target_place(world, "station")
    assert station is not None
    wide, tall = fit_arena(view, columns, lines)
    aims = [station, (-4.0, 99.0)]
    drawn = render_world(view, [(1.0, 1.0), (99.0, -3.0)], aims, columns=wide, lines=tall, robot=0).plain
    rows = drawn.split("\n")
    assert len(rows) == tall <= lines
    assert {len(row) for row in rows} == {wide}
    if tall > 10:
        assert "⌂" in drawn
        assert all(str(amount) in drawn for amount in view.objects.amount[view.objects.food].tolist())


@pytest.mark.parametrize("robots", [1, 4, 30, 1000])
def test_any_world_in_characters(robots: int) -> None:
    view = make_crossing(3, robots=robots)[-1].view
    wide, tall = fit_arena(view, 90, 30)
    rows = render_world(view, columns=wide, lines=tall).plain.split("\n")
    assert (len(rows), {len(row) for row in rows}) == (tall, {wide})
    arrows = sum(row.count(arrow) for row in rows for arrow in ARROWS)
    assert arrows == 0 if robots == 1000 else 0 < arrows <= robots
    assert all(sign in "".join(rows) for sign in ("3", "4", "⌂", "■", "⣿"))
    assert describe_followed_robot(view, 90) == (
        "" if robots == 1 else f"{'1 000' if robots == 1000 else robots} robots  home 0 of 7"
    )


REFUSED = [
    ("forward", GOTO, "a basic behavior has this name already"),
    ("goto", LessonChoices(states=["fly"]), "no behavior 'fly'"),
    ("goto", LessonChoices(states=["forward"], features=["distance_to(B)"]), "no parameter or target 'B'"),
    (
        "goto",
        LessonChoices(states=["forward"], features=["food_left"], targets={"A": "station"}),
        "no parameter 'A'",
    ),
    ("", GOTO, "no file can be called so"),
    (
        "goto",
        LessonChoices(states=["forward"], features=["food_left"], parameters=["A"], targets={"A": "x"}),
        "no target 'x'",
    ),
]


@pytest.mark.parametrize(("name", "choices", "problem"), REFUSED)
def test_a_plan_that_makes_no_sense_is_refused(
    tmp_path: Path, name: str, choices: LessonChoices, problem: str
) -> None:
    with pytest.raises(UnderstudyError, match=problem):
        make_session_start(make_plan(tmp_path, name, choices))


def test_a_plan_with_something_left_to_choose(tmp_path: Path) -> None:
    assert make_session_start(make_plan(tmp_path, choices=LessonChoices(parameters=["A"]))) is None


def test_only_the_last_ended_journals_are_kept_and_other_names_are_left_alone(tmp_path: Path) -> None:
    for name in ("goto", "goto-2"):
        for second in range(8):
            path = interrupted_sessions.make_journal_path(
                tmp_path, name, now=datetime(2026, 1, 1, 12, 0, second)
            )
            path.touch()
            interrupted_sessions.finish_journal(path, tmp_path, name)
    left = sorted(path.name for path in (tmp_path / interrupted_sessions.FOLDER).iterdir())
    assert len(left) == 2 * interrupted_sessions.KEPT
    assert left[-1] == "goto-2026-01-01-12.00.07.ended"


@pytest.mark.parametrize("screen", [QuestionDialog, HelpScreen, LessonForm, LessonScreen, TeachingScreen])
def test_style_sheets_name_widgets_that_there_are(screen: type[Screen[Any]]) -> None:
    """A selector of a class that is called otherwise now would select nothing, and say so nowhere."""
    named = re.findall(r"(?<![\w.#-])[A-Z]\w+", re.sub(r"\{.*?\}", "", screen.CSS))
    assert set(named) <= set(vars(import_module(screen.__module__)))
    assert screen.__name__ in named
