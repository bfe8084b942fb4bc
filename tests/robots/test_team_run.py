"""`understudy run --team` in a terminal, on simulated robots: armed, run, recorded, decided again."""

from __future__ import annotations

import json
import os
import pty
import subprocess
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("mujoco", reason="needs the extra mujoco")

from tests.processes import end_with_tests
from tests.robots.agent_processes import (
    BOUND_S,
    COMMAND,
    ROBOTS,
    save_patrol,
    simulate_patrol,
    wait_until,
)
from tests.robots.domains import own_domain
from tests.ui.cli.commands import run_json

from understudy.records.reader import read_recording

DOMAIN = own_domain()


class Terminal:
    """The command in a terminal of its own; what it prints on standard output is kept."""

    def __init__(self, *arguments: object) -> None:
        self.here, there = pty.openpty()
        command = [*COMMAND, *map(str, arguments)]
        self.process = subprocess.Popen(
            end_with_tests(command), stdin=there, stderr=there, stdout=subprocess.PIPE, text=True
        )
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
        output, _ = self.process.communicate(timeout=BOUND_S)
        assert self.process.returncode == 0, self.shown
        return output

    def close(self) -> None:
        """End it, if it runs still."""
        if self.process.poll() is None:
            self.process.terminate()
            self.process.wait(BOUND_S)
        os.close(self.here)


def run_armed(team: Path, library: Path, act: Callable[[Terminal], None], *options: object) -> Any:
    """Run the coordinator's automaton, armed by a person, and return what `--json` says."""
    command = ["run", "--team", team, "-l", library, "--behavior", "collective_patrol", "--json"]
    with ExitStack() as ends:
        terminal = Terminal(*command, *options)
        ends.callback(terminal.close)
        terminal.wait_for("Type arm and Enter")
        terminal.type("arm\n")
        act(terminal)
        return json.loads(terminal.finish())


def press_when_dispersed(terminal: Terminal) -> None:
    terminal.wait_for("disperse")
    terminal.type("x")


@pytest.mark.long
@pytest.mark.timed
def test_a_team_is_run_in_a_terminal_recorded_and_decided_again(tmp_path: Path) -> None:
    """Until any key stops its robots, or its time is over."""
    record, library = tmp_path / "run.mcap", tmp_path / "library"
    save_patrol(library)
    with simulate_patrol(tmp_path / "files", DOMAIN, robots=2) as team:
        told = run_armed(team, library, press_when_dispersed, "--record", record)
        assert told["robots"] == [*ROBOTS[:2]]
        assert told["ended"] == "stopped by a key"
        timed = run_armed(team, library, lambda terminal: None, "--no-record", "--seconds", 1)
        assert timed["ended"] == "its time is over"
        assert timed["ticks"] > 0
        assert not list(team.parent.glob("recordings/*"))
    recording = read_recording(record)
    assert told["ticks"] == recording.ticks
    assert {path[0] for path in recording.records[0].states} == {"patrol", "disperse"}
    again = run_json("run", "--replay", record)
    assert (again["decisions"], again["differences"]) == (2 * recording.ticks, [])
    assert len(run_json("why", record, "--agent", 1, "--time", 1.0)["agents"]) == 2
