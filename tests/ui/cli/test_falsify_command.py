"""`understudy falsify`: failing worlds from the command line."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator, Sequence
from functools import partial
from math import hypot
from pathlib import Path

import pytest
from msgspec.structs import replace
from tests.falsification.planted import FORAGE, TOO_FAR, make_library, make_measure, plant_idleness
from tests.ui.cli.commands import run, run_json

from understudy.addons.checks.falsification import falsify
from understudy.addons.checks.falsification.failing_world import read_failing_world
from understudy.addons.checks.falsification.failure_replay import compute_end_hash
from understudy.addons.checks.falsification.random_search import RandomSearch
from understudy.addons.checks.falsification.shrink import shrink_failure
from understudy.model.library import TrainedAutomaton
from understudy.model.value_kinds import Column
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.scenario.files import format_scenario
from understudy.sim.world import World
from understudy.storage.library_folder import save_automaton

WORLDS = 40
"""In 6 of them the forager of the planted library fails."""
MOST_RUNS = 60
"""How many runs make a failing world simpler: what comes of more is tested with the search itself."""


@pytest.fixture(autouse=True)
def soon_simple_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Failing worlds are made simpler for some runs only."""
    monkeypatch.setattr(falsify, "shrink_failure", partial(shrink_failure, most_runs=MOST_RUNS))


@pytest.fixture
def planted_library(library: Path) -> Path:
    """A library whose forager stays where it is if its target is 9 m away or more."""
    save_automaton(library, TrainedAutomaton(plant_idleness(TOO_FAR)))
    return library


@pytest.mark.long
def test_a_failing_world_is_kept(planted_library: Path, tmp_path: Path) -> None:
    out = tmp_path / "failures"
    options = ("falsify", planted_library, "forage", "--worlds", WORLDS, "--limit", 600, "-o", out)
    result = run(*options, "--json")
    assert result.exit_code == 1, result.output
    found = json.loads(result.stdout)
    assert found["random"]["runs"] == WORLDS
    assert found["random"]["low"] < found["random"]["failed"] / WORLDS < found["random"]["high"]
    assert len(found["random"]["seeds"]) == found["random"]["failed"]
    assert found["directed"] is None
    failure = found["failure"]
    kept = read_failing_world(failure["folder"])
    assert kept.folder == out / "forage-1"
    assert kept.trial.seed == failure["seed"]
    assert compute_end_hash(make_measure(), kept.trial) == kept.facts.end_hash
    again = run_json(*failure["command"].split()[1:])
    assert again["success"] is False
    text = run(*options)
    assert text.exit_code == 1
    assert "forage fails in" in text.stdout
    assert sorted(each.name for each in out.iterdir()) == ["forage-1", "forage-2"]


def test_no_failing_world(library: Path, tmp_path: Path) -> None:
    options = ("falsify", library, "forage", "--worlds", 40, "--seconds", 1, "-o", tmp_path / "none")
    found = run_json(*options)
    assert found["failure"] is None
    assert found["random"]["failed"] == 0
    assert found["directed"]["runs"] > 0
    assert found["directed"]["failed"] == 0
    assert not (tmp_path / "none").exists()
    result = run(*options)
    assert result.exit_code == 0
    assert "No failing world was found. That is no proof" in result.stdout


PROPERTIES = """
understudy = "properties"
version = 1

[arrives]
behavior = "forage"
world = "forage"
seeds = 1
always = "goal is reached"
within_s = 200

[stays_near]
behavior = "forage"
world = "forage"
seeds = 1
never = "distance(robot, station) is above 9 m"

[dances]
behavior = "forage"
world = "forage"
seeds = 1
never = "waltz is raised"
"""


