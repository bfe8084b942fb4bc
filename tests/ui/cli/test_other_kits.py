"""An automaton of another kit in a library is left out with a note; what needs it is refused with the reason."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import ALWAYS, distance_to

from understudy.errors import FileError, LeftOutOfLibrary, OtherKit, UnderstudyError
from understudy.learning.fit import learn
from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, TrainedAutomaton
from understudy.model.value_kinds import Categorical, Continuous
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.library_folder import open_library, save_automaton
from understudy.ui.web.views.library import read_library_folder

GRIP = Feature("grip_force", Continuous(), "grip_force", unit="N")
OTHERS = {  # what an automaton of another kit may have that this kit has not
    "a feature": BoundFeature(GRIP),
    "the kind of a feature": BoundFeature(
        replace(FORAGE_KIT.features["food_left"], kind=Categorical(("some", "none")))
    ),
    "the unit of a feature": BoundFeature(replace(distance_to, unit="mm"), Binding(A="station")),
}
REASON = "the kit has no feature 'grip_force'; its features are"


def make_grasp(feature: BoundFeature = OTHERS["a feature"], name: str = "grasp") -> TrainedAutomaton:
    states = (START, State("close", "forward"), State("done", flag="done"))
    return TrainedAutomaton(Automaton(name, states, (feature,), transitions={"start": ALWAYS}))


def make_user(name: str = "fetch") -> TrainedAutomaton:
    """An automaton that runs grasp, and is of the library's kit itself."""
    states = (START, State("grasp", "grasp"), State("back", "backwards"))
    return TrainedAutomaton(Automaton(name, states, transitions={"start": ALWAYS}))


@pytest.fixture
def joint_library(library: Path) -> Path:
    save_automaton(library, make_grasp())
    return library


@pytest.mark.parametrize("what", OTHERS)
def test_the_others_are_opened(what: str, library: Path) -> None:
    save_automaton(library, make_grasp(OTHERS[what]))
    opened = open_library(library, FORAGE_KIT, learn)
    assert list(opened.library.taught) == ["deposit", "forage", "goto", "harvest"]
    assert list(opened.library.left_out) == ["grasp"]
    with pytest.raises(
        LeftOutOfLibrary, match=r"behavior 'grasp' was left out of the library, .* with the kit it was taught"
    ):
        opened.library.behavior("grasp")
    with pytest.raises(LeftOutOfLibrary, match="automaton 'grasp' was left out"):
        opened.library.with_automaton(make_user()).automaton("grasp")


def test_where_all_are_of_another_kit_that_is_an_error(tmp_path: Path) -> None:
    for name in ("grasp", "press"):
        save_automaton(tmp_path, make_grasp(name=name))
    with pytest.raises(OtherKit, match=r"grasp\.json .*the kit has no feature 'grip_force'"):
        open_library(tmp_path, FORAGE_KIT, learn)


