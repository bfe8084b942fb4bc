"""Failing worlds: as simple as possible, explained, kept in a folder, replayed bit for bit, and listed in order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace
from tests.falsification.kept import MEASURE, keep
from tests.falsification.planted import FORAGE, make_measure

from understudy.addons.checks.falsification.directed_search import search_directed
from understudy.addons.checks.falsification.failing_world import (
    FACTS_FILE,
    SCENARIO_FILE,
    FailingWorld,
    FailureFacts,
    choose_folder,
    compare_failures,
    list_failing_worlds,
    order_failing_worlds,
    read_failing_world,
)
from understudy.addons.checks.falsification.failure_replay import compute_end_hash
from understudy.addons.checks.falsification.falsify import falsify
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.search_space import DISTURBANCES, SearchSpace
from understudy.addons.checks.falsification.shrink import shrink_failure
from understudy.addons.checks.falsification.simpler_worlds import list_rounder, list_without_robots
from understudy.addons.checks.falsification.trial import GoalMeasure
from understudy.errors import FileError
from understudy.judging.evaluate import make_evaluation_task
from understudy.model.library import Library
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.params import get_count_range
from understudy.sim.scenario.schema import Breakdown, Goal, ObjectClass, RobotGroup, RobotType, Scenario
from understudy.sim.world import World


def list_failing_seeds() -> list[int]:
    results = MEASURE([Trial(FORAGE, seed) for seed in range(200)])
    return [int(row) for row in np.flatnonzero(results.failed)]


def find_failing_seed() -> int:
    return list_failing_seeds()[-1]


def count_things(scenario: Scenario, seed: int) -> tuple[int, int, int]:
    view = World(scenario, [seed]).view()
    return len(view.robots), len(view.objects), int(view.objects.amount.sum())


@pytest.mark.parametrize("which", range(4))
def test_a_shrunk_world_still_fails_and_is_not_larger(which: int) -> None:
    trial = Trial(FORAGE, list_failing_seeds()[which])
    before = MEASURE([trial])
    found = shrink_failure(MEASURE, FORAGE, trial)
    after = MEASURE([found.trial])
    assert after.failed.all()
    assert after.progress_s[0] <= before.progress_s[0] + 10.0
    assert after.last_states[0] == before.last_states[0] == {"start"}
    sizes = zip(count_things(*found.trial), count_things(*trial), strict=True)
    assert all(now <= then for now, then in sizes)
    assert count_things(*found.trial) != count_things(*trial)
    assert found.steps
    (food,) = (thing for thing in found.trial.scenario.objects if thing.name == "food")
    assert get_count_range(food.amount)[0] >= 4 or any("later" in step for step in found.steps)
    things = (*found.trial.scenario.objects, *found.trial.scenario.robots)
    assert all(isinstance(thing.at, tuple) or thing.count == 0 for thing in things)


def test_a_world_that_is_too_large_shrinks_only_as_long_as_it_is() -> None:
    """With the least food and rounder places the robot would be in time."""
    hurried = make_measure(99.0, limit_s=100.0)
    seed = int(np.flatnonzero(hurried([Trial(FORAGE, seed) for seed in range(60)]).failed)[0])
    found = shrink_failure(hurried, FORAGE, Trial(FORAGE, seed))
    assert hurried([found.trial]).failed.all()
    assert "one food left out" not in found.steps  # it would have been in time then


def test_shrinking_ends_after_its_runs() -> None:
    found = shrink_failure(MEASURE, FORAGE, Trial(FORAGE, find_failing_seed()), most_runs=5)
    assert found.runs <= 5
    assert MEASURE([found.trial]).failed.all()


def test_shrinking_ends_after_its_time() -> None:
    found = shrink_failure(MEASURE, FORAGE, Trial(FORAGE, find_failing_seed()), seconds=0.0)
    assert (found.runs, found.steps) == (1, [])


def test_robots_that_need_each_other_stay() -> None:
    team, salvage, swarm = (find_scenario(name) for name in ("forage-team", "salvage", "swarm"))
    placed = replace(team.robots[0], at=((1.0, 1.0, 0.0), (2.0, 2.0, 0.0)), count=msgspec.UNSET)
    assert len(list(list_without_robots(replace(team, robots=(placed,))))) == 2
    assert not list(list_without_robots(salvage))
    assert not list(list_without_robots(swarm))


def make_line() -> tuple[Scenario, GoalMeasure]:
    """Three robots drive ahead at 1 m/s, and all have to come within 3 m of a finish 19 m away, so after 16 s.

    None to two of them fail within 40 s.
    """
    finish = ObjectClass(name="finish", at=((20.0, 5.0),))
    group = RobotGroup(
        type="driver", at=tuple((1.0, 4.0 + number, 0.0) for number in range(3)),
        fails=(Breakdown(at_s=(0.0, 40.0), count=(0, 2)),),
    )  # fmt: skip
    scenario = Scenario(
        name="line", size=(30.0, 10.0), tick_s=0.1, limit_s=25.0, objects=(finish,), robots=(group,),
        types={"driver": RobotType(radius=0.1, speed=1.0, collides=False, behaviors={"ahead": {"drive": 1.0}})},
        goal=Goal(target="finish", within=3.0, all=True),
    )  # fmt: skip
    library = Library(make_scenario_kit(scenario))
    return scenario, GoalMeasure(make_evaluation_task(library, "ahead", scenario))


def test_a_world_in_which_a_robot_fails_is_made_simpler() -> None:
    """Worlds fail in which a robot fails before 16 s. What is left is one robot that fails at a round time."""
    scenario, measure = make_line()
    seeds = range(60)
    failed = measure([Trial(scenario, seed) for seed in seeds]).failed
    ticks = World(scenario, seeds).failure_ticks.reshape(60, 3)
    early = ((ticks >= 0) & (ticks < 155)).sum(axis=1)
    late = ((ticks < 0) | (ticks > 165)).all(axis=1)
    assert failed[early > 0].all()
    assert not failed[late].any()
    seed = int(np.flatnonzero(early == 2)[0])
    found = shrink_failure(measure, scenario, Trial(scenario, seed), most_runs=300)
    assert "a robot less fails" in found.steps
    assert "no robot fails" not in found.steps
    breakdowns = [each for group in found.trial.scenario.robots for each in group.fails]
    assert [len(each.robots or ()) for each in breakdowns] == [1]
    assert [float(each.at_s) % 1.0 for each in breakdowns if isinstance(each.at_s, float)] == [0.0]


def test_a_robot_that_fails_early_is_found_by_the_directed_search() -> None:
    """In a run as usual, none fails; the search varies how many fail and when."""
    scenario, measure = make_line()
    space = SearchSpace(scenario, (DISTURBANCES,))
    found = search_directed(measure, space, seed=1, start=[np.zeros(len(space))], most_runs=200)
    assert found.failures
    robots = found.failures[0][1].scenario.robots[0]
    assert robots.fails[0].count in (1, 2)
    assert robots.fails[0].at_s < 16.0  # type: ignore[operator]


def test_rounded_places_come_the_coarsest_first() -> None:
    at = ((1.234567, 2.345678, 44.4),)
    scenario = replace(FORAGE, objects=(), goal=None, robots=(replace(FORAGE.robots[0], at=at),))
    places = [made.robots[0].at for _, made in list_rounder(scenario)]
    assert places[0] == ((1.0, 2.0, 44.4),)
    assert ((1.23, 2.35, 44.4),) in places
    assert ((1.234567, 2.345678, 45.0),) in places


def test_a_kept_world_replays_bit_for_bit(tmp_path: Path) -> None:
    kept = keep(Trial(FORAGE, find_failing_seed()), tmp_path / "kept")
    again = read_failing_world(tmp_path / "kept")
    assert again == kept
    assert compute_end_hash(MEASURE, again.trial) == kept.facts.end_hash
    elsewhere = Trial(again.trial.scenario, again.trial.seed + 1)
    assert compute_end_hash(MEASURE, elsewhere) != kept.facts.end_hash
    assert (tmp_path / "kept" / "path.png").read_bytes().startswith(b"\x89PNG")


def test_the_moment_is_explained(tmp_path: Path) -> None:
    """The planted robot reads how far it is, and stays in the start of goto."""
    kept = keep(Trial(FORAGE, find_failing_seed()), tmp_path / "kept")
    text = " ".join(kept.facts.why)
    assert "no more progress" in text or "never any progress" in text
    assert "goto > start" in text
    assert text in " ".join((tmp_path / "kept" / "why.txt").read_text().split("\n"))


def test_a_directed_search_finds_what_chance_does_not() -> None:
    found = falsify(make_measure(13.5), FORAGE, worlds=100, seconds=60.0, seed=1, clock=lambda: 0.0)
    assert (found.random.runs, found.random.failed) == (100, 0)
    assert found.found_by == "directed"
    assert found.shrinking is not None
    assert make_measure(13.5)([found.shrinking.trial]).failed.all()


def test_folders_are_never_used_twice(tmp_path: Path) -> None:
    assert choose_folder(tmp_path, "forage") == tmp_path / "forage-1"
    (tmp_path / "forage-1").mkdir()
    assert choose_folder(tmp_path, "forage") == tmp_path / "forage-2"


BROKEN = [  # the content of failure.json, what the error says
    ("{", "is not valid"),
    ('{"understudy": "other"}', "is not valid"),
    ("[]", "is not valid"),
]


@pytest.mark.parametrize(("content", "message"), BROKEN)
def test_a_folder_that_is_no_failing_world(tmp_path: Path, content: str, message: str) -> None:
    with pytest.raises(FileError, match="reading the failing world failed"):
        read_failing_world(tmp_path)
    (tmp_path / FACTS_FILE).write_text(content)
    with pytest.raises(FileError, match=message):
        read_failing_world(tmp_path)


def test_a_failing_world_of_a_newer_version(tmp_path: Path) -> None:
    keep(Trial(FORAGE, find_failing_seed()), tmp_path / "kept")
    path = tmp_path / "kept" / FACTS_FILE
    path.write_text(path.read_text().replace('"version": 1', '"version": 2'))
    with pytest.raises(FileError, match="version 2"):
        read_failing_world(tmp_path / "kept")
    (tmp_path / "kept" / SCENARIO_FILE).unlink()


def make_failing_world(
    name: str, robustness: float, place: tuple[float, float] | None, state: str, **more: Any
) -> FailingWorld:
    facts = FailureFacts(
        behavior="forage", binding={}, seed=1, limit_s=600.0, robustness=robustness, wrong_s=1.0, end_hash="",
        found_by="random", steps=(), why=(), place=place, states=("harvest", "goto", state), **more,
    )  # fmt: skip
    return FailingWorld(Path(name), Trial(FORAGE, 1), facts)


ORDERS = [  # robustness, place (m), state, more; the names are a, b, c in this order; how they are listed
    ([(-0.1, (1, 1), "start"), (-0.5, (1, 1), "start"), (-0.3, (1, 1), "start")], "bca"),
    ([(-0.5, (1, 1), "start"), (-0.4, (2, 1), "start"), (-0.1, (8, 1), "start")], "acb"),  # far before near
    (
        [(-0.5, (1, 1), "start"), (-0.4, (8, 8), "start"), (-0.1, (1, 1), "left")],
        "acb",
    ),  # another state before far
    (
        [(-0.5, None, "start"), (-0.4, (8, 8), "start"), (-0.1, (2, 2), "start")],
        "abc",
    ),  # not kept: the worse first
    ([(-0.5, (1, 1), "start"), (-0.4, (1, 1), "start"), (-0.1, (1, 1), "start", "stays_near")], "acb"),
    (
        [(-0.5, (1, 1), "start"), (-0.4, (9, 9), "start"), (-0.3, (9, 8), "start"), (-0.1, (5, 5), "start")],
        "abdc",
    ),
    ([(-0.5, (1, 1), "start"), (-0.5, (1, 1), "start")], "ab"),  # by name
    ([], ""),
]


@pytest.mark.parametrize(("rows", "order"), ORDERS)
def test_the_worst_comes_first_and_then_the_most_different(rows: list[Any], order: str) -> None:
    worlds = [
        make_failing_world(name, robustness, place, state, property=of[0] if of else None)
        for name, (robustness, place, state, *of) in zip("abcd", rows, strict=False)
    ]
    assert "".join(each.folder.name for each in order_failing_worlds(worlds)) == order
    assert "".join(each.folder.name for each in order_failing_worlds(worlds[::-1])) == order


def test_the_difference_is_in_diagonals() -> None:
    width, height = FORAGE.size
    one, other = (make_failing_world("a", -1.0, place, "start") for place in ((0.0, 0.0), (width, height)))
    assert compare_failures(one, other) == compare_failures(other, one) == pytest.approx(1.0)
    assert compare_failures(one, one) == 0.0


def test_a_folder_is_listed_and_what_cannot_be_read_is_said(tmp_path: Path) -> None:
    kept = keep(Trial(FORAGE, find_failing_seed()), tmp_path / "forage-1")
    assert kept.facts.place is not None
    assert kept.facts.states[-1] == "start"
    (tmp_path / "forage-2").mkdir()
    (tmp_path / "forage-2" / FACTS_FILE).write_text("{")
    (tmp_path / "other").mkdir()  # no failing world
    (tmp_path / "note.txt").write_text("mine")
    worlds, problems = list_failing_worlds(tmp_path)
    assert worlds == (kept,)
    assert len(problems) == 1
    assert "forage-2" in problems[0]
    assert "is not valid" in problems[0]


def test_no_folder_is_an_empty_list_and_a_file_is_refused(tmp_path: Path) -> None:
    assert list_failing_worlds(tmp_path / "failures") == ((), ())
    (tmp_path / "failures").write_text("mine")
    with pytest.raises(FileError, match="reading the failing worlds failed"):
        list_failing_worlds(tmp_path / "failures")
