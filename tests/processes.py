"""Processes that tests start and that end with the test run, even if it is killed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path

IF_NOT_LEFT = '[ "$PPID" = "$0" ] && exec "$@"'
"""Runs a command unless the tests have ended before the kernel was asked to tell of that."""


def end_with_tests(command: Sequence[str | Path]) -> list[str]:
    """Extend a command so that the kernel kills what it starts when the thread that started it ends.

    The process keeps its id, and may be given to `subprocess.Popen` or `run` with any options. Start it from the main
    thread of the tests, or from one that outlives it. Its own children are not killed: they have to notice that it
    ended. Without `setpriv` (util-linux, so Linux only) the command is returned as it is.
    """
    words = [str(word) for word in command]
    setpriv = shutil.which("setpriv")
    if setpriv is None:
        return words
    return [setpriv, "--pdeathsig", "KILL", "--", "sh", "-c", IF_NOT_LEFT, str(os.getpid()), *words]
