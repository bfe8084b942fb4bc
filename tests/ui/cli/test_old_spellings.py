"""Old spellings of commands do what the new ones do, and the help lists none of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.cli.commands import run

PAIRS = [
    ("learn no.csv", "learn table no.csv"),
    ("learn lesson.csv --predict no.csv --json", "learn table lesson.csv --predict no.csv --json"),
    ("learn --recording no.csv --map no.toml", "learn drive no.csv --map no.toml"),
    ("learn --recording drive.csv --driver anna", "learn drive drive.csv --driver anna"),
    ("learn --recording drive.csv --define x", "learn drive drive.csv --define x"),
    ("learn --recording no.mcap --session 2", "learn recording no.mcap --session 2"),
    ("learn --recording drive.csv --recording no.csv", "learn drivers drive.csv no.csv"),
    ("run --replay no.mcap", "replay no.mcap"),
    ("run --robot no.toml", "robots run no.toml"),
    ("run --robot no.toml --no-record", "robots run no.toml --record none"),
    ("run forage --world arena --behavior nothing", "run forage -w arena --behavior nothing"),
    ("run --world nowhere", "run nowhere"),
    ("teach goto --robot no.toml", "robots teach no.toml goto"),
    ("studio --robot no.toml --no-browser", "robots studio no.toml --no-browser"),
    ("studio --recording no.csv --name x", "review no.csv --name x"),
    ("studio --drive nowhere", "drive nowhere"),
    ("falsify library goto --world no:thing --goal done", "falsify-body library goto no:thing --goal done"),
    ("why --exported no.csv", "export why no.csv"),
    ("agent no.toml --name one", "team agent no.toml --name one"),
    ("export goto --to c99 --out out", "export automaton goto --to c99 --out out"),
    ("export data lesson.csv --out no.txt", "export table lesson.csv --out no.txt"),
    ("test --library no", "test no"),
    ("export data no.mcap --to lerobot --out out", "export dataset no.mcap --to lerobot --out out"),
]


@pytest.mark.parametrize(("old", "new"), PAIRS)
def test_an_old_spelling_does_the_same(
    old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lesson.csv").write_text("state,next,kind,x:continuous\nstart,go,directive,1\n")
    (tmp_path / "drive.csv").write_text("time_s,drive\n0.0,1.0\n0.1,1.0\n")
    before, now = run(*old.split()), run(*new.split())
    assert (before.exit_code, before.stdout, before.stderr) == (now.exit_code, now.stdout, now.stderr)
    assert "Usage:" not in now.stderr
    assert before.exit_code in (0, 2)


def test_no_help_lists_an_old_spelling() -> None:
    shown = run("--help").stdout + run("more").stdout
    assert "  run " in shown
    assert "agent " not in shown.replace("agents", "")
    assert "  data " not in run("export", "--help").stdout
    for command in ("run", "studio", "teach"):
        assert "--robot" not in run(command, "--help").stdout
