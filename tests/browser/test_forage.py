"""From an empty library to a robot that forages, with real clicks and keys at the page alone."""

from __future__ import annotations

from collections.abc import Callable
from sys import stderr
from time import monotonic

from playwright.sync_api import Page
from tests.browser.foraging import (
    Forager,
    teach_deposit,
    teach_forage,
    teach_goto,
    teach_harvest,
)

UNSEEN = 2_000


def test_a_robot_learns_to_forage(visit: Callable[[], Page]) -> None:
    """In the end it brings food home, more than once, and nobody presses anything."""
    began = monotonic()

    def say(what: str) -> None:
        stderr.write(f"{monotonic() - began:6.1f} s {person.actions:4} actions  {what}\n")

    person = Forager(visit(), said=say)
    for teach in (teach_goto, teach_harvest, teach_deposit, teach_forage):
        teach(person)
        say(f"{teach.__name__}")
    person.world(UNSEEN)
    person.speed(16)
    food = person.left
    person.test()
    actions = person.actions
    while person.home < min(24, food):
        assert monotonic() - began < 400, person.screen()
        person.page.wait_for_timeout(100)
    assert person.actions == actions
    say("home")
