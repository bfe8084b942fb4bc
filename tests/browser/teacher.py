"""A teacher at the page: looks at what is shown there, and presses keys, as a person does."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Locator, Page, expect
from tests.browser.shared_clock import SharedClock
from tests.browser.window import wait_until

KEYS = {"forward": "ArrowUp", "rotate_left": "ArrowLeft", "rotate_right": "ArrowRight", "done": "4"}
DISTANCE = re.compile(r"distance to A\s*([\d.]+) m")
ANGLE = re.compile(r"angle to A\s*(−?\d+)°")


STEP_S = 0.1
"""How far a clock is moved at once, s; a world does not make up for more than a quarter of a second."""
SHOWN_S = 0.15
"""How far what is shown may lag behind a clock: by a tick, and by what it is rounded."""
PASSES = """([from, until]) => new Promise((resolve) => {
  const look = () => {
    const [minutes, seconds] = document.querySelector(".time").textContent.split(":");
    const shown = 60 * minutes + Number(seconds);
    return shown >= until || shown < from || document.querySelector(".pause").ariaLabel !== "Pause";
  };
  if (look()) return resolve(true);
  const end = (passed) => {
    watch.disconnect();
    resolve(passed);
  };
  const watch = new MutationObserver(() => look() && end(true));
  watch.observe(document.body, { subtree: true, childList: true, characterData: true, attributes: true });
  setTimeout(() => end(look()), 1000);
})"""
"""Waits until it is so late in the world, or in another one, or it is paused; false if nothing is so for a second."""
MOST_WAITS = 60


class Teacher:
    """One page, and what is pressed there."""

    def __init__(self, page: Page, clock: SharedClock | None = None) -> None:
        """`clock` is that of the studio, if the test moves it: then time passes while it waits for that only."""
        self.page, self.clock, self.speed = page, clock, 1.0
        self.actions = 0
        """How often something was pressed or clicked."""

    def begin_goto(self) -> None:
        """Begin the automaton that the page proposes where nothing was taught: goto, with A for the station."""
        self.click("Teach something new")
        self.begin_as_in_the_paper()
        expect(self.state_button("forward")).to_be_visible()
        expect(self.page.get_by_role("complementary")).to_contain_text(DISTANCE)

    def begin_as_in_the_paper(self) -> None:
        """Begin what the form says, with the paper's training: the robot does what it was told last."""
        self.page.get_by_label("Training as in the paper").check()
        self.click("Begin")

    def mode(self, name: str) -> Locator:
        """The button of a mode: Teach or Try."""
        return self.page.get_by_role("group", name="Mode").get_by_role("button", name=name)

    def state_button(self, state: str):  # type: ignore[no-untyped-def]  # a Locator
        """The button that directs to a state."""
        return self.page.get_by_role("toolbar", name="Direct the robot").locator(f'[data-state="{state}"]')

    @property
    def state(self) -> str:
        """The state that is lit."""
        pressed = self.page.get_by_role("toolbar", name="Direct the robot").locator("[aria-pressed=true]")
        states: list[str] = pressed.evaluate_all("all => all.map(one => one.dataset.state)")
        return states[0] if states else ""

    def read_aim(self) -> tuple[float, float]:
        """Distance (m) and angle (deg) to A, as the page shows them."""
        text = self.page.get_by_role("complementary").inner_text()
        distance, angle = DISTANCE.search(text), ANGLE.search(text)
        assert distance, text
        assert angle, text
        return float(distance[1]), float(angle[1].replace("−", "-"))

    def wait_until(self, is_so: Callable[[], object]) -> None:
        """Wait until something is so, as a page on a busy machine shows it late."""
        wait_until(self.page, is_so)

    def let_pass(self, seconds: float) -> None:
        """Wait until so much more time has passed in the world, or it is paused.

        By a clock of the test so much time passes for the person, and accordingly more in a world that goes faster.
        """
        if self.clock is None:
            self._wait_until_later(seconds, 0.0)
            return
        while seconds > 0:
            step = min(seconds, STEP_S)
            self._wait_until_later(step * self.speed - SHOWN_S, step)
            seconds -= step

    def _wait_until_later(self, seconds: float, step: float) -> None:
        """Wait until the page shows a later time; a step of the clock that the world took for a pause is made again."""
        now = self.clock_s
        for _ in range(MOST_WAITS):
            if self.clock is not None:
                self.clock.advance(step)
            if self.page.evaluate(PASSES, [now, now + seconds]):
                return
        raise AssertionError("time does not pass in the world")

    def pause(self) -> None:
        """Let time stand still."""
        self.click("Pause")
        expect(self.page.get_by_role("button", name="Resume", exact=True)).to_be_visible()

    def press_until_shown(self, key: str) -> None:
        """Press a key that adds an example, and wait until the page counts it."""
        before = self.examples
        self.press(key)
        self.wait_until(lambda: self.examples > before)

    def wait_for_change(self, reading: tuple[float, float]) -> None:
        """Wait until the distance or the angle to A differs from a former reading."""
        self.wait_until(lambda: self.read_aim() != reading)

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
        seed = self.page.get_by_label("seed")
        before = seed.input_value()
        self.click("New world")
        expect(seed).not_to_have_value(before)

    @property
    def clock_s(self) -> float:
        """The world's time, s."""
        told = self.page.get_by_title("Time in the world").text_content() or ""
        minutes, seconds = told.split(":")
        return 60 * int(minutes) + float(seconds)

    @property
    def examples(self) -> int:
        """How many examples the lesson has, as its tab says."""
        text = self.page.get_by_role("tab", name=re.compile("Lesson")).inner_text()
        found = re.search(r"\d+", text)
        return int(found[0]) if found else 0
