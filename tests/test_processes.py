"""Processes end with the tests that started them, even if those are killed."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.processes import end_with_tests

ROOT = Path(__file__).parents[1]
BOUND_S = 60.0
TEST = """
import os, subprocess, sys
from tests.processes import end_with_tests

def test_waits():
    child = subprocess.Popen(end_with_tests([sys.executable, "-c", "import signal; signal.pause()"]))
    with open({pipe!r}, "w") as pipe:
        print(os.getpid(), child.pid, file=pipe, flush=True)
    child.wait()
"""


ON_LINUX = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux tells a process that its parent ended"
)


@ON_LINUX
def test_a_killed_program_leaves_no_process() -> None:
    """Although what it started reads a pipe that stays open."""
    read = "import sys; print('ready', flush=True); sys.stdin.read()"
    start = "import subprocess; from tests.processes import end_with_tests; "
    start += f"subprocess.run(end_with_tests([{sys.executable!r}, '-c', {read!r}]), check=True)"
    with subprocess.Popen(
        [sys.executable, "-c", start], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
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


@ON_LINUX
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
        assert select.select([descriptor], [], [], BOUND_S)[0]
        os.close(descriptor)
