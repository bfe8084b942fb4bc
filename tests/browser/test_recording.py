"""A recording at the page: spans are relabeled, boundaries moved, doubts answered, an automaton learned and saved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.studio import find_strip, list_labels, open_studio
from tests.segmentation.driven import ANNA, FAR
from tests.segmentation.driven import MAP as DRIVEN_MAP

Snap = Callable[[Page, str], None]

MAP = """format = "understudy-recording-map/1"
time = "time_s"
[[readings]]
column = "ball_m"
name = "range"
target = "ball"
unit = "m"
[[readings]]
column = "x"
name = "x"
unit = "m"
[[readings]]
column = "y"
name = "y"
unit = "m"
[[commands]]
column = "stick"
channel = "drive"
unit = "m/s"
[behaviors.forward]
drive = 0.8
[behaviors.back]
drive = -0.5
"""


def write_drive(folder: Path) -> Path:
    """A drive to and fro of 40 s; from 20.0 s to 22.0 s the stick is at 0.15, between the two behaviors."""
    random, rows, distance, drive = np.random.default_rng(0), ["time_s,ball_m,x,y,stick"], 3.0, 0.8
    x, y = 0.0, 0.0
    for tick in range(400):
        drive = -0.5 if distance < 1.0 else 0.8 if distance > 3.0 else drive
        stick = 0.15 if 200 <= tick < 220 else drive
        noise = 0.03 * random.normal()
        rows.append(f"{tick / 10:.1f},{distance:.4f},{x:.3f},{y:.3f},{stick + noise:.4f}")
        distance -= 0.1 * drive
        x, y = x + 0.1 * drive * np.cos(tick / 60), y + 0.1 * drive * np.sin(tick / 60)
    (folder / "drive.csv").write_text("\n".join(rows) + "\n")
    (folder / "map.toml").write_text(MAP)
    return folder / "drive.csv"


@pytest.fixture
def page(tmp_path: Path, chromium: Browser) -> Iterator[Page]:
    recording = write_drive(tmp_path)
    options = "--map", str(tmp_path / "map.toml"), "--features", "range(ball)"
    with open_studio(chromium, tmp_path / "library", "--recording", str(recording), *options) as page:
        find_strip(page).wait_for()
        yield page


def place(page: Page, tick: float) -> tuple[float, float]:
    """Where a tick is on the lane of the labels."""
    box = find_strip(page).bounding_box()
    assert box is not None
    return box["x"] + tick / 400 * box["width"], box["y"] + 40


def drag(page: Page, first: float, last: float) -> None:
    page.mouse.move(*place(page, first))
    page.mouse.down()
    page.mouse.move(*place(page, (first + last) / 2))
    page.mouse.move(*place(page, last))
    page.mouse.up()


def test_reviewed_learned_and_saved(page: Page, tmp_path: Path, snap: Snap) -> None:
    before = list_labels(page)
    assert before[:3] == [("forward", 0), ("back", 25), ("forward", 66)]
    assert ("unexplained", 200) in before
    snap(page, "recording-opened")
    pane = page.get_by_role("complementary")

    page.mouse.click(*place(page, 45))  # the first span of back
    expect(pane.get_by_role("heading", name="0:02.5 to 0:06.6")).to_be_visible()
    pane.get_by_role("button", name="forward").click()
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "forward")
    page.get_by_role("button", name="Undo").click()
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "back")

    drag(page, 25, 35)  # its beginning is moved by about a second
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "forward")
    moved = list_labels(page)
    assert moved[:2] == [("forward", 0), ("forward", 25)]
    assert 33 <= moved[2][1] <= 37
    page.keyboard.press("Control+z")
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "back")

    drag(page, 210, 218)  # a part of what nothing explains
    expect(pane.get_by_text("What was this part?")).to_be_visible()
    page.keyboard.press("2")
    expect(find_strip(page).locator(".span[data-label='back'][data-first='210']")).to_have_count(1)
    page.keyboard.press("Control+z")

    pane.get_by_role("button", name="Learn from these labels").click()
    expect(pane.get_by_text("of all ticks")).to_be_visible()
    expect(pane.get_by_text("range (ball) is below 1.")).to_be_visible()
    snap(page, "recording-learned")
    page.get_by_role("button", name="Zoom in").click()
    page.get_by_role("button", name="Zoom in").click()
    page.mouse.move(*place(page, 60))
    snap(page, "recording-zoomed")

    pane.get_by_label("Name", exact=True).fill("to_and_fro")
    pane.get_by_role("button", name="Save").click()
    expect(pane.get_by_role("status")).to_contain_text("to_and_fro.json")
    assert (tmp_path / "library" / "to_and_fro.json").is_file()


def test_what_nothing_explains_gets_a_name(page: Page, snap: Snap) -> None:
    """The stick at 0.15 for 2 s is no behavior that the map has: it is proposed, named, and then a label."""
    pane = page.get_by_role("complementary")
    expect(pane.get_by_role("heading", name="Not explained")).to_be_visible()
    expect(pane.get_by_text("drive 0.15")).to_be_visible()
    snap(page, "recording-proposal")
    pane.get_by_role("button", name="0:20.0 to 0:2").click()
    pane.get_by_label("Name of the behavior").fill("creep")
    pane.get_by_role("button", name="Add").click()
    expect(find_strip(page).locator(".span[data-label='creep']")).to_have_count(1)
    expect(pane.get_by_role("heading", name="Not explained")).to_have_count(0)
    page.get_by_role("button", name="Undo").click()
    expect(pane.get_by_text("drive 0.15")).to_be_visible()


def test_with_the_keyboard_alone(page: Page) -> None:
    page.keyboard.press("ArrowRight")
    pane = page.get_by_role("complementary")
    expect(pane.get_by_role("heading", name="0:00.0 to 0:02.5")).to_be_visible()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowLeft")
    expect(pane.get_by_role("heading", name="0:02.5 to 0:06.6")).to_be_visible()
    page.keyboard.press("0")
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "unexplained")
    page.keyboard.press("Control+z")
    expect(find_strip(page).locator(".span").nth(1)).to_have_attribute("data-label", "back")
    page.keyboard.press("Escape")
    expect(pane.get_by_text("Select a span on the timeline")).to_be_visible()


def test_on_a_narrow_screen(page: Page, snap: Snap) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    expect(page.get_by_role("button", name="Learn from these labels")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    snap(page, "recording-narrow")


@pytest.fixture
def drivers_page(tmp_path: Path, chromium: Browser) -> Iterator[Page]:
    """The drives of Anna, who goes back at 1 m from the ball, and of Ben, who goes back at 2 m, 90 s each."""
    (tmp_path / "map.toml").write_text(DRIVEN_MAP)
    recordings = [ANNA.write(tmp_path / "anna.csv"), FAR.write(tmp_path / "ben.csv")]
    options = [part for each in recordings for part in ("--recording", str(each))]
    options += ["--map", str(tmp_path / "map.toml"), "--features", "range(ball)"]
    with open_studio(chromium, tmp_path / "library", *options) as page:
        find_strip(page).wait_for()
        yield page


def test_contradictions_between_drivers_are_settled(drivers_page: Page, tmp_path: Path, snap: Snap) -> None:
    page = drivers_page
    expect(find_strip(page).locator(".driver")).to_have_text(["anna, anna.csvanna", "ben, ben.csvben"])
    pane = page.get_by_role("complementary")
    pane.get_by_role("button", name="Learn from these labels").click()
    found = pane.get_by_role("region", name="Contradictions")
    row = found.get_by_role("listitem").filter(has_text="anna stays in forward")
    expect(row).to_be_visible()
    expect(found.get_by_text("to settle: who is right?")).to_be_visible()
    row.get_by_role("button", name="ben switches from forward to back").click()
    expect(find_strip(page).locator(".selected")).to_have_count(1)
    snap(page, "recording-contradictions")
    page.emulate_media(color_scheme="dark")
    snap(page, "recording-contradictions-dark")
    page.emulate_media(color_scheme="light")

    row.get_by_role("button", name="ben is right").click()
    expect(row.get_by_text("Settled: ben is right.")).to_be_visible()
    snap(page, "recording-settled")
    page.get_by_role("button", name="Undo").click()
    expect(row.get_by_role("button", name="ben is right")).to_be_visible()
    found.get_by_label("Right everywhere else").select_option("anna")
    expect(row.get_by_text("Settled: anna is right.")).to_be_visible()
    expect(found.get_by_text("All are settled.")).to_be_visible()
    pane.get_by_label("Name", exact=True).fill("after_anna")
    pane.get_by_role("button", name="Save").click()
    expect(pane.get_by_role("status")).to_contain_text("after_anna.json")
    assert "contradicts anna" in (tmp_path / "library" / "after_anna.json").read_text()

    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    found.scroll_into_view_if_needed()
    snap(page, "recording-contradictions-narrow")
