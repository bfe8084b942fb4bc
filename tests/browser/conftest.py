"""A real Chromium and a real studio, for tests that press what a person presses."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from tests.browser.static_studio import StaticStudio
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.window import SNAPS, find_chromium, launch, open_page

PLACE = "UNDERSTUDY_PLACE"
"""The variable that says where the studio runs in tests that do not say so themselves."""
OPENED = ExitStack()
"""The browser of this worker, while tests of this folder run."""
_browsers: list[Browser] = []


@pytest.fixture
def chromium() -> Browser:
    """The system's Chromium, one for all tests; where there is none the test is skipped, but fails where CI is set."""
    found = find_chromium()
    if found is None:
        reason = "there is no Chromium: apt-get install chromium"
        if os.environ.get("CI"):
            pytest.fail(reason)
        pytest.skip(reason)
    if not _browsers or not _browsers[0].is_connected():
        OPENED.close()
        _browsers[:] = [launch(OPENED.enter_context(sync_playwright()), found)]
        OPENED.callback(_browsers[0].close)
    return _browsers[0]


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """End the browser before a test of another folder: while it runs, so does an event loop in this thread."""
    if nextitem is None or not nextitem.path.is_relative_to(Path(__file__).parent):
        _browsers.clear()
        OPENED.close()


@pytest.fixture
def snap(tmp_path: Path) -> Callable[[Page, str], None]:
    """Keeps what a page looks like, under a name: in the folder of UNDERSTUDY_SNAPS, if it is set."""
    folder = os.environ.get(SNAPS)

    def keep_picture(page: Page, name: str) -> None:
        if folder is not None:
            Path(folder).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=Path(folder, f"{name}.png"))

    return keep_picture


@pytest.fixture
def moves_clock() -> bool:
    """Whether time passes in the studio only while the test lets it pass; a file of tests may say so."""
    return False


@pytest.fixture
def place() -> str:
    """Where the studio runs: "served" by a server of its own, or "static", as files, in the page."""
    return os.environ.get(PLACE, "served")


@pytest.fixture
def studio(tmp_path: Path, moves_clock: bool, place: str) -> Iterator[Studio]:
    """A studio with an empty library."""
    made = StaticStudio() if place == "static" else Studio(tmp_path / "library", clock=moves_clock)
    made.start()
    yield made
    made.stop()


@pytest.fixture
def visit(chromium: Browser, studio: Studio) -> Iterator[Callable[..., Page]]:
    """Open the page of the studio, each time as another person; with the options of `open_page`."""
    with ExitStack() as pages:

        def open_studio_page(**options: Any) -> Page:
            page = pages.enter_context(open_page(chromium, studio.address, **options))
            studio.wait_until_open(page)
            return page

        yield open_studio_page


@pytest.fixture
def teacher(visit: Callable[..., Page]) -> Teacher:
    """A person who has begun goto."""
    person = Teacher(visit())
    person.begin_goto()
    return person
