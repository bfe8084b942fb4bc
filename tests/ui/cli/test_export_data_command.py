"""`understudy export data`: tables, data sets, and one sentence for what cannot be written."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from tests.make.transcripts import FOLDER
from tests.ui.cli.commands import run, run_json

from understudy.judging.record_files import read_records
from understudy.learning.csv_table import read_lesson_table
from understudy.learning.fit import learn
from understudy.storage.library_folder import open_document

LESSON, JOURNAL, TRACE = (
    FOLDER / "library" / "goto.json",
    FOLDER / "journals" / "steps.journal",
    FOLDER / "runs" / "forage.jsonl",
)
SOURCES = [  # source, table, rows, a column
    (LESSON, None, 268, "distance_to(A):continuous"),
    (LESSON, "examples", 268, "kind"),
    (JOURNAL, None, 47, "reading.range(ball)"),
    (JOURNAL, "examples", 11, "kind"),
    (JOURNAL, "presses", 9, "correction"),
    (JOURNAL, "episodes", 7, "tick_s"),
    (TRACE, None, 300, "states"),
    (TRACE, "episodes", 1, "seed"),
]


def read_rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as lines:
        return list(csv.DictReader(lines))


@pytest.mark.parametrize(("source", "table", "rows", "column"), SOURCES)
def test_each_table_of_each_source(
    source: Path, table: str | None, rows: int, column: str, tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    chosen = [] if table is None else ["--table", table]
    told = run_json("export", "data", source, "--out", out, *chosen)
    assert (told["rows"], told["out"]) == (len(read_rows(out)), str(out))
    assert told["columns"] == list(read_rows(out)[0])
    assert column in told["columns"]
    assert told["rows"] == rows


def test_a_lesson_that_was_exported_is_learned_alike(tmp_path: Path) -> None:
    run("export", "data", LESSON, "-o", tmp_path / "goto.csv")
    lesson = open_document(LESSON, None, learn).taught.lesson
    assert lesson is not None
    again = read_lesson_table(tmp_path / "goto.csv")
    assert [(each.state, each.next, each.kind, each.values) for each in again.examples] == [
        (each.state, each.next, each.kind, each.values) for each in lesson.examples
    ]


def test_it_says_what_it_wrote(tmp_path: Path) -> None:
    out = tmp_path / "out.jsonl"
    result = run("export", "data", JOURNAL, "--table", "presses", "-o", out)
    assert result.exit_code == 0
    assert result.stdout.split() == f"presses of {JOURNAL} in {out}: 9 rows, 7 columns".split()


@pytest.mark.parametrize("to", ["lerobot", "minari"])
def test_runs_become_one_data_set(to: str, tmp_path: Path) -> None:
    out = tmp_path / "runs-v0"
    told = run_json("export", "data", JOURNAL, JOURNAL, "--to", to, "--out", out)
    episodes = 2 * read_records(JOURNAL)
    whole = [each for each in episodes if to == "lerobot" or each.ticks > 1]
    assert told == {
        "sources": [str(JOURNAL), str(JOURNAL)],
        "to": to,
        "out": str(out),
        "episodes": len(whole),
        "ticks": sum(each.ticks for each in whole),
        "left_out": len(episodes) - len(whole),
    }
    if to == "minari":
        minari = pytest.importorskip("minari", reason="needs Minari: pip install 'minari[hdf5]'")
        assert minari.MinariDataset(out / "data").total_steps == sum(each.ticks - 1 for each in whole)
    else:
        information = json.loads((out / "meta" / "info.json").read_text())
        assert (information["total_episodes"], information["total_frames"]) == (len(whole), told["ticks"])


def test_a_data_set_is_never_overwritten(tmp_path: Path) -> None:
    out = tmp_path / "runs-v0"
    out.mkdir()
    result = run("export", "data", JOURNAL, "--to", "minari", "--out", out)
    assert result.exit_code == 2
    assert "exists" in result.stderr
    assert list(out.iterdir()) == []


BAD = [
    (["export", "data", TRACE, "-o", "out.txt"], "'out.txt' is no table; name a file that ends in .csv, .jsonl or"),
    (["export", "data", TRACE, "-o", LESSON], "is no table"),
    (["export", "data", TRACE, "-o", "out.csv", "--table", "rows"], "'rows' is unknown; give examples, episodes,"),
    (["export", "data", TRACE, "-o", "out.csv", "--table", "examples"], "it has no lesson; name a library's document"),
    (["export", "data", LESSON, "-o", "out.csv", "--table", "ticks"], "ticks are not in"),
    (["export", "data", "nothing.journal", "-o", "out.csv"], "reading it failed: No such file or directory"),
    (["export", "data", TRACE, JOURNAL, "-o", "out.csv"], "is one source too many for a table; name one, or give --to"),
    (["export", "data", TRACE, "-o", "out", "--to", "hdf5"], "'hdf5' is unknown; give lerobot or minari"),
    (["export", "data", TRACE, "-o", "out", "--to", "lerobot", "--table", "ticks"], "--table does not go with --to"),
    (["export", "data", TRACE, "-o", "out", "--to", "lerobot"], "its readings were not recorded; give episodes with"),
    (["export", "data", TRACE, "-o", "nowhere/out.csv"], "nowhere/out.csv: writing the table failed: No such file"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "says"), BAD)
def test_what_cannot_be_written_is_one_sentence(
    arguments: list[object], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2
    assert says in " ".join(result.stderr.split())
    assert list(tmp_path.iterdir()) == []


NAMES = [  # arguments after `export`, the usage that is shown
    (["goto"], "export automaton"),
    (["automaton", "goto"], "export automaton"),
    (["data"], "export data"),
    (["data", "--to", "c99"], "export automaton"),
    (["data", "--to", "lerobot"], "export data"),
    (["data", "--to=minari"], "export data"),
    (["automaton", "--to", "c99"], "export automaton"),
]


@pytest.mark.parametrize(("arguments", "usage"), NAMES)
def test_an_automaton_may_have_the_name_of_a_command(arguments: list[str], usage: str) -> None:
    result = run("export", *arguments)
    assert result.exit_code == 2
    assert f"{usage} [OPTIONS]" in result.stderr
    assert "Missing argument 'NAME'" not in result.stderr


def test_help_shows_both_commands() -> None:
    shown = run("export", "--help").stdout
    assert "automaton" in shown
    assert "data" in shown
