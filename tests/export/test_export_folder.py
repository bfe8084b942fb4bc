"""The folder of an export holds a whole export, or is left as it was."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.export.exports import open_fixture

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.export_folder import check_export_folder
from understudy.addons.export.identifiers import make_identifier, make_identifiers
from understudy.errors import DefinitionError, FileError, SettingError, UnboundParameter, UnknownName


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def test_an_earlier_export_is_replaced_as_a_whole(tmp_path: Path) -> None:
    library, body = open_fixture()
    out = tmp_path / "out"
    export_automaton(library, "forage", out, to="c99", body=body)
    (out / "conformance").write_bytes(b"made by make")
    result = export_automaton(library, "forage", out, to="python", body=body)
    assert set(contents(out)) == set(result.files)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_the_same_export_twice_is_the_same_bytes(tmp_path: Path) -> None:
    library, body = open_fixture()
    for name in ("one", "two"):
        export_automaton(library, "forage", tmp_path / name, to="c99", body=body)
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


@pytest.mark.parametrize("there", ["notes.txt", "forage.h", "sub/notes.txt"])
def test_a_folder_with_other_files_is_refused(there: str, tmp_path: Path) -> None:
    library, body = open_fixture()
    (tmp_path / there).parent.mkdir(exist_ok=True)
    (tmp_path / there).write_text("mine")
    with pytest.raises(FileError, match=f"{there} is there, which is not of an export"):
        export_automaton(library, "forage", tmp_path, to="c99", body=body)
    assert contents(tmp_path) == {there: b"mine"}


@pytest.mark.parametrize("text", ['{"name": "my page"}', "[]", '{"format": "understudy export", "makes": 5}'])
def test_a_manifest_of_something_else_is_kept(text: str, tmp_path: Path) -> None:
    library, body = open_fixture()
    (tmp_path / "manifest.json").write_text(text)
    with pytest.raises(FileError, match=r"manifest\.json is there, which is not of an export"):
        export_automaton(library, "forage", tmp_path, to="python", body=body)
    assert contents(tmp_path) == {"manifest.json": text.encode()}


def test_a_link_to_a_folder_is_followed(tmp_path: Path) -> None:
    """What has the name of the linked folder, but is beside the link, stays as it is."""
    library, body = open_fixture()
    (tmp_path / "elsewhere" / "real").mkdir(parents=True)
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "notes.txt").write_text("mine")
    (tmp_path / "out").symlink_to(tmp_path / "elsewhere" / "real")
    result = export_automaton(library, "forage", tmp_path / "out", to="python", body=body)
    assert contents(tmp_path / "real") == {"notes.txt": b"mine"}
    assert set(contents(tmp_path / "elsewhere" / "real")) == set(result.files)
    assert (tmp_path / "out").is_symlink()


def test_a_link_in_the_folder_is_kept(tmp_path: Path) -> None:
    library, body = open_fixture()
    (tmp_path / "data").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "link").symlink_to(tmp_path / "data")
    with pytest.raises(FileError, match="link is there, which is not of an export"):
        export_automaton(library, "forage", tmp_path / "out", to="python", body=body)


def test_the_working_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would be replaced under the feet of the shell that is in it."""
    library, body = open_fixture()
    monkeypatch.chdir(tmp_path)
    for folder in (".", tmp_path):
        with pytest.raises(FileError, match="it is the working folder"):
            export_automaton(library, "forage", folder, to="python", body=body)
    assert list(tmp_path.iterdir()) == []


class Killed(BaseException):
    """What a test raises where a program would be killed."""


@pytest.mark.parametrize("renames", [0, 1, 2])
def test_a_killed_replacement_is_recovered_by_the_next_run(
    renames: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed means that nothing is cleaned up; the process that was killed runs no longer."""
    library, body = open_fixture()
    out = tmp_path / "out"
    export_automaton(library, "forage", out, to="python", body=body)
    before, rename, left = contents(out), Path.rename, renames

    def kill(path: Path, target: Path) -> Path:
        nonlocal left
        if left == 0:
            raise Killed
        left -= 1
        return rename(path, target)

    ended = subprocess.Popen(["true"])
    ended.wait()
    with monkeypatch.context() as patched:
        patched.setattr(Path, "rename", kill)
        patched.setattr("shutil.rmtree", lambda *_, **__: None)
        patched.setattr("os.getpid", lambda: ended.pid)
        patched.setattr("understudy.addons.export.export_folder.sync_folder", lambda _: kill(out, out))
        with pytest.raises(Killed):
            export_automaton(library, "forage", out, to="json", body=body)
    check_export_folder(out)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert (contents(out) == before) == (renames < 2)
    assert (out / "reader.mjs").exists() == (renames == 2)


def test_a_file_beside_an_earlier_export_is_kept(tmp_path: Path) -> None:
    library, body = open_fixture()
    export_automaton(library, "forage", tmp_path / "out", to="c99", body=body)
    (tmp_path / "out" / "main.c").write_text("mine")
    before = contents(tmp_path / "out")
    with pytest.raises(FileError, match=r"main\.c is there"):
        export_automaton(library, "forage", tmp_path / "out", to="c99", body=body)
    assert contents(tmp_path / "out") == before


def test_mistakes_write_nothing(tmp_path: Path) -> None:
    library, body = open_fixture()
    out = tmp_path / "out"
    with pytest.raises(UnboundParameter, match="parameter 'A' of 'goto' is bound to nothing"):
        export_automaton(library, "goto", out, to="c99", body=body)
    with pytest.raises(UnknownName, match="no automaton 'fly'"):
        export_automaton(library, "fly", out, to="c99", body=body)
    with pytest.raises(UnknownName, match="export has no target 'rust'; it has c99, python, scxml"):
        export_automaton(library, "forage", out, to="rust", body=body)
    with pytest.raises(UnknownName, match="has no reading"):
        export_automaton(library, "forage", out, to="c99", body=BodyInterface((), body.channels))
    with pytest.raises(UnknownName, match="has no channel"):
        export_automaton(library, "forage", out, to="c99", body=BodyInterface(body.readings, ()))
    odd = BodyInterface(body.readings, body.channels, 1 / 3)
    with pytest.raises(SettingError, match=r"tick of 0\.333333 s is no whole number of milliseconds"):
        export_automaton(library, "forage", out, to="c99", body=odd, single_precision=True)
    with pytest.raises(SettingError, match="target python: single precision is not offered"):
        export_automaton(library, "forage", out, to="python", body=body, single_precision=True)
    assert list(tmp_path.iterdir()) == []


IDENTIFIERS = [
    ("range(nearest_food)", "range_nearest_food"),
    ("goto", "goto_"),  # a word of C
    ("3 laps", "n3_laps"),
    ("Tür", "Tur"),
    ("速い", "u901f_u3044"),
    ("Δx m²", "u0394_x_m2"),
    ("!", "unnamed"),
    ("a-b", "a_b"),
]


@pytest.mark.parametrize(("name", "identifier"), IDENTIFIERS)
def test_identifiers(name: str, identifier: str) -> None:
    assert make_identifier(name, {"goto"}) == identifier


def test_names_in_other_scripts_stay_distinct() -> None:
    assert make_identifiers(["速い", "遅い"], what="states") == {
        "速い": "u901f_u3044",
        "遅い": "u9045_u3044",
    }


def test_two_names_that_become_one_are_refused() -> None:
    with pytest.raises(DefinitionError, match="readings 'a b' and 'A_b': both become"):
        make_identifiers(["a b", "A_b"], what="readings")
