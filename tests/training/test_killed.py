"""Kill -9 between operations on files: what was acknowledged is there, the library readable, the lesson identical."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import IO

import pytest
from tests.processes import end_with_tests
from tests.training import scripted
from tests.training.steps import describe_acknowledged

from understudy.learning.fit import learn
from understudy.model.library import TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.journal import AnyEntry, Journal
from understudy.training.session import Session
from understudy.training.trainee import Mode

MOST_OPERATIONS = 60
"""After how many operations on files that follow a step a session is killed at most: several steps take as many."""


def describe_lesson(taught: TrainedAutomaton) -> str:
    """What a saved automaton was shown."""
    lesson = taught.lesson
    return repr([(e.state, e.values, e.next, str(e.kind)) for e in lesson.examples] if lesson else None)


class Reference:
    """The same session, never killed: what the lesson was after each step, and at each entry in between."""

    def __init__(self, folder: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
        self.after: dict[int, str] = {}
        self.during: dict[int, list[str]] = {}
        self.saved: set[str] = set()  # what the library held at some time
        self._lessons: list[str] = []
        self._session: Session | None = None
        write = Journal.write

        def write_and_note(journal: Journal, entry: AnyEntry, *, sync: bool = False) -> None:
            if self._session is not None:
                self._lessons.append(describe_acknowledged(self._session))
            write(journal, entry, sync=sync)

        def save_and_note(library: Path, taught: TrainedAutomaton) -> Path:
            self.saved.add(describe_lesson(taught))
            return save_automaton(library, taught)

        with monkeypatch.context() as patched:
            patched.setattr(Journal, "write", write_and_note)
            patched.setattr(scripted, "save_automaton", save_and_note)
            scripted.play(folder, seed, self._acknowledge)

    def _acknowledge(self, index: int, session: Session) -> None:
        self._session = session
        self.after[index] = describe_acknowledged(session)
        self.during[index] = self._lessons
        self._lessons = []

    def may_be(self, acknowledged: int) -> set[str]:
        """The lesson as it may be found when so many steps were acknowledged, and the next was under way."""
        following = acknowledged + 1
        later = [*self.during.get(following, []), self.after[min(following, max(self.after))]]
        return {self.after[acknowledged], *later}


class Nursery:
    """Forks sessions, so that each begins at once."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self.process = subprocess.Popen(
            end_with_tests([sys.executable, "-m", "tests.training.scripted", str(folder)]),
            cwd=Path(__file__).parents[2],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        if self._read_line() != "ready":
            raise RuntimeError("the nursery did not start")

    def _pipe(self, pipe: IO[str] | None) -> IO[str]:
        if pipe is None:
            raise RuntimeError("the nursery has no pipes")
        return pipe

    def _read_line(self) -> str:
        return self._pipe(self.process.stdout).readline().strip()

    def kill_one(self, folder: Path, seed: int, random: Random) -> int:
        """Run a session that is killed at a random operation on files; the last step it acknowledged, or -2."""
        folder.mkdir()
        said, steps = folder / "said", random.randint(0, scripted.STEPS)
        stdin = self._pipe(self.process.stdin)
        stdin.write(f"{folder} {seed} {steps} {random.randrange(MOST_OPERATIONS)}\n")
        stdin.flush()
        assert self._read_line() == "ended"
        lines = said.read_text().split("\n")[:-1] if said.exists() else []
        return int(lines[-1]) if lines else -2

    def close(self) -> None:
        self._pipe(self.process.stdin).close()
        self._pipe(self.process.stdout).close()
        self.process.wait(timeout=60)


@pytest.fixture(scope="module")
def nursery(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Nursery]:
    """Forks the sessions of all tests."""
    begun = Nursery(tmp_path_factory.mktemp("nursery") / "warm")
    yield begun
    begun.close()


def kill_and_check(
    times: int, nursery: Nursery, folder: Path, monkeypatch: pytest.MonkeyPatch, *, live: bool
) -> None:
    """Kill sessions so many times; with `live`, those that count were killed while they were taught live."""
    random, checked = Random(20261121), 0
    while checked < times:
        seed = random.randrange(2**30) * 2 + live
        here = folder / f"{seed}"
        acknowledged = nursery.kill_one(here, seed, random)
        if acknowledged == -2:
            continue  # killed before the session had begun
        (folder / f"{seed}-reference").mkdir()
        reference = Reference(folder / f"{seed}-reference", seed, monkeypatch)
        again = Session.resume(here / "journal", Forage([seed]), scripted.LIBRARY)
        assert describe_acknowledged(again) in reference.may_be(acknowledged), (seed, acknowledged)
        mode = again.mode
        if mode is Mode.LIVE:  # it decides by all that was acknowledged
            decides = again.trainee.taught.automaton.transitions
            assert repr(decides) == repr(learn(again.lesson)), (seed, acknowledged)
        again.tick()
        again.close()
        if (here / "library").exists():
            opened = open_library(here / "library", FORAGE_KIT, learn)
            assert {describe_lesson(taught) for taught in opened.library.taught.values()} <= reference.saved
        checked += not live or mode is Mode.LIVE


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills with fork and SIGKILL")
@pytest.mark.parametrize("live", [False, True])
def test_killed(nursery: Nursery, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, live: bool) -> None:
    kill_and_check(6, nursery, tmp_path, monkeypatch, live=live)


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills with fork and SIGKILL")
@pytest.mark.parametrize("live", [False, True])
def test_killed_many_times(
    nursery: Nursery, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, live: bool
) -> None:
    kill_and_check(200, nursery, tmp_path, monkeypatch, live=live)
