"""A library that is missing: which ones lie near, and how to name one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from tests.ui.cli.commands import run, run_json

from understudy.storage.library_folder import count_automata
from understudy.ui.cli.near_libraries import describe_near_libraries, find_near_libraries


def test_a_missing_library_says_which_lie_near(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    demo = tmp_path / "here" / "demo"
    demo.mkdir(parents=True)
    (demo / "pictures").mkdir()
    library.rename(demo / "library")
    monkeypatch.chdir(tmp_path / "here")
    for arguments in (["list"], ["show", "goto"], ["check"], ["run", "--behavior", "goto"], ["validate"]):
        refused = run(*arguments)
        assert refused.exit_code == 2
        command = f"understudy {arguments[0]} demo/library"
        assert f"Libraries near: demo/library (4 automata). Name one of them: {command}" in refused.stderr
        assert refused.stderr.count("\n") == 1
    assert len(run_json("list", "demo/library")["automata"]) == 4
    assert "understudy list demo/library" in run("list", "demo/pictures").stdout
    assert "Libraries near" not in run("show", "boss", "demo/library").stderr


# working folder, named folder, what is found
NEAR = [
    (".", "library", ["a/library", "a/twin"]),  # below
    ("a", "lib", ["library", "twin"]),
    ("a/pictures", "library", ["../library", "../twin"]),  # beside
    ("b/c", "library", []),
    ("a/library", "library", [".", "../twin"]),
    (".", "a/libary", ["a/library", "a/twin"]),
    ("far/away/off/yonder", "library", []),
]


@pytest.mark.parametrize(("here", "named", "expected"), NEAR)
def test_libraries_below_and_beside(
    here: str, named: str, expected: list[str], library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "place"
    for folder in ("a/pictures", "b/c", "far/away/off/yonder", ".hidden", "a/twin", "dataset"):
        (place / folder).mkdir(parents=True)
    (place / "a" / "twin" / "goto.json").write_bytes((library / "goto.json").read_bytes())
    (place / ".hidden" / "goto.json").write_bytes((library / "goto.json").read_bytes())
    (place / "dataset" / "info.json").write_text('{"robot": "rover"}')
    library.rename(place / "a" / "library")
    monkeypatch.chdir(place / here)
    assert sorted(map(str, find_near_libraries(Path(named)))) == expected
    if not expected:
        assert describe_near_libraries(Path(named), "understudy list") == []


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.json")
    assert count_automata(tmp_path) == 0
