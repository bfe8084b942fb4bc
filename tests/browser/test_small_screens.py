"""Nothing of the page is off screen, or covered, on phones and tablets."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

SIZES = {"phone upright": (390, 844), "phone lying": (844, 390), "tablet": (800, 1100)}


def width_of_content(page: Page) -> int:
    width: int = page.evaluate("document.documentElement.scrollWidth")
    return width


@pytest.mark.parametrize("size", SIZES)
def test_all_of_the_page_is_on_the_screen(visit: Callable[[], Page], size: str) -> None:
    page = visit()
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    assert width_of_content(page) <= width
    button = page.get_by_role("button", name="Teach something new", exact=True)
    expect(button).to_be_visible()
    button.click(timeout=5000)  # nothing covers it
    expect(page.get_by_role("textbox", name="Name")).to_be_visible()
    assert width_of_content(page) <= width


def test_the_world_takes_most_of_an_upright_tablet(visit: Callable[[], Page]) -> None:
    page = visit()
    page.set_viewport_size({"width": 800, "height": 1100})
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    assert box["height"] > 1100 / 2


@pytest.mark.parametrize("size", SIZES)
def test_the_welcome_card_and_its_message_are_both_seen(visit: Callable[[], Page], size: str) -> None:
    page = visit()
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    card, message = page.locator(".welcome").bounding_box(), page.locator(".toast").bounding_box()
    assert card is not None
    assert message is not None
    assert card["y"] + card["height"] <= message["y"]