def test_a_world_in_which_a_property_fails(planted_library: Path, tmp_path: Path) -> None:
    """That the goal is reached in time fails in the same worlds as the goal is missed; another property elsewhere."""
    (planted_library / "properties.toml").write_text(PROPERTIES, encoding="utf-8")
    options = (
        "falsify",
        planted_library,
        "forage",
        "--worlds",
        WORLDS,
        "-o",
        tmp_path / "failures",
        "--json",
    )
    by_goal = json.loads(run(*options, "--limit", 200).stdout)
    arrives = json.loads(run(*options, "--property", "arrives").stdout)
    assert sorted(arrives["random"]["seeds"]) == sorted(by_goal["random"]["seeds"])
    assert arrives["limit_s"] == 200.0
    near = json.loads(run(*options, "--limit", 200, "--property", "stays_near").stdout)
    assert sorted(near["random"]["seeds"]) != sorted(by_goal["random"]["seeds"])
    wrong_s = near["failure"]["wrong_s"]
    assert (
        near["failure"]["why"][0]
        == f"At {wrong_s:.1f} s it failed: never distance(robot, station) is above 9 m."
    )
    kept = read_failing_world(near["failure"]["folder"])
    world = World(kept.trial.scenario, [kept.trial.seed])
    engine = Engine.from_program(world, link(make_library(TOO_FAR), "forage", {}))
    for _ in range(round(wrong_s / world.tick_s)):
        assert measure_way_home(world) <= 9.0
        engine.tick()
    assert measure_way_home(world) > 9.0


def measure_way_home(world: World) -> float:
    """The distance of the robot from the station, m."""
    view = world.view()
    station = view.names.classes.index("station")
    (x,), (y,) = (each[view.objects.kind == station] for each in (view.objects.x, view.objects.y))
    return hypot(view.robots.x[0] - x, view.robots.y[0] - y)


MISTAKES = [
    (("--property", "sings"), "--property names 'sings'"),
    (("--property", "dances"), "waltz"),
    (("--seconds", "0"), "--seconds is 0"),
    (("--worlds", "0"), "--worlds is 0"),
    (("--vary", "walls"), "--vary is 'walls'"),
    (("--limit", "0.01"), "--limit is 0.01 s"),
    (("--world", "nowhere"), "nowhere"),
]


@pytest.mark.parametrize(("options", "message"), MISTAKES)
def test_mistakes(library: Path, options: tuple[str, ...], message: str) -> None:
    (library / "properties.toml").write_text(PROPERTIES, encoding="utf-8")
    result = run("falsify", library, "forage", *options)
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())


def test_a_world_without_a_goal(library: Path, tmp_path: Path) -> None:
    path = tmp_path / "endless.toml"
    path.write_text(format_scenario(replace(FORAGE, goal=None)))
    result = run("falsify", library, "forage", "--world", path)
    assert result.exit_code == 2
    assert "goal is missing" in " ".join(result.stderr.split())


def test_a_file_where_failing_worlds_should_go(library: Path, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("kept")
    result = run("falsify", library, "forage", "-o", tmp_path / "taken")
    assert result.exit_code == 2
    assert "--out" in result.stderr
    assert (tmp_path / "taken").read_text() == "kept"


def test_a_behavior_that_does_not_exist(library: Path) -> None:
    result = run("falsify", library, "forag")
    assert result.exit_code == 2
    assert "forag" in result.stderr


@pytest.fixture
def heeds_interrupts() -> Iterator[None]:
    """SIGINT is heeded, also where a shell has started the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeds_interrupts")
def test_an_interrupted_search_keeps_what_it_found(
    planted_library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C comes as soon as the search has found a failing world."""
    add = RandomSearch.add

    def add_and_interrupt(found: RandomSearch, seeds: Sequence[int], values: Column) -> None:
        add(found, seeds, values)
        if found.failed:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(RandomSearch, "add", add_and_interrupt)
    options = ("--seconds", 600, "--limit", 600, "-o", tmp_path / "failures", "--json")
    done = run("falsify", planted_library, "forage", *options)
    assert done.exit_code == 1
    found = json.loads(done.stdout)
    assert found["interrupted"]
    assert found["random"]["failed"] > 0
    assert read_failing_world(found["failure"]["folder"]).facts.robustness < 0
