"""Long runs: a page that watches for hours keeps no more than it needs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from subprocess import PIPE, Popen
from sys import executable, stderr
from time import monotonic

import pytest
from playwright.sync_api import Browser, CDPSession, Page
from tests.browser.studio import READY
from tests.browser.teacher import Teacher

HOURS, TIMES = 8, 7.5
"""At 16 times the pace of life, and a second that lasts so long: an hour in half a minute."""
MOST_GROWTH = 2**20
"""Bytes per simulated hour over the second half."""
CLOCK = re.compile(r"(\d+):(\d\d)\.\d")


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """A studio in a hurry."""
    command = [executable, "-u", "-m", "tests.browser.hurried", str(tmp_path / "library"), str(TIMES)]
    with Popen(command, stdout=PIPE, text=True) as process:
        assert process.stdout is not None
        yield next(found[1] for line in process.stdout if (found := READY.search(line)))
        process.terminate()


@pytest.mark.soak
def test_hours_of_watching(chromium: Browser, address: str) -> None:
    page = chromium.new_page(viewport={"width": 1280, "height": 800})
    page.goto(address)
    teacher = Teacher(page)
    teacher.begin_goto()
    page.get_by_role("combobox", name="Speed").select_option("16")
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    sizes = []
    until = monotonic() + 1_500
    for hour in range(1, HOURS + 1):
        while hours(page) < hour:
            assert monotonic() < until, f"{hours(page):.2f} hours so far"
            for key in ("ArrowUp", "ArrowLeft"):
                teacher.press(key)
                page.wait_for_timeout(1_000)
                teacher.press("Control+z")
        sizes.append(measure_heap(session))
    page.close()
    stderr.write(f"the page held, bytes after each hour: {sizes}\n")
    assert (sizes[-1] - sizes[HOURS // 2 - 1]) / (HOURS / 2) < MOST_GROWTH, sizes


def hours(page: Page) -> float:
    """The world's time, as the page shows it."""
    found = CLOCK.search(page.locator(".time").inner_text())
    assert found is not None
    return (int(found[1]) * 60 + int(found[2])) / 3600


def measure_heap(session: CDPSession) -> int:
    """Bytes the page's objects take, without those that nobody needs."""
    session.send("HeapProfiler.collectGarbage")
    metrics = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
    return int(metrics["JSHeapUsedSize"])
