"""A studio in a process of its own: killed at any moment, it loses nothing that it acknowledged."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from tests.make.studios import GOTO
from tests.processes import end_with_tests
from websockets.sync.client import ClientConnection, connect

LONGEST_S = 60.0
"""How long is waited for the process at most."""


@contextmanager
def run_studio(folder: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A studio, and its port."""
    code = "from understudy.ui.cli import run_command_line; run_command_line()"
    words = [sys.executable, "-c", code, "studio", "--library", str(folder), "--no-browser", "--port", "0"]
    command = end_with_tests(words)
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )
    try:
        assert process.stdout is not None
        said = process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)/", said)
        assert found, (said, process.stderr and process.stderr.read())
        yield process, int(found[1])
    finally:
        process.kill()
        process.communicate(timeout=LONGEST_S)


class Line:
    """A page on a real socket."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket, self.numbers = socket, count(1)
        self.news: dict[str, Any] = {}

    def say(self, do: str, **fields: Any) -> dict[str, Any]:
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "do": do, **fields}))
        while True:
            received = self.hear()
            if received.get("re") == number:
                return received

    def hear(self) -> dict[str, Any]:
        received = self.socket.recv(timeout=LONGEST_S)
        if isinstance(received, bytes):
            return {}
        said: dict[str, Any] = json.loads(received)
        if said.get("is") == "session":
            self.news = said
        return said


@contextmanager
def line(port: int) -> Iterator[Line]:
    with connect(f"ws://127.0.0.1:{port}/ws", max_size=None) as socket:
        yield Line(socket)


def wait_for_examples(person: Line, count: int) -> list[tuple[int, str, str]]:
    while not person.news.get("session") or len(person.news["session"]["examples"]) < count:
        person.hear()
    return [(each["number"], each["state"], each["next"]) for each in person.news["session"]["examples"]]


@pytest.mark.timed
def test_killed_in_the_middle_of_a_lesson(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    with run_studio(folder) as (process, port), line(port) as person:
        assert person.say(**GOTO)["ok"]
        person.say("pause", paused=True)
        for state in ("forward", "rotate_left"):
            assert person.say("press", state=state)["ok"]
            assert person.say("step")["ok"]
        before = wait_for_examples(person, 4)
        assert person.say("press", state="done")["ok"]  # acknowledged, and not acted on yet
        process.send_signal(signal.SIGKILL)
        process.wait(LONGEST_S)
    with run_studio(folder) as (process, port), line(port) as person:
        while not person.news:
            person.hear()
        assert [each["name"] for each in person.news["library"]["interrupted"]] == ["goto"]
        assert "goto" in person.news["message"]["text"]
        assert person.say("open", name="goto")["ok"]
        assert wait_for_examples(person, 4) == before
        assert person.news["session"]["pending"] == "done"
        assert person.news["paused"]
        assert "interrupted" in person.news["message"]["text"]
        person.say("step")
        process.send_signal(signal.SIGTERM)
        assert process.wait(LONGEST_S) in (0, -signal.SIGTERM)
    with run_studio(folder) as (_, port), line(port) as person:
        assert person.say("open", name="goto")["ok"]
        assert wait_for_examples(person, 5) == [*before, (5, "rotate_left", "done")]
        assert person.say("save")["ok"]
    assert (folder / "goto.json").exists()
