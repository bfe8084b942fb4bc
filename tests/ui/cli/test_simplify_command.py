"""`understudy simplify`: what would change is shown, and nothing changes unless it is to be kept."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import goto

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton

TABLE = ["state,next,kind,distance:continuous"]
TABLE += [f"go,{'stop' if number < 20 else 'go'},directive,{number / 4}" for number in range(40)]
TABLE[1 + 6], TABLE[1 + 33] = "go,go,confirmation,1.5", "go,stop,directive,8.25"


def learn_library(folder: Path, lines: list[str]) -> Path:
    table, library = folder / "lesson.csv", folder / "library"
    table.write_text("\n".join(lines).replace("go,go,directive", "go,go,confirmation") + "\n")
    assert run("learn", table, "-l", library, "-n", "walk").exit_code == 0
    return library


@pytest.fixture
def library(tmp_path: Path) -> Path:
    return learn_library(tmp_path, TABLE)


def test_dry_by_default(library: Path) -> None:
    before = (library / "walk.json").read_bytes()
    told = run_json("simplify", "walk", "-l", library)
    assert told["suggested"] == {"pruning": told["pruning"], "left_out": 40, "wrong": 5, "wrong_pruned": 3}
    assert told["leaves"] == {"before": 6, "after": 2}
    assert told["conditions"]["go"]["after"] == ["stop when distance is below 4.88", "stays otherwise"]
    assert [(row["number"], row["before"], row["after"], row["shown"]) for row in told["decisions"]] == [
        (6, "go", "stop", "go"),
        (33, "stop", "go", "stop"),
    ]
    text = run("simplify", "walk", "-l", library).stdout
    assert "examples left out in turn: 3 of 40 wrong, 5 without pruning" in text
    assert "  + stop when distance is below 4.88\n" in text
    assert "2 of 40 examples would be decided otherwise" in text
    assert "33 in go: stop → go (shown: stop)" in text
    assert "Nothing was changed" in text
    assert (library / "walk.json").read_bytes() == before


def test_kept_and_taken_back(library: Path) -> None:
    before = run_json("show", "walk", "-l", library)["conditions"]
    told = run_json("simplify", "walk", "-l", library, "--keep")
    assert told["kept"]
    now = run_json("show", "walk", "-l", library)
    assert now["conditions"]["go"] == told["conditions"]["go"]["after"]
    assert now["options"]["pruning"] == told["pruning"]
    assert run_json("diff", "walk", "-l", library)["changes"]["options"] == [f"+ pruning: {told['pruning']}"]
    assert now["rebuilt"] is None
    back = run_json("simplify", "walk", "-l", library, "--pruning", "0", "--keep")
    assert back["leaves"] == {"before": 2, "after": 6}
    assert run_json("show", "walk", "-l", library)["conditions"] == before


def test_a_small_lesson_is_better_left_as_it_is(tmp_path: Path) -> None:
    small = learn_library(tmp_path, TABLE[:1] + TABLE[15:25])
    text = " ".join(run("simplify", "walk", "-l", small).stdout.split())
    assert "too few to prune" in text
    refused = run("simplify", "walk", "-l", small, "--keep")
    assert refused.exit_code == 2
    assert "say how much with --pruning" in " ".join(refused.output.split())
    assert run_json("simplify", "walk", "-l", small, "--keep", "-p", "9")["leaves"]["after"] == 1


def test_how_to_keep_it_all_the_same(tmp_path: Path) -> None:
    """Nothing was suggested, so it has to be said how much; one of the ten was pressed wrong."""
    small = learn_library(tmp_path, TABLE[:11])
    assert (
        "Nothing was changed: --pruning 1 --keep saves it so" in run("simplify", "walk", "-l", small).stdout
    )
    assert run_json("simplify", "walk", "-l", small, "--pruning", "1", "--keep")["leaves"]["after"] == 1


def test_what_has_no_questions(library: Path, tmp_path: Path) -> None:

    save_automaton(tmp_path / "other", TrainedAutomaton(goto))
    for name, folder, told in (("goto", tmp_path / "other", "written by hand"), ("x", library, "reading")):
        refused = run("simplify", name, "-l", folder)
        assert refused.exit_code == 2
        assert told in " ".join(refused.output.split())
