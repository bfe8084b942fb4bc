"""JupyterLab as a process, with a folder of notebooks and no settings but those of the test."""

from __future__ import annotations

import json
import os
import re
import secrets
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from urllib.request import urlopen

from playwright.sync_api import Locator, Page, TimeoutError, expect
from tests.browser.studio_forks import end_with_parent
from tests.browser.window import wait_until

READY = re.compile(r"(http://127\.0\.0\.1:\d+)/lab")
STARTS, START_S = 3, 60.0
"""How often it is started, and how long each start may take."""
QUIET = {
    "notification": {"fetchNews": "false", "checkForUpdates": False},
    "themes": {"theme": "JupyterLab Light"},
}
"""Settings of JupyterLab, so that it asks nothing of other hosts."""
STARTED, DROPPED = "[*]:", "[ ]:"
"""What stands beside a cell that runs, and beside one that never did."""


class Jupyter:
    """A JupyterLab on a port of its own, which only knows the token of these tests."""

    def __init__(self, folder: Path, **settings: dict[str, object]) -> None:
        """`folder` is for the notebooks; `settings` are those of JupyterLab's plugin for its application."""
        self._root, self._settings = folder, {**QUIET, **settings}
        self.folder = folder
        self.address, self.token = "", secrets.token_hex(16)
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start it, and wait until it listens."""
        own = self._root / ".jupyter"
        plugins = own / "settings" / "@jupyterlab" / "apputils-extension"
        plugins.mkdir(parents=True, exist_ok=True)
        for name, values in self._settings.items():
            (plugins / f"{name}.jupyterlab-settings").write_text(json.dumps(values), encoding="utf-8")
        places = {
            "JUPYTER_CONFIG_DIR": own / "config",
            "JUPYTER_DATA_DIR": own / "data",
            "JUPYTER_RUNTIME_DIR": own / "runtime",
            "JUPYTERLAB_SETTINGS_DIR": own / "settings",
            "JUPYTERLAB_WORKSPACES_DIR": own / "workspaces",
            "IPYTHONDIR": own / "ipython",
        }
        options = (
            "--no-browser", "--allow-root", "--ServerApp.ip=127.0.0.1", "--ServerApp.port=0",
            f"--ServerApp.root_dir={self._root}", f"--IdentityProvider.token={self.token}",
            "--LabApp.extension_manager=readonly",
        )  # fmt: skip
        environment = {**os.environ, **{name: str(path) for name, path in places.items()}}
        for _ in range(STARTS):  # between picking a free port and listening there, another may take it
            with self._log.open("wb") as log:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "jupyterlab", *options],
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    env=environment,
                    preexec_fn=end_with_parent,
                )
            if self._wait_until_it_listens(self._process):
                return
        raise AssertionError("JupyterLab did not start: " + self._log.read_text("utf-8", errors="replace"))

    def _wait_until_it_listens(self, process: subprocess.Popen[bytes]) -> bool:
        """Tell whether it listens, which it does some time after it says where."""
        end = time.monotonic() + START_S
        while process.poll() is None and time.monotonic() < end:
            if found := READY.search(self._log.read_text("utf-8", errors="replace")):
                self.address = found[1]
                with suppress(OSError), urlopen(f"{self.address}/api/status?token={self.token}", timeout=5):
                    return True  # by its token: not another program that took its port
            with suppress(subprocess.TimeoutExpired):
                process.wait(0.05)
        self.stop()
        return False

    @property
    def _log(self) -> Path:
        return self._root / ".jupyter.log"

    def begin(self, name: str) -> None:
        """Let the notebooks be in a folder of this name from here on."""
        self.folder = self._root / name
        self.folder.mkdir()

    def open(self, page: Page, notebook: str) -> Notebook:
        """Open a notebook, and wait until its kernel is there."""
        page.goto(self.url(notebook))
        return Notebook(page)

    def url(self, notebook: str) -> str:
        """The address of a notebook alone, without the list of files."""
        return f"{self.address}/doc/tree/{self.folder.relative_to(self._root) / notebook}?token={self.token}"

    def restart_kernels(self, page: Page) -> None:
        """End all kernels, and start others in their place."""
        for kernel in self._list_kernels(page):
            page.request.post(f"{self.address}/api/kernels/{kernel['id']}/restart", headers=self._access)
        wait_until(page, lambda: all(each["execution_state"] == "idle" for each in self._list_kernels(page)))

    def end_kernels(self, page: Page) -> None:
        """End all kernels."""
        for kernel in self._list_kernels(page):
            page.request.delete(f"{self.address}/api/kernels/{kernel['id']}", headers=self._access)

    @property
    def _access(self) -> dict[str, str]:
        return {"Authorization": f"token {self.token}"}

    def _list_kernels(self, page: Page) -> list[dict[str, str]]:
        kernels: list[dict[str, str]] = page.request.get(
            f"{self.address}/api/kernels", headers=self._access
        ).json()
        return kernels

    def stop(self) -> None:
        """Ask it to end, as the system does, with its kernels."""
        if self._process is None:
            return
        self._process.send_signal(signal.SIGTERM)
        self._process.wait(30)
        self._process = None


class Notebook:
    """A notebook that is open in a page, from which its cells are run."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.cells = page.locator(".jp-Notebook .jp-Cell")
        self.widget = page.locator(".understudy")
        self.wait_for_kernel()

    def wait_for_kernel(self) -> None:
        """Wait until the kernel is idle."""
        expect(self.page.locator('.jp-Notebook-ExecutionIndicator[data-status="idle"]')).to_be_attached()

    def start(self, cell: int) -> None:
        """Start a cell, counted from 0; right after loading, the notebook takes no keys yet, or drops what it began."""
        prompt = self.cells.nth(cell).locator(".jp-InputPrompt")
        before = prompt.inner_text()
        for _ in range(20):
            self._accept_dialog()
            with suppress(TimeoutError):  # if the dialog comes only now
                self.cells.nth(cell).locator(".cm-content").click(timeout=3_000)
            self.page.keyboard.press("Control+Enter")
            waits = "|".join(re.escape(each) for each in (before, STARTED, DROPPED))
            with suppress(AssertionError):
                expect(prompt).not_to_have_text(re.compile(f"^({waits})$"), timeout=1_000)
                return
            if prompt.inner_text() == STARTED:
                return
        raise AssertionError(f"cell {cell} does not start")

    def _accept_dialog(self) -> None:
        """Accept what JupyterLab asks or says on a busy machine, such as which kernel it is to start."""
        dialog = self.page.locator(".jp-Dialog").first
        if dialog.is_visible():
            sys.stderr.write(f"JupyterLab: {dialog.inner_text()}\n")
            dialog.locator(".jp-mod-accept").click()

    def run(self, cell: int) -> None:
        """Run a cell to its end."""
        self.start(cell)
        prompt = self.cells.nth(cell).locator(".jp-InputPrompt")
        expect(prompt).to_have_text(re.compile(r"\[\d+\]"))

    def read(self, cell: int) -> str:
        """Run a cell, and return what it prints."""
        self.run(cell)
        printed = self.cells.nth(cell).locator(".jp-OutputArea-output")
        expect(printed).not_to_have_count(0)
        expect(printed.first).not_to_have_text("")
        return "\n".join(printed.all_text_contents()).strip()

    def state(self, name: str) -> Locator:
        """The button of a state."""
        return self.widget.locator(f'.states [data-state="{name}"]')

    def read_value(self, label: str) -> float:
        """The number that a reading shows."""
        text = self.widget.locator(".readings div", has_text=label).locator("dd").inner_text()
        return float(text.replace("−", "-").rstrip("°m "))


def write_notebook(path: Path, *cells: str) -> None:
    """Write a notebook of code cells."""
    made: list[dict[str, object]] = [
        {"cell_type": "code", "id": f"cell-{number}", "source": source, "metadata": {}, "outputs": [],
         "execution_count": None}
        for number, source in enumerate(cells)
    ]  # fmt: skip
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    content = {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    path.write_text(json.dumps(content), encoding="utf-8")
