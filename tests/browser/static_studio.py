"""The studio as static files, served by a server that knows nothing of it."""

from __future__ import annotations

import fcntl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache, partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from threading import Thread
from zipfile import ZipFile

import pytest
from playwright.sync_api import Page
from tests.browser.studio import Studio

ROOT = Path(__file__).parents[2]
TARGET = ROOT / "build" / "site-studio"
STAMP = ROOT / "build" / "site-studio.stamp"
SOURCES = ("src/understudy", "tools")
MISSING = 2
"""The exit code of the tool where a part or its headers cannot be had."""

both_places = pytest.mark.parametrize("place", ["served", "static"])
"""Runs a test with a studio that is served, and with one of static files."""


class StaticStudio(Studio):
    """The studio of static files; what a person teaches there is in the browser, and time is real."""

    def __init__(self) -> None:
        super().__init__(Path())
        self._server: ThreadingHTTPServer | None = None

    def start(self) -> None:
        """Serve the files, which are built first if they are not as their source; skip the test if that cannot be."""
        handler = partial(QuietHandler, directory=str(build_site()))
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.address = f"http://127.0.0.1:{self._server.server_port}/"
        Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()

    def stop(self) -> None:
        """End the server."""
        if self._server is not None:
            self._server.shutdown()
            self._server.server_close()

    def wait_until_open(self, page: Page) -> None:
        """Wait until Python runs in the page."""
        page.get_by_label("seed").wait_for()

    def list_automata(self, page: Page) -> set[str]:
        """List the automata of the library by the zip that the page offers."""
        page.get_by_role("tab", name="Library").click()
        with page.expect_download() as download:
            page.get_by_role("button", name="Export library").click()
        with ZipFile(BytesIO(Path(download.value.path()).read_bytes())) as archive:
            return {Path(name).stem for name in archive.namelist()}


class QuietHandler(SimpleHTTPRequestHandler):
    """Sends files, and prints nothing."""

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing."""


@cache
def build_site() -> Path:
    """Build the static files if their source has changed, and return their folder."""
    TARGET.parent.mkdir(exist_ok=True)
    with _lock(STAMP.with_suffix(".lock")):
        if not STAMP.is_file() or STAMP.read_text() != _describe_sources():
            command = [sys.executable, "tools/page_site.py", str(TARGET)]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
            if done.returncode == MISSING:
                pytest.skip(done.stderr.strip())
            assert done.returncode == 0, done.stderr
            STAMP.write_text(_describe_sources())
    return TARGET


def _describe_sources() -> str:
    files = (path for folder in SOURCES for path in sorted((ROOT / folder).rglob("*")))
    return "\n".join(
        f"{path} {path.stat().st_mtime_ns}"
        for path in files
        if path.is_file() and "__pycache__" not in path.parts
    )


@contextmanager
def _lock(path: Path) -> Iterator[None]:
    """Let one process at a time build."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
