"""Chromium and its windows: one browser for all tests of a worker, and for each page a context of its own."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any

from playwright.sync_api import Browser, Page, Playwright, ViewportSize, expect

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""Where Chromium may be; the shell without windows takes a third of the work of a browser with them."""
SNAPS = "UNDERSTUDY_SNAPS"
"""The variable that names a folder for what pages looked like."""
QUIET = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
WINDOW: ViewportSize = {"width": 1280, "height": 800}
"""The window of a person at a desk."""
PATIENCE_MS = 180_000
"""How long a test waits for a state before it fails: a bound for busy machines, never what is tested."""
COARSE = 0.5
"""Pixels of the screen for each of the layout's, where nobody looks at the picture: a quarter of the work."""
LOOK_MS = 30
"""How long to wait between two looks at a page for what is no state of one element."""
FRAME_MS = 100
FRAME_OF_TEST_MS = 4
SLOW_SCREEN = """(() => {
const later = window.setTimeout;
window.requestAnimationFrame = (draw) => later(() => draw(performance.now()), FRAME_MS);
window.cancelAnimationFrame = clearTimeout;
if (PROMPT) window.setTimeout = (call, ms, ...given) => later(call, (ms ?? 0) <= 100 ? 4 : ms, ...given);
})()"""
"""A screen that shows few frames a second: drawn by the processor, they are the largest cost of these tests.

For tests that move the clock, and wait until the page shows that, it shows all at once.
"""


def find_chromium() -> str | None:
    """Find the system's Chromium."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def launch(playwright: Playwright, path: str) -> Browser:
    """Start Chromium."""
    expect.set_options(timeout=PATIENCE_MS)
    return playwright.chromium.launch(executable_path=path, args=list(QUIET))


def wait_until(page: Page, is_so: Callable[[], object]) -> None:
    """Look at a page until something is so."""
    until = monotonic() + PATIENCE_MS / 1e3
    while not is_so():
        assert monotonic() < until, f"not so within {PATIENCE_MS / 1e3:.0f} s"
        page.wait_for_timeout(LOOK_MS)


@contextmanager
def open_page(
    chromium: Browser,
    address: str,
    *,
    fine: bool = False,
    prompt: bool = False,
    script: str = "",
    **options: Any,
) -> Iterator[Page]:
    """Open a page as another person; its errors, and requests to elsewhere, fail the test.

    Pages are drawn coarsely, but not for a test that looks at pixels (`fine`), and seldom, unless pictures are kept.
    A `script` runs first in the page; `options` are those of the context.
    """
    errors: list[str] = []
    if not (fine or SNAPS in os.environ):
        options.setdefault("device_scale_factor", COARSE)
    options.setdefault("viewport", WINDOW)
    options.setdefault("reduced_motion", "reduce")
    context = chromium.new_context(**options)
    context.set_default_timeout(PATIENCE_MS)
    if SNAPS not in os.environ:
        frame, shown = (FRAME_OF_TEST_MS, "true") if prompt else (FRAME_MS, "false")
        context.add_init_script(SLOW_SCREEN.replace("FRAME_MS", str(frame)).replace("PROMPT", shown))
    if script:
        context.add_init_script(script)
    page = context.new_page()

    def check(url: str) -> None:
        if not url.startswith((address, address.replace("http", "ws"), "data:", "blob:")):
            errors.append(f"the page asks for {url}")

    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: check(request.url))
    try:
        page.goto(address)
        yield page
    finally:
        context.close()
    assert not errors, errors
