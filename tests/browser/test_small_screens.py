"""On phones and tablets nothing is off screen, covered, too small to be pressed, or too small to be read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.studio import Studio
from tests.browser.window import open_page

SIZES = {"phone upright": (390, 844), "phone lying": (844, 390), "tablet": (800, 1100)}


def width_of_content(page: Page) -> int:
    width: int = page.evaluate("document.documentElement.scrollWidth")
    return width


def test_all_of_the_page_is_on_the_screen(visit: Callable[[], Page]) -> None:
    """The welcome card and its message are both seen, and the world takes most of an upright tablet."""
    page = visit()
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        page.reload()
        button = page.get_by_role("button", name="Teach something new", exact=True)
        expect(button).to_be_visible()
        expect(page.locator(".toast")).to_be_visible()
        assert width_of_content(page) <= width, size
        card, message = page.locator(".welcome").bounding_box(), page.locator(".toast").bounding_box()
        assert card is not None
        assert message is not None
        assert card["y"] + card["height"] <= message["y"], size
        if size == "tablet":
            box = page.locator("canvas").first.bounding_box()
            assert box is not None
            assert box["height"] > height / 2
        button.click()  # nothing covers it
        expect(page.get_by_role("textbox", name="Name")).to_be_visible()
        assert width_of_content(page) <= width, size


LOOK = """() => {
  const shown = (each) => each.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });
  const scrolled = (each) => each.closest(".graph-place, .table-place, .failed") !== null;
  const called = (each) => each.outerHTML.slice(0, 120);
  const small = [], outside = [], tiny = [], keys = [];
  for (const each of document.querySelectorAll("button, select, input, summary, .opener")) {
    if (!shown(each)) continue;
    const label = each.matches("[type=checkbox]") ? each.closest("label") : null;
    const box = (label ?? each).getBoundingClientRect();
    if (box.width < 43.5 || box.height < 43.5) small.push(`${box.width} x ${box.height}: ${called(each)}`);
    if (!scrolled(each) && (box.left < -0.5 || box.right > screen.width + 0.5)) outside.push(called(each));
  }
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const at = texts.currentNode.parentElement;
    if (texts.currentNode.data.trim() === "" || !shown(at) || at.closest("option, .placeholder")) continue;
    const scale = at instanceof SVGGraphicsElement ? at.getScreenCTM().a : 1;
    const size = parseFloat(getComputedStyle(at).fontSize) * scale;
    if (size < 12.99) tiny.push(`${size}: ${called(at)}`);
  }
  for (const each of document.querySelectorAll("kbd, .keys")) if (shown(each)) keys.push(called(each));
  return { small, outside, tiny, keys, wide: document.documentElement.scrollWidth - screen.width };
}"""
"""What is too small to be pressed (44 px) or read (13 px), off the screen to a side, or tells of keys."""
FINE = {"small": [], "outside": [], "tiny": [], "keys": [], "wide": 0}


@pytest.fixture
def touch_page(chromium: Browser, studio: Studio, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The page on a screen that is touched, without a keyboard."""
    width, height = SIZES[request.param]
    screen = {"width": width, "height": height}
    with open_page(chromium, studio.address, viewport=screen, has_touch=True, is_mobile=True) as page:
        page.get_by_role("button", name="Teach something new", exact=True).wait_for()
        yield page


@pytest.mark.parametrize("touch_page", SIZES, indirect=True)
def test_all_can_be_pressed_and_read(touch_page: Page, snap: Callable[[Page, str], None]) -> None:
    """From the first look to a lesson that is saved, on every tab."""
    page = touch_page
    looks = {"welcome": page.evaluate(LOOK)}
    page.get_by_role("button", name="Teach something new", exact=True).tap()
    expect(page.get_by_role("textbox", name="Name")).to_be_in_viewport()
    page.get_by_role("button", name="Names of the states").tap()
    looks["form"] = page.evaluate(LOOK)
    page.get_by_role("button", name="Begin", exact=True).tap()
    expect(page.locator("canvas")).to_be_in_viewport(ratio=0.9)
    for state in ("rotate_left", "forward", "done"):
        button = page.locator(f"[data-state={state}]")
        expect(button).to_be_in_viewport()  # beside the world, without scrolling
        button.tap()
        expect(button).to_have_attribute("aria-pressed", "true")
        expect(button.and_(page.locator(".waiting"))).to_have_count(0)
    page.get_by_role("button", name="Save", exact=True).tap()
    for tab in ("Automaton", "Lesson", "Coach", "Library"):
        page.get_by_role("tab", name=re.compile(tab)).tap()
        expect(page.get_by_role("tab", name=re.compile(tab), selected=True)).to_be_visible()
        if tab == "Automaton":
            page.get_by_role("button", name="why?").tap()
            expect(page.get_by_role("region", name="Why")).to_be_visible()
        if tab == "Lesson":
            page.get_by_role("button", name="Example 1", exact=True).tap()
            page.get_by_role("button", name="values").tap()
        if tab == "Library":
            page.get_by_role("button", name="Export goto", exact=True).tap()
            page.get_by_role("form", name="Export goto").get_by_label("Export as").select_option("ros2")
        looks[tab] = page.evaluate(LOOK)
        snap(page, f"touched-{tab}")
    assert {place: seen for place, seen in looks.items() if seen != FINE} == {}


@pytest.mark.parametrize("touch_page", SIZES, indirect=True)
def test_the_tour_tells_of_no_keys(touch_page: Page) -> None:
    page = touch_page
    page.get_by_role("button", name="Show me how").tap()
    begin = page.get_by_role("button", name="Begin", exact=True)
    expect(begin).to_have_attribute("data-pointed", "")
    expect(begin).to_be_in_viewport(ratio=0.9)  # at the end of a long form, without scrolling
    begin.tap()
    tour = page.get_by_role("region", name="Tour")
    expect(tour).to_contain_text("2 of 6")
    expect(tour).to_be_in_viewport()
    assert page.evaluate(LOOK) == FINE
    expect(tour).not_to_contain_text(re.compile("[↑←→␣]|Space"))
