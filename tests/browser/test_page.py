"""Whole lessons at the page, with real clicks and keys in a real browser."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

Visit = Callable[[], Page]
Snap = Callable[[Page, str], None]

PAINTED_LATE = """
const later = window.setTimeout;
window.requestAnimationFrame = (draw) => later(() => draw(performance.now()), 800);
window.setTimeout = (call, ms, ...given) => later(call, (ms ?? 0) + 800, ...given);
"""


def test_a_correction_and_back(teacher: Teacher) -> None:
    """A press in testing is a correction, and undo takes back what it showed."""
    teacher.press("ArrowLeft")
    teacher.wait_until(lambda: teacher.examples == 2)
    teacher.press("t")
    expect(
        teacher.page.get_by_role("group", name="Mode").get_by_role("button", name="Try")
    ).to_have_attribute("aria-pressed", "true")
    before = teacher.examples
    teacher.press("ArrowUp")
    expect(
        teacher.page.get_by_role("group", name="Mode").get_by_role("button", name="Teach")
    ).to_have_attribute("aria-pressed", "true")
    teacher.page.get_by_role("tab", name=re.compile("Lesson")).click()
    expect(teacher.page.get_by_role("row", name=re.compile("correction"))).not_to_have_count(0)
    assert teacher.examples > before
    teacher.press("Control+z")
    expect(teacher.page.get_by_role("row", name=re.compile("correction"))).to_have_count(0)
    assert teacher.examples == before


def test_examples_that_contradict_each_other_are_marked(teacher: Teacher, snap: Snap) -> None:
    """At the same place once to the left and once to the right: one of them was a slip."""
    teacher.press("Space")
    for key in ("ArrowLeft", "ArrowRight"):
        teacher.press(key)
        teacher.press(".")
        expect(teacher.state_button("start")).to_have_attribute("aria-pressed", "false")
        teacher.click("Reset")
        expect(teacher.state_button("start")).to_have_attribute("aria-pressed", "true")
    teacher.page.get_by_role("tab", name=re.compile("Lesson")).click()
    expect(teacher.page.get_by_text("2 contradict each other")).to_be_visible()
    snap(teacher.page, "contradictions")


def test_an_example_is_edited(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    teacher.press("Space")
    teacher.press("ArrowLeft")
    teacher.click("Step")
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    teacher.click("Example 1")
    page.get_by_role("combobox", name="in", exact=True).select_option("forward")
    row = page.get_by_role("row", name=re.compile("^Example 1 "))
    expect(row).to_contain_text("forward")
    page.get_by_role("combobox", name="go to").select_option("done")
    expect(row).to_contain_text("done")
    teacher.click("values")
    field = page.get_by_role("textbox", name="angle to A")
    field.fill("left")
    field.press("Enter")
    expect(page.get_by_text("'left' is not a number")).to_be_visible()
    field.fill("-20")
    field.press("Enter")
    expect(row).to_contain_text("−20°")
    snap(page, "edited")


def test_a_page_loaded_anew_shows_the_same(teacher: Teacher) -> None:
    """Also one that is painted late: what the server tells at once may come before anything is painted."""
    teacher.press("ArrowLeft")
    teacher.wait_until(lambda: teacher.examples == 2)
    teacher.page.reload()
    expect(teacher.state_button("rotate_left")).to_be_visible()
    assert teacher.examples == 2
    expect(teacher.state_button("forward")).to_be_enabled()
    teacher.press_until_shown("ArrowUp")
    teacher.page.add_init_script(PAINTED_LATE)
    teacher.page.reload()
    expect(teacher.state_button("rotate_left")).to_be_visible()
    expect(teacher.page.get_by_role("banner")).to_contain_text("goto (A)")
    expect(teacher.page.get_by_role("complementary")).to_contain_text("goto")


def test_a_seed_is_typed_while_the_robot_goes_on(teacher: Teacher) -> None:
    """News from the server leave what is typed as it is."""
    teacher.page.get_by_role("combobox", name="Speed").select_option("0.25")
    seed = teacher.page.get_by_label("seed")
    teacher.press("ArrowLeft")
    seed.fill("4")
    expect(teacher.state_button("rotate_left")).to_have_attribute("aria-pressed", "true")
    expect(seed).to_have_value("4")
    seed.press_sequentially("2")
    seed.press("Enter")
    expect(teacher.page.get_by_text("World 42, from the start")).to_be_visible()
    expect(seed).to_have_value("42")


def test_who_looks_on_cannot_direct_until_the_other_is_gone(
    teacher: Teacher, visit: Visit, snap: Snap
) -> None:
    other = Teacher(visit())
    expect(other.state_button("forward")).to_be_disabled()
    teacher.press("ArrowUp")
    expect(other.state_button("forward")).to_have_attribute("aria-pressed", "true")
    snap(other.page, "looking-on")
    teacher.page.close()
    other.page.get_by_role("button", name=re.compile("Take|Direct")).first.click()
    expect(other.state_button("rotate_left")).to_be_enabled()
    other.press("Space")
    other.press("ArrowLeft")
    expect(other.state_button("rotate_left")).to_have_attribute("aria-pressed", "true")


def test_a_server_that_is_killed_loses_nothing(teacher: Teacher, studio: Studio, snap: Snap) -> None:
    for key in ("ArrowLeft", "ArrowUp", "ArrowRight"):
        teacher.press_until_shown(key)
    before = teacher.examples
    studio.kill()
    expect(teacher.page.get_by_text(re.compile("[Cc]onnection|lost|gone"))).not_to_have_count(0)
    snap(teacher.page, "connection-lost")
    studio.start()
    teacher.page.get_by_role("button", name="Resume goto").first.click()
    expect(teacher.state_button("forward")).to_be_visible()
    teacher.wait_until(lambda: teacher.examples == before)


def test_back_on_the_timeline(teacher: Teacher) -> None:
    """The robot is back where it was, the lesson stays, and it goes on from there."""
    teacher.press("ArrowUp")
    expect(teacher.state_button("forward")).to_have_attribute("aria-pressed", "true")
    teacher.let_pass(3.0)  # so that it drives at all moments gone back to
    teacher.pause()
    far, before = teacher.read_aim(), teacher.examples
    line = teacher.page.get_by_role("slider", name="Rewind")
    line.focus()
    for _ in range(3):
        line.press("ArrowLeft")
        expect(teacher.page.get_by_text(re.compile(r"^Back at "))).to_be_visible()
    teacher.wait_for_change(far)
    near = teacher.read_aim()
    assert teacher.examples == before
    teacher.page.get_by_role("button", name=re.compile("Resume")).click()
    teacher.wait_for_change(near)
