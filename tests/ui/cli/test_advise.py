"""`understudy advise`: what a lesson lacks."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.make.goto_sessions import GOTO, make_goto_session
from tests.ui.cli.commands import run, run_json

from understudy.learning.fit import learn_automaton
from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    lesson = make_goto_session((*GOTO, ("forward", "left", "directive", 0.3, 350)))
    save_automaton(tmp_path / "taught", TrainedAutomaton(learn_automaton(lesson), lesson))
    return tmp_path / "taught"


def test_most_useful_first_as_text_and_as_one_object(folder: Path) -> None:
    told = run_json("advise", "goto", "-l", folder)
    first, *others = told["advice"]
    assert (told["name"], first["kind"], first["examples"]) == ("goto", "contradiction", [2, 7])
    weights = [first["weight"], *(each["weight"] for each in others)]
    assert weights == sorted(weights, reverse=True)
    text = run("advise", "goto", "-l", folder).stdout
    assert "1. Tell me which is right in forward" in text
    assert max(map(len, text.splitlines())) <= 80
    assert len(run_json("advise", "goto", "-l", folder, "--most", 1)["advice"]) == 1
    assert "more: --most" in run("advise", "goto", "-l", folder, "--most", 1).stdout


def test_a_region_is_plain_data_without_what_may_be_anything(folder: Path) -> None:
    gaps = [
        each
        for each in run_json("advise", "goto", "-l", folder, "--most", 50)["advice"]
        if each["kind"] == "gap"
    ]
    behind = next(each["region"] for each in gaps if each["sentence"].count("behind you: I was"))
    ((low, high),) = behind["angle_to(A)"]["parts"]
    assert (round(low, 3), round(high, 3), list(behind)) == (2.356, 3.927, ["angle_to(A)"])


def test_with_a_world_situations_are_those_of_its_robot(folder: Path) -> None:
    asked = ("advise", "goto", "-l", folder, "--world", "forage", "--bind", "A=nearest_food")
    told = run_json(*asked, "--most", 20)
    assert {"gap", "contradiction"} <= {each["kind"] for each in told["advice"]}
    assert told["advice"][0]["evidence"].startswith("I went wrong there in ")
    assert "I went wrong there in" in run(*asked).stdout
    assert not any(each["evidence"] for each in run_json("advise", "goto", "-l", folder)["advice"])
    bad = run("advise", "goto", "-l", folder, "--world", "forage", "--bind", "A=moon")
    assert bad.exit_code == 2
    assert "no target 'moon'" in bad.output


def test_what_cannot_be_advised_on(folder: Path, library: Path) -> None:
    assert run("advise", "nothing", "-l", folder).exit_code == 2
    by_hand = run("advise", "goto", "-l", library)
    assert by_hand.exit_code == 2
    assert "it was written by hand" in by_hand.output
    nowhere = run("advise", "goto", "-l", folder, "--bind", "A=station")
    assert nowhere.exit_code == 2
    assert "--bind: A=station needs a world" in " ".join(nowhere.output.split())
