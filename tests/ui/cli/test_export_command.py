"""`understudy export`, and `understudy export why` on what the exported code traced."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from tests.ui.cli.commands import ROOT, run, run_json

LESSONS = ROOT / "tests" / "fixtures" / "v0_1_0" / "library"


@pytest.fixture
def lesson_library(tmp_path: Path) -> Path:
    """A library with lessons."""
    (tmp_path / "taught").mkdir()
    for name in ("goto", "harvest", "deposit", "forage"):
        shutil.copy(LESSONS / f"{name}.json", tmp_path / "taught")
    return tmp_path / "taught"


def test_it_says_what_it_wrote(library: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    found = run_json("export", "forage", "--library", library, "--to", "python", "--out", out)
    assert set(found["files"]) == {path.name for path in out.iterdir()}
    assert found["ticks"] > 100
    assert found["untranslated"] == found["rounded_cuts"] == []
    shown = run("export", "forage", "--library", library, "--to", "c99", "--float32", "--out", out)
    assert shown.exit_code == 0, shown.output
    assert "forage for c99: " in shown.stdout


def test_parameters_are_bound(library: Path, tmp_path: Path) -> None:
    arguments = ["export", "goto", "--library", library, "--to", "python", "--out", tmp_path / "out"]
    result = run(*arguments)
    assert result.exit_code == 2
    assert "parameter 'A' of 'goto' is bound to nothing" in result.stderr
    assert not (tmp_path / "out").exists()
    assert run_json(*arguments, "--bind", "A=station")["target"] == "python"


def trace(folder: Path) -> Path:
    """Two ticks of the exported forager, as its indices are."""
    header = (folder / "forage.py").read_text().split("TRACE_HEADER = ")[1].splitlines()[0].strip("\"'")
    path = folder.parent / "trace.csv"
    path.write_text(f"{header}\n0,4.0.0.1,1.0.1.1,0.0.-1.0\n0.1,4.1.1.1,1.1.1.1,0.0.-1.0\n0.2,4")
    return path


def test_why_finds_the_examples_behind_exported_decisions(lesson_library: Path, tmp_path: Path) -> None:
    run_json("export", "forage", "--library", lesson_library, "--to", "python", "--out", tmp_path / "out")
    path = trace(tmp_path / "out")
    found = run_json("export", "why", path, "--library", lesson_library)
    assert found["ticks"] == 2  # the last line has no end
    assert [(each["automaton"], each["before"], each["after"]) for each in found["decisions"]] == [
        ("forage", "start", "harvest"),
        ("harvest", "start", "goto"),
    ]
    assert all(each["examples"] and each["shown"] for each in found["decisions"])
    tick = run_json("export", "why", path, "--library", lesson_library, "--time", "0.15")["decisions"]
    assert [each["time"] for each in tick] == [0.1, 0.1, 0.1]
    assert tick[2]["why"] == "stays in start: there are no examples there"


def test_why_says_times_of_long_clocks_in_full(lesson_library: Path, tmp_path: Path) -> None:
    run_json("export", "forage", "--library", lesson_library, "--to", "python", "--out", tmp_path / "out")
    path = trace(tmp_path / "out")
    later = path.read_text().replace("\n0,", "\n1700000000,").replace("\n0.1,", "\n1700000000.1,")
    path.write_text(later)
    shown = run("export", "why", path, "--library", lesson_library, "--time", "1700000000.15")
    assert shown.stdout.startswith("1700000000.1 forage ")
    early = run("export", "why", path, "--library", lesson_library, "--time", "1600000000.5")
    assert "--time is 1600000000.5, before the trace begins" in early.stderr


def test_why_refuses_a_trace_of_another_library(lesson_library: Path, library: Path, tmp_path: Path) -> None:
    run_json("export", "forage", "--library", lesson_library, "--to", "python", "--out", tmp_path / "out")
    result = run("export", "why", trace(tmp_path / "out"), "--library", library)
    assert result.exit_code == 2
    assert "forage has changed since it was exported" in result.stderr


BAD_TRACES = [
    ("nothing\n", "at line 1: it is not a trace of exported code"),
    ("{header}\n0,4.0.0\n", "at line 2: '0,4.0.0' is no tick"),
    ("{header}\n0,4.9.0.1\n", "line 2 has an index that forage does not have"),
    ("{header}\n0,4.0.99.1\n", "line 2 has an index that forage does not have"),
]


@pytest.mark.parametrize(("text", "problem"), BAD_TRACES)
def test_bad_traces_are_refused_in_a_sentence(
    text: str, problem: str, lesson_library: Path, tmp_path: Path
) -> None:
    run_json("export", "forage", "--library", lesson_library, "--to", "python", "--out", tmp_path / "out")
    path = trace(tmp_path / "out")
    path.write_text(text.replace("{header}", path.read_text().splitlines()[0]))
    result = run("export", "why", path, "--library", lesson_library)
    assert result.exit_code == 2
    assert problem in " ".join(result.stderr.split())
