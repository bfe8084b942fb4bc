"""A library of a foraging robot written by hand, for the tests of the commands."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton
from understudy.ui.cli import progress_bar


@pytest.fixture(autouse=True)
def no_progress_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write no lines of progress, which a command writes only where the computer is slow."""
    monkeypatch.setattr(progress_bar, "SILENCE_S", 1e6)


@pytest.fixture
def library(tmp_path: Path) -> Path:
    folder = tmp_path / "library"
    for automaton in AUTOMATA:
        save_automaton(folder, TrainedAutomaton(automaton))
    return folder
