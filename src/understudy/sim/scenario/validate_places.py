"""Check places in a scenario: inside the arena, of valid shapes, without overlaps, with room for everything."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import dist, floor, hypot, pi
from typing import NamedTuple

from msgspec import UNSET
from msgspec.structs import replace

from understudy.sim.layout.clearance import (
    Segment,
    find_crossing_edges,
    is_point_in_polygon,
    list_edges,
    list_wall_segments,
    measure_point_to_segment,
    place_polygon,
)
from understudy.sim.params import count_robots, get_count_range, get_region_box
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import (
    ArenaPoint,
    ArenaRegion,
    Breakdown,
    ObjectClass,
    Obstacle,
    Placement,
    RobotGroup,
    Scenario,
)

DENSEST = pi / 12**0.5
"""The largest share of a plane that equal discs can cover."""


CLOSE = 1e-9
"""The largest rounding error of a distance, m."""


class PlacedDisc(NamedTuple):
    """A round thing at a given place, in m, and its key in the scenario."""

    key: str
    x: float
    y: float
    radius: float


def check_places(checker: ScenarioErrors) -> None:
    """Raise SettingError if something cannot be at its place."""
    scenario = checker.scenario
    for name, region in scenario.regions.items():
        _check_region(checker, f"regions.{name}", region)
    _check_walls(checker)
    for index, obstacle in enumerate(scenario.obstacles):
        _check_shape(checker, f"obstacles[{index}]", obstacle)
    if not scenario.robots:
        checker.fail("robots", "is empty", "give at least one robot")
    for index, robots in enumerate(scenario.robots):
        _check_robots(checker, f"robots[{index}]", robots)
    for index, thing in enumerate(scenario.objects):
        _check_objects(checker, f"objects[{index}]", thing)
    for key, placing, radius in list_placed(scenario):
        _check_placing(checker, key, placing, radius)
    _check_order(checker)
    _check_overlaps(checker)
    _check_room(checker)


def list_placed(scenario: Scenario) -> Iterator[tuple[str, Placement, float]]:
    """Yield everything that has places: its key, the thing, and its radius (m)."""
    for index, obstacle in enumerate(scenario.obstacles):
        radius = obstacle.radius or max((hypot(*point) for point in obstacle.points or ()), default=0.0)
        yield f"obstacles[{index}]", obstacle, radius
    for index, thing in enumerate(scenario.objects):
        yield f"objects[{index}]", thing, thing.radius
    for index, robots in enumerate(scenario.robots):
        yield f"robots[{index}]", robots, scenario.types[robots.type].radius


def replace_placed(scenario: Scenario, key: str, thing: Placement | None) -> Scenario:
    """Return a scenario with another thing at a key such as "objects[0]", or without any there."""
    section, _, index = key.removesuffix("]").partition("[")
    things = list(getattr(scenario, section))
    things[int(index) : int(index) + 1] = [] if thing is None else [thing]
    return replace(scenario, **{section: tuple(things)})


def _check_region(checker: ScenarioErrors, key: str, region: ArenaRegion) -> None:
    round_one = region.center is not None and region.radius is not None
    if (region.box is not None) == round_one or (region.center is None) != (region.radius is None):
        checker.fail(key, "is neither a box nor a circle", "give either a box, or a center and a radius")
    width, height = checker.scenario.size
    if region.box is not None:
        x0, y0, x1, y1 = region.box
        if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
            remedy = f"give (x0, y0, x1, y1) with 0 <= x0 < x1 <= {width} and 0 <= y0 < y1 <= {height}"
            checker.fail(f"{key}.box", f"is {list(region.box)}", remedy)
    elif region.center is not None:
        _check_inside(checker, f"{key}.center", region.center, 0.0)


def _check_inside(checker: ScenarioErrors, key: str, place: Sequence[float], radius: float) -> None:
    (x, y), (width, height) = place[:2], checker.scenario.size
    if not (radius <= x <= width - radius and radius <= y <= height - radius):
        where = f"x from {radius} to {width - radius} and y from {radius} to {height - radius}"
        checker.fail(key, f"is ({x}, {y}), outside the arena", f"give {where}")


def _check_walls(checker: ScenarioErrors) -> None:
    for index, wall in enumerate(checker.scenario.walls):
        key, least = f"walls[{index}].points", 3 if wall.closed else 2
        if len(wall.points) < least:
            checker.fail(key, f"has {len(wall.points)} points", f"give at least {least}")
        for number, point in enumerate(wall.points):
            _check_inside(checker, f"{key}[{number}]", point, 0.0)
            if number and point == wall.points[number - 1]:
                checker.fail(f"{key}[{number}]", "is the point before it again", "leave one of the two out")


def _check_shape(checker: ScenarioErrors, key: str, obstacle: Obstacle) -> None:
    if (obstacle.radius is None) == (obstacle.points is None):
        checker.fail(key, "is neither round nor a polygon", "give either a radius or points")
    if obstacle.points is None:
        return
    if len(obstacle.points) < 3:
        checker.fail(f"{key}.points", f"has {len(obstacle.points)} points", "give at least 3")
    crossing = find_crossing_edges(obstacle.points)
    if crossing is not None:
        first, second = crossing
        problem = f"is a polygon whose edges {first} and {second} meet"
        if first == second:
            problem = f"has the corner {first} twice in a row"
        checker.fail(f"{key}.points", problem, "give its corners in order around it, each once")


def _check_robots(checker: ScenarioErrors, key: str, robots: RobotGroup) -> None:
    types = checker.scenario.types
    checker.check_known(f"{key}.type", robots.type, types, what="type of robot")
    if isinstance(robots.count, tuple) or robots.count == 0:
        count = list(robots.count) if isinstance(robots.count, tuple) else robots.count
        checker.fail(
            f"{key}.count",
            f"is {count}",
            "give one whole number from 1 up: robots are the same in all worlds",
        )
    capacity = types[robots.type].capacity
    if robots.stored > capacity:
        problem = f"is {robots.stored}, and the type {robots.type!r} has a capacity of {capacity}"
        checker.fail(f"{key}.stored", problem, f"give at most {capacity}")
    for index, breakdown in enumerate(robots.fails):
        _check_breakdown(checker, f"{key}.fails[{index}]", breakdown, count_robots(robots.count, robots.at))


def _check_breakdown(checker: ScenarioErrors, key: str, breakdown: Breakdown, robots: int) -> None:
    """Raise SettingError if a group does not have the robots that are to fail."""
    if breakdown.robots is None:
        most = get_count_range(breakdown.count)[1]
        if most > robots:
            checker.fail(f"{key}.count", f"is {most}, and the group has {robots}", f"give at most {robots}")
        return
    if breakdown.count != 1:
        checker.fail(f"{key}.count", "is given beside robots", "leave out one of the two")
    for each in breakdown.robots:
        if each >= robots:
            checker.fail(
                f"{key}.robots",
                f"has number {each}, and the group has {robots}",
                f"count from 0 to {robots - 1}",
            )


def _check_objects(checker: ScenarioErrors, key: str, thing: ObjectClass) -> None:
    if thing.aloft and (thing.solid or thing.pushable):
        checker.fail(
            f"{key}.aloft", "is given for what robots bump into", "leave it out, or leave out `solid`"
        )
    region = checker.scenario.regions.get(thing.within or "")
    for word, setting in (("presence", thing.presence), ("walk", thing.walk)):
        if setting is not None and region is not None and region.box is None:
            checker.fail(
                f"{key}.within", f"is a circle for things with a {word}", "give a region that is a box"
            )
    if thing.presence is None:
        return
    for word, value in (("at", isinstance(thing.at, tuple)), ("near", thing.near is not None)):
        if value:
            checker.fail(
                f"{key}.{word}", "is given for things that appear at random", "leave it out, or give `within`"
            )
    if isinstance(thing.count, tuple):
        checker.fail(f"{key}.count", "is drawn for things that come and go", "give one whole number")


def _check_placing(checker: ScenarioErrors, key: str, placing: Placement, radius: float) -> None:
    scenario = checker.scenario
    if isinstance(placing.at, tuple):
        for word in ("count", "within", "near"):
            if getattr(placing, word) is not None and getattr(placing, word) is not UNSET:
                checker.fail(f"{key}.{word}", "is given beside places", "leave it out, or leave out `at`")
        if not placing.at:
            checker.fail(f"{key}.at", "is empty", "give at least one place, or a count")
        solid = isinstance(placing, RobotGroup) or (
            isinstance(placing, ObjectClass) and (placing.solid or placing.pushable)
        )
        for index, place in enumerate(placing.at):
            if len(place) not in (2, 3):
                checker.fail(
                    f"{key}.at[{index}]",
                    f"has {len(place)} numbers",
                    "give x and y, then degrees if you like",
                )
            _check_inside(checker, f"{key}.at[{index}]", place, radius if solid else 0.0)
    if placing.within is not None:
        checker.check_known(f"{key}.within", placing.within, scenario.regions, what="region")
    if placing.near_m and placing.near is None:
        checker.fail(f"{key}.near_m", "is given without `near`", "name the object that they are near")
    if placing.near is None:
        return
    names = [thing.name for thing in scenario.objects]
    checker.check_known(f"{key}.near", placing.near, names, what="class of objects")
    near = scenario.objects[names.index(placing.near)]
    if near.presence is not None or (not isinstance(near.at, tuple) and _fewest(near) < 1):
        remedy = "give that object a count of at least 1 and no presence"
        checker.fail(f"{key}.near", f"is {placing.near!r}, which is not always there", remedy)
    if (near.solid or near.pushable) and placing.near_m < radius + near.radius - CLOSE:
        problem = f"is {placing.near_m}, inside {placing.near!r}, which is solid"
        checker.fail(f"{key}.near_m", problem, f"give at least {radius + near.radius:g}")


def _fewest(placing: Placement) -> int:
    return get_count_range(placing.count)[0] if isinstance(placing.count, int | tuple) else 1


def _check_order(checker: ScenarioErrors) -> None:
    """Raise SettingError if an object is near itself, directly or through others."""
    near = {thing.name: thing.near for thing in checker.scenario.objects}
    for index, thing in enumerate(checker.scenario.objects):
        at, visited = thing.near, {thing.name}
        while at is not None and at not in visited:
            visited.add(at)
            at = near[at]
        if at == thing.name:
            remedy = "place one of them without the other"
            checker.fail(f"objects[{index}].near", f"leads back to {thing.name!r} itself", remedy)


def _check_overlaps(checker: ScenarioErrors) -> None:
    """Raise SettingError if solid things at given places overlap; obstacles may overlap each other."""
    scenario = checker.scenario
    walls = tuple(list_wall_segments(scenario))
    polygons = tuple(_polygons(scenario))
    grid: dict[tuple[int, int], list[PlacedDisc]] = {}
    discs = list(_solid_discs(scenario))
    cell = 2.0 * max((disc.radius for disc in discs), default=1.0)
    for disc in discs:
        stays = disc.key.startswith("obstacles")
        if not stays:
            _check_disc(checker, disc, walls, polygons)
        column, row = floor(disc.x / cell), floor(disc.y / cell)
        for near in ((column + dx, row + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)):
            for before in grid.get(near, ()):
                both_stay = stays and before.key.startswith("obstacles")
                if not both_stay and dist(before[1:3], disc[1:3]) < before.radius + disc.radius - CLOSE:
                    checker.fail(disc.key, f"overlaps {before.key}", "give a free place")
        grid.setdefault((column, row), []).append(disc)


def _check_disc(
    checker: ScenarioErrors,
    disc: PlacedDisc,
    walls: Sequence[Segment],
    polygons: Sequence[tuple[str, Sequence[ArenaPoint]]],
) -> None:
    place = (disc.x, disc.y)
    if any(measure_point_to_segment(place, wall) < disc.radius for wall in walls):
        checker.fail(disc.key, "overlaps a wall", "give a free place")
    for key, corners in polygons:
        if is_point_in_polygon(place, corners) or any(
            measure_point_to_segment(place, edge) < disc.radius for edge in list_edges(corners)
        ):
            checker.fail(disc.key, f"overlaps {key}", "give a free place")


def _polygons(scenario: Scenario) -> Iterator[tuple[str, tuple[ArenaPoint, ...]]]:
    for index, obstacle in enumerate(scenario.obstacles):
        if obstacle.points is not None and isinstance(obstacle.at, tuple):
            for number, place in enumerate(obstacle.at):
                yield f"obstacles[{index}].at[{number}]", place_polygon(obstacle.points, place)


def _solid_discs(scenario: Scenario) -> Iterator[PlacedDisc]:
    for key, placing, radius in list_placed(scenario):
        if isinstance(placing, Obstacle) and placing.radius is None:
            continue
        if isinstance(placing, ObjectClass) and not (placing.solid or placing.pushable):
            continue
        if isinstance(placing, RobotGroup) and not scenario.types[placing.type].collides:
            continue
        if isinstance(placing.at, tuple):
            for index, (x, y, *_) in enumerate(placing.at):
                yield PlacedDisc(f"{key}.at[{index}]", x, y, radius)


def _check_room(checker: ScenarioErrors) -> None:
    """Raise SettingError if things cannot fit by their size alone; the rest is found when a world is laid out."""
    scenario = checker.scenario
    width, height = scenario.size
    taken = 0.0
    for key, placing, radius in list_placed(scenario):
        if isinstance(placing.at, tuple) or (
            isinstance(placing, ObjectClass) and placing.presence is not None
        ):
            continue
        reach = (
            radius + placing.apart
            if not (isinstance(placing, Obstacle) and placing.points)
            else placing.apart
        )
        x0, y0, x1, y1 = get_region_box(scenario, placing.within)
        if min(x1, width - reach) < max(x0, reach) or min(y1, height - reach) < max(y0, reach):
            region = f"the region {placing.within!r}" if placing.within else "the arena"
            checker.fail(key, f"finds no room in {region}", "give a smaller radius or `apart`, or more room")
        if isinstance(placing, Obstacle) and placing.points is not None:
            continue
        if isinstance(placing, RobotGroup) and not scenario.types[placing.type].collides:
            continue
        count, half = _fewest(placing), 0.5 * placing.apart
        taken += count * pi * (radius + half) ** 2
        if taken > DENSEST * (width + 2 * half) * (height + 2 * half):
            problem = f"asks for {count}, which do not fit: there is not enough free space"
            checker.fail(f"{key}.count", problem, "give fewer, smaller radii, less `apart`, or a larger size")
