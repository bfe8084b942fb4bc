"""The studio as a process that can be stopped, killed and started again."""

from __future__ import annotations

import atexit
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TextIO

import msgspec
from playwright.sync_api import Browser, Locator, Page
from tests.browser.shared_clock import SharedClock
from tests.browser.studio_forks import End, Start
from tests.browser.window import open_page

from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.storage.library_folder import open_library

READY = re.compile(r"The (?:studio is|recording is|recordings are|drive is) at (http://\S+)")


def find_clock(library: Path) -> Path:
    """Return the file of the clock of a studio with a library."""
    return library.with_suffix(".clock")


class Studio:
    """`understudy studio` on a library."""

    def __init__(self, library: Path, *what: str, clock: bool = False, scores: bool = False) -> None:
        """`what` is a scenario, forage if left out, or options such as a robot's file.

        With a `clock`, time passes in the world only when the test says so. With `scores`, what is trained is run in
        new worlds after each press.
        """
        self.library, self._what, self._scores = library, what or ("forage",), scores
        self.address = ""
        self.clock = SharedClock(find_clock(library)) if clock else None
        self._port = "0"
        self._process = 0
        self._said: TextIO | None = None

    def start(self) -> None:
        """Start it, on the same port as before, and wait until it says where it is."""
        options = ["--no-browser", "--library", str(self.library), "--port", self._port]
        clock = find_clock(self.library) if self.clock else ""
        self._process, self._said = start_forks().start(
            ["studio", *self._what, *options], str(clock), self._scores
        )
        said = []
        for line in self._said:
            said.append(line)
            if found := READY.search(line):
                self.address = found[1]
                self._port = self.address.rstrip("/").rsplit(":", 1)[1]
                return
        self.kill()
        raise AssertionError("the studio did not start: " + "".join(said))

    def wait_until_open(self, page: Page) -> None:
        """Wait until a page can be used."""
        page.get_by_role("heading", name="Understudy").wait_for()

    def list_automata(self, page: Page) -> set[str]:
        """List the automata of the library, whatever the page shows."""
        scenario = find_scenario(self._what[0])
        return set(open_library(self.library, make_scenario_kit(scenario)).library.taught)

    def stop(self) -> None:
        """Ask it to end, as the system does."""
        self._end(signal.SIGTERM)

    def kill(self) -> None:
        """End it at once."""
        self._end(signal.SIGKILL)

    def _end(self, how: signal.Signals) -> None:
        if self._said is not None:
            ended = start_forks().end(self._process, how)
            self._said.close()
            self._said = None
            assert ended >= 0, "the studio did not end"


class StudioForks:
    """The process whose forks are studios: it has imported everything once."""

    def __init__(self) -> None:
        self._environment = dict(os.environ)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.browser.studio_forks"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=Path(__file__).parents[2],
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        self._hear("ready")

    def start(self, arguments: list[str], clock: str, scores: bool) -> tuple[int, TextIO]:
        """Start a command in the folder and environment of the test; return its process and what it prints."""
        changed = {name: value for name, value in os.environ.items() if self._environment.get(name) != value}
        path = [each for each in os.environ.get("PYTHONPATH", "").split(os.pathsep) if each]
        with TemporaryDirectory() as folder:
            pipe = Path(folder) / "said"
            os.mkfifo(pipe)
            said = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
            process = self._ask(Start(arguments, str(pipe), str(Path.cwd()), path, changed, clock, scores))
        os.set_blocking(said, True)
        return process, os.fdopen(said)

    def end(self, process: int, how: signal.Signals) -> int:
        """Send a studio a signal, and return its wait status, or -1 if it had to be killed."""
        return self._ask(End(process, how))

    def close(self) -> None:
        """End all studios."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()

    def _ask(self, request: Start | End) -> int:
        assert self._process.stdin is not None
        self._process.stdin.write(msgspec.json.encode(request) + b"\n")
        self._process.stdin.flush()
        return int(self._hear(r"-?\d+"))

    def _hear(self, expected: str) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline().decode().strip()
        assert re.fullmatch(expected, line), f"the process of studios said {line!r}"
        return line


@cache
def start_forks() -> StudioForks:
    """Start the process of studios, once; it ends with this one."""
    made = StudioForks()
    atexit.register(made.close)
    return made


@contextmanager
def open_studio(
    chromium: Browser, library: Path, *what: str, clock: bool = False, **options: Any
) -> Iterator[Page]:
    """Open the page of a studio of its own; `options` are those of the page."""
    studio = Studio(library, *what, clock=clock)
    studio.start()
    try:
        with open_page(chromium, studio.address, **options) as page:
            yield page
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
