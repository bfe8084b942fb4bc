"""Laying worlds out: free places, by the seed alone, as the scenario says."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import atan2, dist, hypot, isnan, nan, pi, tau
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from understudy.errors import SettingError
from understudy.jit.plain import make_plain
from understudy.sim.kernels import clearance as space
from understudy.sim.kernels import rng as draws
from understudy.sim.kernels.rng import draw_uniform_column
from understudy.sim.layout.clearance import (
    have_common_point,
    is_point_in_polygon,
    list_edges,
    list_wall_segments,
    measure_point_to_segment,
    place_polygon,
)
from understudy.sim.layout.placement import lay_out_worlds
from understudy.sim.params import make_world_params
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario
from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    ArenaPoint,
    ArenaRegion,
    ObjectClass,
    Obstacle,
    Placement,
    RobotGroup,
    RobotType,
    Scenario,
    Wall,
)
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.state import WorldState

SLACK = 1e-9
TRIANGLE = ((-0.5, -0.3), (0.5, -0.3), (0.0, 0.6))
EMPTY = Scenario(
    size=(10.0, 8.0), types={"rover": RobotType(radius=0.2)}, robots=(RobotGroup(type="rover", count=3),)
)


def laid_out(scenario: Scenario, *seeds: int) -> WorldState:
    return lay_out_worlds(scenario, make_world_params(scenario), np.array(seeds, np.int64))


def number(placing: Placement) -> int:
    return placing.count if isinstance(placing.count, int) else 1


class Thing(NamedTuple):
    """Something round, or a polygon, in a world that is laid out."""

    place: ArenaPoint
    radius: float
    apart: float
    corners: tuple[ArenaPoint, ...] = ()


def things_in(scenario: Scenario, state: WorldState, world: int) -> Iterator[Thing]:
    """All that stands in a world, with the free space it asks for."""
    disc, segment = 0, len(list(list_wall_segments(scenario)))
    for obstacle in scenario.obstacles:
        for _ in range(number(obstacle)):
            if obstacle.radius is not None:
                row = state.discs[world, disc]
                yield Thing((row["x"], row["y"]), row["radius"], obstacle.apart)
                disc += 1
            else:
                edges = state.segments[world, segment : segment + len(obstacle.points or ())]
                corners = tuple(zip(edges["x0"], edges["y0"], strict=True))
                yield Thing(corners[0], 0.0, obstacle.apart, corners)
                segment += len(edges)
    rules = make_world_params(scenario)
    for slot, kind in enumerate(rules.class_of):
        row = state.objects[world, slot]
        if row["present"]:
            yield Thing((row["x"], row["y"]), rules.classes[kind]["radius"], rules.classes[kind]["apart"])
    robots = state.robots.reshape(len(state.seeds), -1)[world]
    aparts = [group.apart for group in scenario.robots for _ in range(number(group))]
    for row, apart in zip(robots, aparts, strict=True):
        yield Thing((row["x"], row["y"]), rules.types[row["type"]]["radius"], apart)


def gap(one: Thing, other: Thing) -> float:
    """The distance between the rims of two things; below 0 where they overlap."""
    if one.corners and other.corners:
        edges, others = list_edges(one.corners), list_edges(other.corners)
        if any(have_common_point(a, b) for a in edges for b in others):
            return -1.0
        if is_point_in_polygon(one.place, other.corners) or is_point_in_polygon(other.place, one.corners):
            return -1.0
        return min(
            measure_point_to_segment(end, b)
            for a, b in [*zip_all(edges, others), *zip_all(others, edges)]
            for end in a
        )
    if one.corners or other.corners:
        polygon, disc = (one, other) if one.corners else (other, one)
        if is_point_in_polygon(disc.place, polygon.corners):
            return -1.0
        return (
            min(measure_point_to_segment(disc.place, edge) for edge in list_edges(polygon.corners))
            - disc.radius
        )
    return dist(one.place, other.place) - one.radius - other.radius


def zip_all(ones: Any, others: Any) -> list[tuple[Any, Any]]:
    return [(one, other) for one in ones for other in others]


def check_free(scenario: Scenario, state: WorldState) -> None:
    """Nothing overlaps, and each keeps the free space that it asks for, from bounds and walls as well."""
    width, height = scenario.size
    walls = list(list_wall_segments(scenario))
    for world in range(len(state.seeds)):
        things = list(things_in(scenario, state, world))
        for one, other in combinations(things, 2):
            assert gap(one, other) >= max(one.apart, other.apart) - SLACK
        for thing in things:
            away = thing.radius + thing.apart - SLACK
            for x, y in thing.corners or (thing.place,):
                assert away <= x <= width - away
                assert away <= y <= height - away
            for wall in walls:
                ends = Thing(wall[0], 0.0, 0.0, wall) if thing.corners else None
                assert (gap(thing, ends) if ends else measure_point_to_segment(thing.place, wall)) >= away


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    size = st.floats(0.05, 0.6)
    apart = st.sampled_from((0.0, 0.0, 0.1, 0.4))
    obstacles = draw(
        st.lists(
            st.one_of(
                st.builds(Obstacle, radius=size, count=st.integers(0, 4), apart=apart),
                st.builds(Obstacle, points=st.just(TRIANGLE), count=st.integers(0, 3), apart=apart),
                st.builds(Obstacle, points=st.just(TRIANGLE[::-1]), count=st.integers(0, 2), apart=apart),
            ),
            max_size=3,
        )
    )
    objects = [
        ObjectClass(
            name=f"thing {index}",
            radius=draw(size),
            count=draw(st.integers(1, 4)),
            apart=draw(apart),
            solid=draw(st.booleans()),
        )
        for index in range(draw(st.integers(0, 3)))
    ]
    walls = draw(st.sampled_from(((), (Wall(points=((3.0, 0.0), (3.0, 5.0), (5.0, 5.0))),))))
    groups = draw(
        st.lists(
            st.builds(RobotGroup, type=st.just("rover"), count=st.integers(1, 12), apart=apart),
            min_size=1,
            max_size=2,
        )
    )
    return replace(
        EMPTY, obstacles=tuple(obstacles), objects=tuple(objects), walls=walls, robots=tuple(groups)
    )


@settings(max_examples=150)
@given(scenarios(), st.integers(0, 2**63 - 1))
def test_nothing_overlaps(scenario: Scenario, seed: int) -> None:
    try:
        check_scenario(scenario)
        state = laid_out(scenario, seed, 7)
    except SettingError as error:
        assume("fit" not in str(error))
        raise
    check_free(scenario, state)


@pytest.mark.parametrize("name", ["arena", "rooms", "soccer", "forage"])
def test_built_in_worlds_are_free(name: str) -> None:
    scenario = load_scenario(name)
    obstacles = tuple(
        replace(each, count=each.count[1] if isinstance(each.count, tuple) else number(each))
        for each in scenario.obstacles
    )
    objects = tuple(thing for thing in scenario.objects if not isinstance(thing.at, tuple))
    robots = tuple(replace(group, count=number(group)) for group in scenario.robots)
    scenario = replace(scenario, obstacles=obstacles, objects=objects, robots=robots, goal=None)
    check_free(scenario, laid_out(scenario, *range(30)))


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_every_seed_has_its_world(name: str) -> None:
    """No seed of a built-in scenario finds itself without a free place."""
    laid_out(load_scenario(name), *range(2000))


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_a_world_is_the_same_alone(name: str) -> None:
    scenario = load_scenario(name)
    seeds = (11, 3, 2**63 - 1, 0, 3)
    among = laid_out(scenario, *seeds)
    robots = make_world_params(scenario).robots
    for world, seed in enumerate(seeds):
        alone = laid_out(scenario, seed)
        assert alone.robots.tobytes() == among.robots[world * robots : (world + 1) * robots].tobytes()
        for field in ("objects", "discs", "segments"):
            np.testing.assert_array_equal(getattr(alone, field)[0], getattr(among, field)[world])
    assert among.robots[:robots].tobytes() != among.robots[robots : 2 * robots].tobytes()


def test_draws_are_those_of_the_key() -> None:
    for seed, item, tick, stream in ((0, 0, 0, 0), (5, 9, 77, 65_540), (2**63 - 1, 2**31, 1, 3)):
        column = np.array([seed], np.int64)
        drawn = draw_uniform_column(column, item=item, tick=tick, stream=stream)[0]
        assert draws.draw_uniform(seed, item, tick, stream) == drawn
        assert space.scale_to_integer(2, 9, drawn) == 2 + int(8 * drawn)


def test_counts_and_amounts_are_drawn_from_all_there_are() -> None:
    scenario = replace(
        EMPTY, objects=(ObjectClass(name="food", count=(2, 4), amount=(4, 6)),), spare_objects=3
    )
    state = laid_out(scenario, *range(300))
    present = state.objects["present"][:, :7]
    counts = present.sum(axis=1)
    assert set(counts.tolist()) == {2, 3, 4}
    assert (
        np.sort(present, axis=1)[:, ::-1] == present
    ).all()  # the first ones are there, spare ones are not
    amounts = state.objects["amount"]
    assert set(amounts[:, :4][present[:, :4] == 1].tolist()) == {4, 5, 6}
    assert (amounts[state.objects["present"] == 0] == 0).all()
    np.testing.assert_array_equal(amounts, state.objects["at_first"])
    assert (state.objects["due"] == -1).all()
    assert (state.objects["captured"] == -1).all()


def test_what_is_not_there_is_marked() -> None:
    obstacles = (Obstacle(radius=0.3, count=(0, 2)), Obstacle(points=TRIANGLE, count=(0, 2)))
    state = laid_out(replace(EMPTY, obstacles=obstacles), *range(100))
    assert state.discs.shape == (100, 2)
    assert set((state.discs["radius"] > 0).sum(axis=1).tolist()) == {0, 1, 2}
    assert set((~np.isnan(state.segments["x0"])).sum(axis=1).tolist()) == {0, 3, 6}
    assert set(state.discs["height"].flat) == {0.0, 0.6}


def test_given_places_and_headings() -> None:
    scenario = replace(
        EMPTY,
        robots=(RobotGroup(type="rover", at=((1.0, 2.0, 90.0), (3.0, 4.0))), RobotGroup(type="rover")),
        objects=(ObjectClass(name="home", home=True, at=((5.0, 5.0),)),),
        obstacles=(Obstacle(points=TRIANGLE, at=((7.0, 4.0, 90.0),)), Obstacle(radius=0.5, at=((2.0, 6.0),))),
    )
    state = laid_out(scenario, 4)
    assert [(row["x"], row["y"]) for row in state.robots[:2]] == [(1.0, 2.0), (3.0, 4.0)]
    assert state.robots["heading"][0] == pytest.approx(pi / 2)
    assert 0 <= state.robots["heading"][1] < tau
    assert state.robots["id"].tolist() == [0, 1, 2]
    corners = zip(state.segments["x0"][0], state.segments["y0"][0], strict=True)
    for corner, wanted in zip(corners, place_polygon(TRIANGLE, (7.0, 4.0, 90.0)), strict=True):
        assert corner == pytest.approx(wanted)
    assert (state.discs["x"][0, 0], state.discs["y"][0, 0]) == (2.0, 6.0)


def test_types_and_what_robots_carry() -> None:
    types = {"rover": RobotType(capacity=5), "giant": RobotType(radius=1.0)}
    robots = (RobotGroup(type="giant", count=2), RobotGroup(type="rover", count=2, stored=3))
    state = laid_out(replace(EMPTY, types=types, robots=robots), 0)
    assert state.robots["type"].tolist() == [1, 1, 0, 0]
    assert state.robots["stored"].tolist() == [0, 0, 3, 3]


def test_within_a_region() -> None:
    regions = {
        "corner": ArenaRegion(box=(0.0, 0.0, 3.0, 2.0)),
        "spot": ArenaRegion(center=(7.0, 5.0), radius=1.5),
    }
    scenario = replace(
        EMPTY,
        regions=regions,
        objects=(ObjectClass(name="food", count=3, within="corner"),),
        robots=(RobotGroup(type="rover", count=4, within="spot"),),
    )
    state = laid_out(scenario, *range(50))
    food = state.objects[:, :3]
    assert food["x"].max() <= 3.0
    assert food["y"].max() <= 2.0
    assert np.hypot(state.robots["x"] - 7.0, state.robots["y"] - 5.0).max() <= 1.5


def test_beside_an_object() -> None:
    home = ObjectClass(name="home", at=((1.0, 1.0),), home=True, apart=0.5)
    scenario = replace(EMPTY, objects=(home,), robots=(RobotGroup(type="rover", near="home", near_m=0.8),))
    state = laid_out(scenario, *range(50))
    x, y = state.robots["x"] - 1.0, state.robots["y"] - 1.0
    np.testing.assert_allclose(np.hypot(x, y), 0.8)
    toward_center = atan2(3.0, 4.0)
    assert np.abs(np.arctan2(y, x) - toward_center).max() <= pi / 8 + SLACK
    right_there = replace(scenario, robots=(RobotGroup(type="rover", near="home"),))
    state = laid_out(right_there, 1)
    assert (state.robots["x"][0], state.robots["y"][0]) == (1.0, 1.0)


def test_several_beside_an_object_go_around_it() -> None:
    home = ObjectClass(name="home", home=True, apart=2.0)
    scenario = replace(
        EMPTY, objects=(home,), robots=(RobotGroup(type="rover", near="home", near_m=1.0, count=8),)
    )
    state = laid_out(scenario, *range(20))
    robots = state.robots.reshape(20, 8)
    for world in range(20):
        places = [(row["x"], row["y"]) for row in robots[world]]
        assert min(dist(*pair) for pair in combinations(places, 2)) >= 0.4 - SLACK


def test_what_is_near_waits_for_what_it_is_near() -> None:
    """Also where that is declared later."""
    objects = (ObjectClass(name="food", near="home", near_m=0.6), ObjectClass(name="home", home=True))
    state = laid_out(replace(EMPTY, objects=objects, spare_objects=0), *range(20))
    food, home = state.objects[:, 0], state.objects[:, 1]
    np.testing.assert_allclose(np.hypot(food["x"] - home["x"], food["y"] - home["y"]), 0.6)


def test_what_comes_and_goes_begins_absent() -> None:
    intruder = ObjectClass(
        name="intruder", presence=AppearanceSchedule(away_s=(10.0, 30.0), first_s=(2.0, 4.0))
    )
    boss = ObjectClass(name="boss", presence=AppearanceSchedule(away_s=(10.0, 30.0)))
    state = laid_out(replace(EMPTY, objects=(intruder, boss), spare_objects=0), *range(200))
    assert (state.objects["present"] == 0).all()
    due = state.objects["due"]
    assert (due[:, 0].min(), due[:, 0].max()) == (20, 40)
    assert 100 <= due[:, 1].min() < due[:, 1].max() <= 300


def test_ghosts_may_stand_in_each_other() -> None:
    ghosts = replace(
        EMPTY,
        size=(1.0, 1.0),
        types={"rover": RobotType(collides=False)},
        robots=(RobotGroup(type="rover", count=100),),
    )
    state = laid_out(ghosts, 0)
    assert ((state.robots["x"] >= 0.2) & (state.robots["x"] <= 0.8)).all()


def test_a_new_free_place_in_a_running_world() -> None:
    scenario = replace(
        EMPTY,
        walls=(Wall(points=((3.0, 0.0), (3.0, 5.0))),),
        obstacles=(Obstacle(radius=0.5, count=2), Obstacle(points=TRIANGLE, count=2)),
        objects=(
            ObjectClass(name="boss", radius=0.3, apart=0.2),
            ObjectClass(name="box", solid=True, count=3),
        ),
        spare_objects=0,
    )
    rules = make_world_params(scenario)
    state = lay_out_worlds(scenario, rules, np.arange(40))
    robots = state.robots.reshape(40, -1)
    for world in range(40):
        rows = robots[world], state.objects[world], state.discs[world], state.segments[world]
        kind = rules.classes[0]
        args = make_plain(
            (kind, rules.types, rules.classes, rules.class_of, rules.width, rules.height, *rows)
        )
        found, x, y = space.find_free_place(world, 0, 1, *args)
        assert found
        assert (found, x, y) == space.find_free_place(world, 0, 1, *args)
        assert (x, y) != space.find_free_place(world, 0, 2, *args)[1:]
        state.objects[world, 0]["x"], state.objects[world, 0]["y"] = x, y
    counted = replace(
        scenario, objects=(replace(scenario.objects[0], count=1), replace(scenario.objects[1], count=3))
    )
    check_free(counted, state)


def test_no_free_place_names_the_key() -> None:
    crowded = replace(EMPTY, size=(3.0, 3.0), robots=(RobotGroup(type="rover", count=55),))
    with pytest.raises(SettingError, match=r"robots\[0\]\.count .*no free place") as caught:
        laid_out(crowded, 5)
    assert caught.value.setting == "robots[0].count"


def test_nan_segments_are_no_obstacles() -> None:
    state = laid_out(replace(EMPTY, obstacles=(Obstacle(points=TRIANGLE, count=(0, 1)),)), *range(20))
    absent = next(row for row in state.segments if isnan(row["x0"][0]))
    assert space.is_clear_of_segments(1.0, 1.0, 5.0, make_plain(absent), 0, len(absent))
    assert isnan(space.measure_to_segment(0.0, 0.0, nan, nan, nan, nan))


@given(st.tuples(st.floats(-1, 1), st.floats(-1, 1)))
def test_kernels_agree_with_plain_geometry(point: ArenaPoint) -> None:
    edges = list_edges(place_polygon(TRIANGLE, (0.0, 0.0)))
    rows = laid_out(replace(EMPTY, obstacles=(Obstacle(points=TRIANGLE, at=((5.0, 4.0),)),)), 0).segments[0]
    x, y = point[0] + 5.0, point[1] + 4.0
    distance = min(measure_point_to_segment(point, edge) for edge in edges)
    assume(distance > 1e-6)
    assert space.is_inside_polygons(x, y, make_plain(rows), 0, len(rows)) == is_point_in_polygon(
        point, [edge[0] for edge in edges]
    )
    assert min(space.measure_to_segment(x, y, *tuple(row)[:4]) for row in rows) == pytest.approx(
        distance, abs=1e-9
    )


@pytest.mark.soak
def test_a_million_robots_in_one_world() -> None:
    many = replace(EMPTY, size=(2000.0, 2000.0), robots=(RobotGroup(type="rover", count=1_000_000),))
    state = laid_out(many, 0)
    assert len(state.robots) == 1_000_000
    cells = np.floor(np.stack([state.robots["x"], state.robots["y"]]) / 0.4).astype(np.int64)
    order = np.lexsort(cells)
    near = state.robots[order]
    step = np.hypot(np.diff(near["x"]), np.diff(near["y"]))
    assert step.min() >= 0.4 - SLACK
    assert hypot(state.robots["x"].max(), state.robots["y"].max()) < hypot(2000.0, 2000.0)
