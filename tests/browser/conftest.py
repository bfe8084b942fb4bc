"""A real Chromium and a real studio, for tests that press what a person presses."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from tests.browser.studio import Studio

NAMES = ("chromium", "chromium-browser", "google-chrome")
SNAPS = "UNDERSTUDY_SNAPS"
"""The variable that names a folder for what pages looked like."""
QUIET = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    """The system's Chromium; where there is none the test is skipped, but in continuous integration it fails.

    It ends with the module: as long as it is there, an event loop runs in this thread, and no test can run another.
    """
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        reason = "there is no Chromium: apt-get install chromium"
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=list(QUIET))
        yield browser
        browser.close()


@pytest.fixture
def snap(tmp_path: Path) -> Callable[[Page, str], None]:
    """Keeps what a page looks like, under a name: in the folder of UNDERSTUDY_SNAPS, or beside the test's files."""
    folder = Path(os.environ.get(SNAPS) or tmp_path / "snaps")
    folder.mkdir(parents=True, exist_ok=True)

    def kept(page: Page, name: str) -> None:
        page.screenshot(path=folder / f"{name}.png")

    return kept


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with an empty library, in a process of its own."""
    made = Studio(tmp_path / "library")
    made.start()
    yield made
    made.stop()


@pytest.fixture
def visit(chromium: Browser, studio: Studio) -> Iterator[Callable[[], Page]]:
    """Open the page, each time as somebody else; its errors, and requests to elsewhere, fail the test."""
    errors: list[str] = []
    contexts = []

    def foreign(url: str) -> None:
        if not url.startswith((studio.address, studio.address.replace("http", "ws"), "data:", "blob:")):
            errors.append(f"the page asks for {url}")

    def opened() -> Page:
        context = chromium.new_context(viewport={"width": 1280, "height": 800})
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: foreign(request.url))
        page.goto(studio.address)
        page.get_by_role("heading", name="Understudy").wait_for()
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not errors, errors
