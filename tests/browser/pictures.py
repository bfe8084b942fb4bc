"""Takes the pictures of the documents at the real page: `python -m tests.browser.pictures`.

Most are of a lesson of foraging, the rest of tests that do what the documents tell. It takes four minutes. With --out
FOLDER they go there, with --only WORD only those whose names have this word in them, if tests take them.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias

from playwright.sync_api import Page, expect, sync_playwright
from tests.browser import curriculum
from tests.browser.foraging import GOTO, HARVEST, WAYS, Forager, on_its_way
from tests.browser.studio import Studio
from tests.browser.window import SNAPS, WINDOW, find_chromium, launch

from understudy.training.trainee import SessionView

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"
ANYWHERE = 1_000
OF_TESTS = {
    "studio-doubt": ("test_doubt.py", "doubt"),
    "studio-team": ("test_team.py", "team"),
    "studio-robot": ("test_robot.py", "robot"),
    "studio-properties": ("test_properties.py", "properties-refused"),
    "notebook": ("test_notebook.py", "notebook-taught"),
    "studio-recording": ("test_recording.py", "recording-learned"),
    "studio-contradictions": ("test_recording.py", "recording-contradictions"),
    "studio-driving": ("test_driving.py", "driving-under-way"),
}
"""Pictures that tests take, with the test's file and what the picture is called there."""
FEW, UNSURE = 2, 11
"""So many ways do not tell enough, and a world in which that shows."""


Take: TypeAlias = Callable[[str], None]
"""Takes a picture of the page, by its name."""


def main(folder: Path) -> None:
    """One lesson after the other, with a picture where there is something to see."""
    with at_the_page() as page:
        person = Forager(page)

        def take(name: str) -> None:
            page.mouse.move(0, 0)
            page.wait_for_timeout(300)
            page.screenshot(path=folder / f"{name}.png")

        goto(person, take)
        harvest(person, take)
        curriculum.teach_deposit(person)
        curriculum.teach_forage(person)
        forage(person, take)
        outcomes(person, take)


def goto(person: Forager, take: Take) -> None:
    """Unsure after two ways, on its way while it is shown, and while it decides."""
    person.begin(GOTO)
    for number in range(len(WAYS) - 1):
        if number == FEW:
            coach(person, take)
        person.way(number)
    seed, target, away = WAYS[-1]
    person.world(seed, target)
    person.show(GOTO, until=on_its_way)
    person.turn_away(away)
    person.show(GOTO, until=lambda view: view.state == "forward" and _way(view) < 3.0)
    take("studio-goto")
    person.show(GOTO)
    person.teach(GOTO, passes=5)
    person.world(ANYWHERE, "station")
    person.go(1)
    person.test()
    person.watch(_content, until=lambda view: view.state == "forward" and _way(view) < 2.0, limit_s=60)
    take("studio")
    person.save()


def coach(person: Forager, take: Take) -> None:
    """What to show next, and a robot that asks."""
    page = person.page
    page.get_by_role("tab", name="Coach").click()
    person.click("pause")
    person.world(UNSURE, "station")
    person.go(1)
    person.test()
    carry_on = page.get_by_role("button", name="Carry on")
    carry_on.wait_for()
    take("studio-coach")
    person.click("no")
    carry_on.click()
    person.press("t")
    page.get_by_role("tab", name="Automaton").click()


def harvest(person: Forager, take: Take) -> None:
    """The form, what it shows, and the automaton with goto open in it."""
    person.world(curriculum.PLENTY)
    person.fill(HARVEST)
    take("studio-form")
    person.begin(HARVEST)
    curriculum.show_harvest(person)
    person.teach(HARVEST, passes=3)
    person.page.get_by_role("tab", name="Lesson").click()
    take("studio-lesson")
    person.page.get_by_role("tab", name="Automaton").click()
    person.page.get_by_role("button", name="What goto runs").click()
    person.world(ANYWHERE)
    person.go(2)
    person.test()
    person.watch(_content, until=lambda view: view.path[-1] == "forward", limit_s=60)
    person.page.wait_for_timeout(600)
    take("studio-harvest")
    person.go(8)
    person.watch(_content, until=lambda view: view.flag is not None, limit_s=120)
    person.save()


def forage(person: Forager, take: Take) -> None:
    """By itself, on its way home the second time."""
    person.world(ANYWHERE + 1)
    person.go(8)
    person.page.get_by_role("button", name="What harvest runs").click()
    person.test()
    person.watch(_content, until=lambda view: person.food[0] > 0 and view.state == "harvest", limit_s=400)
    person.watch(_content, until=lambda view: view.state == "deposit", limit_s=400)
    person.page.get_by_role("button", name="What deposit runs").click()
    person.go(1)
    person.watch(_content, until=lambda view: view.path[-1] == "forward", limit_s=100)
    person.page.wait_for_timeout(1_500)
    take("studio-forage")


def outcomes(person: Forager, take: Take) -> None:
    """Goto promises to arrive, forgets when it is there, and is not saved so."""
    page = person.page
    page.get_by_role("tab", name="Library").click()
    page.get_by_role("button", name="Open goto", exact=True).click()
    person.world(ANYWHERE + 2, "station")
    page.get_by_role("tab", name="Lesson").click()
    page.get_by_role("button", name="+ property").click()
    page.get_by_label("seconds").fill("60")
    page.get_by_role("button", name="Add property", exact=True).click()
    person.save()
    flags = page.get_by_role("row").filter(has=page.get_by_role("cell", name="done", exact=True))
    forgotten = flags.count()
    for _ in range(forgotten):
        left = flags.count()
        flags.first.get_by_role("button").click()
        page.get_by_role("button", name="Delete", exact=True).click()
        expect(flags).to_have_count(left - 1)
    page.get_by_role("button", name="Test lessons").click()
    expect(page.get_by_role("region", name="Tested")).to_contain_text("Failed: ")
    page.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_role("alert", name="Before it is saved")).to_be_visible()
    page.locator("#tab-panel").evaluate("each => each.scrollTo(0, 0)")
    page.wait_for_timeout(600)
    take("studio-outcomes")
    for left in range(forgotten):
        page.keyboard.press("Control+z")
        expect(flags).to_have_count(left + 1)
    person.save()


def _content(view: SessionView) -> str | None:
    """Nothing to press."""
    return None


def _way(view: SessionView) -> float:
    return view.features["distance_to(A)"]


def take_from_tests(folder: Path, only: str) -> None:
    """Run the tests that take pictures of the documents, and keep these."""
    for name, (test, called) in OF_TESTS.items():
        if only not in name:
            continue
        with tempfile.TemporaryDirectory() as snaps:
            command = [sys.executable, "-m", "pytest", "-q", "-n0", str(Path(__file__).parent / test)]
            subprocess.run(command, check=True, env={**os.environ, SNAPS: snaps, "CI": "1"})
            shutil.copyfile(Path(snaps, f"{called}.png"), folder / f"{name}.png")


@contextmanager
def at_the_page() -> Iterator[Page]:
    """The page of a studio with an empty library."""
    found = find_chromium() or ""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        studio = Studio(Path(folder) / "library")
        studio.start()
        browser = launch(playwright, found)
        page = browser.new_page(viewport=WINDOW)
        page.goto(studio.address)
        yield page
        browser.close()
        studio.stop()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=PICTURES)
    parser.add_argument("--only", default="")
    chosen = parser.parse_args()
    if not chosen.only:
        main(chosen.out)
    take_from_tests(chosen.out, chosen.only)
