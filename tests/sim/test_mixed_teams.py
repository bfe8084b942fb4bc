"""Teams of types that differ: each has a kit, a library and a folder of its own, under one coordinator of both."""

from __future__ import annotations

from pathlib import Path

import pytest

from understudy.errors import DefinitionError, FileError, SettingError
from understudy.model.automaton import START, Automaton, State
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import Tree, make_leaf
from understudy.sim.kit import have_different_kits, make_scenario_kit, make_type_kits
from understudy.sim.scenario.files import load_scenario, parse_scenario
from understudy.sim.team.libraries import (
    Libraries,
    collect_libraries,
    find_behavior_sort,
    find_type_folders,
    list_running_sorts,
    load_type_libraries,
    make_team,
)
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.lesson_design import parse_feature

SALVAGE = load_scenario("salvage")
KIT = make_scenario_kit(SALVAGE)
KITS = make_type_kits(SALVAGE, KIT)
ALIKE = parse_scenario(
    """
understudy = "scenario"
version = 1
size = [9, 9]
types.red = { color = "red", behaviors = { go = { drive = 1 } } }
types.blue = { color = "blue", behaviors = { go = { drive = 1 } } }
robots = [{ type = "red" }, { type = "blue" }]
"""
)


def make_constant_automaton(name: str, behavior: str) -> Automaton:
    """An automaton that does one thing for good."""
    states = (START, State("on", behavior))
    return Automaton(name, states, (), (), False, {"start": Tree((make_leaf(1),))})


def make_libraries() -> Libraries:
    """Scouts and carriers who both roam, and carriers who haul; a crew that is led."""
    scouts = Library.from_automata(
        KITS["scout"],
        make_constant_automaton("roam", "forward"),
        make_constant_automaton("explore", "forward"),
    )
    carriers = Library.from_automata(
        KITS["carrier"],
        make_constant_automaton("roam", "rotate_left"),
        make_constant_automaton("haul", "load"),
        make_constant_automaton("gather", "unload"),
    )
    return collect_libraries(
        SALVAGE,
        {"scout": scouts, "carrier": carriers},
        lambda name, kit: Library.from_automata(kit, make_constant_automaton("lead", "share")),
    )


def test_the_kit_of_a_type_has_what_it_senses_and_does_itself() -> None:
    scout, carrier = KITS["scout"], KITS["carrier"]
    own = {"stored", "salvage_here", "at_harbor", "food_left"}
    assert set(carrier.features) == set(KIT.features)
    assert set(KIT.features) - set(scout.features) == own
    assert set(KIT.behaviors) - set(scout.behaviors) == {"load", "unload"}
    assert list(scout.targets) == list(KIT.targets)


def test_types_that_do_not_differ_share_the_kit_and_the_folder(tmp_path: Path) -> None:
    kit = make_scenario_kit(ALIKE)
    assert all(each is kit for each in make_type_kits(ALIKE, kit).values())
    assert not have_different_kits(make_type_kits(ALIKE, kit))
    assert find_type_folders(ALIKE, tmp_path, kit) == {"red": (tmp_path, kit), "blue": (tmp_path, kit)}
    found = load_type_libraries(ALIKE, tmp_path, kit, lambda where, kit: Library(kit))
    assert found["red"] is found["blue"]


FOLDERS = [  # what is there: whose automata are where
    ((), {"scout": "scout", "carrier": "carrier"}),
    (("scout/roam",), {"scout": "scout", "carrier": "carrier"}),
    (("roam",), {"scout": "", "carrier": ""}),  # an old folder, from before types had their own
    (("roam", "carrier/haul"), {"scout": "", "carrier": "carrier"}),
]


@pytest.mark.parametrize(("there", "expected"), FOLDERS)
def test_where_automata_of_a_type_are(
    tmp_path: Path, there: tuple[str, ...], expected: dict[str, str]
) -> None:
    for path in there:
        *folders, name = path.split("/")
        save_automaton(
            tmp_path.joinpath(*folders), TrainedAutomaton(make_constant_automaton(name, "forward"))
        )
    found = find_type_folders(SALVAGE, tmp_path, KIT)
    assert {name: where for name, (where, _) in found.items()} == {
        name: tmp_path / folder if folder else tmp_path for name, folder in expected.items()
    }
    assert all((kit is KIT) == (where == tmp_path) or kit == KIT for where, kit in found.values())


def test_whose_behavior_is_meant() -> None:
    libraries = make_libraries()
    names = ("explore", "haul", "lead", "load", "carrier/roam", None)
    assert [find_behavior_sort(libraries, name) for name in names] == [
        "scout", "carrier", "crew", "carrier", "carrier", "crew",
    ]  # fmt: skip
    with pytest.raises(SettingError, match="several sorts of robots; name it as scout/roam and carrier/roam"):
        find_behavior_sort(libraries, "roam")


def test_a_basic_behavior_is_run_by_all_who_have_it() -> None:
    libraries = make_libraries()
    assert list_running_sorts(libraries, "scout", "forward") == ["scout", "carrier"]
    assert list_running_sorts(libraries, "carrier", "load") == ["carrier"]
    assert list_running_sorts(libraries, "carrier", "roam") == ["carrier"]
    alike = collect_libraries(
        ALIKE, Library.from_automata(make_scenario_kit(ALIKE), make_constant_automaton("on", "go"))
    )
    assert list_running_sorts(alike, "red", "on") == ["red", "blue"]


def test_each_type_runs_its_own_automaton_of_a_name() -> None:
    team = make_team(SALVAGE, [3], make_libraries(), {"scout": ("roam", {}), "carrier": ("roam", {})})
    headings = team.ground.sense([("bearing", "harbor")])
    team.run(10)
    turned = team.ground.sense([("bearing", "harbor")])["bearing", "harbor"] - headings["bearing", "harbor"]
    assert team.paths == [("on",)] * 12
    assert (abs(turned[4:]) > 0.5).all()  # scouts cannot tell where the harbor is


def test_an_order_to_both_roles_splits_one_of_them() -> None:
    """Four scouts explore; of eight carriers a third, that is three, gather, and the others haul."""
    team = make_team(SALVAGE, [3], make_libraries(), {"crew": ("lead", {})})
    team.run(2)
    assert [path[0] for path in team.paths] == ["explore"] * 4 + ["gather"] * 3 + ["haul"] * 5


def test_an_order_asks_of_nobody_what_their_own_library_has_not() -> None:
    libraries = dict(make_libraries())
    libraries["scout"] = Library.from_automata(KITS["scout"], make_constant_automaton("roam", "forward"))
    with pytest.raises(DefinitionError, match=r"its scouts \(scout\) have no behavior 'explore'"):
        make_team(SALVAGE, [3], libraries, {"crew": ("lead", {})})


def test_an_automaton_of_another_type_is_refused_by_its_folder(tmp_path: Path) -> None:
    carriers, kit = Library(KITS["carrier"]), KITS["scout"]
    stored = parse_feature(carriers, "stored")
    wrong = Automaton("full", (START,), (stored,), (), False, {})
    save_automaton(tmp_path / "scout", TrainedAutomaton(wrong))
    with pytest.raises(FileError, match="stored"):
        open_library(tmp_path / "scout", kit)
