"""A library of a foraging robot written by hand, for the tests of the commands."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton


@pytest.fixture
def library(tmp_path: Path) -> Path:
    folder = tmp_path / "library"
    for automaton in AUTOMATA:
        save_automaton(folder, TrainedAutomaton(automaton))
    return folder
