"""A person who teaches foraging at the page: looks at what is shown there, and presses, as the scripted teacher does.

What they wish and what they complain of is the scripted teacher's; what they see is what the page writes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from math import inf
from time import monotonic

from playwright.sync_api import Page, expect
from tests.browser.glance import glance
from tests.browser.hand import drag_robot, turn_robot
from tests.browser.shared_clock import SharedClock
from tests.browser.teacher import Teacher

from understudy.model.plain_names import format_names as plain
from understudy.training.trainee import SessionView
from understudy_lab.tasks import forage_teacher
from understudy_lab.teachers.person import Seen, TryResult, Wish
from understudy_lab.teachers.teacher import LessonPlan

FOOD = re.compile(r"(\d+) at home, (\d+) carried, (\d+) left")
ARROWS = {"forward": "ArrowUp", "rotate_left": "ArrowLeft", "rotate_right": "ArrowRight"}

REACTION_S = 0.12
"""How long they still think about a press; that they see and press late comes by itself."""
FIRST_FRESH = 100
"""Robots are tried in worlds from here on, and shown things in those before."""
LOOK_S = 0.05
"""How much time passes between two looks."""
PATIENCE_S, MOST_HELP = 30.0, 8
ASIDE_PX, AWAY = 120, 0.95
GOES_TO = {"harvest": "nearest_food", "deposit": "station"}


@dataclass(frozen=True, slots=True)
class About:
    """What a person chooses in the form, and how fast time goes while they show it and while it tries."""

    topic: LessonPlan
    states: Sequence[str]
    features: Sequence[str]
    shows: int
    tries: int
    drives: int = 1
    """How fast while it is on its way, where there is nothing to press."""
    flags: bool = True


GOTO = About(forage_teacher.GOTO, (), (), shows=1, tries=4)
HARVEST = About(
    forage_teacher.HARVEST,
    ["goto(nearest_food)", "load_food"],
    ["done", "food_left", "food_stored", "food_below_me"],
    shows=2,
    tries=8,
    drives=8,
)
DEPOSIT = About(
    forage_teacher.DEPOSIT,
    ["goto(station)", "unload_food"],
    ["done", "food_stored", "at_station"],
    shows=2,
    tries=8,
    drives=8,
)
FORAGE = About(
    forage_teacher.FORAGE,
    ["harvest", "deposit"],
    ["done", "food_stored", "food_left"],
    shows=16,
    tries=16,
    flags=False,
)


class Forager(Teacher):
    """One page, and a person who teaches there."""

    def __init__(
        self, page: Page, clock: SharedClock | None = None, *, said: Callable[[str], None] = lambda what: None
    ) -> None:
        super().__init__(page, clock)
        self._fresh, self._said = count(FIRST_FRESH), said
        self.corrections, self._helped = 0, 0

    # What they see

    def screen(self) -> SessionView:
        """What the page shows now."""
        return glance(self.page)

    @property
    def food(self) -> tuple[int, int]:
        """How much food is at home, and how much there is, as the page says."""
        found = FOOD.search(self.page.get_by_role("complementary").inner_text())
        assert found is not None
        home, carried, left = (int(each) for each in found.groups())
        return home, home + carried + left

    # What they do

    def direct(self, state: str) -> None:
        """Direct the robot, with the key where it is an arrow; until it does that."""
        if state in ARROWS:
            self.press(ARROWS[state])
        else:
            self.actions += 1
            self.state_button(state).click()
        while self.clock is not None and self.state_button(state).get_attribute("aria-pressed") != "true":
            self.let_pass(LOOK_S)
        expect(self.state_button(state)).to_have_attribute("aria-pressed", "true")

    def begin(self, about: About) -> None:
        """Begin an automaton, chosen in the form; silence is consent."""
        self.fill(about)
        self.begin_as_in_the_paper()
        self._begin(about.topic.name)

    def fill(self, about: About) -> None:
        """Fill in the form for an automaton; for the first one it proposes all but the options."""
        form = self.page.locator("form.choice")
        if about is GOTO:
            self.click("Teach something new")
        else:
            self.click("+ Teach something new")
            form.get_by_role("textbox", name="Name", exact=True).fill(about.topic.name)
            if not about.flags:
                form.get_by_label("Flags").fill("")
        form.get_by_label("Reaction time").fill("0.2" if about is GOTO else "0")
        for label in (*about.states, *about.features):
            self.actions += 1
            form.get_by_role("checkbox", name=plain(label), exact=True).check()
        self.actions += 1
        form.get_by_role("checkbox", name="Learn from silence").check()

    def _begin(self, name: str) -> None:
        """It is trained now; what the robot did since the last was saved is saved first, where that is asked."""
        trained = self.page.get_by_role("banner").locator(".what").filter(has_text=name)
        asks = self.page.get_by_role("button", name=re.compile("^Save, then"))
        expect(trained.or_(asks).first).to_be_visible()
        if asks.is_visible():
            self.actions += 1
            asks.click()
        expect(trained).to_be_visible()
        expect(self.page.locator("form.choice")).to_have_count(0)

    def open(self, name: str) -> None:
        """Train one of the library on."""
        self.actions += 1
        self.page.get_by_role("tab", name="Library").click()
        self.click(f"Open {name}")
        self._begin(name)

    def save(self) -> None:
        """Keep it in the library, where it is not there as it is now."""
        save = self.page.get_by_role("button", name="Save", exact=True)
        if save.is_enabled():
            self.click("Save")
        anyway = self.page.get_by_role("button", name="Save anyway")
        expect(
            anyway.or_(self.page.get_by_role("button", name="Save", exact=True, disabled=True))
        ).to_be_visible()
        if anyway.is_visible():  # it says what changed beside what was pressed
            anyway.click()
        expect(save).to_be_disabled()

    def world(self, seed: int, target: str | None = None) -> None:
        """The world of a number, and what A stands for in it."""
        self.actions += 1
        field = self.page.get_by_label("seed")
        field.fill(str(seed))
        field.press("Enter")
        expect(field).not_to_be_focused()
        expect(field).to_have_value(str(seed))
        if target is not None:
            self.stand_for(target)
        self.let_pass(LOOK_S)

    def stand_for(self, target: str) -> None:
        """Let A stand for something."""
        choice = self.page.get_by_label("What A stands for")
        if choice.input_value() != target:
            self.actions += 1
            choice.select_option(target)
            expect(choice).to_have_value(target)
            self.let_pass(LOOK_S)

    def go(self, times: int) -> None:
        """Choose how fast time goes."""
        if times != self.speed:
            self.speed = times
            choice = self.page.get_by_role("combobox", name="Speed")
            self.actions += 1
            choice.select_option(str(times))
            expect(choice).to_have_value(str(times))

    def afresh(self) -> None:
        """The automaton from its start state, the robot where it is."""
        self.click("Restart automaton")
        expect(self.state_button("start")).to_have_attribute("aria-pressed", "true")
        self.let_pass(LOOK_S)

    def test(self) -> None:
        """Let it decide by itself."""
        testing = self.page.get_by_role("group", name="Mode").get_by_role("button", name="Try")
        if testing.get_attribute("aria-pressed") != "true":
            self.press("t")
        expect(testing).to_have_attribute("aria-pressed", "true")

    # Watching

    def show(self, about: About, *, until: Seen | None = None) -> None:
        """Direct the robot to whatever they wish."""
        topic = about.topic

        def wish(view: SessionView) -> str | None:
            self.go(about.drives if view.state == "goto" else about.shows)
            return topic.show(view)

        until = until or topic.finished
        while self.watch(wish, until=until, limit_s=topic.limit_s, patience_s=PATIENCE_S) is TryResult.LOST:
            self.correct_below(about)

    def try_out(self, about: About) -> TryResult:
        """Let it show what it learned, and correct the first thing that looks wrong."""
        topic = about.topic
        self.go(about.tries)
        self.test()
        return self.watch(
            topic.complain, until=topic.finished, limit_s=topic.limit_s, patience_s=PATIENCE_S, corrects=True
        )

    def correct(self, wish: Wish) -> bool:
        """Let time stand still, press what is right if it still is, and let it try on; whether it was.

        So nothing is recorded that they only did not prevent in time.
        """
        with self.hold_time():
            view = self.screen()
            wished = wish(view)
            wrong = wished is not None and wished != view.state
            if wished is not None and wrong:
                self.state_button(wished).click()
                self.press(".")
                expect(self.state_button(wished)).to_have_attribute("aria-pressed", "true")
                self.actions += 1
                self.test()
        return wrong

    def watch(
        self, wish: Wish, *, until: Seen, limit_s: float, patience_s: float = inf, corrects: bool = False
    ) -> TryResult:
        """Press what they wish where it is not so, until they have seen enough or lost patience."""
        path: tuple[str, ...] = ()
        began = changed = self.screen().time_s
        hand: tuple[str, float] | None = None
        while (view := self.screen()).time_s - began < limit_s:
            wished = wish(view)
            if wished is None or wished == view.state:
                hand = None
                if view.waiting is None and until(view):
                    return TryResult.ENOUGH
            elif hand is None or hand[0] != wished:
                hand = wished, self._now_s + REACTION_S
            elif self._now_s >= hand[1]:
                hand = None
                if not corrects:
                    self.direct(wished)
                elif self.correct(wish):
                    return TryResult.CORRECTED
            if view.path != path:
                path, changed = view.path, view.time_s
            if view.time_s - changed > patience_s:
                return TryResult.LOST
            self.look_again()
        return TryResult.LOST

    @property
    def _now_s(self) -> float:
        """The person's time, s."""
        return monotonic() if self.clock is None else self.clock.read()

    def look_again(self) -> None:
        """Let a little time pass until the next look."""
        if self.clock is None:
            self.page.wait_for_timeout(20)
        else:
            self.let_pass(max(LOOK_S, 0.1 / self.speed))

    def let_alone(self, *, limit_s: float) -> None:
        """Hands off, as fast as it goes, until all food is home."""
        self.go(16)
        self.test()
        actions = self.actions
        while (food := self.food)[0] < food[1]:
            assert self.screen().time_s < limit_s, f"{food[0]} of {food[1]} at home: {self.screen()}"
            self.let_pass(0.2)
        assert self.actions == actions

    # Teaching

    def teach(self, about: About, *, passes: int, most: int = 30) -> None:
        """Let it try in fresh worlds, and correct it, until so many tries in a row needed no correction."""
        passed = tried = 0
        fresh = True
        while passed < passes:
            tried += 1
            assert tried <= most, f"{about.topic.name} did not come right in {most} tries"
            if fresh:
                self.world(
                    next(self._fresh), ("station", "nearest_food")[tried % 2] if about is GOTO else None
                )
            verdict = self.try_out(about)
            self._said(f"{about.topic.name}: try {tried} {verdict.name.lower()}")
            passed = passed + 1 if verdict is TryResult.ENOUGH else 0
            fresh = verdict is not TryResult.CORRECTED
            if verdict is TryResult.LOST:
                self.help(about)
            self.corrections += verdict is not TryResult.ENOUGH

    def help(self, about: About) -> None:
        """Where it lost its way: correct what is below, or show it from there."""
        if innermost(self.screen().path, about) is not about:
            self.correct_below(about)
        else:
            self.press("t")
            self.show(about)

    def correct_below(self, about: About) -> None:
        """Open what lost its way, and correct it there; where goto needs nothing there, show a way once more."""
        path = self.screen().path
        below = innermost(path, about)
        self._helped += 1
        assert below is not about, f"{about.topic.name} lost its way: {self.screen()}"
        assert self._helped <= MOST_HELP, f"{about.topic.name} lost its way again: {self.screen()}"
        self.save()
        self.open(below.topic.name)
        if below is GOTO:
            above = path[path.index("goto") - 1] if path.index("goto") else about.topic.name
            self.stand_for(GOES_TO[above])
        corrections = self.corrections
        while (verdict := self.try_out(below)) is TryResult.CORRECTED:
            self.corrections += 1
        self._said(
            f"{below.topic.name}, in {'/'.join(path)}: {verdict.name.lower()}, "
            f"{self.corrections - corrections} corrections"
        )
        if verdict is TryResult.LOST:
            self.help(below)
        elif (
            below is GOTO and self.corrections == corrections and about is not DEPOSIT
        ):  # which needs its load
            self.way(self._helped % len(WAYS))
        self.save()
        self.open(about.topic.name)

    @contextmanager
    def hold_time(self) -> Iterator[None]:
        """Let time stand still meanwhile."""
        self.press("Space")
        expect(self.page.get_by_role("button", name="Resume")).to_be_visible()
        yield
        self.press("Space")
        expect(self.page.get_by_role("button", name="Pause", exact=True)).to_be_visible()

    def move_aside(self) -> None:
        """Put the robot elsewhere."""
        with self.hold_time():
            drag_robot(self.page, ASIDE_PX, 0)
            self.actions += 1

    def turn_away(self, side: int) -> None:
        """Turn the robot so that A is on its left (1) or right (-1)."""
        with self.hold_time():
            heading = 0.0
            for _ in range(2):  # the first shows where A is
                before = self.screen().features["angle_to(A)"]
                turn_robot(self.page, heading)
                self.actions += 1
                self.wait_until(lambda: self.screen().features["angle_to(A)"] != before)  # noqa: B023
                heading += self.screen().features["angle_to(A)"] - side * AWAY

    def way(self, number: int) -> None:
        """Show goto one of its ways; once it is on a long one, that it has to go back to it."""
        seed, target, away = WAYS[number]
        self.world(seed, target)
        if away:
            self.show(GOTO, until=on_its_way)
            self.turn_away(away)
        self.show(GOTO)


def innermost(path: Sequence[str], about: About) -> About:
    """The innermost automaton that runs, of those that were taught before."""
    known = {each.topic.name: each for each in (GOTO, HARVEST, DEPOSIT)}
    return next((known[name] for name in reversed(path) if name in known), about)


def on_its_way(view: SessionView) -> bool:
    """It has turned to A and drives there."""
    return view.state == "forward" and view.waiting is None


WAYS = ((1, "station", 0), (13, "nearest_food", 0), (47, "station", -1), (32, "nearest_food", 1))
"""Worlds to show the way in, where to, and to which side A is when turned away from it: near on the left and on the
right, far on the right and on the left.
"""
