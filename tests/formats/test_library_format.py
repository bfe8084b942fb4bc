"""Libraries of 0.1.0 open, run as they were built, and are written again byte for byte."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest
from tests.bodies import kit as scripted_kit
from tests.make.transcripts import FOLDER
from tests.sim.patrollers import ROBOTS
from tests.training.test_squad_session import SQUAD
from tests.ui.cli.commands import run_json

from understudy.judging.properties.stored_moments import run_moment_property
from understudy.learning.fit import learn, learn_automaton
from understudy.model.library import Kit, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.document import encode_document
from understudy.storage.library_folder import (
    list_versions,
    load_version,
    make_file_stem,
    open_library,
    save_automaton,
)

HARVESTS = ["harvest by DecisionTreeClassifier", "harvest by KNeighborsClassifier", "harvest by pruned trees"]
FITTED = "classifiers are fitted again on loading"
LIBRARIES = [  # folder, kit, automata
    ("library", FORAGE_KIT, ["deposit", "fetch", "forage", "goto", "harvest", *HARVESTS]),
    ("scripted", scripted_kit, ["pooled: α/β", "taught"]),
    ("squad", ROBOTS.kit, ["patrol", "servo", "wander"]),
    ("squad/patrol", SQUAD.kit, ["lead"]),
]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.json")}


def needs(folder: str) -> None:
    if folder == "library":
        pytest.importorskip("sklearn", reason="needs the extra sklearn")


@pytest.mark.parametrize(("folder", "known", "names"), LIBRARIES)
def test_a_library_opens_and_is_written_as_it_was(
    folder: str, known: Kit, names: list[str], tmp_path: Path
) -> None:
    needs(folder)
    opened = open_library(FOLDER / folder, known, learn)
    assert sorted(opened.library.taught) == names
    reasons = {name: FITTED for name in names if name.endswith("Classifier")}
    assert opened.rebuilt == reasons, "its trees are those that this version learns"
    for taught in opened.library.taught.values():
        save_automaton(tmp_path, taught)
    assert contents(tmp_path) == contents(FOLDER / folder)


@pytest.mark.parametrize(("folder", "known", "names"), LIBRARIES)
def test_its_lessons_teach_the_same(folder: str, known: Kit, names: list[str]) -> None:
    needs(folder)
    for name, taught in open_library(FOLDER / folder, known, learn).library.taught.items():
        if taught.lesson is not None:
            again = encode_document(TrainedAutomaton(learn_automaton(taught.lesson), taught.lesson))
            assert again == (FOLDER / folder / f"{make_file_stem(name)}.json").read_bytes()


def test_former_versions_open(tmp_path: Path) -> None:
    for name in ("deposit", "forage", "goto", "harvest"):
        (version,) = list_versions(FOLDER / "library", name)
        assert (version.number, version.saved) == (1, datetime(2026, 11, 18, 11, 6, 40, tzinfo=UTC))
        opened = load_version(FOLDER / "library", name, 1, FORAGE_KIT, learn)
        assert opened.rebuilt is None
        assert encode_document(opened.taught) == version.file.read_bytes()


def test_what_a_lesson_holds_is_there() -> None:
    """Facts that a reader finds in the documents."""
    needs("library")
    taught = open_library(FOLDER / "library", FORAGE_KIT, learn).library.taught
    fetch, goto = taught["fetch"].lesson, taught["goto"].lesson
    assert fetch is not None
    assert goto is not None
    assert {each.number: each.quarantined for each in fetch.examples if each.quarantined} == {
        2: "shown by mistake"
    }
    assert fetch.options.unlearning
    assert goto.options.watched
    assert any(not each.is_from_press for each in goto.examples)
    assert (goto.automaton.parameters, list(goto.automaton.flags)) == (("A",), ["done"])


def test_its_outcomes_come_about() -> None:
    needs("library")
    library = open_library(FOLDER / "library", FORAGE_KIT, learn).library
    lesson = library.taught["fetch"].lesson
    assert lesson is not None
    (outcome,) = lesson.properties
    assert (outcome.flag, outcome.seconds, outcome.start.world) == ("done", 60.0, "forage")
    assert run_moment_property(outcome, "fetch", library).problem == ""


def test_the_commands_read_it(tmp_path: Path) -> None:
    needs("library")
    shutil.copytree(FOLDER / "library", tmp_path / "library")
    before = contents(tmp_path / "library")
    assert len(run_json("list", "-l", tmp_path / "library")["automata"]) == 8
    run_json("rebuild", "-l", tmp_path / "library")
    assert contents(tmp_path / "library") == before
    evaluated = run_json("eval", "-l", tmp_path / "library", "--behavior", "forage", "--seeds", "0:1")
    assert evaluated["success"] == 1.0
