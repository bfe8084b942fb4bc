"""`understudy teach` itself: in a real pseudo-terminal, killed and resumed; what it refuses."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.processes import end_with_tests
from tests.ui.cli.commands import run

GOTO = (
    "--parameters", "A", "--states", "forward,rotate_left,rotate_right", "--flags", "done",
    "--features", "distance_to(A),angle_to(A)", "--targets", "A=station",
)  # fmt: skip
ESCAPES = re.compile(rb"\x1b(\[[0-9;?<>=:]*[a-zA-Z]|[PX^_\]].*?(\x07|\x1b\\)|.)", re.DOTALL)
LONGEST_S = 60.0


class Terminal:
    """A process at a pseudo-terminal of 80 x 24."""

    def __init__(self, *arguments: str) -> None:
        self._ours, theirs = pty.openpty()
        termios.tcsetwinsize(theirs, (24, 80))
        self.process = subprocess.Popen(
            end_with_tests([sys.executable, "-m", "understudy.ui.cli", *arguments]),
            stdin=theirs, stdout=theirs, stderr=theirs, close_fds=True, start_new_session=True,
            env={**os.environ, "TERM": "xterm-256color", "COLORTERM": "", "PYTHONWARNINGS": "default"},
        )  # fmt: skip
        os.close(theirs)
        self.read_part = b""

    def press(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def _read(self, timeout_s: float) -> bool:
        if not select.select([self._ours], [], [], timeout_s)[0]:
            return False
        try:
            read = os.read(self._ours, 65536)
        except OSError:  # it ended
            return False
        self.read_part += read
        return bool(read)

    def until(self, text: str) -> None:
        """Wait until this was shown since the last such wait."""
        limit = time.monotonic() + LONGEST_S
        while text not in self.text:
            self._read(0.1)
            if time.monotonic() > limit or (self.process.poll() is not None and text not in self.text):
                raise AssertionError(f"{text!r} was not shown in {self.text[-3000:]!r}")
        self.read_part = b""

    @property
    def text(self) -> str:
        return " ".join(ESCAPES.sub(b"", self.read_part).decode(errors="replace").split())

    def end(self) -> int:
        """Wait for its end."""
        limit = time.monotonic() + LONGEST_S
        while self.process.poll() is None and time.monotonic() < limit:
            self._read(0.05)
        while self._read(0.0):
            pass
        return self.process.wait(LONGEST_S)

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        os.close(self._ours)


@contextmanager
def terminal(*arguments: str) -> Iterator[Terminal]:
    opened = Terminal(*arguments)
    try:
        yield opened
    finally:
        opened.close()


@pytest.mark.timed
def test_it_teaches_in_a_terminal_survives_a_kill_and_saves(tmp_path: Path) -> None:
    library = str(tmp_path / "library")
    with terminal("teach", "goto", "--library", library, *GOTO) as first:
        first.until("No examples yet")
        first.press("\x1b[D")  # the left arrow
        first.until("with its default")
        first.process.send_signal(signal.SIGKILL)
        first.end()
    with terminal("teach", "goto", "--library", library, *GOTO) as second:
        second.until("resume it")
        second.press("\r")
        second.until("The lesson is restored")
        second.press(" 1")
        second.until("with its default")
        second.press("s")
        second.until("Saved in")
        second.press("q")
        assert second.end() == 0
        assert "goto is in" in second.text
        assert "with 4 examples" in second.text
    assert (tmp_path / "library" / "goto.json").exists()


def test_it_needs_a_terminal(tmp_path: Path) -> None:
    result = run("teach", "goto", "--library", tmp_path / "library", *GOTO)
    assert result.exit_code == 2
    assert "is not a terminal; run it in one (ssh -t HOST" in " ".join(result.stderr.split())
    assert not (tmp_path / "library").exists()


BAD = [
    (("--states", "fly"), "no behavior 'fly'"),
    (("--targets", "A"), "'A' is not a binding; write PARAMETER=TARGET"),
    (("--states", "forward(A", "--features", "food_left"), "is not a name"),
    (("--world", "moon"), "no world 'moon'; it has arena, boxes, forage"),
    (("--parameters", "station"), "has the name of a target"),
]


@pytest.mark.parametrize(("arguments", "problem"), BAD)
def test_bad_arguments_end_before_anything_is_begun(
    tmp_path: Path, arguments: tuple[str, ...], problem: str
) -> None:
    result = run("teach", "goto", "--library", tmp_path / "library", *arguments)
    assert result.exit_code == 2
    assert problem in " ".join(result.stderr.split())
    assert not (tmp_path / "library").exists()
