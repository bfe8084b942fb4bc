"""Driving at the page: the stick is dragged with the mouse, labels appear meanwhile, and an automaton is learned."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.shared_clock import SharedClock
from tests.browser.studio import find_clock, find_strip, list_labels, open_studio
from tests.browser.window import wait_until

Snap = Callable[[Page, str], None]
TICK_S = 0.1


@pytest.fixture
def page(tmp_path: Path, chromium: Browser) -> Iterator[Page]:
    options = "--seed", "3", "--features", "distance_to(nearest_food),angle_to(nearest_food)"
    library = tmp_path / "library"
    with open_studio(chromium, library, "forage", "--drive", *options, clock=True, script=TRAFFIC) as page:
        stick(page).wait_for()
        yield page


@pytest.fixture
def clock(page: Page, tmp_path: Path) -> SharedClock:
    """The clock by which the world runs: it stands still until a test moves it."""
    return SharedClock(find_clock(tmp_path / "library"))


TRAFFIC = """(() => {
  window.traffic = { sent: 0, frames: 0, wake: () => {} };
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function (data) {
    send.call(this, data);
    traffic.sent += 1;
    traffic.wake();
  };
  const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage");
  Object.defineProperty(WebSocket.prototype, "onmessage", { set(take) {
    set.call(this, (event) => {
      take(event);
      if (typeof event.data === "string") return;
      traffic.frames += 1;
      traffic.wake();
    });
  } });
})()"""
"""Counts what the page says of the stick, and the moments of the world that it is shown."""
NOTE = "() => [traffic.sent, traffic.frames]"
HEARD = """([sent, frames]) => new Promise((resolve, reject) => {
  traffic.wake = () => {
    if (traffic.sent > sent && traffic.frames > frames) resolve();
  };
  traffic.wake();
  setTimeout(() => reject(new Error("the world does not go on")), 60000);
})"""
"""Waits until the page said where the stick is, and was shown another moment."""


def hold_for(page: Page, clock: SharedClock, seconds: float) -> None:
    """Hold the stick where it is for so long, tick by tick: the studio forgets a stick that it does not hear of."""
    for _ in range(round(seconds / TICK_S)):
        before = page.evaluate(NOTE)
        clock.advance(TICK_S)
        page.evaluate(HEARD, before)


def stick(page: Page) -> Locator:
    return page.locator(".stick")


def labels(page: Page) -> list[str]:
    """The labels of the drive, without what nothing explains."""
    return [label for label, _ in list_labels(page) if label != "unexplained"]


def lean(page: Page, right: float, up: float) -> None:
    """Move the mouse, which holds the stick, so far from its middle, as a share of half its size."""
    box = stick(page).bounding_box()
    assert box is not None
    page.mouse.move(
        box["x"] + box["width"] / 2 * (1 + right), box["y"] + box["height"] / 2 * (1 - up), steps=4
    )


def test_driven_with_the_mouse_and_learned(
    page: Page, clock: SharedClock, tmp_path: Path, snap: Snap
) -> None:
    """To the food, 3.5 m away and 164 degrees to the left, at 0.5 m/s and 69 degrees a second; then toward home."""
    expect(page.get_by_text("Drive the robot, and it learns from how you drive.")).to_be_visible()
    snap(page, "driving-opened")
    lean(page, 0, 0)
    page.mouse.down()
    lean(page, -0.9, 0)
    span = find_strip(page).locator(".span")
    hold_for(page, clock, 2.25)
    expect(span.first).to_have_attribute("data-label", "rotate_left")  # while it is held
    lean(page, 0, 0.9)
    hold_for(page, clock, 6.5)
    page.keyboard.down("a")
    lean(page, 0, 0)
    hold_for(page, clock, 3.0)
    page.keyboard.up("a")
    lean(page, -0.9, 0)
    hold_for(page, clock, 1.1)
    lean(page, 0, 0.9)
    hold_for(page, clock, 2.8)
    expect(span.last).to_have_attribute("data-label", "forward")
    snap(page, "driving-under-way")
    page.mouse.up()
    page.get_by_role("button", name="Pause").click()
    pane = page.get_by_role("complementary")
    learn = pane.get_by_role("button", name="Learn from these labels")
    expect(learn).to_be_enabled()
    told = labels(page)
    assert told == ["rotate_left", "forward", "load_food", "rotate_left", "forward"], told
    learn.click()
    expect(pane.get_by_text("of all ticks")).to_be_visible()
    snap(page, "driving-learned")

    page.get_by_role("button", name="Let it drive").click()
    expect(page.get_by_text("Move the stick to take over.")).to_be_visible()
    for _ in range(10):
        if page.get_by_text("By itself: forward").is_visible():
            break
        hold_for(page, clock, 1.0)
    expect(page.get_by_text("By itself: forward")).to_be_visible()
    expect(page.get_by_role("button", name="New world")).to_be_disabled()
    snap(page, "driving-by-itself")
    page.emulate_media(color_scheme="dark")
    snap(page, "driving-by-itself-dark")
    page.emulate_media(color_scheme="light")
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Drive", exact=True)).to_be_visible()
    expect(pane.get_by_text("of all ticks")).to_be_visible()  # what it does by itself changes nothing
    pane.get_by_label("Name").fill("as_driven")
    pane.get_by_role("button", name="Save").click()
    expect(pane.get_by_role("status")).to_contain_text("as_driven.json")
    assert (tmp_path / "library" / "as_driven.json").is_file()
    assert len([*(tmp_path / "recordings").glob("forage-*.jsonl")]) == 1


def test_driven_with_the_keyboard(page: Page, clock: SharedClock) -> None:
    page.keyboard.press("Space")
    expect(page.get_by_text("Move the stick: the world waits for you.")).to_be_visible()
    page.keyboard.down("ArrowUp")
    hold_for(page, clock, 1.5)
    page.keyboard.down("ArrowRight")  # both: ahead and to the right
    page.keyboard.up("ArrowUp")
    hold_for(page, clock, 1.2)
    page.keyboard.up("ArrowRight")
    page.keyboard.down("a")
    expect(page.get_by_role("button", name="load food").first).to_have_attribute("aria-pressed", "true")
    hold_for(page, clock, 1.0)
    page.keyboard.press("Space")
    page.keyboard.up("a")
    expect(page.get_by_role("button", name="Drive", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Learn from these labels")).to_be_enabled()
    told = labels(page)
    assert told == ["forward", "rotate_right", "load_food"], told
    page.keyboard.press("ArrowRight")  # a key of the review again
    expect(page.get_by_text("What was it?")).to_be_visible()


PAD = """
window.pad = {axes: [0, 0], buttons: Array.from({length: 17}, () => ({pressed: false}))};
navigator.getGamepads = () => [window.pad, null, null, null];
dispatchEvent(new Event("gamepadconnected"));
"""


def test_driven_with_a_gamepad_in_two_worlds(page: Page, clock: SharedClock, snap: Snap) -> None:
    """Start begins and pauses, the left stick drives, and X, the second button, unloads."""
    page.evaluate(PAD)

    def push(button: int, then: str) -> None:
        page.evaluate(f"window.pad.buttons[{button}].pressed = true")
        expect(page.get_by_role("button", name=then, exact=True)).to_be_visible()
        page.evaluate(f"window.pad.buttons[{button}].pressed = false")

    expect(page.get_by_text("or the left stick of the gamepad after a press of Start")).to_be_visible()
    push(9, "Pause")
    page.evaluate("window.pad.axes = [0.02, -0.9]")
    hold_for(page, clock, 1.5)
    page.evaluate("window.pad.axes = [-0.95, 0.05]")
    hold_for(page, clock, 1.2)
    page.evaluate("window.pad.axes = [0.03, 0.03]; window.pad.buttons[2].pressed = true")
    hold_for(page, clock, 1.0)
    push(9, "Drive")
    page.evaluate("window.pad.buttons[2].pressed = false")
    expect(page.get_by_role("button", name="Learn from these labels")).to_be_enabled()
    told = labels(page)
    assert told == ["forward", "rotate_left", "unload_food"], told

    page.get_by_role("button", name="New world").click()
    expect(page.get_by_text("seed 4")).to_be_visible()
    push(9, "Pause")
    page.evaluate("window.pad.axes = [0, -1]")
    hold_for(page, clock, 1.5)
    push(9, "Drive")
    expect(page.locator(".strip .gap")).to_have_count(1)  # another episode of the same drive
    expect(page.get_by_role("button", name="Learn from these labels")).to_be_enabled()
    assert labels(page) == [*told, "forward"]
    snap(page, "driving-two-worlds")


def test_the_robot_rests_when_the_page_is_left(page: Page, clock: SharedClock) -> None:
    """Keys that are held when the window loses the focus count as let go of."""
    page.keyboard.press("Space")
    page.keyboard.down("ArrowUp")
    hold_for(page, clock, 1.5)
    expect(find_strip(page).locator(".span")).not_to_have_count(0)
    page.evaluate("dispatchEvent(new Event('blur'))")
    waits = page.get_by_text("Move the stick: the world waits for you.")

    def rests() -> bool:
        clock.advance(TICK_S)
        return waits.is_visible()

    wait_until(page, rests)
    expect(waits).to_be_visible()


def test_on_a_narrow_screen(page: Page, clock: SharedClock, snap: Snap) -> None:
    """The world and the stick are on the first screen."""
    page.set_viewport_size({"width": 390, "height": 844})
    box = stick(page).bounding_box()
    assert box is not None
    assert box["y"] + box["height"] < 844
    assert abs(box["width"] - box["height"]) < 1
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    lean(page, 0, 0)
    page.mouse.down()
    lean(page, 0, 0.9)
    hold_for(page, clock, 1.5)
    expect(find_strip(page).locator(".span")).not_to_have_count(0)
    snap(page, "driving-narrow")
    page.mouse.up()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_the_stick_takes_over_from_the_automaton(page: Page, clock: SharedClock, snap: Snap) -> None:
    page.keyboard.press("Space")
    for key in ("ArrowUp", "ArrowLeft"):
        page.keyboard.down(key)
        hold_for(page, clock, 1.5)
        page.keyboard.up(key)
    page.keyboard.press("Space")
    pane = page.get_by_role("complementary")
    by_itself = page.get_by_role("button", name="Let it drive")
    learn = pane.get_by_role("button", name="Learn from these labels")
    expect(learn).to_be_enabled()
    expect(by_itself).to_be_disabled()
    learn.click()
    expect(pane.get_by_text("of all ticks")).to_be_visible()
    by_itself.click()
    expect(page.get_by_text("Move the stick to take over.")).to_be_visible()
    expect(page.get_by_text("By itself: ")).to_be_visible()
    expect(page.get_by_text("Move the stick to take over.")).to_be_visible()
    before = labels(page)

    page.set_viewport_size({"width": 390, "height": 844})
    snap(page, "driving-by-itself-narrow")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.set_viewport_size({"width": 1280, "height": 800})
    page.keyboard.down("ArrowRight")
    expect(page.get_by_text("Move the stick to take over.")).to_have_count(0)
    hold_for(page, clock, 1.5)
    page.keyboard.up("ArrowRight")
    page.keyboard.press("Space")
    expect(learn).to_be_enabled()
    assert labels(page) == [*before, "rotate_right"]
    expect(page.locator(".strip .gap")).to_have_count(1)  # another episode
