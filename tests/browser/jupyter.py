"""JupyterLab as a process, with a folder of notebooks and no settings but those of the test."""

from __future__ import annotations

import json
import os
import re
import secrets
import signal
import subprocess
import sys
from pathlib import Path

READY = re.compile(r"(http://127\.0\.0\.1:\d+)/lab")
QUIET = {
    "notification": {"fetchNews": "false", "checkForUpdates": False},
    "themes": {"theme": "JupyterLab Light"},
}
"""Settings of JupyterLab, so that it asks nothing of other hosts."""


class Jupyter:
    """A JupyterLab on a port of its own, which only knows the token of this test."""

    def __init__(self, folder: Path, **settings: dict[str, object]) -> None:
        """`folder` holds the notebooks; `settings` are those of JupyterLab's plugin for its application."""
        self.folder, self._settings = folder, {**QUIET, **settings}
        self.address, self.token = "", secrets.token_hex(16)
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Start it, and wait until it says where it is."""
        own = self.folder / ".jupyter"
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
            f"--ServerApp.root_dir={self.folder}", f"--IdentityProvider.token={self.token}",
            "--LabApp.extension_manager=readonly",
        )  # fmt: skip
        self._process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, **{name: str(path) for name, path in places.items()}},
        )
        assert self._process.stdout is not None
        said = []
        for line in self._process.stdout:
            said.append(line)
            if found := READY.search(line):
                self.address = found[1]
                return
        raise AssertionError("JupyterLab did not start: " + "".join(said))

    def url(self, notebook: str) -> str:
        """The address of a notebook alone, without the list of files."""
        return f"{self.address}/doc/tree/{notebook}?token={self.token}"

    def stop(self) -> None:
        """Ask it to end, as the system does, with its kernels."""
        if self._process is None:
            return
        assert self._process.stdout is not None
        self._process.send_signal(signal.SIGTERM)
        for _ in self._process.stdout:  # what it says must go somewhere, or it waits
            pass
        self._process.wait(30)
        self._process.stdout.close()
        self._process = None
