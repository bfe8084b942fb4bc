"""From an empty library to a robot that forages, with real clicks and keys at the page alone."""

from __future__ import annotations

from collections.abc import Callable
from sys import stderr

import pytest
from playwright.sync_api import Page
from tests.browser.curriculum import teach_deposit, teach_forage, teach_goto, teach_harvest
from tests.browser.foraging import Forager
from tests.browser.static_studio import both_places
from tests.browser.studio import Studio

from understudy_lab.tasks.forage_teacher import CAPACITY

pytestmark = both_places
UNSEEN = (2_000, 2_001)
"""Worlds that nobody taught or tried the robot in, with 15 and 49 units of food."""
LIMIT_S = 1_000
"""In the world's time."""
MOST_ACTIONS = 600
"""How often a person presses or clicks until it forages."""


@pytest.fixture
def moves_clock() -> bool:
    """Time passes while the person looks: as fast as the page shows it."""
    return True


def test_a_robot_learns_to_forage(visit: Callable[..., Page], studio: Studio) -> None:
    """It brings all food home, on more ways than one, in worlds it has not seen, and nobody presses anything."""

    def say(what: str) -> None:
        stderr.write(f"{person.actions:4} actions  {what}\n")

    person = Forager(visit(fine=True, prompt=True), studio.clock, said=say)
    for teach in (teach_goto, teach_harvest, teach_deposit, teach_forage):
        teach(person)
        say(teach.__name__)
    for seed in UNSEEN:
        person.world(seed)
        assert person.food[1] > CAPACITY
        person.let_alone(limit_s=LIMIT_S)
        say(f"{person.food[0]} units at home")
    assert person.actions < MOST_ACTIONS
    assert studio.list_automata(person.page) == {"goto", "harvest", "deposit", "forage"}
