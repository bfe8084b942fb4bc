"""Library folders: what is saved is there, what was there is kept, whatever happens in between."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.make.automata import make_goto, make_kit
from tests.processes import end_with_tests

from understudy.errors import DefinitionError, FileError, RecursionRefused, UnderstudyError, UnknownName
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.storage import atomic_write
from understudy.storage.library_folder import (
    LONGEST,
    list_documents,
    list_versions,
    load_version,
    make_file_stem,
    open_document,
    open_library,
    rename_automaton,
    save_automaton,
)

KIT = make_kit(make_goto().automaton)


def variant(reaction_s: float, name: str = "goto") -> TrainedAutomaton:
    original = make_goto(name)
    assert original.lesson is not None
    return TrainedAutomaton(original.automaton, replace(original.lesson, options=LearnerOptions(reaction_s)))


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_save_and_open(tmp_path: Path) -> None:
    path = save_automaton(tmp_path / "new" / "library", make_goto())
    assert path.name == "goto.json"
    opened = open_library(tmp_path / "new" / "library", KIT)
    assert opened.library.taught["goto"] == make_goto()
    assert opened.rebuilt == {}


def test_renaming_takes_the_versions_along(tmp_path: Path) -> None:
    for reaction_s in (0.1, 0.2, 0.3):
        save_automaton(tmp_path, variant(reaction_s))
    for reaction_s in (0.4, 0.5):
        save_automaton(tmp_path, variant(reaction_s, "reach"))
    with pytest.raises(DefinitionError, match="is there already"):
        rename_automaton(tmp_path, "goto", variant(0.3, "reach"))
    (tmp_path / "reach.json").unlink()
    assert rename_automaton(tmp_path, "goto", variant(0.3, "reach")).name == "reach.json"
    assert list(open_library(tmp_path, KIT).library.taught) == ["reach"]
    kept = list_versions(tmp_path, "reach")
    lessons = [load_version(tmp_path, "reach", each.number, KIT).taught.lesson for each in kept]
    assert [each.number for each in kept] == [1, 2, 3]
    assert [lesson.options.reaction_s for lesson in lessons if lesson] == [0.4, 0.1, 0.2]
    assert list_versions(tmp_path, "goto") == ()


def test_a_folder_may_be_given_as_a_text(tmp_path: Path) -> None:
    folder = str(tmp_path / "library")
    save_automaton(folder, variant(0.1))
    path = save_automaton(folder, variant(0.2))
    assert list_documents(folder) == [path]
    assert open_document(str(path), KIT).taught == variant(0.2)
    assert load_version(folder, "goto", 1, KIT).taught == variant(0.1)
    rename_automaton(folder, "goto", variant(0.2, "reach"))
    assert [version.number for version in list_versions(folder, "reach")] == [1]
    assert list(open_library(folder, KIT).library.taught) == ["reach"]


NO_AUTOMATA: dict[str, tuple[Any, str]] = {
    "a lesson": (
        make_goto().lesson,
        r"lesson 'goto': .* give TrainedAutomaton\(learn_automaton\(lesson\), lesson\)",
    ),
    "an automaton": (make_goto().automaton, r"automaton 'goto': .* give TrainedAutomaton\(automaton\)"),
    "a name": ("goto", "'goto': it is not a trained automaton; give a TrainedAutomaton"),
    "nothing": (None, "None: it is not a trained automaton"),
}


@pytest.mark.parametrize(("given", "said"), NO_AUTOMATA.values(), ids=NO_AUTOMATA)
def test_only_trained_automata_are_kept(given: Any, said: str, tmp_path: Path) -> None:
    for keep in (
        lambda: save_automaton(tmp_path, given),
        lambda: rename_automaton(tmp_path, "goto", given),
        lambda: Library(KIT).with_automaton(given),
    ):
        with pytest.raises(DefinitionError, match=said):
            keep()
    assert contents(tmp_path) == {}


def test_former_versions_are_kept(tmp_path: Path) -> None:
    for reaction_s in (0.1, 0.2, 0.2, 0.3):  # saving the same twice changes nothing
        save_automaton(tmp_path, variant(reaction_s))
    kept = list_versions(tmp_path, "goto")
    assert [version.number for version in kept] == [1, 2]
    assert all(version.saved is not None for version in kept)
    for number, reaction_s in ((1, 0.1), (2, 0.2)):
        lesson = load_version(tmp_path, "goto", number, KIT).taught.lesson
        assert lesson is not None
        assert lesson.options.reaction_s == reaction_s
    with pytest.raises(UnknownName, match="it has 1 and 2"):
        load_version(tmp_path, "goto", 3, KIT)


ODD = [
    "con",
    "LPT1",
    "a/b",
    "..",
    ".hidden",
    "größe",
    "状態",
    "with space",
    " around ",
    "a.json",
    "%41",
    "x" * LONGEST,
    "*?",
]


@pytest.mark.parametrize("name", ODD)
def test_odd_names(name: str, tmp_path: Path) -> None:
    save_automaton(tmp_path, make_goto(name))
    save_automaton(tmp_path, variant(0.7, name))
    assert [path.parent for path in tmp_path.glob("*.json")] == [tmp_path]
    assert list(open_library(tmp_path, KIT).library.taught) == [name]
    assert len(list_versions(tmp_path, name)) == 1


@given(st.text(max_size=40), st.text(max_size=40))
def test_file_names_are_safe_and_tell_names_apart(one: str, other: str) -> None:
    stems = []
    for name in (one, other):
        try:
            stems.append(make_file_stem(name))
        except DefinitionError:
            return
    assert all(set(each).isdisjoint('/\\:*?"<>|.\0') and each == each.strip() for each in stems)
    assert (stems[0] == stems[1]) == (one == other)


@pytest.mark.parametrize("name", ["", "a\nb", "x" * (LONGEST + 1), "\ud800", "\0"])
def test_impossible_names(name: str, tmp_path: Path) -> None:
    with pytest.raises(DefinitionError, match="no file can be called so"):
        save_automaton(tmp_path, make_goto(name))
    assert contents(tmp_path) == {}


@pytest.mark.parametrize(("first", "second"), [("goto", "GoTo"), ("straße", "STRASSE"), ("é", "e\u0301")])
def test_names_that_some_file_systems_confuse(first: str, second: str, tmp_path: Path) -> None:
    save_automaton(tmp_path, make_goto(first))
    before = contents(tmp_path)
    with pytest.raises(DefinitionError, match="has that name already"):
        save_automaton(tmp_path, make_goto(second))
    assert contents(tmp_path) == before


def test_two_files_for_one_automaton(tmp_path: Path) -> None:
    path = save_automaton(tmp_path, make_goto())
    (tmp_path / "goto copy.json").write_bytes(path.read_bytes())
    with pytest.raises(
        FileError, match=r"goto copy\.json.*contains automaton 'goto', as goto\.json beside it does"
    ):
        open_library(tmp_path, KIT)


def test_recursion_is_refused(tmp_path: Path) -> None:
    for name, runs in (("a", "b"), ("b", "c"), ("c", "a")):
        save_automaton(tmp_path, TrainedAutomaton(Automaton(name, (START, State("on", runs)))))
    with pytest.raises(RecursionRefused) as caught:
        open_library(tmp_path, KIT)
    assert set(caught.value.cycle) == {"a", "b", "c"}
    assert str(tmp_path) in str(caught.value)


def test_a_basic_behavior_has_the_name(tmp_path: Path) -> None:
    save_automaton(tmp_path, make_goto())
    with pytest.raises(FileError, match=r"goto\.json.*basic behavior"):
        open_library(tmp_path, KIT + Kit.from_parts(Behavior("goto")))


@pytest.mark.parametrize("make", [Path.mkdir, os.mkfifo])
def test_what_is_not_a_file_is_no_document(tmp_path: Path, make: Callable[[Path], None]) -> None:
    make(tmp_path / "goto.json")
    with pytest.raises(FileError, match=r"goto\.json: it is not a file; remove it"):
        open_library(tmp_path, KIT)


def test_a_folder_may_be_named_by_text(tmp_path: Path) -> None:
    save_automaton(str(tmp_path / "library"), make_goto())
    assert list(open_library(str(tmp_path / "library"), KIT).library.taught) == ["goto"]


def test_the_folder_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "library").write_text("kept")
    with pytest.raises(FileError, match=r"library: it is a file, not a folder"):
        save_automaton(tmp_path / "library", make_goto())
    assert (tmp_path / "library").read_text() == "kept"


def test_an_error_names_the_file_asked_for_and_not_the_one_beside_it(tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught, atomic_write.convert_os_errors(tmp_path / "x.png", "writing"):
        atomic_write.write_atomically(tmp_path / "nowhere" / "x.png", b"")
    assert caught.value.path == str(tmp_path / "x.png")


def test_no_folder(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="nowhere"):
        open_library(tmp_path / "nowhere", KIT)


def test_what_is_not_finished_is_no_document(tmp_path: Path) -> None:
    save_automaton(tmp_path, make_goto())
    left = tmp_path / f".goto.json.1{atomic_write.UNFINISHED}"
    left.write_text("{")
    (tmp_path / ".DS_Store.json").write_text("{")
    (tmp_path / "notes.txt").write_text("mine")
    assert list(open_library(tmp_path, KIT).library.taught) == ["goto"]
    save_automaton(tmp_path, variant(0.9))
    assert not left.exists()
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("failing", ["fsync", "replace"])
def test_nothing_changes_on_an_error(failing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save_automaton(tmp_path, make_goto())
    before = contents(tmp_path)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(*((os, "fsync", full) if failing == "fsync" else (Path, "replace", full)))
    with pytest.raises(FileError, match="No space left"):
        save_automaton(tmp_path, variant(0.9))
    assert contents(tmp_path) == before


def test_a_library_that_may_not_be_written(tmp_path: Path) -> None:
    (tmp_path / "library").write_text("a file")
    with pytest.raises(FileError):
        save_automaton(tmp_path / "library", make_goto())
    assert (tmp_path / "library").read_text() == "a file"


SAVER = """
import os, sys
from pathlib import Path
from random import Random
from tests.killed_at_operation import kill_self_after
from tests.storage.test_library_folder import variant
from understudy.storage.library_folder import save_automaton
turns = int(sys.argv[2])
save_automaton(Path(sys.argv[3]), variant(0.0))  # what is imported late is imported here
for attempt, line in enumerate(sys.stdin):
    if (child := os.fork()) == 0:
        kill_self_after(int(line))
        for turn in range(turns * attempt, turns * (attempt + 1)):
            save_automaton(Path(sys.argv[1]), variant(turn / 1000))
            os.write(1, f"{turn} ".encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.write(1, b"ended\\n")
"""
TURNS = 4
"""How often a process saves unless it is killed."""
KILLED_AFTER = range(0, 320, 7)
"""After how many operations on files it is killed: a save has about 140."""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills with fork and SIGKILL")
def test_killed_at_any_moment(tmp_path: Path) -> None:
    """Whenever a saving process is killed, the library opens, and all it said it had saved is there."""
    root, folder = Path(__file__).parents[2], tmp_path / "library"
    path = os.pathsep.join([str(root), str(root / "src")])
    words = [sys.executable, "-c", SAVER, str(folder), str(TURNS), str(tmp_path / "warm")]
    said, killed = set[int](), 0
    with subprocess.Popen(
        end_with_tests(words),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=root,
        env={**os.environ, "PYTHONPATH": path},
    ) as saver:
        assert saver.stdin is not None
        assert saver.stdout is not None
        for operations in KILLED_AFTER:
            saver.stdin.write(f"{operations}\n")
            saver.stdin.flush()
            *turns, end = saver.stdout.readline().split()
            assert end == "ended"
            killed += len(turns) < TURNS
            said |= {int(turn) for turn in turns}
            if not list(folder.glob("*.json")):
                assert not said
                continue
            kept = open_library(folder, KIT).library.taught["goto"].lesson
            assert kept is not None
            found = [kept.options.reaction_s]
            for version in list_versions(folder, "goto"):
                lesson = load_version(folder, "goto", version.number, KIT).taught.lesson
                assert lesson is not None
                found.append(lesson.options.reaction_s)
            assert {turn / 1000 for turn in said} <= set(found)
        saver.stdin.close()
    assert killed > 5
    assert said


def test_many_savers_lose_nothing(tmp_path: Path) -> None:
    """Processes that save at the same time take turns: each save is the current or a former version."""
    code = (
        "import sys; from pathlib import Path; from tests.storage.test_library_folder import variant;"
        "from understudy.storage.library_folder import save_automaton;"
        "[save_automaton(Path(sys.argv[1]), variant(int(sys.argv[2]) / 10 + turn / 100)) for turn in range(5)]"
    )
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(root), str(root / "src")])}
    savers = [
        subprocess.Popen(
            end_with_tests([sys.executable, "-c", code, str(tmp_path), str(each)]), cwd=root, env=environment
        )
        for each in range(3)
    ]
    assert [saver.wait() for saver in savers] == [0, 0, 0]
    assert len(list_versions(tmp_path, "goto")) == 14
    open_library(tmp_path, KIT)


def test_errors_are_ours(tmp_path: Path) -> None:
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(UnderstudyError):
        open_library(tmp_path, KIT)
