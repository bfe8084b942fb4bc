"""Worker processes end with the program that uses them, even if it is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.processes import end_with_tests

KILLED = """
import os, signal
from understudy.analysis.process_pool import open_process_pool
with open_process_pool(2) as pool:
    print(pool.submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills with SIGKILL")
def test_workers_end_with_a_killed_program() -> None:
    """They have the standard output that is read here, so that it ends only with the last of them."""
    path = str(Path(__file__).parents[2] / "src")
    done = subprocess.run(
        end_with_tests([sys.executable, "-c", KILLED]),
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert int(done.stdout) > 0
