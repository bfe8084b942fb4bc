"""A teacher at the page: looks at what is shown there, and presses keys, as a person does."""

from __future__ import annotations

import re
from collections.abc import Callable
from time import monotonic

from playwright.sync_api import Locator, Page, expect

KEYS = {"forward": "ArrowUp", "rotate_left": "ArrowLeft", "rotate_right": "ArrowRight", "done": "4"}
DISTANCE = re.compile(r"distance to A\s*([\d.]+) m")
ANGLE = re.compile(r"angle to A\s*(−?\d+)°")
NEAR_M = 0.35


class Teacher:
    """One page, and what is pressed there."""

    def __init__(self, page: Page, *, turns_deg: float = 3.0, drives_deg: float = 9.0) -> None:
        """How far off A may be when it stops turning, and before it stops driving."""
        self.page, self._turns_deg, self._drives_deg = page, turns_deg, drives_deg
        self.actions = 0
        """How often something was pressed or clicked."""

    def begin_goto(self) -> None:
        """Begin the automaton that the page proposes where nothing was taught: goto, with A for the station."""
        self.click("Teach something new")
        self.begin_as_in_the_paper()
        expect(self.directing("forward")).to_be_visible()
        expect(self.page.get_by_role("complementary")).to_contain_text(DISTANCE)

    def begin_as_in_the_paper(self) -> None:
        """Begin what the form says, with the paper's training: the robot does what it was told last."""
        self.page.get_by_label("Training as in the paper").check()
        self.click("Begin")

    def mode(self, name: str) -> Locator:
        """The button of a mode: Teach or Try."""
        return self.page.get_by_role("group", name="Mode").get_by_role("button", name=name)

    def directing(self, state: str):  # type: ignore[no-untyped-def]  # a Locator
        """The button that directs to a state."""
        return self.page.get_by_role("toolbar", name="Direct the robot").locator(f'[data-state="{state}"]')

    @property
    def state(self) -> str:
        """The state that is lit."""
        pressed = self.page.get_by_role("toolbar", name="Direct the robot").locator("[aria-pressed=true]")
        states: list[str] = pressed.evaluate_all("all => all.map(one => one.dataset.state)")
        return states[0] if states else ""

    def reading(self) -> tuple[float, float]:
        """Distance (m) and angle (deg) to A, as the page shows them."""
        text = self.page.get_by_role("complementary").inner_text()
        distance, angle = DISTANCE.search(text), ANGLE.search(text)
        assert distance, text
        assert angle, text
        return float(distance[1]), float(angle[1].replace("−", "-"))

    def wish(self, reading: tuple[float, float], now: str) -> str:
        """What is right at a distance and an angle to A, while it does something."""
        distance, angle = reading
        if distance < NEAR_M:
            return "done"
        if abs(angle) > (self._drives_deg if now == "forward" else self._turns_deg):
            return "rotate_left" if angle > 0 else "rotate_right"
        return "forward"

    def show_the_way(self, *, seconds: float = 60.0) -> None:
        """Direct the robot to A with keys, until it is done."""
        until = monotonic() + seconds
        now = ""
        while monotonic() < until:
            wish = self.wish(self.reading(), now)
            if wish != now:
                self.press(KEYS[wish])
                now = wish
            if now == "done":
                self.page.wait_for_timeout(300)
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(f"not there within {seconds} s")

    def wait_until(self, is_so: Callable[[], bool], *, seconds: float = 10.0) -> None:
        """Wait until something is so, as a page on a busy machine shows it late."""
        until = monotonic() + seconds
        while not is_so():
            assert monotonic() < until, f"not so within {seconds} s"
            self.page.wait_for_timeout(20)

    def press_until_shown(self, key: str) -> None:
        """Press a key that adds an example, and wait until the page counts it."""
        before = self.examples
        self.press(key)
        self.wait_until(lambda: self.examples > before)

    def wait_for_change(self, reading: tuple[float, float]) -> None:
        """Wait until the distance or the angle to A differs from a former reading."""
        self.wait_until(lambda: self.reading() != reading)

    def press(self, key: str) -> None:
        """Press a key."""
        self.actions += 1
        self.page.keyboard.press(key)

    def click(self, name: str) -> None:
        """Click a button."""
        self.actions += 1
        self.page.get_by_role("button", name=name, exact=True).click()

    def new_world(self) -> None:
        """Another world."""
        self.click("New world")
        self.page.wait_for_timeout(200)

    @property
    def clock_s(self) -> float:
        """The world's time, s."""
        minutes, seconds = self.page.get_by_title("Time in the world").inner_text().split(":")
        return 60 * int(minutes) + float(seconds)

    @property
    def examples(self) -> int:
        """How many examples the lesson has, as its tab says."""
        text = self.page.get_by_role("tab", name=re.compile("Lesson")).inner_text()
        found = re.search(r"\d+", text)
        return int(found[0]) if found else 0
