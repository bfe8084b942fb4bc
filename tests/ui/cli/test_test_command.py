"""`understudy test`: a library on its own lessons, beside what it was."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace as replace_fields
from tests.sim.patrollers import ROBOTS, SCENARIO
from tests.ui.cli.commands import run, run_json
from tests.ui.cli.forage_parts import goto

from understudy.judging.properties.stored_moments import add_moment_property, make_moment_property
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import START, Automaton, State
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.property import StoredMoment
from understudy.model.tree import Tree, make_leaf
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import format_scenario
from understudy.sim.team.libraries import collect_libraries, make_coordinator_body
from understudy.storage.library_folder import open_library, save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.cli import library_tests
from understudy.ui.cli.library_tests import LibrarySetting
from understudy_lab.bench.patrol import lead


@pytest.fixture
def fetch_library(library: Path) -> Path:
    """The library with an automaton that fetches something from the station, which promises to be there in time."""
    known = open_library(library, FORAGE_KIT).library
    lesson = new_lesson(
        known, "fetch", states=["goto(station)"], flags=["done"], features=["done"], live=False
    )
    session = Session(Forage([9]), known, lesson)
    session.direct("goto")
    session.run_for(60.0)
    session.direct("done")
    session.tick()
    session.reset(11)
    add_moment_property(session, flag="done", within_s=60.0)
    save_automaton(library, session.make_trained_automaton())
    return library


def run_test(folder: Path, *arguments: object) -> dict[str, dict[str, Any]]:
    return {each["name"]: each for each in run_json("test", folder, *arguments)["automata"]}


def run_failing(folder: Path) -> tuple[dict[str, dict[str, Any]], str]:
    result = run("test", folder, "--json")
    assert result.exit_code == 1, result.output
    text = run("test", folder)
    assert text.exit_code == 1
    return {each["name"]: each for each in json.loads(result.stdout)["automata"]}, " ".join(
        text.stdout.split()
    )


def test_all_as_shown(fetch_library: Path) -> None:
    told = run_json("test", fetch_library)
    assert (told["world"], told["works"]) == ("forage", True)
    (fetch,) = (each for each in told["automata"] if each["name"] == "fetch")
    assert fetch["examples"] == 3
    assert fetch["outcomes"][0]["took_s"] > 1.0
    text = run("test", fetch_library)
    assert text.exit_code == 0
    assert "✓ fetch 3 examples, 1 property\n" in text.stdout
    assert "✓ goto nothing recorded\n" in text.stdout
    assert text.stdout.endswith("library, in forage: 5 automata, all as shown\n")


def test_an_outcome_that_no_longer_comes(fetch_library: Path) -> None:
    """Whoever changes GoTo is told what that does to those who run it."""
    save_automaton(
        fetch_library, TrainedAutomaton(replace(goto, transitions={"start": Tree((make_leaf(0),))}))
    )
    told, text = run_failing(fetch_library)
    assert told["fetch"]["failed"] == [
        {"outcome": "done is raised within 60 s in forage", "problem": None, "comes_with_former": ["goto"]}
    ]
    assert (told["goto"]["works"], told["goto"]["former"]) == (True, 1)
    assert told["goto"]["affected"] == ["deposit", "fetch", "harvest", "forage"]
    assert (
        "property fails: done is raised within 60 s in forage; it holds with the former version of goto"
        in text
    )
    assert "changed since version 1; deposit, fetch, harvest and forage run it" in text
    assert "5 automata, 1 does not do what was shown" in text


def test_two_outcomes_of_one_wording(fetch_library: Path) -> None:
    """Each says what is wrong with itself."""
    taught = open_library(fetch_library, FORAGE_KIT).library.taught["fetch"]
    assert taught.lesson is not None
    (fine,) = taught.lesson.properties
    assert isinstance(fine.start, StoredMoment)
    slow = replace(fine, seconds=0.2)
    broken = replace(slow, start=replace(fine.start, snapshot=b"nothing"))
    save_automaton(
        fetch_library, TrainedAutomaton(taught.automaton, replace(taught.lesson, properties=(slow, broken)))
    )
    told, text = run_failing(fetch_library)
    first, second = told["fetch"]["failed"]
    assert (first["problem"], "snapshot" in second["problem"]) == (None, True)
    assert text.count("is not a snapshot") == 1


def test_a_press_that_is_no_longer_heeded(fetch_library: Path) -> None:
    """Two say otherwise at the very same moment: the one that was right is outvoted."""
    taught = open_library(fetch_library, FORAGE_KIT).library.taught["fetch"]
    assert taught.lesson is not None
    first = taught.lesson.examples[0]
    against = [replace(first, number=number, next="done") for number in (8, 9)]
    lesson = replace(taught.lesson, examples=(*taught.lesson.examples, *against), properties=())
    save_automaton(fetch_library, TrainedAutomaton(learn_automaton(lesson), lesson))
    told, text = run_failing(fetch_library)
    assert told["fetch"]["no_longer"] == [
        "where it went from start to goto as shown (example 1), it now goes to done"
    ]
    assert told["fetch"]["otherwise"] == [1]
    assert "where it went from start to goto as shown (example 1), it now goes to done" in text
    assert "1 example decided differently than shown: 1" in text


def test_a_coordinator_is_tested_with_its_robots(tmp_path: Path) -> None:
    for automaton in (ROBOTS.automaton(name) for name in ROBOTS.taught):
        save_automaton(tmp_path, TrainedAutomaton(automaton))
    known = collect_libraries(SCENARIO, ROBOTS, lambda name, kit: Library.from_automata(kit, lead()))
    coordinator_body = make_coordinator_body(SCENARIO, "patrol", known)
    lesson = new_lesson(
        known["patrol"], "out", states=["wander"], flags=["done"], features=["all_done"], live=False
    )
    session = Session(coordinator_body, known["patrol"], lesson)
    session.direct("wander")
    session.run_for(1.0)
    session.direct("done")
    session.tick()
    outcome = make_moment_property(session, flag="done", within_s=3.0)
    assert isinstance(outcome.start, StoredMoment)
    assert (outcome.start.sort, outcome.start.agent) == ("patrol", 0)
    add_moment_property(session, flag="done", within_s=3.0)
    save_automaton(tmp_path / "patrol", session.make_trained_automaton())
    told = run_test(tmp_path)
    assert set(told) == {"wander", "servo", "patrol", "patrol/out"}
    assert told["patrol/out"]["works"]
    wander = ROBOTS.automaton("wander")
    save_automaton(
        tmp_path, TrainedAutomaton(replace(wander, transitions={"start": wander.transitions["start"]}))
    )
    assert run_test(tmp_path)["wander"]["affected"] == ["patrol", "patrol/out"]


def test_the_folder_as_an_option(fetch_library: Path, tmp_path: Path) -> None:
    """As all other commands have it."""
    assert (
        run_json("test", "-l", fetch_library)
        == run_json("test", fetch_library)
        == run_json("test", fetch_library, "-l", fetch_library)
    )
    refused = run("test", fetch_library, "-l", tmp_path)
    assert refused.exit_code == 2
    assert "name one of them" in " ".join(refused.output.split())


@pytest.mark.parametrize("command", [("test",), ("rebuild", "-l")])
def test_a_world_that_is_found_out_is_named(command: tuple[str, ...], library: Path, tmp_path: Path) -> None:
    """A scenario of one's own cannot be guessed: that is said, with what was tried, and it can be named."""
    assert run_json(*command, library)["world"] == "forage"
    assert f"{library}, in forage: " in run(*command, library).stdout
    mine = tmp_path / "mine.toml"
    text = run("worlds", "forage").stdout.replace('name = "forage"', 'name = "mine"')
    own = '[features]\nhunger = { reading = "food_stored", doc = "How empty it is." }'
    mine.write_text(text.replace("[features]", own))
    known = Library(make_scenario_kit(find_scenario(str(mine))))
    lesson = new_lesson(known, "eat", states=["forward"], features=["hunger"], live=False)
    folder = tmp_path / "mine"
    save_automaton(folder, TrainedAutomaton(learn_automaton(lesson), lesson))
    refused = run(*command, folder)
    assert refused.exit_code == 2
    told = " ".join(refused.output.split())
    assert "--world cannot be determined: none of the scenarios forage, arena, boxes," in told
    assert "has everything that its automata use" in told
    assert "give the scenario, such as --world my-scenario.toml" in told
    assert run_json(*command, folder, "--world", mine)["world"] == "mine"


