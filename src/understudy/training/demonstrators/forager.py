"""A scripted teacher of foraging: GoTo, Harvest, Deposit and Forage in turn (paper section 4.1).

It shows a case or two, lets the robot try, and presses only where a person would: a good deal later than a program,
and only for what looks wrong. A lesson is finished when so many tries in a row needed no correction; one that will
not come right is thrown away and taught again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import isnan, pi, tau
from pathlib import Path
from typing import TypeAlias

import numpy as np

from understudy.model.lesson import Lesson, Options
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.training.demonstrators.person import Person, Reaction, Seen, Wish
from understudy.training.design import new_lesson
from understudy.training.screen import Screen
from understudy.training.session import Session
from understudy.training.trainee import Mode

MakesBody: TypeAlias = Callable[[str, int], Body]
"""Makes a world, resettable, to practice an automaton in, from its name and a seed."""

NEAR_M = 0.38  # what a person would call being there
TOO_FAR_M = 0.47  # where a person would say it is not there yet
ASTRAY = 0.6  # rad: driving past it, plainly
FACING = 0.12  # rad: as good as facing it, while turning


@dataclass(frozen=True, slots=True)
class Part:
    """One automaton to teach: what to choose for it, how to show it, when to complain, when it is finished."""

    name: str
    choose: Callable[[Library], Lesson]
    show: Wish
    complain: Wish
    finished: Seen
    targets: tuple[Mapping[str, str], ...] = ({},)
    practices: tuple[str, ...] = ()  # where, case by case
    suits: Callable[[Screen, int], bool] = lambda screen, case: True  # the situation wanted for a case
    enough: Callable[[Screen, int], bool] = lambda screen, case: False  # a case need not be shown to its end
    shown: int = 2
    tries: int = 4
    limit_s: float = 60.0
    again: bool = True


@dataclass(slots=True)
class Account:
    """What teaching one automaton took, lessons thrown away included."""

    examples: int = 0
    presses: int = 0
    seconds: float = 0.0
    lessons: int = 0


@dataclass(slots=True)
class Teaching:
    """A taught library, and what it took by automaton."""

    library: Library
    accounts: dict[str, Account] = field(default_factory=dict)


def _bearing(screen: Screen) -> float:
    """Signed bearing of A, left positive, rad."""
    return (screen.features["angle_to(A)"] + pi) % tau - pi


def show_goto(screen: Screen) -> str | None:
    """Turn to A, drive to it, say done."""
    distance, bearing = screen.features["distance_to(A)"], _bearing(screen)
    if screen.state == "done" or isnan(distance):
        return None
    if distance < NEAR_M:
        return "done"
    toward = "rotate_left" if bearing > 0 else "rotate_right"
    if screen.state == "start":
        return "forward" if abs(bearing) < ASTRAY else toward
    if screen.state == "forward":
        return toward if abs(bearing) > ASTRAY else None
    turned = -bearing if screen.state == "rotate_right" else bearing
    return "forward" if turned < FACING else None


def complain_goto(screen: Screen) -> str | None:
    """Only what looks wrong: driving past A, turning away from it, not stopping, stopping too far away."""
    distance, bearing = screen.features["distance_to(A)"], _bearing(screen)
    if isnan(distance):
        return None
    toward = "rotate_left" if bearing > 0 else "rotate_right"
    if screen.state == "done":
        return "forward" if distance > TOO_FAR_M else None
    if screen.state == "start":
        return show_goto(screen)
    if screen.state == "forward":
        if distance < NEAR_M - 0.1:
            return "done"
        return toward if abs(bearing) > 1.5 * ASTRAY else None
    turned = -bearing if screen.state == "rotate_right" else bearing
    return "forward" if -pi / 2 < turned < -ASTRAY else None


LOOK_S = 1.0  # to look at a fresh world and pass it over


SITUATIONS = ((1, 1.2, 2.6), (-1, 1.2, 2.6), (-1, 3.2, 5.5), (1, 3.2, 5.5))
"""Which side A is on (1 left), and how far, m: each side near and far, so that only the side can tell."""


def goto_situation(screen: Screen, case: int) -> bool:
    """A well to the left of the robot or to its right, near or far."""
    if case >= len(SITUATIONS):
        return True
    side, nearest, farthest = SITUATIONS[case]
    distance = screen.features["distance_to(A)"]
    return 0.8 < side * _bearing(screen) < 2.6 and nearest < distance < farthest


def raised(screen: Screen) -> bool:
    """The automaton says it is done."""
    return screen.flag is not None


GOTO = Part(
    "goto",
    lambda library: new_lesson(
        library,
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
    ),
    show_goto,
    complain_goto,
    raised,
    targets=({"A": "station"}, {"A": "nearest_food"}),
    practices=("an arena",),
    suits=goto_situation,
    enough=lambda screen, case: SITUATIONS[case][1] > 3 and screen.features["distance_to(A)"] < 2.6,
    shown=4,
    again=False,
    tries=8,
    limit_s=60.0,
)


def show_harvest(screen: Screen) -> str | None:
    """Go to food, load until full or the source is empty, then on to the next; done when full or none is left."""
    full = screen.features["food_stored"] >= CAPACITY
    none_left = screen.features["food_left"] == 0.0
    if screen.state == "done":
        return None
    if full or none_left:
        return "done"
    if screen.state == "start":
        return "goto"
    if screen.state == "goto":
        return "load_food" if screen.features["done"] == 1.0 else None
    return "goto" if screen.features["food_below_me"] == 0 else None


CAPACITY = 12


def harvested(screen: Screen) -> bool:
    return screen.flag is not None


def complain_harvest(screen: Screen) -> str | None:
    full = screen.features["food_stored"] >= CAPACITY
    none_left = screen.features["food_left"] == 0.0
    if screen.state == "done":
        return None if full or none_left else "goto" if screen.features["food_below_me"] == 0 else "load_food"
    return show_harvest(screen)


HARVEST = Part(
    "harvest",
    lambda library: new_lesson(
        library,
        "harvest",
        states=["goto(nearest_food)", "load_food"],
        flags=["done"],
        features=["done", "food_left", "food_stored", "food_below_me"],
    ),
    show_harvest,
    complain_harvest,
    raised,
    practices=("little food in many places", "the last food"),
    shown=2,
    tries=4,
    limit_s=120.0,
)


def show_deposit(screen: Screen) -> str | None:
    """Go to the station, unload everything; done when nothing is left to unload."""
    if screen.state == "done":
        return None
    if screen.features["food_stored"] == 0:
        return "done"
    if screen.state == "start":
        return "goto"
    if screen.state == "goto":
        return "unload_food" if screen.features["done"] == 1.0 else None
    return "goto" if screen.features["at_station"] == 0.0 else None


DEPOSIT = Part(
    "deposit",
    lambda library: new_lesson(
        library,
        "deposit",
        states=["goto(station)", "unload_food"],
        flags=["done"],
        features=["done", "food_stored", "at_station"],
    ),
    show_deposit,
    show_deposit,
    raised,
    practices=("one unit to deposit", "food to deposit"),
    shown=1,
    tries=3,
    limit_s=120.0,
)


def show_forage(screen: Screen) -> str | None:
    """Harvest and deposit in turn."""
    if screen.state == "start":
        return "harvest"
    if screen.state == "harvest":
        return "deposit" if screen.features["done"] == 1.0 else None
    return "harvest" if screen.features["done"] == 1.0 and screen.features["food_left"] == 1.0 else None


def foraged(screen: Screen) -> bool:
    return screen.features["food_left"] == 0.0 and screen.features["food_stored"] == 0.0


FORAGE = Part(
    "forage",
    lambda library: new_lesson(
        library,
        "forage",
        states=["harvest", "deposit"],
        features=["done", "food_stored", "food_left"],
    ),
    show_forage,
    show_forage,
    foraged,
    practices=("food for two ways",),
    shown=1,
    tries=1,
    again=False,
    limit_s=400.0,
)
PARTS = (GOTO, HARVEST, DEPOSIT, FORAGE)


def teach(
    library: Library,
    make: MakesBody,
    seed: int,
    *,
    options: Mapping[str, Options],
    reaction: Reaction = Reaction(),
    parts: tuple[Part, ...] = PARTS,
) -> Teaching:
    """Teach the parts in turn, each as a state of the next; same seed, same lessons."""
    draws = np.random.default_rng([seed, 1])
    teaching = Teaching(library)
    for part in parts:
        account = teaching.accounts[part.name] = Account()
        lesson = part.choose(teaching.library)
        session = teach_part(part, teaching.library, make, lesson, draws, options[part.name], reaction, account)
        teaching.library = teaching.library.with_taught(session.taught())
    return teaching


def teach_part(
    part: Part,
    library: Library,
    make: MakesBody,
    lesson: Lesson,
    draws: np.random.Generator,
    options: Options,
    reaction: Reaction,
    account: Account,
    *,
    most_lessons: int = 3,
    most_corrections: int = 12,
) -> Session:
    lesson = replace(lesson, options=options)
    for _ in range(most_lessons):
        pupil = _Pupil(part, library, make, lesson, draws, reaction)
        good = pupil.teach(most_corrections)
        account.lessons += 1
        account.presses += pupil.presses
        account.seconds += pupil.seconds
        account.examples = pupil.session.screen().examples
        if good:
            break
    return pupil.session


class _Pupil:
    """One lesson: cases shown, then tries until enough in a row need no correction."""

    def __init__(
        self,
        part: Part,
        library: Library,
        make: MakesBody,
        lesson: Lesson,
        draws: np.random.Generator,
        reaction: Reaction,
    ) -> None:
        self.part, self.library, self.make = part, library, make
        self.draws, self.reaction = draws, reaction
        self.seconds, self.presses = 0.0, 0
        self.lesson = lesson
        self._case = -1

    def next_case(self) -> None:
        self._case += 1
        case, part = self._case, self.part
        practice = part.practices[case % len(part.practices)]
        if case:
            self._account()
            self.lesson = self.session.lesson
        world = self.make(practice, int(self.draws.integers(2**40)))
        targets = part.targets[case % len(part.targets)]
        self.session = Session(world, self.library, self.lesson, targets=targets)
        while not part.suits(self.session.screen(), case):
            self.session.reset(int(self.draws.integers(2**40)))
            self.seconds += LOOK_S
        self.person = Person(self.session, self.draws, self.reaction)

    def _account(self) -> None:
        self.seconds += self.person.seconds
        self.presses += self.person.presses
        self.person.seconds = self.person.presses = 0

    def teach(self, most_corrections: int) -> bool:
        part = self.part
        for _ in range(part.shown):
            self.next_case()
            self.show()
            if part.again:
                self.session.restart()
                self.show()
        passed = corrections = 0
        self.next_case()
        while passed < part.tries and corrections <= most_corrections:
            if self.person.test(part.complain, until=part.finished, limit_s=part.limit_s):
                passed += 1
                self.next_case()
                continue
            passed = 0
            corrections += 1
            if self.session.mode is Mode.TESTING:  # took too long without anything to complain of: try elsewhere
                self.next_case()
        self._account()
        return passed >= part.tries

    def show(self) -> None:
        part, case = self.part, self._case
        self.person.watch(
            part.show,
            until=lambda screen: part.finished(screen) or part.enough(screen, case),
            limit_s=part.limit_s,
        )
