"""The lessons of foraging at the page, from goto to the whole."""

from __future__ import annotations

from tests.browser.foraging import DEPOSIT, FORAGE, GOTO, HARVEST, WAYS, Forager

from understudy_lab.tasks.forage_teacher import CAPACITY

PLENTY, LAST, TWO_WAYS = 6, 42, 8
"""Worlds with 34, 10 and 13 units of food."""


def teach_goto(person: Forager, *, passes: int = 6) -> None:
    """From both sides, near and far; then let it try."""
    person.begin(GOTO)
    for number in range(len(WAYS)):
        person.way(number)
    person.teach(GOTO, passes=passes)
    person.save()


def teach_harvest(person: Forager, *, passes: int = 3) -> None:
    """Show it, then let it try."""
    person.world(PLENTY)
    person.begin(HARVEST)
    show_harvest(person)
    person.teach(HARVEST, passes=passes)
    person.save()


def show_harvest(person: Forager) -> None:
    """Until it is full, that it is full, and until no food is left."""
    person.show(HARVEST)
    person.afresh()
    person.show(HARVEST)
    person.world(LAST)
    person.show(HARVEST)


def teach_deposit(person: Forager) -> None:
    """With what it has just harvested; and that it goes back where it was put away from the station."""
    person.begin(DEPOSIT)
    person.look_again()
    assert person.screen().features["food_stored"] > 2, person.screen()
    person.show(DEPOSIT, until=lambda view: 0 < view.features["food_stored"] < CAPACITY - 1)
    person.move_aside()
    person.show(DEPOSIT)
    person.save()


def teach_forage(person: Forager) -> None:
    """One round with two ways."""
    person.world(TWO_WAYS)
    person.begin(FORAGE)
    person.show(FORAGE)
    person.teach(FORAGE, passes=1)
    person.save()
