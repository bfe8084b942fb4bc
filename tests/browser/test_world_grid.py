"""A hundred worlds at once: what is trained runs in all, a red one leads to its mistake, and a press corrects it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect
from tests.browser.foraging import GOTO, Forager
from tests.browser.studio import Studio


def test_a_red_world_leads_to_its_mistake(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    page = visit(prompt=True)
    person = Forager(page, studio.clock)
    person.begin(GOTO)
    person.direct("forward")
    page.get_by_role("button", name="Show 100 worlds").click()
    worlds = page.get_by_role("region", name="A hundred worlds")
    expect(worlds).to_contain_text("works in 0 of 100 worlds in which it was not taught", timeout=30_000)
    red = worlds.get_by_role("button", name="where it goes wrong")
    expect(red).to_have_count(100)
    snap(page, "a hundred worlds")
    red.nth(41).click()
    expect(worlds).to_have_count(0)
    expect(page.get_by_label("seed")).to_have_value("300000041")
    expect(page.get_by_role("button", name="Resume", exact=True)).to_be_visible()
    expect(page.get_by_text("Press what it should do, and resume")).to_be_visible()
    snap(page, "where it goes wrong")
    page.locator('[data-state="rotate_left"]').first.click()  # before it resumes, as the message says
    page.get_by_role("button", name="Show 100 worlds").first.click()
    expect(worlds).to_contain_text("of which 1 was shown here", timeout=30_000)
    worlds.get_by_role("button", name="Close the worlds").click()
    expect(worlds).to_have_count(0)


@pytest.mark.parametrize("size", [(390, 844), (844, 390), (1366, 768)])
def test_the_worlds_fit_every_screen(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None], size: tuple[int, int]
) -> None:
    page = visit(prompt=True)
    person = Forager(page, studio.clock)
    person.begin(GOTO)
    person.direct("forward")
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.locator(".show-grid").first.click()
    worlds = page.get_by_role("region", name="A hundred worlds")
    red = worlds.get_by_role("button", name="where it goes wrong")
    expect(red).to_have_count(100, timeout=30_000)
    snap(page, f"a hundred worlds at {size[0]}")
    field = worlds.locator(".grid-field").bounding_box()
    assert field is not None
    for index in (0, 99):
        box = red.nth(index).bounding_box()
        assert box is not None
        assert field["x"] - 1 <= box["x"]
        assert box["x"] + box["width"] <= field["x"] + field["width"] + 1
        assert box["y"] + box["height"] <= min(field["y"] + field["height"], size[1]) + 1