def test_the_world_of_a_squads_library_is_found_out(tmp_path: Path) -> None:
    """A coordinator's automaton belongs to it, however little the robots' automata need."""
    roam = Automaton(
        "roam", (START, State("forwards", "forwards")), (), (), False, {"start": Tree((make_leaf(1),))}
    )
    save_automaton(tmp_path, TrainedAutomaton(roam))
    order = Automaton(
        "order", (START, State("roam", "roam")), (), (), False, {"start": Tree((make_leaf(1),))}
    )
    save_automaton(tmp_path / "patrol", TrainedAutomaton(order))
    assert run_json("rebuild", "-l", tmp_path)["world"] == "patrol"
    assert set(run_test(tmp_path)) == {"roam", "patrol/order"}


def test_mistakes(tmp_path: Path, library: Path) -> None:
    refused = run("test", tmp_path / "nothing")
    assert (refused.exit_code, "opening the library" in refused.output) == (2, True)
    (tmp_path / "nothing").mkdir()
    refused = run("test", tmp_path / "nothing")
    assert refused.exit_code == 2
    assert "name a folder with automata" in " ".join(refused.output.split())


def test_the_one_bad_file_is_named(library: Path) -> None:
    """All others are of the foraging world: what is wrong elsewhere is nobody's business."""
    (library / "goto.json").write_text("{")
    refused = run("test", library)
    assert refused.exit_code == 2
    assert "goto.json" in refused.output
    assert "feature" not in refused.output


