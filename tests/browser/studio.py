"""The studio as a process that can be stopped, killed and started again."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

READY = re.compile(r"The (?:studio|recording|drive) is at (http://\S+)")


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
