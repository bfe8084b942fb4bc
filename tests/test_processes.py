"""Processes end with the tests that started them, even if those are killed."""

from __future__ import annotations

import select
import subprocess
import sys
from pathlib import Path

import pytest
from tests.processes import end_with_tests

BOUND_S = 60.0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a process that its parent ended")
def test_a_killed_run_leaves_no_process() -> None:
    """Although what it started reads a pipe that stays open."""
    read = "import sys; print('ready', flush=True); sys.stdin.read()"
    start = f"import subprocess; subprocess.run({end_with_tests([sys.executable, '-c', read])!r}, check=True)"
    with subprocess.Popen(
        [sys.executable, "-c", start], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "ready\n"
        run.kill()
        assert select.select([run.stdout], [], [], BOUND_S)[0]  # closed by the end of all that write to it
        assert run.stdout.read() == ""


def test_a_command_keeps_its_words(tmp_path: Path) -> None:
    command = end_with_tests([sys.executable, "-c", "import sys; print(sys.argv[1:])", "--", tmp_path, "-x"])
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert said == f"{['--', str(tmp_path), '-x']}\n"
