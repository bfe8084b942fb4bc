"""Keys at the page on a keyboard of another country, of which the browser tells what is printed on it."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect
from tests.browser.teacher import Teacher

FRENCH = """
const names = { KeyA: "q", KeyQ: "a", Period: ":", Digit0: "à", Digit1: "&", Digit4: "'" };
const keyboard = { getLayoutMap: () => Promise.resolve(new Map(Object.entries(names))) };
Object.defineProperty(navigator, "keyboard", { value: keyboard });
"""
SEND = """([key, code, shiftKey]) =>
    dispatchEvent(new KeyboardEvent("keydown", { key, code, shiftKey, cancelable: true }))"""


def test_a_french_keyboard(visit: Callable[[], Page]) -> None:
    page = visit()
    page.add_init_script(FRENCH)
    page.reload()
    teacher = Teacher(page)
    teacher.begin_goto()
    teacher.press("Space")
    expect(page.get_by_role("button", name="Step", exact=True)).to_contain_text(":")
    expect(teacher.state_button("done")).to_have_attribute("aria-keyshortcuts", "4")
    page.evaluate(SEND, ["'", "Digit4", False])
    page.evaluate(SEND, [":", "Period", False])
    expect(teacher.state_button("done")).to_have_attribute("aria-pressed", "true")
    page.evaluate(SEND, ["0", "Digit0", True])  # digits are typed with Shift
    page.evaluate(SEND, [":", "Period", False])
    expect(teacher.state_button("start")).to_have_attribute("aria-pressed", "true")
