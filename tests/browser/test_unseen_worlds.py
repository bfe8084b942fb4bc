"""What was taught, tried in a hundred worlds at the page; a click goes to one in which it failed."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.studio import Studio, open_studio
from tests.browser.teacher import Teacher
from tests.browser.test_review import goes, open_goto, tab

from understudy.judging.evaluate import evaluate
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT

Snap = Callable[[Page, str], None]
RESULT = re.compile(r"Succeeded in (\d+) of 100 worlds")


@pytest.fixture
def teacher(studio: Studio, visit: Callable[[], Page]) -> Teacher:
    """Goto, shown once, so that it loses its way in some worlds; its lesson is open."""
    teacher = open_goto(studio, visit, goes().make_trained_automaton())
    tab(teacher.page, "Lesson")
    return teacher


def part(page: Page) -> Locator:
    """Where the lesson is tried in unseen worlds."""
    return page.get_by_role("region", name="Unseen worlds")


def test_it_is_tried_in_a_hundred_worlds_and_a_failure_is_opened(
    teacher: Teacher, visit: Callable[[], Page], snap: Snap
) -> None:
    page, unseen = teacher.page, part(teacher.page)
    snap(page, "unseen-before")
    unseen.get_by_role("button", name="Try in 100 worlds").click()
    expect(unseen).to_contain_text(RESULT)
    judged = evaluate(
        Library(FORAGE_KIT).with_automaton(goes().make_trained_automaton()), "goto", "forage", range(1000, 1100),
        binding={"A": "station"},
    )  # fmt: skip
    succeeded = int(judged.taught.finished.sum())
    assert 0 < succeeded < 100
    expect(unseen).to_contain_text(f"Succeeded in {succeeded} of 100 worlds")
    expect(unseen).to_contain_text(re.compile(r"95% interval \d+ to \d+ %"))
    seeds = [seed for seed, done in zip(judged.seeds, judged.taught.finished, strict=True) if not done]
    failed = unseen.get_by_role("list", name="Worlds in which it failed").get_by_role("listitem")
    assert [int(re.findall(r"\d+", text)[0]) for text in failed.all_inner_texts()] == seeds[: failed.count()]
    snap(page, "unseen-failed")

    onlooker = visit()
    tab(onlooker, "Lesson")
    expect(part(onlooker)).to_contain_text(f"Succeeded in {succeeded} of 100 worlds")
    expect(part(onlooker).get_by_role("button", name="Try in 100 worlds")).to_be_disabled()

    failed.first.get_by_role("button", name=f"Open world {seeds[0]}").click()
    expect(page.get_by_label("seed")).to_have_value(str(seeds[0]))
    expect(page.get_by_role("group", name="Mode").get_by_role("button", name="Try")).to_have_attribute(
        "aria-pressed", "true"
    )
    snap(page, "unseen-opened")
    teacher.press("ArrowLeft")  # a correction
    teacher.press(".")
    expect(unseen).to_contain_text("before the lesson changed")
    snap(page, "unseen-changed")
    unseen.get_by_role("button", name="Close what was tried").click()
    expect(unseen).not_to_contain_text(RESULT)


SLOW = """
import numpy as np
from understudy import Continuous, feature
from understudy.model.library import Kit
from understudy.sim.forage import FORAGE_KIT


@feature(Continuous())
def double_stored(robot):
    return np.asarray(2.0 * robot.food_stored)


kit = FORAGE_KIT + Kit.from_parts(double_stored)
"""
"""A kit with a function, so that worlds are tried tick by tick, which takes many seconds."""


def test_it_says_how_far_it_is_while_the_world_goes_on_and_is_cancelled(
    tmp_path: Path, chromium: Browser, monkeypatch: pytest.MonkeyPatch, snap: Snap
) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    path = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path))
    with open_studio(chromium, tmp_path / "library", "forage", "--kit", "slow:kit") as page:
        teacher = Teacher(page)
        teacher.click("Teach something new")
        page.get_by_label("double stored", exact=True).check()
        teacher.begin_as_in_the_paper()
        expect(teacher.state_button("forward")).to_be_enabled()
        for key in ("ArrowLeft", "ArrowUp", "ArrowLeft"):
            teacher.press_until_shown(key)
        tab(page, "Lesson")
        unseen = part(page)
        unseen.get_by_role("button", name="Try in 100 worlds").click()
        expect(unseen.get_by_role("progressbar", name="Worlds tried")).to_be_visible()
        expect(unseen).to_contain_text("goto station: 0 of 100 worlds")
        before = teacher.clock_s
        teacher.wait_until(lambda: teacher.clock_s > before)
        snap(page, "unseen-running")
        unseen.get_by_role("button", name="Cancel").click()
        expect(page.get_by_text("Test cancelled")).to_be_visible()
        expect(unseen.get_by_role("button", name="Try in 100 worlds")).to_be_enabled()
        expect(unseen.get_by_role("progressbar")).to_have_count(0)
