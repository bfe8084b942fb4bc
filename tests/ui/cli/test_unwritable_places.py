"""Places that cannot be written: what a command makes is refused before it begins, by the right name."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.make.transcripts import FOLDER
from tests.ui.cli.commands import run, run_json

RUN = ["run", "forage", "--behavior", "goto", "--bind", "A=station", "-l", "{lib}", "--seed", "1"]
OWN = ["run", "tests.own_worlds:make_slope", "-l", "{lib}"]
EXPORT = ["export", "automaton", "goto", "-l", "{lib}", "--to", "python", "--bind", "A=station"]
TRACE = str(FOLDER / "runs" / "forage.jsonl")
MAKING = [  # a command up to the name of what it makes, and that name
    ([*RUN, "--record"], "run.gif"),
    ([*RUN, "--record"], "run.png"),
    ([*RUN, "--record"], "run.mcap"),
    ([*RUN, "--trace"], "run.jsonl"),
    ([*RUN, "--record", "{good}/run.mcap", "--trace"], "run.jsonl"),
    ([*RUN, "--trace", "{good}/run.jsonl", "--record"], "run.gif"),
    ([*OWN, "--record"], "run.mcap"),
    ([*OWN, "--record"], "run.gif"),
    ([*EXPORT, "--out"], "made"),
    (["export", "table", TRACE, "--out"], "made.csv"),
    (["export", "dataset", TRACE, "--to", "lerobot", "--out"], "made"),
]
REFUSALS = [  # what is the matter, and what is said
    ("a file in place of the folder", "Not a directory"),
    ("a folder in place of the file", "older"),
    (errno.EACCES, "Permission denied"),
    (errno.EROFS, "Read-only file system"),
    (errno.ENOSPC, "No space left on device; free space on that disk"),
]


def refuse_writing(folder: Path, number: int) -> Callable[..., Any]:
    """Make a `Path.open` that refuses to write to a folder."""
    usual = Path.open

    def open_path(path: Path, mode: str = "r", *given: Any, **named: Any) -> Any:
        if "r" not in mode and path.is_relative_to(folder):
            raise OSError(number, os.strerror(number), str(path))
        return usual(path, mode, *given, **named)

    return open_path


def list_contents(folder: Path) -> dict[str, bytes | None]:
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.parametrize(("trouble", "said"), REFUSALS, ids=[str(trouble) for trouble, _ in REFUSALS])
@pytest.mark.parametrize(
    ("words", "name"), MAKING, ids=[" ".join([*words[-4:], name]) for words, name in MAKING]
)
def test_it_is_refused_at_once(
    words: list[str],
    name: str,
    trouble: str | int,
    said: str,
    library: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    place, good = tmp_path / "place", tmp_path / "good"
    good.mkdir()
    if trouble == "a file in place of the folder":
        place.write_text("kept")
    elif trouble == "a folder in place of the file":
        (place / name).mkdir(parents=True)
        (place / name / "mine").write_text("kept")
    else:
        place.mkdir()
        monkeypatch.setattr(Path, "open", refuse_writing(place, int(trouble)))
    before = list_contents(tmp_path)

    def fail_if_called(*_: object, **__: object) -> None:
        pytest.fail("it began")

    monkeypatch.setattr("understudy.jit.decorators.Kernel.__call__", fail_if_called)
    monkeypatch.setattr("understudy.storage.library_folder.read_document", fail_if_called)
    result = run(*(word.format(lib=library, good=good) for word in words), place / name)
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith(f"Error: {place / name}: ")
    assert said in result.stderr or "already" in result.stderr or "is not of an export" in result.stderr
    assert result.stderr.count("\n") == 1
    assert list_contents(tmp_path) == before


@pytest.mark.parametrize("name", ["run.gif", "run.png", "run.mcap"])
def test_a_place_that_can_be_written_keeps_only_what_was_made(
    name: str, library: Path, tmp_path: Path
) -> None:
    place = tmp_path / "place"
    place.mkdir()
    run_json(*(word.format(lib=library) for word in RUN), "--seconds", "0.3", "--record", place / name)
    assert [each.name for each in place.iterdir()] == [name]


def test_an_export_makes_the_folders_around_it(library: Path, tmp_path: Path) -> None:
    place = tmp_path / "some" / "where"
    run_json(*(word.format(lib=library) for word in EXPORT), "--out", place)
    assert [each.name for each in place.parent.iterdir()] == ["where"]