def truncate(text: str) -> str:
    return text[: len(text) // 2]


def test_where_all_need_one_of_another_kit_that_is_an_error(tmp_path: Path) -> None:
    for taught in (make_grasp(), make_user(), make_user("carry")):
        save_automaton(tmp_path, taught)
    with pytest.raises(OtherKit, match=REASON):
        open_library(tmp_path, FORAGE_KIT, learn)


DAMAGES: list[Callable[[str], str]] = [
    truncate,
    lambda text: text.replace('"grip_force"', "7", 1),
    lambda text: text.replace('"continuous"', '"contiguous"'),
    lambda text: text.replace('"done"', '"start"'),
]


@pytest.mark.parametrize("damage", DAMAGES, ids=["cut", "number", "kind", "state"])
def test_a_damaged_file_stays_an_error(damage: Callable[[str], str], joint_library: Path) -> None:
    path = joint_library / "grasp.json"
    path.write_text(damage(path.read_text()))
    with pytest.raises(FileError) as caught:
        open_library(joint_library, FORAGE_KIT, learn)
    assert not isinstance(caught.value, OtherKit)
    assert "grasp.json" in str(caught.value)
    assert run("eval", "-l", joint_library, "--seeds", "0:1").exit_code == 2


OPENING = [
    ["run", "forage", "--behavior", "goto", "--bind", "A=station", "--seconds", "0.2"],
    ["eval", "--behavior", "goto", "--bind", "A=station", "--seeds", "0:1"],
    ["list", "--world", "forage"],
    ["show", "goto", "--world", "forage"],
    ["test", "--world", "forage"],
    ["test"],
    ["check", "--world", "forage", "--worlds", "0", "--fail-on", "never"],
    ["advise", "goto", "--world", "forage"],
    ["rebuild"],
    ["export", "automaton", "goto", "--to", "json", "--bind", "A=station", "--out", "{out}"],
]


@pytest.mark.parametrize("words", OPENING, ids=" ".join)
def test_commands_say_what_was_left_out(words: list[str], joint_library: Path, tmp_path: Path) -> None:
    given = [word.format(out=tmp_path / "out") for word in words]
    result = run(*given, "-l", joint_library, "--json")
    notes = [line for line in result.stderr.splitlines() if line.startswith("Note: grasp is of another kit")]
    assert len(notes) == 1, result.output
    assert "left out" in notes[0]
    assert f"{joint_library / 'grasp.json'} at $.automaton.features[0].name" in notes[0]
    assert REASON in notes[0]
    if words[0] == "advise":  # what is written by hand has no lesson
        assert "it was written by hand" in result.stderr
    else:
        assert result.exit_code == 0, result.output
        json.loads(result.stdout)


NEEDING = [
    ["run", "forage", "--behavior", "{name}"],
    ["eval", "--behavior", "{name}", "--seeds", "0:1"],
    ["show", "grasp", "--world", "forage"],
    ["check", "grasp", "--world", "forage"],
    ["export", "automaton", "{name}", "--world", "forage", "--to", "json", "--out", "{out}"],
    ["advise", "grasp", "--world", "forage"],
]


@pytest.mark.parametrize("name", ["grasp", "fetch"])
@pytest.mark.parametrize("words", NEEDING, ids=" ".join)
def test_what_needs_it_is_refused_with_the_reason(
    words: list[str], name: str, joint_library: Path, tmp_path: Path
) -> None:
    save_automaton(joint_library, make_user())
    result = run(*(word.format(name=name, out=tmp_path / "out") for word in words), "-l", joint_library)
    assert result.exit_code == 2, result.output
    (error,) = [line for line in result.stderr.splitlines() if line.startswith("Error: ")]
    assert REASON in error
    assert not (tmp_path / "out").exists()


def test_a_test_says_which_cannot_run(joint_library: Path) -> None:
    save_automaton(joint_library, make_user())
    result = run("test", "--world", "forage", "-l", joint_library)
    assert REASON in result.output
    assert "fetch" in result.output


def test_the_world_is_that_of_most_automata(joint_library: Path) -> None:
    result = run("test", "-l", joint_library, "--json")
    assert json.loads(result.stdout)["world"] == "forage"
    assert f"Note: the world is forage, which fits 4 of 5 automata of {joint_library}." in result.stderr
    for name in ("press", "turn", "lift"):
        save_automaton(joint_library, make_grasp(name=name))
    result = run("test", "-l", joint_library)
    assert result.exit_code == 2
    assert "cannot be determined" in result.stderr
    told = run_json(
        "export",
        "automaton",
        "forage",
        "-l",
        joint_library,
        "--to",
        "json",
        "--out",
        joint_library.parent / "out",
    )
    assert told["name"] == "forage"


def test_the_studio_says_it_where_it_lists_the_library(joint_library: Path) -> None:
    save_automaton(joint_library, make_user())
    rows = {row.name: row for row in read_library_folder(joint_library, FORAGE_KIT).data([]).trained}
    assert rows["goto"].complete
    assert not rows["grasp"].complete
    assert REASON in (rows["grasp"].problem or "")
    assert not rows["fetch"].complete
    assert (rows["fetch"].problem or "").startswith("behavior 'grasp' was left out of the library")


@pytest.mark.parametrize("kit", [FORAGE_KIT, Kit.from_parts(GRIP)])
def test_an_error_keeps_its_data(kit: Kit, joint_library: Path) -> None:
    """Of a library of two kits, each kit opens its own part."""
    opened = open_library(joint_library, kit, learn)
    assert {*opened.library.taught, *opened.library.left_out} == {
        "deposit",
        "forage",
        "goto",
        "grasp",
        "harvest",
    }
    for name, reason in opened.library.left_out.items():
        with pytest.raises(UnderstudyError) as caught:
            opened.library.automaton(name)
        assert isinstance(caught.value, LeftOutOfLibrary)
        assert (caught.value.name, caught.value.reason) == (name, reason)
