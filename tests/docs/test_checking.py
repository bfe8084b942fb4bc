"""The page on checking: its lesson, and what the check prints on it."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from tests.docs.pages import ROOT, blocks
from tests.ui.cli.commands import run
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton


def test_the_lesson_of_the_page_is_checked_as_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    lesson, shown = (
        next(block for block in blocks(ROOT / "docs" / "checking.md") if block.language == language)
        for language in ("csv", "text")
    )
    (tmp_path / "lesson.csv").write_text(lesson.text, encoding="utf-8")
    learned = run("learn", "lesson.csv", "--name", "approach", "--library", "library")
    assert learned.exit_code == 0, learned.output
    done = run("check", "library")
    assert done.exit_code == 0, done.output
    assert done.stdout.split() == shown.text.split()


def test_the_workflow_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All steps of the page in their order, but with fewer worlds; a step after a failed one would not run."""
    monkeypatch.chdir(tmp_path)
    for automaton in AUTOMATA:
        save_automaton(tmp_path / "library", TrainedAutomaton(automaton))
    (workflow,) = (block for block in blocks(ROOT / "docs" / "checking.md") if block.language == "yaml")
    steps = re.findall(r"run: understudy (.*)", workflow.text)
    assert [step.split()[0] for step in steps] == ["validate", "check", "test", "falsify", "check"]
    for step in steps:
        command = step.replace("10000", "100").replace("--seconds 60", "--seconds 1").partition(" > ")[0]
        result = run(*shlex.split(command))
        assert result.exit_code == 0, (step, result.output)
