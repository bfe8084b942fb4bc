"""A test run that is killed leaves no process behind."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TEST = """
import os, subprocess, sys
from tests.processes import end_with_tests

def test_waits():
    child = subprocess.Popen(end_with_tests([sys.executable, "-c", "import signal; signal.pause()"]))
    with open({pipe!r}, "w") as pipe:
        print(os.getpid(), child.pid, file=pipe, flush=True)
    child.wait()
"""


@pytest.mark.timed
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a process that its parent ended")
def test_a_killed_run_leaves_no_process(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "conftest.py").write_text("from tests.conftest import pytest_configure\n")
    (tmp_path / "test_that_waits.py").write_text(TEST.format(pipe=str(pipe)))
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-n",
        "1",
        "-p",
        "no:cacheprovider",
        "-c",
        os.devnull,
        str(tmp_path),
    ]
    given = {**os.environ, "PYTHONPATH": os.pathsep.join((str(ROOT), *sys.path))}
    run = subprocess.Popen(command, cwd=tmp_path, env=given, stdout=subprocess.DEVNULL)
    with pipe.open() as file:
        worker, child = (int(word) for word in file.readline().split())
    descriptors = [os.pidfd_open(each) for each in (worker, child)]
    run.send_signal(signal.SIGKILL)
    run.wait()
    for descriptor in descriptors:  # it can be read once the process has ended
        assert select_ended(descriptor)
        os.close(descriptor)


def select_ended(descriptor: int) -> bool:
    """Wait until a process has ended, for a minute at most."""
    return bool(select.select([descriptor], [], [], 60.0)[0])
