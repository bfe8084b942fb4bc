"""The page keeps the rules of axe-core, in light and in dark, and can be used without a mouse."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.studio import Studio, open_studio
from tests.browser.teacher import DISTANCE, Teacher
from tests.browser.window import wait_until

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.storage.library_folder import open_library

SOURCE = Path(__file__).parents[2] / "page"
AXE = Path("node_modules", "axe-core", "axe.min.js")
SERIOUS = ("serious", "critical")
MOST_TABS = 120
SCHEMES: dict[Literal["light", "dark"], str] = {"light": "", "dark": "{runOnly: ['color-contrast']}"}
"""The color schemes, each with what is checked in it: only colors differ."""

Snap = Callable[[Page, str], None]


@pytest.fixture(scope="session")
def axe(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The source of axe-core as page/package-lock.json names it, of which nothing else is installed."""
    if (SOURCE / AXE).is_file():
        return (SOURCE / AXE).read_text()
    npm = shutil.which("npm") or ""
    if not npm:
        reason = "there is no npm, which brings axe-core"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    page = tmp_path_factory.mktemp("axe")
    lock = json.loads((SOURCE / "package-lock.json").read_text(encoding="utf-8"))
    place = AXE.parent.as_posix()
    needs = {"devDependencies": {AXE.parent.name: lock["packages"][place]["version"]}}
    lock["packages"] = {"": needs, place: lock["packages"][place]}
    (page / "package.json").write_text(json.dumps(needs), encoding="utf-8")
    (page / "package-lock.json").write_text(json.dumps(lock), encoding="utf-8")
    command = [npm, "ci", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=page, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return (page / AXE).read_text()


MOVES = """() => document.getAnimations().some(
  (each) => each.playState === "running" && each.effect.getTiming().iterations !== Infinity
    && each.currentTime >= each.effect.getTiming().delay
)"""
"""Whether anything moves that comes to rest; not what will move later, such as a message that leaves after 9 s."""


def findings(page: Page, axe: str) -> list[str]:
    """What axe-core finds wrong, where it is serious: by all rules in light, and by those of colors in dark, too."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(axe)
    found = []
    for scheme, rules in SCHEMES.items():
        page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        wait_until(page, lambda: not page.evaluate(MOVES))
        seen: dict[str, Any] = page.evaluate(f"axe.run({rules})")
        found += [
            f"{scheme}: {each['id']}: {each['help']}: {node['html'][:160]} {node['failureSummary'][-160:]}"
            for each in seen["violations"]
            if each["impact"] in SERIOUS
            for node in each["nodes"]
        ]
    return found


def test_nothing_is_in_the_way_of_anybody(visit: Callable[[], Page], snap: Snap, axe: str) -> None:
    teacher = Teacher(visit())
    page = teacher.page
    wrong = {}

    def look(name: str) -> None:
        wrong[name] = findings(page, axe)
        snap(page, f"{len(wrong)}-{name}")

    look("welcome")
    teacher.click("Show me how")
    look("form")
    teacher.click("Names of the states")
    look("names")
    teacher.begin_as_in_the_paper()
    expect(page.get_by_role("complementary")).to_contain_text(DISTANCE)
    look("begun")
    for key in ("ArrowLeft", "ArrowUp", "ArrowRight"):
        teacher.press_until_shown(key)
    look("training")
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    look("lesson")
    teacher.click("Example 1")
    teacher.click("values")
    look("example")
    teacher.click("Example 1")
    page.get_by_role("tab", name="Coach").click()
    expect(page.get_by_role("list", name="Advice")).to_be_visible()
    teacher.click("pause")
    look("coach")
    teacher.press("t")
    expect(page.get_by_role("status", name="Question of the robot")).to_be_visible()
    look("asked")
    teacher.click("no")
    teacher.press("Space")
    look("testing")
    teacher.press("ArrowUp")
    look("corrected")
    teacher.press("Space")
    look("paused")
    page.get_by_role("tab", name="Automaton").click()
    teacher.click("why?")
    expect(page.get_by_role("region", name="Why")).to_be_visible()
    teacher.click("simplify …")
    expect(page.get_by_role("region", name="Simplify")).to_be_visible()
    look("why and simpler")
    teacher.click("Leave")
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    teacher.click("+ property")
    look("promise")
    teacher.click("Add property")
    teacher.click("Test lessons")
    expect(page.get_by_role("region", name="Tested")).to_be_visible()
    look("tested")
    teacher.click("Try in 100 worlds")
    expect(page.get_by_role("region", name="How often it succeeded")).to_be_visible()
    look("tried")
    teacher.click("Save")
    page.get_by_role("tab", name=re.compile("Library")).click()
    look("library")
    nests(teacher)
    look("nested")
    assert not {name: each for name, each in wrong.items() if each}


def test_driving_is_in_nobodys_way(chromium: Browser, tmp_path: Path, axe: str) -> None:
    with open_studio(chromium, tmp_path / "library", "forage", "--drive") as page:
        page.locator(".stick").wait_for()
        wrong = {"opened": findings(page, axe)}
        page.keyboard.press("Space")
        page.keyboard.down("ArrowUp")
        expect(page.locator(".strip .span")).not_to_have_count(0)
        wrong["driving"] = findings(page, axe)
        page.keyboard.press("Space")
        expect(page.get_by_role("button", name="Drive", exact=True)).to_be_visible()  # it is paused
        page.get_by_role("button", name="Learn from these labels").click()
        expect(page.get_by_text("of all ticks")).to_be_visible()
        wrong["learned"] = findings(page, axe)
        assert not {name: each for name, each in wrong.items() if each}


def nests(teacher: Teacher) -> None:
    """Begin an automaton that runs goto, and open goto in its graph."""
    page = teacher.page
    page.get_by_role("tab", name="Automaton").click()
    teacher.click("+ Teach something new")
    page.get_by_label("Name", exact=True).fill("carry")
    page.get_by_label("goto station", exact=True).check()
    page.get_by_label("food stored", exact=True).check()
    teacher.begin_as_in_the_paper()
    teacher.click("What goto runs")
    expect(page.locator(".inner").get_by_text("turn left", exact=True)).to_be_visible()


def test_goto_is_taught_and_saved_without_a_mouse(visit: Callable[[], Page], studio: Studio) -> None:
    teacher = Teacher(visit())
    page = teacher.page
    tab_to(page, "Teach something new")
    page.keyboard.press("Enter")
    tab_to(page, "Begin")
    page.keyboard.press("Enter")
    expect(page.get_by_role("complementary")).to_contain_text(DISTANCE)
    tab_to(page, "rotate_left")
    page.keyboard.press("Enter")
    expect(teacher.state_button("rotate_left")).to_have_attribute("aria-pressed", "true")
    for key, state in (("ArrowUp", "forward"), ("ArrowRight", "rotate_right"), ("4", "done")):
        page.keyboard.press(key)
        expect(teacher.state_button(state)).to_have_attribute("aria-pressed", "true")
    tab_to(page, "New world")
    page.keyboard.press("Enter")
    page.keyboard.press("t")
    expect(page.get_by_role("group", name="Mode").get_by_role("button", name="Try")).to_have_attribute(
        "aria-pressed", "true"
    )
    expect(teacher.state_button("start")).to_have_attribute("aria-pressed", "false")
    tab_to(page, "Automaton")
    for _ in ("Lesson", "Coach", "Library"):
        page.keyboard.press("ArrowRight")
    expect(page.get_by_role("tab", name=re.compile("Library"))).to_be_focused()
    tab_to(page, "Save")
    page.keyboard.press("Enter")
    expect(page.get_by_text("in the library", exact=True)).to_be_visible()
    assert "goto" in open_library(studio.library, make_scenario_kit(find_scenario("forage"))).library.taught


def tab_to(page: Page, name: str) -> None:
    """Press Tab until the focus is on what has this name."""
    for _ in range(MOST_TABS):
        page.keyboard.press("Tab")
        focused = page.evaluate(
            "(e => e.getAttribute('aria-label') ?? e.dataset.state ?? e.innerText)(document.activeElement)"
        )
        if re.match(rf"{re.escape(name)}\b", (focused or "").strip()):
            return
    raise AssertionError(f"Tab does not come to {name}")
