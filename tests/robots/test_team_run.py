"""`understudy run --team` in a terminal, on simulated robots: armed, run, recorded, decided again."""

from __future__ import annotations

import json
import os
import pty
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from tests.robots.agent_processes import COMMAND, wait_until
from tests.robots.test_live_run import save_library
from tests.ui.cli.commands import said

from understudy.robots.recording.reader import read_recording

pytestmark = [pytest.mark.long, pytest.mark.timed]
DOMAIN = 64
PATIENCE_S = 60.0


class Terminal:
    """The command in a terminal of its own; what it prints on standard output is kept."""

    def __init__(self, *arguments: object) -> None:
        self.here, there = pty.openpty()
        command = [*COMMAND, *map(str, arguments)]
        self.process = subprocess.Popen(command, stdin=there, stderr=there, stdout=subprocess.PIPE, text=True)
        os.close(there)
        self.shown = ""
        self._reading = Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        """Read what the terminal shows: a full one would hold up the command."""
        with suppress(OSError):  # it has ended
            while True:
                self.shown += os.read(self.here, 4096).decode(errors="replace")

    def wait_for(self, text: str) -> None:
        """Wait until the terminal has shown a text."""
        wait_until(lambda: text in self.shown, f"{text!r} was never shown")

    def type(self, text: str) -> None:
        """Type a text."""
        os.write(self.here, text.encode())

    def finish(self) -> str:
        """Return its standard output when it has ended."""
        output, _ = self.process.communicate(timeout=PATIENCE_S)
        assert self.process.returncode == 0, self.shown
        return output

    def close(self) -> None:
        """End it, if it runs still."""
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(20.0)
        os.close(self.here)


@pytest.fixture
def team(tmp_path: Path) -> Iterator[Path]:
    """The file of four simulated robots, beside a library."""
    save_library(tmp_path / "library")
    command = [*COMMAND, "robots", "simulate", "patrol", "--domain", str(DOMAIN), "--rate", "10"]
    file = tmp_path / "files" / "team.toml"
    simulated = subprocess.Popen(
        [*command, "--write-files", str(file.parent)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        wait_until(file.is_file, "the simulated robots never came")
        yield file
    finally:
        simulated.terminate()
        simulated.wait(20.0)


def run_armed(team: Path, act: Callable[[Terminal], None], *options: object) -> Any:
    """Run the coordinator's automaton, armed by a person, and return what `--json` says."""
    with ExitStack() as ends:
        library = team.parent.parent / "library"
        terminal = Terminal("run", "--team", team, "-l", library, "--behavior", "lead", "--json", *options)
        ends.callback(terminal.close)
        terminal.wait_for("Type arm and Enter")
        terminal.type("arm\n")
        act(terminal)
        return json.loads(terminal.finish())


def test_a_team_is_run_recorded_and_decided_again(team: Path, tmp_path: Path) -> None:
    record = tmp_path / "run.mcap"
    told = run_armed(team, lambda terminal: None, "--seconds", 8, "--record", record)
    assert told["robots"] == [f"pioneer_{number}" for number in range(1, 5)]
    assert told["ended"] == "its time is over"
    assert told["ticks"] >= 40
    recording = read_recording(record)
    assert {path[0] for path in recording.paths[0]} == {"walk", "left"}
    again = said("run", "--replay", record)
    assert (again["decisions"], again["differences"]) == (4 * recording.ticks, [])
    assert len(said("why", record, "--agent", 3, "--time", 3.0)["agents"]) == 2


def test_any_key_stops_the_robots(team: Path) -> None:
    def press(terminal: Terminal) -> None:
        terminal.wait_for("walk")
        terminal.type("x")

    told = run_armed(team, press, "--no-record")
    assert told["ended"] == "stopped by a key"
    assert not list(team.parent.glob("recordings/*"))
