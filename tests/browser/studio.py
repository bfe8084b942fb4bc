"""The studio as a process that can be stopped, killed and started again."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page

READY = re.compile(r"The (?:studio is|recording is|recordings are|drive is) at (http://\S+)")


class Studio:
    """`understudy studio` on a library."""

    def __init__(self, library: Path, *what: str) -> None:
        """`what` is a scenario, forage if left out, or options such as a robot's file."""
        self.library, self._what = library, what or ("forage",)
        self.address = ""
        self._port = "0"
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Start it, on the same port as before, and wait until it says where it is."""
        command = [sys.executable, "-m", "understudy.ui.cli", "studio", *self._what, "--no-browser"]
        options = ["--library", str(self.library), "--port", self._port]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self._process = subprocess.Popen(
            [*command, *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
        )
        assert self._process.stdout is not None
        said = []
        for line in self._process.stdout:
            said.append(line)
            if found := READY.search(line):
                self.address = found[1]
                self._port = self.address.rstrip("/").rsplit(":", 1)[1]
                return
        raise AssertionError("the studio did not start: " + "".join(said))

    def stop(self) -> None:
        """Ask it to end, as the system does."""
        self._end(signal.SIGTERM)

    def kill(self) -> None:
        """End it at once."""
        self._end(signal.SIGKILL)

    def _end(self, how: signal.Signals) -> None:
        if self._process is not None:
            self._process.send_signal(how)
            self._process.wait(20)
            assert self._process.stdout is not None
            self._process.stdout.close()
            self._process = None


@contextmanager
def open_drive_page(chromium: Browser, library: Path, *what: str) -> Iterator[Page]:
    """The page of a recording or of a drive, in a studio of its own; errors of the page fail."""
    studio = Studio(library, *what)
    studio.start()
    errors: list[str] = []
    try:
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(studio.address)
        yield page
        assert not errors
    finally:
        studio.stop()


def find_strip(page: Page) -> Locator:
    """The labels over time."""
    return page.get_by_role("group", name="Labels over time")


def list_labels(page: Page) -> list[tuple[str, int]]:
    """The labels of the spans on the timeline, each with its first tick."""
    return [
        (str(each.get_attribute("data-label")), int(each.get_attribute("data-first") or -1))
        for each in find_strip(page).locator(".span").all()
    ]
