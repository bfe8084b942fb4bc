"""Every screen of the trainer shows names as people read them, never those of the code."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.ui.terminal.desks import GOTO, Hand, make_plan, make_trainer

from understudy.ui.controller.training_plan import LessonChoices

IDENTIFIER = re.compile(r"\w*_\w+|\w+\([A-Za-z]\w*\)", re.ASCII)
TARGET = {"A": "nearest_food"}


async def teach(hand: Hand) -> None:
    await hand.press("left")
    await hand.wait(0.5)
    await hand.press("up")
    await hand.wait(0.5)


async def try_it(hand: Hand) -> None:
    await teach(hand)
    await hand.press("t")
    await hand.wait(1.5)


async def explain(hand: Hand) -> None:
    await try_it(hand)
    await hand.press("question_mark")


async def correct(hand: Hand) -> None:
    await try_it(hand)
    await hand.press("right")
    await hand.wait(0.1)


async def undone(hand: Hand) -> None:
    await teach(hand)
    await hand.press("u")


async def driven(hand: Hand) -> None:
    await hand.press("d")


async def open_library(hand: Hand) -> None:
    await teach(hand)
    await hand.press("l")


async def delete(hand: Hand) -> None:
    await open_library(hand)
    await hand.press("x", "u")


async def chosen(hand: Hand) -> None:
    await hand.press("c")


async def open_help(hand: Hand) -> None:
    await hand.press("h")


async def leave(hand: Hand) -> None:
    await teach(hand)
    await hand.press("q")


async def open_advice(hand: Hand) -> None:
    await try_it(hand)
    await hand.press("C")


async def run_check(hand: Hand) -> None:
    await teach(hand)
    await hand.press("K")


async def stay(hand: Hand) -> None:
    """Look at the first screen."""


SCREENS: list[tuple[Callable[[Hand], Awaitable[None]], LessonChoices, str]] = [
    # what was done, with which choices, and what the screen then shows
    (stay, GOTO, "▶  start"),
    (stay, LessonChoices(), "[ ] turn left"),
    (teach, GOTO, "turn left → forward"),
    (explain, GOTO, "it went from turn left to forward"),
    (correct, GOTO, "correction: forward → turn right"),
    (undone, GOTO, "Undone: turn left → forward"),
    (driven, GOTO, "turn left"),
    (open_library, GOTO, "distance to A"),
    (delete, GOTO, "What fetch it learned"),
    (chosen, GOTO, "[x] turn left"),
    (open_help, GOTO, "The lesson"),
    (leave, GOTO, "fetch it has unsaved changes"),
    (open_advice, GOTO, "A"),
    (run_check, GOTO, "What a check finds"),
]


def read(hand: Hand) -> str:
    """The text of the whole screen."""
    screen = hand.app.screen
    return "\n".join(strip.text for strip in screen._compositor.render_strips())


@pytest.mark.parametrize(("act", "choices", "said"), SCREENS, ids=lambda each: getattr(each, "__name__", ""))
def test_no_screen_shows_names_of_the_code(
    act: Callable[[Hand], Awaitable[None]], choices: LessonChoices, said: str, tmp_path: Path
) -> None:
    async def look() -> str:
        made = make_plan(tmp_path, "fetch_it", replace(choices, targets=TARGET), seed=3)
        async with make_trainer(made, size=(140, 48)) as hand:
            await act(hand)
            await hand.pilot.pause()
            return read(hand)

    shown = asyncio.run(look())
    assert said in shown
    assert IDENTIFIER.findall(shown) == []


def test_an_interrupted_session_is_offered_in_plain_names(tmp_path: Path) -> None:
    async def look() -> str:
        async with make_trainer(make_plan(tmp_path, "fetch_it")) as hand:
            await teach(hand)
            (journal,) = (tmp_path / ".journals").iterdir()
            killed = journal.read_bytes()
        journal.write_bytes(killed)
        async with make_trainer(make_plan(tmp_path, "fetch_it"), offer=True) as hand:
            return read(hand)

    shown = asyncio.run(look())
    assert "A session of fetch it was interrupted" in shown
    assert IDENTIFIER.findall(shown) == []


MORE = [  # what is written in the line for more states, and the state that it makes
    ("back=turn left", ("back", "rotate_left")),
    ("turn back=rotate_left", ("turn_back", "rotate_left")),
]


@pytest.mark.parametrize(("written", "made"), MORE)
def test_names_may_be_written_as_they_are_read(written: str, made: tuple[str, str], tmp_path: Path) -> None:
    async def choose() -> list[tuple[str, str | None]]:
        async with make_trainer(make_plan(tmp_path, "fetch_it", replace(GOTO, targets=TARGET))) as hand:
            await hand.press("c", *["tab"] * 3)
            await hand.press(*("space" if each == " " else "=" if each == "=" else each for each in written))
            await hand.press("ctrl+g")
            return [(state.name, state.behavior) for state in hand.trainer.session.automaton.states]

    states = asyncio.run(choose())
    assert made in states
    assert ("rotate_right", "rotate_right") in states
