"""Tables of commands in narrow terminals: no name is broken, and nothing is left out."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.make.automata import make_goto
from typer.testing import CliRunner

from understudy.storage.library_folder import save_automaton
from understudy.ui.cli.main import make_command_line
from understudy.ui.cli.output import join_lines


def run_at(width: int, *arguments: object) -> str:
    runner = CliRunner(env={"COLUMNS": str(width), "NO_COLOR": "1", "TERM": "dumb"})
    told = runner.invoke(make_command_line(), [str(each) for each in arguments])
    assert told.exit_code == 0, told.output
    return told.stdout


@pytest.fixture
def lessons(library: Path) -> Path:
    """The library of a robot, and an automaton with examples and former versions."""
    taught = make_goto()
    for _ in range(2):
        save_automaton(library, taught)
    return library


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_show_breaks_no_name(width: int, lessons: Path) -> None:
    taught = make_goto()
    assert taught.lesson is not None
    told = run_at(width, "show", "goto", lessons)
    shown = told.partition("What was shown")[2]
    for feature in taught.automaton.features:
        assert str(feature) in shown
    for state in taught.automaton.states:
        assert state.name in told
    for line in told.splitlines():
        assert len(line.rstrip()) <= width
    assert "…" not in told


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_list_breaks_no_name(width: int, lessons: Path) -> None:
    told = run_at(width, "list", lessons).partition("automata")[2]
    for name in ("deposit", "forage", "goto(A)", "harvest, deposit"):
        assert name in told
    assert "…" not in told
    for line in told.splitlines():
        assert len(line.rstrip()) <= width


def test_a_column_without_entries_is_left_out(library: Path) -> None:
    told = run_at(80, "list", library)
    assert "runs" in told
    assert "former" not in told


@given(st.lists(st.text("ab c", min_size=1, max_size=12), max_size=8), st.integers(5, 30))
def test_lines_break_between_parts_only(parts: list[str], width: int) -> None:
    lines = join_lines(parts, width)
    assert " ".join(lines) == ", ".join(parts)
    alone = {each for part in parts for each in (part, f"{part},")}
    assert all(len(line) <= width or line in alone for line in lines)
