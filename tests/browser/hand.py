"""A hand at the mouse: takes the robot that is trained, found by its color in the picture, and puts it elsewhere."""

from __future__ import annotations

from math import cos, sin

from playwright.sync_api import Page

FIND = """() => {
  const canvas = document.querySelector("canvas");
  const testing = document.querySelector(".modes [aria-pressed=true]")?.innerText === "Try";
  const named = getComputedStyle(canvas).getPropertyValue(testing ? "--test" : "--train").trim();
  const color = [1, 3, 5].map((at) => parseInt(named.slice(at, at + 2), 16));
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const box = canvas.getBoundingClientRect();
  let [count, x, y] = [0, 0, 0];
  for (let pixel = 0; pixel < width * height; pixel += 1) {
    if (color.some((each, at) => Math.abs(data[4 * pixel + at] - each) > 3)) continue;
    count += 1;
    x += pixel % width;
    y += Math.floor(pixel / width);
  }
  const share = box.width / width / count;
  return count > 0 ? [box.x + x * share, box.y + y * share] : null;
}"""
"""Where its ring is in the window, px."""


TURNING_PX = 60
"""How far from the robot the mouse is that it turns to."""


def drag_robot(page: Page, right_px: float, down_px: float) -> None:
    """Drag the robot that is trained so far over the screen."""
    x, y = find_robot(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right_px, y + down_px, steps=6)
    page.mouse.up()
    page.mouse.move(0, 0)


def turn_robot(page: Page, heading: float) -> None:
    """Turn it where it is, with Shift; radians, to the left of rightwards."""
    page.keyboard.down("Shift")
    drag_robot(page, TURNING_PX * cos(heading), -TURNING_PX * sin(heading))
    page.keyboard.up("Shift")


def find_robot(page: Page) -> tuple[float, float]:
    """Return where the robot that is trained is in the window, px."""
    wait_for_still_picture(page)
    found = page.evaluate(FIND)
    assert found is not None, "no robot in the color of its mode"
    x, y = found
    return x, y


STILL = """async () => {
  const drawn = () => document.querySelector("canvas").toDataURL();
  const frame = () => new Promise(requestAnimationFrame);
  for (let before = ""; before !== drawn(); ) {
    before = drawn();
    await frame();
    await frame();
  }
}"""


def wait_for_still_picture(page: Page) -> None:
    """Wait until the world is drawn as it was two frames before: the view has come to where it goes."""
    page.evaluate(STILL)


def drag_finger(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Put a finger on the screen, move it in ten steps, and lift it."""
    touch = page.context.new_cdp_session(page)
    for step in range(11):
        x, y = (first + (last - first) * step / 10 for first, last in zip(start, end, strict=True))
        kind = "touchMove" if step else "touchStart"
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    touch.detach()
