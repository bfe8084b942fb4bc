"""A hundred new worlds side by side: what runs there, where robots went, and the way to where it goes wrong."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot
from typing import Any

import numpy as np
import pytest
from tests.make.studios import GOTO, Page, open_page, serve_studio
from tests.ui.web.test_unseen_worlds import teach

from understudy.judging.behavior_run import ProgramRun
from understudy.judging.robot_paths import PathMonitor
from understudy.judging.rollout import roll_out
from understudy.model.library import Library
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy.ui.controller.world_grid import FIRST_SEED, MOST_LOOKS, WORLDS
from understudy.ui.web.server import StudioServer


@pytest.fixture
def person(server: StudioServer) -> Iterator[Page]:
    """Somebody who has shown a goto that works in some worlds."""
    with serve_studio(server) as client, open_page(client) as here:
        here.done(**GOTO)
        teach(here, server)
        yield here


def read_grid(person: Page) -> dict[str, Any]:
    person.done("run_world_grid")
    grid: dict[str, Any] = person.done("read_world_grid")["grid"]
    return grid


def test_every_world_has_its_robot_its_things_and_its_end(person: Page, server: StudioServer) -> None:
    grid = read_grid(person)
    assert [each["seed"] for each in grid["worlds"]] == [*range(FIRST_SEED, FIRST_SEED + WORLDS)]
    assert grid["works"] == sum(each["works"] for each in grid["worlds"])
    assert 0 < grid["works"] < WORLDS
    assert grid["success"] == "done is raised, wherever that is"
    assert len(grid["times"]) <= MOST_LOOKS
    for each in grid["worlds"]:
        world = World(server.host.world.scenario, [each["seed"]])
        robot = world.state.robots
        (path,) = each["paths"]
        assert path[:2] == [round(float(robot["x"][0]), 2), round(float(robot["y"][0]), 2)]
        assert len(path) % 2 == 0
        last = grid["times"][len(path) // 2 - 1]
        assert last >= each["end_s"] - 1e-6 or last == grid["times"][-1]
        assert len(each["things"]) == len(world.view().objects.kind)


def test_where_it_works_the_robot_ends_near_the_station(person: Page, server: StudioServer) -> None:
    grid, scene = read_grid(person), server.host.world.scenario
    station = next(index for index, each in enumerate(scene.objects) if each.name == "station")
    for each in grid["worlds"]:
        if each["works"]:
            x, y = each["paths"][0][-2:]
            (home,) = (thing for thing in each["things"] if thing["kind"] == station)
            assert hypot(home["x"] - x, home["y"] - y) < 2.0


def test_the_world_here_waits_while_nobody_looks_at_it(person: Page, server: StudioServer) -> None:
    """Otherwise what it does meanwhile, unseen, would be watched, and teach."""
    person.done("pause", paused=False)
    read_grid(person)
    assert server.host.active_trainer.session.paused


def test_the_worlds_stay_the_same_until_they_are_shown(person: Page) -> None:
    first = read_grid(person)
    bad = next(each["seed"] for each in first["worlds"] if not each["works"])
    person.done("visit_grid_world", seed=bad)
    again = read_grid(person)
    assert [each["seed"] for each in again["worlds"]] == [each["seed"] for each in first["worlds"]]
    assert [each["seed"] for each in again["worlds"] if each["was_shown"]] == [bad]
    assert not any(each["was_shown"] for each in first["worlds"])


def test_a_world_in_which_it_fails_opens_paused_before_the_mistake(
    person: Page, server: StudioServer
) -> None:
    grid = read_grid(person)
    bad = next(each["seed"] for each in grid["worlds"] if not each["works"])
    examples = len(server.host.active_trainer.session.examples)
    person.done("bind_targets", targets={"A": "nearest_food"})
    answer = person.done("visit_grid_world", seed=bad)
    while person.news["seed"] != bad:
        person.wait_for_news()
    session = person.news["session"]
    assert (session["mode"], person.news["paused"], person.news["seed"]) == ("testing", True, bad)
    assert session["targets"] == {"A": "station"}
    assert f"World {bad}: " in person.news["message"]["text"], answer
    person.done("pause", paused=False)
    for _ in range(40):
        person.done("step")
    assert len(server.host.active_trainer.session.examples) == examples  # silence teaches nothing there


def test_what_cannot_be_shown_is_said(server: StudioServer) -> None:
    with serve_studio(server) as client, open_page(client) as here:
        assert "open" in here.say("run_world_grid")["error"].lower()
        here.done(**GOTO)
        assert "nothing to run yet" in here.say("run_world_grid")["error"]
        assert "nothing was run" in here.say("read_world_grid")["error"]
        assert "nothing was run" in here.say("visit_grid_world", seed=5)["error"]
        teach(here, server)
        grid = read_grid(here)
        good = next(each["seed"] for each in grid["worlds"] if each["works"])
        assert f"did not go wrong in a world {good}" in here.say("visit_grid_world", seed=good)["error"]
        assert "did not go wrong" in here.say("visit_grid_world", seed=1)["error"]


def test_paths_are_those_that_robots_take() -> None:
    """By hand: two robots in two worlds go ahead for a second; the second world's limit is half of that."""
    scenario = find_scenario("patrol")
    library = Library(make_scenario_kit(scenario))
    world, program = World(scenario, [1, 2]), link(library, "forwards", {})
    run = ProgramRun(world, program, library, {})
    monitor = PathMonitor(run, [3, 0], stride=2)
    alone = [World(scenario, [seed]) for seed in (1, 2)]
    starts = [np.stack([each.state.robots["x"], each.state.robots["y"]], axis=1)[[3, 0]] for each in alone]
    roll_out(run, [monitor], np.array([1.0, 0.5]))
    times, paths = monitor.list_paths(20)
    assert times == pytest.approx([0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0])
    assert [path.shape for path in paths] == [(7, 2, 2), (4, 2, 2)]
    for path, start in zip(paths, starts, strict=True):
        np.testing.assert_array_equal(path[0], start)
    assert monitor.end_s.tolist() == pytest.approx([1.0, 0.5])
    moved = np.linalg.norm(paths[0][1] - paths[0][0], axis=1)
    assert (moved > 0).all()
    few, short = monitor.list_paths(3)
    assert few == pytest.approx([0.0, 0.5, 1.0])
    assert [len(each) for each in short] == [3, 2]
