"""A library handed to agents: checked first, taken over as a whole, the former one kept."""

from __future__ import annotations

from pathlib import Path

import pytest

from understudy.errors import FileError
from understudy.robots.team_network.library_push import LibraryFolder, read_library_files


def fingerprint(folder: Path) -> str:
    """Whatever is in it; a document that says "broken" cannot be used."""
    content = "".join(path.read_text() for path in sorted(folder.rglob("*.json")))
    if "broken" in content:
        raise FileError(path=folder, place="", problem="is broken", remedy="mend it")
    return content


def make_folder(where: Path, agent: str = "scout") -> LibraryFolder:
    (where / "library").mkdir(parents=True)
    (where / "library" / "go.json").write_text("old")
    return LibraryFolder(where / "library", agent, fingerprint)


NEW = {"go.json": b"new", "patrol/lead.json": b"lead"}


def test_a_library_is_taken_over_as_a_whole_and_the_former_is_kept(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    assert folder.prepare(NEW) == ""
    assert read_library_files(folder.folder) == {"go.json": b"old"}  # not before all are ready
    assert folder.switch() == ""
    assert read_library_files(folder.folder) == NEW
    assert read_library_files(tmp_path / "library.former") == {"go.json": b"old"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["library", "library.former"]


def test_two_agents_of_one_folder_keep_the_former_library(tmp_path: Path) -> None:
    first = make_folder(tmp_path)
    second = LibraryFolder(first.folder, "other", fingerprint)
    assert [each.prepare(NEW) for each in (first, second)] == ["", ""]
    assert [each.switch() for each in (first, second)] == ["", ""]
    assert read_library_files(tmp_path / "library.former") == {"go.json": b"old"}


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"go.json": b"broken"}, "is broken"),
        ({"../go.json": b"new"}, "no path"),
        ({"/etc/go.json": b"new"}, "no path"),
        ({"go.py": b"new"}, "no path"),
    ],
)
def test_what_cannot_be_used_changes_nothing(tmp_path: Path, files: dict[str, bytes], said: str) -> None:
    folder = make_folder(tmp_path)
    assert said in folder.prepare(files)
    assert folder.switch() == "has no library prepared"
    assert read_library_files(folder.folder) == {"go.json": b"old"}
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_a_kill_between_the_renames_leaves_a_whole_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = make_folder(tmp_path)
    folder.prepare(NEW)
    renamed, rename = list[Path](), Path.rename

    def rename_once(source: Path, target: Path) -> Path:
        if renamed:
            raise KeyboardInterrupt
        renamed.append(source)
        return rename(source, target)

    monkeypatch.setattr(Path, "rename", rename_once)
    with pytest.raises(KeyboardInterrupt):
        folder.switch()
    monkeypatch.undo()
    assert not folder.folder.exists()
    folder.recover()
    assert read_library_files(folder.folder) == NEW


def test_a_folder_without_automata_is_not_pushed(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="has no automata"):
        read_library_files(tmp_path)
