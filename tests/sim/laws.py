"""The laws of worlds, in plain NumPy: what holds of a state, and between a state and the one a tick later."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import Percept
from understudy.model.value_kinds import TAU, Categorical, Toroidal
from understudy.runtime.body import Commands
from understudy.sim.kit import list_type_readings
from understudy.sim.scenario.schema import (
    Camera,
    RandomSensor,
    SensorBase,
    Sonar,
    StallSensor,
    TargetLocator,
)
from understudy.sim.world import World

SLACK = 1e-9
"""What rounding may do to a distance, m."""
BOX_SHARE = 0.01
"""Boxes may overlap by this share of their radius."""

Floats = NDArray[Any]


class Kept(NamedTuple):
    """What a tick is compared with: the state before it."""

    robots: NDArray[Any]
    objects: NDArray[Any]


def copy_state(world: World) -> Kept:
    return Kept(world.state.robots.copy(), world.state.objects.copy())


def check_state(world: World) -> None:
    """All is finite, inside the arena, and nothing solid overlaps."""
    state, rules = world.state, world.rules
    for name in ("x", "y", "heading", "speed", "spin"):
        assert np.isfinite(state.robots[name]).all(), name
    assert ((state.robots["heading"] >= 0) & (state.robots["heading"] < TAU)).all()
    kinds = rules.classes[rules.class_of]
    for index in range(world.worlds):
        robots = state.robots[index * world.robots : (index + 1) * world.robots]
        types = rules.types[robots["type"]]
        objects = state.objects[index]
        there = objects["present"] != 0
        for name in ("x", "y"):
            assert np.isfinite(objects[name][there]).all()
        _check_inside(world, robots["x"], robots["y"], types["radius"])
        solid = there & (kinds["solid"] != 0)
        _check_inside(world, objects["x"][solid], objects["y"][solid], kinds["radius"][solid])
        own = (
            np.concatenate([robots["x"], objects["x"][solid]]),
            np.concatenate([robots["y"], objects["y"][solid]]),
        )
        radius = np.concatenate([types["radius"], kinds["radius"][solid]])
        box = np.concatenate([np.zeros(len(robots), bool), kinds["pushable"][solid] != 0])
        allowed = SLACK + BOX_SHARE * radius * box
        ghost = np.concatenate([types["collides"] == 0, np.zeros(solid.sum(), bool)])
        robot = np.arange(len(radius)) < len(robots)
        apart = np.hypot(own[0][:, None] - own[0], own[1][:, None] - own[1]) - radius[:, None] - radius
        pairs = ~np.eye(len(radius), dtype=bool)
        pairs &= ~((ghost[:, None] | ghost) & robot[:, None] & robot)
        assert (apart >= -np.maximum(allowed[:, None], allowed))[pairs].all(), apart[pairs].min()
        discs = state.discs[index]
        discs = discs[discs["radius"] > 0]
        if len(discs):
            away = np.hypot(own[0][:, None] - discs["x"], own[1][:, None] - discs["y"])
            away -= radius[:, None] + discs["radius"]
            assert (away >= -allowed[:, None]).all(), away.min()
        segments = pieces(world, index)
        if len(segments):
            away = to_segments(own[0], own[1], segments) - radius[:, None]
            assert (away >= -allowed[:, None]).all(), away.min()


def check_tick(world: World, before: Kept, commands: Commands) -> None:
    """Who is not driven stays, nobody goes farther than it can, nobody goes through anything, food stays."""
    state, rules = world.state, world.rules
    now, then = state.robots, before.robots
    types = rules.types[then["type"]]
    step = np.hypot(now["x"] - then["x"], now["y"] - then["y"])
    most = types["speed"] * np.where(types["noise_drive"] > 0, 2.0, 1.0)
    assert (step <= most * (1 + 1e-12) + SLACK).all()
    braking = np.isfinite(types["acceleration"]) & (then["speed"] != 0)
    pulled = (now["holding"] != 0) | (then["holding"] != 0)
    stays = (commands["drive"] == 0) & ~braking & ~pulled
    stays |= then["frozen"] != 0
    assert (now["x"][stays] == then["x"][stays]).all()
    assert (now["y"][stays] == then["y"][stays]).all()
    spinning = np.isfinite(types["turning_acceleration"]) & (then["spin"] != 0)
    looks = ((commands["turn"] == 0) & ~spinning) | (then["frozen"] != 0)
    assert (now["heading"][looks] == then["heading"][looks]).all()
    _check_food(world, before)
    kinds = rules.classes[rules.class_of]
    still = ~((kinds["walk"] > 0) | (kinds["pushable"] != 0) | ~np.isnan(kinds["away_least"]))
    still &= kinds["pull"] == 0
    for name in ("x", "y"):
        assert (state.objects[name][:, still] == before.objects[name][:, still]).all()
    for index in range(world.worlds):
        rows = slice(index * world.robots, (index + 1) * world.robots)
        _check_paths(world, index, then[rows], now[rows], before.objects[index])
        _check_boxes(world, index, then[rows], now[rows], before.objects[index])


def pieces(world: World, index: int) -> Floats:
    """Segments that are there [S, 4]."""
    segments = world.state.segments[index]
    found = np.stack([segments[name] for name in ("x0", "y0", "x1", "y1")], axis=1)
    there: Floats = found[~np.isnan(found).any(axis=1)]
    return there


def to_segments(x: Floats, y: Floats, segments: Floats) -> Floats:
    """Distances [N, S] of places from segments."""
    start, end = segments[:, :2], segments[:, 2:]
    along = end - start
    squared = np.maximum((along**2).sum(axis=1), 1e-300)
    dx, dy = x[:, None] - start[:, 0], y[:, None] - start[:, 1]
    share = np.clip((dx * along[:, 0] + dy * along[:, 1]) / squared, 0.0, 1.0)
    distance: Floats = np.hypot(dx - share * along[:, 0], dy - share * along[:, 1])
    return distance


def _check_inside(world: World, x: Floats, y: Floats, radius: Floats) -> None:
    least = radius - SLACK
    assert ((x >= least) & (x <= world.rules.width - least)).all()
    assert ((y >= least) & (y <= world.rules.height - least)).all()


def _check_food(world: World, before: Kept) -> None:
    """What robots carry, have delivered, and what is left in the sources is as much as before."""
    state = world.state
    amounts = before.objects["amount"].sum() - state.objects["amount"].sum()
    carried = sum(
        int(state.robots[name].sum()) - int(before.robots[name].sum()) for name in ("stored", "delivered")
    )
    assert amounts == carried
    assert (state.objects["amount"] >= 0).all()
    assert (state.objects["amount"] <= before.objects["amount"]).all()
    capacity = world.rules.types["capacity"][state.robots["type"]]
    assert ((state.robots["stored"] >= 0) & (state.robots["stored"] <= capacity)).all()


def _check_boxes(world: World, index: int, then: Floats, now: Floats, objects: Floats) -> None:
    """A box moves only with hands enough, and all who hold it go as it does, within their reach."""
    rules, boxes = world.rules, world.state.objects[index]
    kinds = rules.classes[rules.class_of]
    held = np.flatnonzero(now["holding"])
    slots = now["holding"][held] - 1
    assert (kinds["pull"][slots] > 0).all()
    assert (boxes["present"][slots] != 0).all()
    hands = np.bincount(slots, minlength=len(boxes))
    assert (boxes["hands"] == hands).all()
    gathered = boxes["gathered"] - objects["gathered"]
    assert (gathered >= 0).all()
    assert (gathered <= objects["present"]).all()
    moved = np.hypot(boxes["x"] - objects["x"], boxes["y"] - objects["y"])
    came = (kinds["pull"] > 0) & (moved > 0) & (boxes["appeared"] == objects["appeared"]) & (gathered == 0)
    assert (hands[came] >= kinds["pull"][came]).all()
    for name in ("x", "y"):
        own, of_box = now[name] - then[name], boxes[name] - objects[name]
        assert np.allclose(own[held], of_box[slots], rtol=0.0, atol=SLACK)
    away = np.hypot(now["x"][held] - boxes["x"][slots], now["y"][held] - boxes["y"][slots])
    assert (away <= rules.types["reach"][now["type"][held]] + 1e-6).all()


def _check_paths(world: World, index: int, then: Floats, now: Floats, objects: Floats) -> None:
    """The straight ways of a tick come no nearer to anything solid that stays, or to each other, than radii allow."""
    rules = world.rules
    types = rules.types[then["type"]]
    radius = types["radius"]
    ways = np.stack([then["x"], then["y"], now["x"], now["y"]], axis=1)
    discs = world.state.discs[index]
    discs = discs[discs["radius"] > 0]
    kinds = rules.classes[rules.class_of]
    solid = (objects["present"] != 0) & (kinds["solid"] != 0) & (kinds["pushable"] == 0)
    x = np.concatenate([discs["x"], objects["x"][solid]])
    y = np.concatenate([discs["y"], objects["y"][solid]])
    radii = np.concatenate([discs["radius"], kinds["radius"][solid]])
    away = to_segments(x, y, ways).T - radius[:, None] - radii
    assert (away >= -SLACK).all(), away.min()
    assert not _cross(ways, pieces(world, index)).any()
    collides = types["collides"] != 0
    first, second = np.triu_indices(len(then), 1)
    both = collides[first] & collides[second]
    first, second = first[both], second[both]
    relative = ways[first] - ways[second]
    along = relative[:, 2:] - relative[:, :2]
    squared = np.maximum((along**2).sum(axis=1), 1e-300)
    share = np.clip(-(relative[:, :2] * along).sum(axis=1) / squared, 0.0, 1.0)
    nearest_x, nearest_y = (relative[:, :2] + share[:, None] * along).T
    nearest = np.hypot(nearest_x, nearest_y)
    assert (nearest >= radius[first] + radius[second] - SLACK).all()


def _cross(ways: Floats, segments: Floats) -> Floats:
    """Which ways [N, 4] lead across which segments [S, 4], as [S, N]."""
    start_x, start_y, end_x, end_y = segments.T[:, :, None]
    along_x, along_y = end_x - start_x, end_y - start_y
    way_x, way_y = ways[:, 2] - ways[:, 0], ways[:, 3] - ways[:, 1]

    def side(x: Floats, y: Floats) -> Floats:
        found: Floats = along_x * (y - start_y) - along_y * (x - start_x)
        return found

    def way_side(x: Floats, y: Floats) -> Floats:
        found: Floats = way_x * (y - ways[:, 1]) - way_y * (x - ways[:, 0])
        return found

    apart = side(ways[:, 0], ways[:, 1]) * side(ways[:, 2], ways[:, 3]) < 0
    crossing: Floats = apart & (way_side(start_x, start_y) * way_side(end_x, end_y) < 0)
    return crossing


NEVER_ABSENT = ("x", "y", "heading", "speed", "turning", "stuck", "food_stored", "food_here", "food_left",
                "station_here", "holding", "enough", "random", "ahead", "left", "right", "around", "front",
                "rear")  # fmt: skip
"""Readings that are absent only for robots without the sensor, frozen ones, and where an answer dropped out."""


def check_percept(world: World, percept: Percept) -> None:
    """Readings keep their kinds and ranges; absent only where that is meant."""
    kinds = {reading.name: reading.kind for reading in world.readings}
    frozen = world.state.robots["frozen"] != 0
    sensors = [_by_reading(world, name) for name in world.names.types]
    for (name, target), column in percept.items():
        assert not np.isinf(column).any(), name
        assert np.isnan(column[frozen]).all()
        kind = kinds[name]
        values = column[~np.isnan(column)]
        if isinstance(kind, Categorical):
            assert np.isin(values, (0.0, 1.0)).all(), name
        elif isinstance(kind, Toroidal):
            assert ((values >= 0) & (values < kind.period)).all(), name
        for index, by_reading in enumerate(sensors):
            own = column[(world.state.robots["type"] == index) & ~frozen]
            sensor = by_reading.get(name)
            if sensor is None:
                assert np.isnan(own).all(), (name, target)
                continue
            if name in NEVER_ABSENT and sensor.dropout == 0:
                assert not np.isnan(own).any(), (name, target)
            _check_range(name, own[~np.isnan(own)], sensor)
    for one, other in (("range", "bearing"), ("blob_x", "blob_size")):
        for name, target in percept:
            if name == one:
                assert (np.isnan(percept[one, target]) == np.isnan(percept[other, target])).all()


def _by_reading(world: World, type_name: str) -> dict[str, SensorBase]:
    kind = world.scenario.types[type_name]
    return {reading.name: kind.sensors[index] for index, reading in list_type_readings(kind)}


def _check_range(name: str, values: Floats, sensor: SensorBase) -> None:
    low, high = -np.inf, np.inf
    if isinstance(sensor, Sonar):
        low, high = 0.0, sensor.range
    elif isinstance(sensor, Camera):
        low, high = 0.0, sensor.width_px if name == "blob_x" else np.inf
    elif isinstance(sensor, TargetLocator) and name == "range":
        low = 0.0
    elif isinstance(sensor, RandomSensor | StallSensor):
        low, high = 0.0, 1.0
    assert ((values >= low) & (values <= high)).all(), name
