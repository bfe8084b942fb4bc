"""Driving at the page: the stick is dragged with the mouse, labels appear meanwhile, and an automaton is learned."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.studio import Studio

Snap = Callable[[Page, str], None]


@pytest.fixture
def page(tmp_path: Path, chromium: Browser) -> Iterator[Page]:
    studio = Studio(
        tmp_path / "library", "forage", "--drive", "--seed", "3",
        "--features", "distance_to(nearest_food),angle_to(nearest_food)",
    )  # fmt: skip
    studio.start()
    errors: list[str] = []
    try:
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(studio.address)
        stick(page).wait_for()
        yield page
        assert not errors
    finally:
        studio.stop()


def stick(page: Page) -> Locator:
    return page.locator(".stick")


def labels(page: Page) -> list[str]:
    found = page.get_by_role("group", name="Labels over time").locator(".span").all()
    return [str(each.get_attribute("data-label")) for each in found]


def lean(page: Page, right: float, up: float) -> None:
    """Move the mouse, which holds the stick, so far from its middle, as a share of half its size."""
    box = stick(page).bounding_box()
    assert box is not None
    page.mouse.move(
        box["x"] + box["width"] / 2 * (1 + right), box["y"] + box["height"] / 2 * (1 - up), steps=4
    )


def drive(page: Page, *moves: tuple[float, float, float]) -> None:
    """Hold the stick with the mouse, lean it so far for so many seconds each, and let go."""
    lean(page, 0, 0)
    page.mouse.down()
    for right, up, seconds in moves:
        lean(page, right, up)
        page.wait_for_timeout(1000 * seconds)
    page.mouse.up()


def test_driven_with_the_mouse_and_learned(page: Page, tmp_path: Path, snap: Snap) -> None:
    expect(page.get_by_text("Drive the robot, and it learns from how you drive.")).to_be_visible()
    snap(page, "driving-opened")
    lean(page, 0, 0)
    page.mouse.down()
    lean(page, 0, 0.95)
    span = page.get_by_role("group", name="Labels over time").locator(".span")
    expect(span.first).to_have_attribute("data-label", "forward", timeout=10_000)  # while the mouse holds it
    for right, up in ((0.9, 0), (0, 0.9), (-0.9, 0), (0.1, 0.9)):
        lean(page, right, up)
        page.wait_for_timeout(2000)
    snap(page, "driving-under-way")
    page.mouse.up()
    page.get_by_role("button", name="Pause").click()
    pane = page.get_by_role("complementary")
    learn = pane.get_by_role("button", name="Learn from these labels")
    expect(learn).to_be_enabled(timeout=10_000)
    told = [each for each in labels(page) if each != "unexplained"]
    assert told[:4] == ["forward", "rotate_right", "forward", "rotate_left"], told
    learn.click()
    expect(pane.get_by_text("of all ticks")).to_be_visible(timeout=30_000)
    snap(page, "driving-learned")
    pane.get_by_label("Name").fill("as_driven")
    pane.get_by_role("button", name="Save").click()
    expect(pane.get_by_role("status")).to_contain_text("as_driven.json")
    assert (tmp_path / "library" / "as_driven.json").is_file()
    assert len([*(tmp_path / "recordings").glob("forage-*.jsonl")]) == 1
