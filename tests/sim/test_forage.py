"""The foraging world: closed forms for motion, loading, the corner cases, settings and errors."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, hypot, inf, isnan, nan, pi, sin, tau
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as replace_parts

from understudy.errors import DefinitionError, FileError, SettingError, UnknownName
from understudy.runtime.body import list_reading_keys
from understudy.sim.forage import (
    FORAGE_KIT,
    Forage,
    ForageSettings,
    make_corner_cases,
    make_practice_worlds,
    recover_forage_settings,
)
from understudy.sim.kernels.rng import draw_uniform_column
from understudy.sim.scenario.files import load_scenario

ON = np.ones(1)


class Seen(NamedTuple):
    """What tests look at in a world of one robot."""

    x: float
    y: float
    heading: float
    stored: int
    delivered: int
    station: tuple[float, float]
    sources: list[tuple[float, float, int]]  # place and amount


def observe(world: Forage, row: int = 0) -> Seen:
    view = world.view(row)
    robots, objects = view.robots, view.objects
    rows = list(zip(objects.x.tolist(), objects.y.tolist(), objects.amount.tolist(), strict=True))
    (station,) = (each[:2] for each, home in zip(rows, objects.home, strict=True) if home)
    return Seen(
        float(robots.x[0]),
        float(robots.y[0]),
        float(robots.heading[0]),
        int(robots.stored[0]),
        int(robots.delivered[0]),
        station,
        [each for each, food in zip(rows, objects.food, strict=True) if food],
    )


def at_food(world: Forage) -> None:
    x, y, _ = observe(world).sources[0]
    world.place(0, x, y, 0.0)


def load(world: Forage, ticks: int) -> None:
    for _ in range(ticks):
        world.act({"load": ON})


def test_forward_drives_straight() -> None:
    world = Forage([1])
    world.place(0, 2.0, 3.0, pi / 6)
    for _ in range(20):
        world.act(kit_command("forward"))
    view = observe(world)
    assert (view.x, view.y) == pytest.approx((2.0 + cos(pi / 6), 3.0 + sin(pi / 6)))
    assert view.heading == pytest.approx(pi / 6)
    assert world.time_s == pytest.approx(2.0)


def test_rotating_left_grows_the_heading_and_wraps() -> None:
    world = Forage([1])
    world.place(0, 2.0, 3.0, tau - 0.06)
    world.act(kit_command("rotate_left"))
    assert observe(world).heading == pytest.approx(0.06)
    world.act(kit_command("rotate_right"))
    assert observe(world).heading == pytest.approx(tau - 0.06)
    assert (observe(world).x, observe(world).y) == (2.0, 3.0)


def test_driving_and_turning_is_an_arc() -> None:
    world = Forage([1])
    world.place(0, 6.0, 6.0, 0.0)
    for _ in range(10):
        world.act({"drive": ON, "turn": ON})
    radius, angle = 0.5 / 1.2, 1.2  # v / w; w t
    view = observe(world)
    assert (view.x, view.y) == pytest.approx((6 + radius * sin(angle), 6 + radius * (1 - cos(angle))))
    assert view.heading == pytest.approx(angle)


def test_walls_stop_the_robot_and_let_it_slide() -> None:
    world = Forage([1])
    world.place(0, 11.7, 3.0, pi / 4)
    for _ in range(20):
        world.act({"drive": ON})
    assert (observe(world).x, observe(world).y) == pytest.approx((11.8, 3.0 + sin(pi / 4)), abs=0.01)


def test_what_is_not_driven_stays() -> None:
    world = Forage(range(5))
    before = world.sense(list_reading_keys(world))
    for _ in range(10):
        world.act({})
    after = world.sense(list_reading_keys(world))
    assert all(np.array_equal(before[key], after[key], equal_nan=True) for key in before)


def test_bearings_are_in_the_robot_frame() -> None:
    world = Forage([4])
    x, y = observe(world).station
    for heading, bearing in ((0.0, 0.0), (pi / 2, 3 * pi / 2), (pi, pi), (3 * pi / 2, pi / 2)):
        world.place(0, x - 0.4, y, heading)
        percept = world.sense([("bearing", "station"), ("range", "station"), ("station_here", None)])
        assert percept["bearing", "station"][0] == pytest.approx(bearing, abs=1e-12)
        assert percept["range", "station"][0] == pytest.approx(0.4)
        assert percept["station_here", None][0] == 1.0


LOADING = [  # ticks of load_food, units then stored (a unit takes 1 s, 10 ticks)
    (9, 0),
    (10, 1),
    (19, 1),
    (20, 2),
]


@pytest.mark.parametrize(("ticks", "stored"), LOADING)
def test_loading_takes_its_time(ticks: int, stored: int) -> None:
    world = Forage([2])
    at_food(world)
    load(world, ticks)
    assert observe(world).stored == stored


def test_work_broken_off_is_lost() -> None:
    world = Forage([2])
    at_food(world)
    load(world, 9)
    world.act({})
    load(world, 9)
    assert observe(world).stored == 0


def test_loading_needs_standing_still_and_reach() -> None:
    world = Forage([2])
    at_food(world)
    for _ in range(20):
        world.act({"load": ON, "turn": ON})
    x, y = observe(world).station
    world.place(0, x, y, 0.0)
    load(world, 20)
    assert observe(world).stored == 0


def test_full_robot_loads_no_more_and_unloads_only_at_the_station() -> None:
    world = Forage([2], ForageSettings(stored=12))
    at_food(world)
    for channel in ("load", "unload"):
        for _ in range(30):
            world.act({channel: ON})
        assert (observe(world).stored, observe(world).delivered) == (12, 0)
    world.place(0, *observe(world).station, 0.0)
    for _ in range(30):
        world.act({"unload": ON})
    assert (observe(world).stored, observe(world).delivered) == (9, 3)


def test_an_empty_source_is_no_longer_nearest() -> None:
    world = Forage([2], ForageSettings(sources=(2, 2), amounts=(1, 1)))
    at_food(world)
    assert world.sense([("food_here", None)])["food_here", None][0] == 1.0
    load(world, 10)
    percept = world.sense(list_reading_keys(world))
    assert percept["food_here", None][0] == 0.0
    assert percept["food_left", None][0] == 1.0
    x, y, _ = observe(world).sources[1]
    assert percept["range", "nearest_food"][0] == pytest.approx(
        hypot(x - observe(world).x, y - observe(world).y)
    )


def test_corner_cases_are_what_they_say() -> None:
    cases = make_corner_cases()
    worlds = {name: Forage(range(20), case) for name, case in cases.items()}
    assert (worlds["robot starts full"].sense([("food_stored", None)])["food_stored", None] == 12).all()
    assert (
        worlds["starts empty at the station"].sense([("range", "station")])["range", "station"] == 0
    ).all()
    for row in range(20):
        view = observe(worlds["food beside the station"], row)
        ways = [hypot(x - view.station[0], y - view.station[1]) for x, y, _ in view.sources]
        assert ways == pytest.approx([0.6] * len(ways))  # between two reaches of 0.5 m and one
    assert (worlds["one last unit left"].total == 1).all()
    small = worlds["source empties before the robot is full"]
    assert all(amount < 12 for row in range(20) for _, _, amount in observe(small, row).sources)
    nothing = worlds["no food at all"]
    percept = nothing.sense(list_reading_keys(nothing))
    assert np.isnan(percept["range", "nearest_food"]).all()
    assert np.isnan(percept["bearing", "nearest_food"]).all()
    assert (percept["food_left", None] == 0).all()
    assert nothing.success().all()
    nothing.act({})
    assert (nothing.finished_s == 0.1).all()


def test_layout_keeps_things_apart_and_off_the_walls() -> None:
    world = Forage(range(200))
    for row in range(200):
        view = observe(world, row)
        things = [view.station, *((x, y) for x, y, _ in view.sources)]
        assert 2 <= len(view.sources) <= 4
        assert all(4 <= amount <= 16 for _, _, amount in view.sources)
        assert all(0.9 <= x <= 11.1 and 0.9 <= y <= 11.1 for x, y in things)
        assert all(hypot(a[0] - b[0], a[1] - b[1]) >= 1.1 for i, a in enumerate(things) for b in things[:i])


def test_a_world_is_the_same_alone_and_among_others() -> None:
    assert observe(Forage([7])) == observe(Forage(range(10)), 7)


def test_there_is_one_description() -> None:
    assert ForageSettings().scenario() == load_scenario("forage")


@pytest.mark.parametrize("name", [*make_corner_cases(), *make_practice_worlds()])
def test_settings_are_found_again(name: str) -> None:
    made = {**make_corner_cases(), **make_practice_worlds()}[name]
    scenario = made.scenario()
    assert recover_forage_settings(replace_parts(scenario, name="mine", about="Hm.", limit_s=5.0)) == made
    assert (
        recover_forage_settings(replace_parts(scenario, obstacles=load_scenario("rooms").obstacles)) is None
    )


def test_other_scenarios_are_no_settings() -> None:
    others = ("arena", "forage-team", "patrol", "regions", "rooms", "salvage", "soccer")
    assert [recover_forage_settings(load_scenario(name)) for name in others] == [None] * len(others)


def test_draws_are_spread_evenly_and_keyed_by_everything() -> None:
    seeds = np.arange(20_000, dtype=np.int64)
    base = draw_uniform_column(seeds, item=1, tick=2, stream=3)
    assert base.min() >= 0
    assert base.max() < 1
    assert np.histogram(base, bins=10, range=(0, 1))[0].min() > 1800
    for other in ({"item": 2}, {"tick": 3}, {"stream": 4}):
        drawn = draw_uniform_column(seeds, **{**{"item": 1, "tick": 2, "stream": 3}, **other})
        assert abs(np.corrcoef(base, drawn)[0, 1]) < 0.03


WRONG: list[tuple[dict[str, Any], str]] = [  # settings, the one that is named
    ({"width": -1.0}, "width"),
    ({"height": 0.5}, "height"),
    ({"width": float("nan")}, "width"),
    ({"capacity": 0}, "capacity"),
    ({"capacity": 2.5}, "capacity"),
    ({"stored": 13}, "stored"),
    ({"stored": -1}, "stored"),
    ({"tick_s": 0.0}, "tick_s"),
    ({"tick_s": -0.1}, "tick_s"),
    ({"load_s": 0.25}, "load_s"),
    ({"unload_s": 0.0}, "unload_s"),
    ({"sources": (3, 2)}, "sources"),
    ({"sources": 3}, "sources"),
    ({"amounts": (0, 2)}, "amounts"),
    ({"amounts": (1.0, 2)}, "amounts"),
    ({"forward_speed": 6.0}, "forward_speed"),
    ({"forward_speed": True}, "forward_speed"),
    ({"turning_speed": 100.0}, "turning_speed"),
    ({"radius": 0.6}, "radius"),
    ({"food_beside_station": True, "sources": (0, 2)}, "food_beside_station"),
]


@pytest.mark.parametrize(("wrong", "named"), WRONG)
def test_settings_that_make_no_sense(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(SettingError) as raised:
        ForageSettings(**wrong)
    assert raised.value.setting == named


def test_too_many_things_for_the_room() -> None:
    with pytest.raises(SettingError, match="does not fit"):
        Forage([1], ForageSettings(width=3.0, height=3.0, sources=(9, 9)))


def test_bad_seeds_places_and_commands() -> None:
    world = Forage([1])
    for seeds in ([-1], [2**63], [1, 2]):
        with pytest.raises(SettingError, match="seeds"):
            world.reset(seeds)
    for place in ((-0.1, 5.0, 0.0), (5.0, 12.1, 0.0), (5.0, 5.0, nan)):
        with pytest.raises(SettingError, match="place"):
            world.place(0, *place)
    with pytest.raises(UnknownName, match="'sonar'"):
        world.sense([("sonar", None)])
    with pytest.raises(UnknownName, match="no target 'food'"):
        world.sense([("range", "food")])
    with pytest.raises(UnknownName, match="'fly'"):
        world.act({"fly": ON})
    with pytest.raises(DefinitionError, match="shape"):
        world.act({"drive": np.ones(2)})
    with pytest.raises(DefinitionError, match="nan for robot 0"):
        world.act({"drive": np.array([np.nan])})


def test_a_snapshot_is_refused_elsewhere() -> None:
    snapshot = Forage([1]).snapshot()
    for other in (Forage([1, 2]), Forage([1], ForageSettings(capacity=5))):
        with pytest.raises(FileError, match="restore it in a world like"):
            other.restore(snapshot)
    with pytest.raises(FileError, match="cut short"):
        Forage([1]).restore(snapshot[:-3])
    with pytest.raises(FileError, match="is not a snapshot"):
        Forage([1]).restore(b"\xff\xfe")


def test_a_snapshot_goes_back() -> None:
    world = Forage([1])
    before, snapshot = observe(world), world.snapshot()
    at_food(world)
    load(world, 25)
    world.restore(snapshot)
    assert (observe(world), world.snapshot()) == (before, snapshot)


commands = st.lists(
    st.fixed_dictionaries(
        {}, optional={name: st.floats(-2, 2) for name in ("drive", "turn", "load", "unload")}
    ),
    min_size=1,
    max_size=60,
)


@settings(max_examples=60)
@given(seed=st.integers(0, 2**63 - 1), script=commands, beside=st.booleans())
def test_food_is_conserved_and_the_robot_stays_inside(
    seed: int, script: list[dict[str, float]], beside: bool
) -> None:
    quick = ForageSettings(load_s=0.1, unload_s=0.1, food_beside_station=beside, starts_at_station=True)
    world = Forage([seed], quick)
    total = int(world.total[0])
    for command in script:
        world.act({name: np.array([value]) for name, value in command.items()})
        view = observe(world)
        assert sum(amount for _, _, amount in view.sources) + view.stored + view.delivered == total
        assert world.total[0] == total
        assert 0 <= view.stored <= quick.capacity
        assert all(0.2 - 1e-9 <= at <= 11.8 + 1e-9 for at in (view.x, view.y))
        assert 0 <= view.heading < tau


@settings(max_examples=60)
@given(seed=st.integers(0, 10_000), heading=st.floats(0, tau))
def test_sensing_equals_a_plain_reference(seed: int, heading: float) -> None:
    world = Forage([seed, seed + 1], replace(ForageSettings(), sources=(0, 3)))
    world.place(0, observe(world).x, observe(world).y, heading)
    percept = world.sense(list_reading_keys(world))
    for row in range(2):
        view = observe(world, row)
        spots = {"station": view.station}
        ranges = [hypot(x - view.x, y - view.y) if amount else inf for x, y, amount in view.sources]
        if ranges:
            spots["nearest_food"] = view.sources[ranges.index(min(ranges))][:2]
        for target in ("station", "nearest_food"):
            found = percept["range", target][row], percept["bearing", target][row]
            if target not in spots:
                assert isnan(found[0])
                assert isnan(found[1])
                continue
            dx, dy = spots[target][0] - view.x, spots[target][1] - view.y
            assert found[0] == pytest.approx(hypot(dx, dy))
            off = (found[1] - (atan2(dy, dx) - view.heading) + pi) % tau - pi
            assert abs(off) < 1e-9
            assert 0 <= found[1] < tau


def test_equally_near_sources_go_by_id() -> None:
    world = Forage([1], ForageSettings(sources=(3, 3)))
    food = np.flatnonzero(world.view().objects.food)
    world.place(0, 6.0, 6.0, 0.0)
    for slot, (x, y) in zip(
        world.view().objects.slot[food], [(7.0, 6.0), (5.0, 6.0), (6.0, 7.0)], strict=True
    ):
        world.move_object(slot, x, y)
    keys = [("bearing", "nearest_food"), ("range", "nearest_food")]
    for empty, bearing in ((None, 0.0), (0, pi), (1, pi / 2), (2, nan)):
        if empty is not None:
            world.state.objects["amount"][0, world.view().objects.slot[food[empty]]] = 0
        found = world.sense(keys)
        assert found[keys[0]][0] == pytest.approx(bearing, nan_ok=True)
        assert isnan(found[keys[1]][0]) == isnan(bearing)


def kit_command(name: str) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    return {channel: np.array([value]) for channel, value in FORAGE_KIT.behaviors[name].command.items()}