PROPERTIES = """understudy = "properties"
version = 1
[delivers]
behavior = "forage"
world = "forage"
seeds = 5
always = "goal"
within_s = 600
[hurries]
behavior = "forage"
world = "forage"
seeds = 5
always = "goal"
within_s = 30
"""


def test_properties_in_worlds(library: Path) -> None:
    (library / "properties.toml").write_text(PROPERTIES.partition("[hurries]")[0])
    told = run_json("test", library)
    assert told["works"]
    (delivers,) = told["properties"]
    assert (delivers["verdict"], delivers["worlds"], delivers["failed"]) == ("holds", 5, [])
    (library / "properties.toml").write_text(PROPERTIES)
    result = run("test", library, "--json")
    assert result.exit_code == 1
    told = json.loads(result.stdout)
    assert not told["works"]
    hurries = told["properties"][1]
    assert (hurries["property"], hurries["failures"]) == ("goal is reached within 30 s", 5)
    assert hurries["failed"][0]["failed_s"] == pytest.approx(30.0)
    text = run("test", library)
    assert text.exit_code == 1
    assert "✗ hurries forage in forage: goal is reached within 30 s\n" in text.stdout
    assert "2 properties: 1 fails, 1 holds\n" in text.stdout


def test_an_undecided_property_fails_with_strict(library: Path) -> None:
    few = PROPERTIES.partition("[hurries]")[0] + "at_least = 0.99\n"
    (library / "properties.toml").write_text(few)
    told = run("test", library)
    assert (told.exit_code, "1 property: 1 undecided\n" in told.stdout) == (0, True)
    assert "give at least 535 seeds" in " ".join(told.stdout.split())
    assert run("test", library, "--strict").exit_code == 1
    (library / "properties.toml").write_text(few.replace("0.99", "0.1"))
    assert run("test", library, "--strict").exit_code == 0


MISTAKES = [  # what is written instead, the key that is named
    (('"goal"', '"front is below 1 m"'), "delivers.always: the body has no feature or reading 'front'"),
    (('"goal"', '"distance_to(station) is below 1"'), "delivers.always: '1' has no unit"),
    (('"goal"', '"failed is raised"'), "delivers.always: the behavior has no flag 'failed'"),
    (
        ('"goal"', '"angle_to(station) is above 200°"'),
        "delivers.always: 'angle_to(station) is above 200°' is about a value from −180° to 180°",
    ),
    (
        ('"goal"', '"x is at least 2 m and below 1 m"'),
        "delivers.always: 'x is at least 2 m and x is below 1 m' can",
    ),
    (('behavior = "forage"', 'behavior = "fly"'), "delivers.behavior: "),
    (('world = "forage"', 'world = "mars"'), "delivers.world: "),
    (('world = "forage"', 'world = "plain.toml"'), "delivers.always: scenario 'plain': goal is missing"),
]


@pytest.mark.parametrize(("change", "said"), MISTAKES)
def test_a_mistake_in_properties(change: tuple[str, str], said: str, library: Path) -> None:
    plain = replace_fields(find_scenario("forage"), goal=None, name="plain")
    (library / "plain.toml").write_text(format_scenario(plain))
    (library / "properties.toml").write_text(PROPERTIES.replace(*change, 1))
    refused = run("test", library)
    assert refused.exit_code == 2
    assert f"properties.toml at {said}" in " ".join(refused.output.split())
    assert "Traceback" not in refused.output


def test_what_is_left_is_estimated_by_kind(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The first of a kind may have loaded kernels, for 2 s; of a kind that was not run yet nothing is known."""
    now_s, estimates = 0.0, list[float]()

    def lesson(setting: LibrarySetting, took_s: float) -> float:
        nonlocal now_s
        now_s += took_s
        return took_s

    def failure(setting: LibrarySetting, took_s: float) -> float:
        return lesson(setting, took_s)

    def run_here(
        calls: Iterable[Callable[[], float]], *, jobs: int, estimate_left_s: Callable[[], float]
    ) -> Iterator[tuple[int, Future[float]]]:
        for number, call in enumerate(calls):
            estimates.append(estimate_left_s())
            future = Future[float]()
            future.set_result(call())
            yield number, future

    monkeypatch.setattr(library_tests, "share_calls", run_here)
    calls = [(lesson, 1.5), (lesson, 0.5), (lesson, 0.25), (failure, 7.0), (failure, 6.0), (failure, 1.0)]
    setting = LibrarySetting(tmp_path, None, None)
    found = library_tests._run(setting, calls, 4, lambda done, total: None, lambda: now_s)
    assert found == [1.5, 0.5, 0.25, 7.0, 6.0, 1.0]
    assert estimates == [0.0, 0.0, 0.5, 0.0, 10.0, 6.0]
