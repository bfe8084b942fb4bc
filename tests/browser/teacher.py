"""A teacher at the page: looks at what is shown there, and presses keys, as a person does."""

from __future__ import annotations

import re
from time import monotonic

from playwright.sync_api import Page, expect

KEYS = {"forward": "ArrowUp", "rotate_left": "ArrowLeft", "rotate_right": "ArrowRight", "done": "4"}
DISTANCE = re.compile(r"distance_to\(A\)\s*([\d.]+) m")
ANGLE = re.compile(r"angle_to\(A\)\s*(−?\d+)°")
NEAR_M, AHEAD_DEG = 0.35, 9.0


class Teacher:
    """One page, and what is pressed there."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def begin_goto(self) -> None:
        """Begin the automaton that the page proposes where nothing was taught: goto, with A for the station."""
        self.page.get_by_role("button", name="New automaton", exact=True).click()
        self.page.get_by_role("button", name="Begin").click()
        expect(self.directing("forward")).to_be_visible()
        expect(self.page.get_by_role("complementary")).to_contain_text(DISTANCE)

    def directing(self, state: str):  # type: ignore[no-untyped-def]  # a Locator
        """The button that directs to a state."""
        return self.page.get_by_role("toolbar", name="Direct the robot").get_by_role(
            "button", name=state, exact=True
        )

    @property
    def state(self) -> str:
        """The state that is lit."""
        pressed = self.page.get_by_role("toolbar", name="Direct the robot").locator("[aria-pressed=true]")
        return pressed.get_attribute("aria-label") or "" if pressed.count() else ""

    def reading(self) -> tuple[float, float]:
        """Distance (m) and angle (deg) to A, as the page shows them."""
        text = self.page.get_by_role("complementary").inner_text()
        distance, angle = DISTANCE.search(text), ANGLE.search(text)
        assert distance, text
        assert angle, text
        return float(distance[1]), float(angle[1].replace("−", "-"))

    def show_the_way(self, *, seconds: float = 60.0) -> None:
        """Direct the robot to A with keys, until it is done."""
        until = monotonic() + seconds
        now = ""
        while monotonic() < until:
            distance, angle = self.reading()
            wish = "forward"
            if distance < NEAR_M:
                wish = "done"
            elif abs(angle) > (AHEAD_DEG if now == "forward" else AHEAD_DEG / 3):
                wish = "rotate_left" if angle > 0 else "rotate_right"
            if wish != now:
                self.page.keyboard.press(KEYS[wish])
                now = wish
            if now == "done":
                self.page.wait_for_timeout(300)
                return
            self.page.wait_for_timeout(20)
        raise AssertionError(f"not there within {seconds} s")

    def press(self, key: str) -> None:
        """Press a key."""
        self.page.keyboard.press(key)

    def new_world(self) -> None:
        """Another world."""
        self.page.get_by_role("button", name="New world").click()
        self.page.wait_for_timeout(200)

    @property
    def examples(self) -> int:
        """How many examples the lesson has, as its tab says."""
        text = self.page.get_by_role("tab", name=re.compile("Lesson")).inner_text()
        found = re.search(r"\d+", text)
        return int(found[0]) if found else 0
