"""A library handed to agents: checked first, taken over as a whole, the former one kept."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from threading import Barrier

import pytest

from understudy.addons.robots.team_network import library_push
from understudy.addons.robots.team_network.library_push import LibraryFolder, read_library_files
from understudy.errors import FileError
from understudy.storage.atomic_write import lock_folder


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


def test_a_folder_or_a_pipe_is_no_document(tmp_path: Path) -> None:
    folder = make_folder(tmp_path).folder
    (folder / "patrol.json").mkdir()
    os.mkfifo(folder / "stop.json")
    pipe = os.open(folder / "stop.json", os.O_RDWR | os.O_NONBLOCK)  # so that a reader gets an error
    try:
        assert read_library_files(folder) == {"go.json": b"old"}
    finally:
        os.close(pipe)


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
    assert read_library_files(folder.folder) == {"go.json": b"old"}  # to which the others go back, too
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_agents_of_one_folder_that_switch_at_once_keep_the_former_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    together, inside, entered = Barrier(3), list[int](), 0

    @contextmanager
    def lock_together(folder: Path) -> Iterator[None]:
        nonlocal entered
        together.wait(60.0)  # all have looked at the folder before one of them changes it
        with lock_folder(folder):
            inside.append(1)
            assert len(inside) == 1
            entered += 1
            yield
            inside.pop()

    monkeypatch.setattr(library_push, "lock_folder", lock_together)
    for number in range(3):
        first = make_folder(tmp_path / str(number))
        folders = [first, *(LibraryFolder(first.folder, name, fingerprint) for name in ("other", "third"))]
        assert [each.prepare(NEW) for each in folders] == ["", "", ""]
        with ThreadPoolExecutor(3) as threads:
            assert list(threads.map(LibraryFolder.switch, folders)) == ["", "", ""]
            assert read_library_files(first.folder) == NEW
            former = first.folder.with_name("library.former")
            assert read_library_files(former) == {"go.json": b"old"}
            assert list(threads.map(LibraryFolder.forget, folders)) == ["", "", ""]
        assert read_library_files(first.folder) == {"go.json": b"old"}
        assert [path.name for path in (tmp_path / str(number)).iterdir()] == ["library"]
        assert entered == 6 * (number + 1)


def test_a_broken_library_is_replaced(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    assert folder.prepare(NEW) == ""
    (folder.folder / "go.json").write_text("broken")
    assert folder.switch() == ""
    assert read_library_files(folder.folder) == NEW


@pytest.mark.parametrize("failing", [1, 2])
def test_a_folder_that_cannot_be_renamed_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    folder = make_folder(tmp_path)
    folder.prepare(NEW)
    calls, rename = list[Path](), Path.rename

    def rename_until(source: Path, target: Path) -> Path:
        calls.append(source)
        if len(calls) == failing:
            raise PermissionError(errno.EACCES, "Permission denied", str(source))
        return rename(source, target)

    monkeypatch.setattr(Path, "rename", rename_until)
    assert "replacing failed: Permission denied" in folder.switch()
    assert read_library_files(folder.folder) == {"go.json": b"old"}
    assert folder.forget() == ""
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_a_kill_while_preparing_leaves_no_half_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = LibraryFolder(tmp_path / "library", "scout", fingerprint)  # of a computer without a library
    split = library_push._split

    def split_once(name: str) -> tuple[str, ...]:
        if name != "go.json":
            raise KeyboardInterrupt
        return split(name)

    monkeypatch.setattr(library_push, "_split", split_once)
    with pytest.raises(KeyboardInterrupt):
        folder.prepare(NEW)
    assert len(list(tmp_path.iterdir())) == 1
    LibraryFolder(tmp_path / "library", "scout", fingerprint).recover()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="inodes are those of files")
def test_a_prepared_library_is_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, synced, sync = make_folder(tmp_path), set[int](), os.fsync

    def note_sync(descriptor: int) -> None:
        synced.add(os.fstat(descriptor).st_ino)
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", note_sync)
    assert folder.prepare(NEW) == ""
    prepared = tmp_path / "library.scout.next"
    assert {path.stat().st_ino for path in (tmp_path, prepared, *prepared.rglob("*"))} <= synced
    synced.clear()
    assert folder.switch() == ""
    assert tmp_path.stat().st_ino in synced


def test_going_back_restores_the_former_library(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    folder.prepare(NEW)
    folder.switch()
    assert folder.forget() == ""
    assert read_library_files(folder.folder) == {"go.json": b"old"}
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_a_library_that_cannot_be_read_is_replaced(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    (folder.folder / "folder.json").mkdir()
    assert folder.prepare(NEW) == ""
    assert folder.switch() == ""
    assert read_library_files(folder.folder) == NEW


def test_a_settled_library_stays(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    folder.prepare(NEW)
    folder.switch()
    folder.settle()
    assert folder.forget() == ""
    assert read_library_files(folder.folder) == NEW


def test_an_agent_that_did_not_switch_goes_back_for_one_that_did(tmp_path: Path) -> None:
    first = make_folder(tmp_path)
    second = LibraryFolder(first.folder, "other", fingerprint)
    assert [each.prepare(NEW) for each in (first, second)] == ["", ""]
    assert first.switch() == ""
    assert [each.forget() for each in (second, first)] == ["", ""]
    assert read_library_files(first.folder) == {"go.json": b"old"}
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_only_what_was_replaced_goes_back(tmp_path: Path) -> None:
    folder = make_folder(tmp_path)
    folder.prepare(NEW)
    folder.switch()
    folder.settle()
    folder.prepare(NEW)  # the same again, which changes nothing
    folder.switch()
    assert folder.forget() == ""
    assert read_library_files(folder.folder) == NEW
    assert read_library_files(tmp_path / "library.former") == {"go.json": b"old"}


def test_a_folder_without_automata_is_not_pushed(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="has no automata"):
        read_library_files(tmp_path)
