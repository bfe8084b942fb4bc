"""Takes the pictures of the documents at the real page: `python -m tests.browser.pictures`."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright
from tests.browser.conftest import NAMES, QUIET
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

PICTURES = Path(__file__).parents[2] / "docs" / "pictures"


def main() -> None:
    """A lesson of goto, and the page as it tests what it learned."""
    found = next(path for name in NAMES if (path := shutil.which(name)))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        studio = Studio(Path(folder) / "library")
        studio.start()
        browser = playwright.chromium.launch(executable_path=found, args=list(QUIET))
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(studio.address)
        teacher = Teacher(page)
        teacher.begin_goto()
        for world in range(3):
            if world:
                teacher.new_world()
            teacher.show_the_way()
        teacher.new_world()
        teacher.press("t")
        page.wait_for_timeout(5_500)
        page.screenshot(path=PICTURES / "studio.png")
        browser.close()
        studio.stop()


if __name__ == "__main__":
    main()
