"""`understudy check`: what can go wrong with a library, without running it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from tests.sim.patrollers import ROBOTS, SCENARIO, lead
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import ALWAYS, distance_to, goto

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.sim.team.libraries import collect_libraries
from understudy.storage.library_folder import save_automaton


def list_findings(result: Any, kind: str) -> list[dict[str, Any]]:
    return [each for each in result["findings"] if each["kind"] == kind]


def break_goto(library: Path) -> None:
    """Let goto stay in forward for good."""
    transitions = MappingProxyType({**goto.transitions, "forward": Tree((make_leaf(1),))})
    save_automaton(library, TrainedAutomaton(replace(goto, transitions=transitions)))


def test_a_library_that_holds(library: Path) -> None:
    result = run_json("check", library)
    assert result["holds"]
    assert {each["name"] for each in result["checked"]} == {"goto", "harvest", "deposit", "forage"}
    assert not [each for each in result["findings"] if each["severity"] == "error"]
    assert "4 automata checked" in run("check", library).stdout


def test_exit_codes_follow_the_severity(library: Path) -> None:
    break_goto(library)
    result = run_json("check", library, "goto")
    (never_left,) = list_findings(result, "state never left")
    assert never_left["severity"] == "warning"
    assert never_left["certain"]
    assert "State forward is never left" in run("check", library, "goto").stdout
    codes = {severity: run("check", library, "goto", "--fail-on", severity).exit_code for severity in
             ("error", "warning", "note", "never")}  # fmt: skip
    assert codes == {"error": 0, "warning": 1, "note": 1, "never": 0}
    failed = run("check", library, "goto", "--fail-on", "warning", "--json")
    assert not json.loads(failed.stdout)["holds"]


def test_an_error_fails_by_default(library: Path) -> None:
    lost = Automaton("lost", (START, State("go", "forward")), transitions={"start": Tree((make_leaf(0),))})
    save_automaton(library, TrainedAutomaton(lost))
    assert run("check", library).exit_code == 1
    assert run("check", library, "goto").exit_code == 0


def test_a_scenario_excludes_what_its_sensors_never_give(library: Path) -> None:
    """Loading without food in reach begins anew for ever: but food is in reach wherever goto arrives."""
    free, tied = run_json("check", library), run_json("check", library, "--world", "forage")
    assert "harvest" in {each["automaton"] for each in list_findings(free, "cycle")}
    assert "harvest" not in {each["automaton"] for each in list_findings(tied, "cycle")}
    assert not free["ties"]
    assert any("at most 0.5 m" in tie for tie in tied["ties"])
    text = " ".join(run("check", library, "--world", "forage", "--all").stdout.split())
    assert "food_left is never absent" in text


def test_a_cell_says_where_in_words_and_numbers(library: Path) -> None:
    cell = list_findings(run_json("check", library, "harvest"), "cycle")[0]["cells"][0]
    assert "distance_to(nearest_food)" in cell["condition"]
    assert cell["ranges"]["distance_to(nearest_food)"]["parts"] == [[None, 0.3]]
    assert cell["at"]["distance_to(nearest_food)"] < 0.3


SPIN = Automaton(
    "spin",
    (START, State("left", "rotate_left"), State("right", "rotate_right"), State("ahead", "forward")),
    (BoundFeature(distance_to, Binding(A="station")),),
    transitions={
        "start": ALWAYS,
        "left": Tree((Node(TestKind.BELOW, 0, high=0.01, yes=1, no=2), make_leaf(3), make_leaf(2))),
        "right": ALWAYS,
        "ahead": ALWAYS,
    },
)
"""Left and right undo each other everywhere but at the station, where left and ahead do."""


def test_warnings_are_tried_in_the_world(tmp_path: Path) -> None:
    save_automaton(tmp_path, TrainedAutomaton(SPIN))
    first, second = list_findings(
        run_json("check", tmp_path, "--world", "forage", "--worlds", "3"), "chatter"
    )
    assert (first["states"], first["trial"]["worlds"], first["trial"]["happened"]) == (
        ["left", "right"],
        3,
        3,
    )
    assert (second["states"], second["trial"]["happened"]) == (["left", "ahead"], 0)
    untried = run_json("check", tmp_path, "--world", "forage", "--worlds", "0")
    assert all(
        each["trial"] is None for each in (*untried["findings"], *run_json("check", tmp_path)["findings"])
    )


def test_how_to_show_what_did_not_happen_is_left_out(tmp_path: Path) -> None:
    save_automaton(tmp_path, TrainedAutomaton(SPIN))
    arguments = ("check", tmp_path, "--world", "forage", "--worlds", "3")
    short = " ".join(run(*arguments).stdout.split())
    assert "at every tick. It happens in 3 of 3 worlds. → Put the robot into left" in short
    assert short.index("It happens in 3 of 3 worlds.") < short.index("It did not happen in 3 worlds.")
    assert short.count("→ Put the robot") == 1
    assert run(*arguments, "--all").stdout.count("→ Put the robot") == 2


def test_what_is_assumed_of_cells_is_said_once(library: Path) -> None:
    text = " ".join(run("check", library).stdout.split())
    assert "assumes: readings of this cell occur" not in text
    assert "findings assume that such readings occur: --world tries how often" in text
    assert "assumes: readings of this cell occur" in " ".join(run("check", library, "--all").stdout.split())


@pytest.fixture
def team(tmp_path: Path) -> Path:
    folder = tmp_path / "team"
    for taught in ROBOTS.taught.values():
        save_automaton(folder, taught)
    return folder


def test_coordinators(team: Path) -> None:
    kit = collect_libraries(SCENARIO, ROBOTS)["patrol"].kit
    library = Library.from_automata(kit, lead())
    save_automaton(team / "patrol", library.taught["lead"])
    result = run_json("check", team, "--world", "patrol", "--worlds", "0")
    assert "patrol/lead" in {each["name"] for each in result["checked"]}
    assert not list_findings(result, "missing behavior")
    states = (START, State("go", "fly"))
    save_automaton(
        team / "patrol", TrainedAutomaton(Automaton("wrong", states, transitions={"start": ALWAYS}))
    )
    failed = run("check", team, "patrol/wrong", "--world", "patrol", "--json")
    assert failed.exit_code == 1
    (missing,) = list_findings(json.loads(failed.stdout), "missing behavior")
    assert "orders fly, for which no member" in missing["sentence"]


def test_a_flag_that_nothing_raises(library: Path) -> None:
    never = MappingProxyType(
        {**goto.transitions, **dict.fromkeys(("start", "forward", "left", "right"), ALWAYS)}
    )
    save_automaton(library, TrainedAutomaton(replace(goto, transitions=never)))
    result = run("check", library, "--json")
    assert result.exit_code == 1
    waiting = {each["automaton"] for each in list_findings(json.loads(result.stdout), "flag never raised")}
    assert waiting == {"harvest", "deposit", "forage"}  # each waits for the one below it


BAD = [
    (("{library}", "nothing"), "has no automaton 'nothing'"),
    (("{nowhere}",), "nowhere"),
    (("{library}", "--world", "moon"), "moon"),
    (("{library}", "--fail-on", "luck"), "luck"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD)
def test_what_cannot_be_checked_is_said(library: Path, arguments: tuple[str, ...], words: str) -> None:
    given = [each.format(library=library, nowhere=library / "nowhere") for each in arguments]
    result = run("check", *given)
    assert result.exit_code == 2
    assert words in result.output + result.stderr
    assert "Traceback" not in result.output


def test_a_broken_file_is_no_finding(library: Path) -> None:
    (library / "goto.json").write_text("{}", encoding="utf-8")
    result = run("check", library)
    assert result.exit_code == 2
    assert "goto.json" in result.stderr
