"""A body of one's own in the studio: a Gymnasium environment, which draws itself, and is taught by presses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

pytest.importorskip("gymnasium")

MODULE = """
import gymnasium

from understudy.addons.bridges.environments.gymnasium import GymnasiumBody


def make(seed):
    return GymnasiumBody(
        gymnasium.make("CartPole-v1", render_mode="rgb_array"),
        [seed],
        names=["place", "speed", "angle", "spin"],
        behaviors=["push_left", "push_right"],
    )


def make_blind():
    return gymnasium.make("CartPole-v1")
"""
PICTURE = """() => {
  const canvas = document.querySelector("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let sum = 0;
  for (let at = 0; at < data.length; at += 4) sum = (31 * sum + data[at] + 3 * data[at + 2]) % 1000003;
  return sum;
}"""
"""A number that changes with what is drawn."""
BROWN = """() => {
  const canvas = document.querySelector("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let at = 0; at < data.length; at += 4)
    if (Math.abs(data[at] - 202) + Math.abs(data[at + 1] - 152) + Math.abs(data[at + 2] - 101) < 30) count += 1;
  return count;
}"""
"""How many pixels have the color of CartPole's pole."""


@pytest.fixture
def world() -> str:
    """Which function of the module makes the world."""
    return "make"


@pytest.fixture
def studio(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, world: str) -> Iterator[Studio]:
    (tmp_path / "carts_of_tests.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    made = Studio(tmp_path / "library", "--world", f"carts_of_tests:{world}")
    made.start()
    yield made
    made.stop()


def begin(page: Page, *, states: list[str], features: list[str]) -> Teacher:
    """Begin an automaton in the form, with these states and features."""
    teacher = Teacher(page)
    teacher.click("Teach something new")
    page.get_by_label("Name", exact=True).fill("balance")
    form = page.get_by_role("tabpanel")
    for name in states + features:
        form.get_by_label(name.replace("_", " "), exact=True).check()
    teacher.begin_as_in_the_paper()
    return teacher


def test_an_environment_is_drawn_and_taught(
    visit: Callable[..., Page], snap: Callable[[Page, str], None]
) -> None:
    page = visit(fine=True)
    page.wait_for_function(f"({BROWN})() > 50")
    snap(page, "own_body_welcome")
    page.get_by_label("Speed").select_option(label="0.25×")
    teacher = begin(page, states=["push_left", "push_right"], features=["angle", "spin"])
    teacher.state_button("push_right").click()
    page.keyboard.press("Space")  # it begins paused
    expect(teacher.state_button("push_right")).to_have_attribute("aria-pressed", "true")
    before = page.evaluate(PICTURE)
    page.wait_for_function(f"({PICTURE})() !== {before}")
    assert teacher.examples >= 1
    snap(page, "own_body_taught")
    expect(page.get_by_role("status")).to_contain_text("The episode is over")
    snap(page, "own_body_over")
    teacher.new_world()
    expect(page.get_by_role("status")).to_contain_text("World 1")
    teacher.click("Save")
    expect(page.get_by_text("in the library")).to_be_visible()
    for hidden in ("Add to the world", "Rewind", "Overlays"):
        expect(page.get_by_label(hidden)).not_to_be_visible()


@pytest.mark.parametrize("world", ["make_blind"])
def test_without_pictures_the_page_says_so(
    visit: Callable[[], Page], snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    expect(page.get_by_role("img")).to_have_accessible_name(
        "The world carts_of_tests:make_blind draws no picture."
    )
    begin(page, states=["action_0", "action_1"], features=["obs_2"])
    snap(page, "own_body_blind")
