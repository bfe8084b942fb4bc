"""Make a scenario from a world as it stands, so that a world that was edited by hand can be kept and shared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from math import degrees

from msgspec import UNSET
from msgspec.structs import replace

from understudy.sim.scenario.files import remove_markers
from understudy.sim.scenario.schema import MOUSE, Breakdown, ObjectClass, Obstacle, RobotGroup, Scenario
from understudy.sim.view import WorldView

PLACES = 6
"""Digits after the point of a place: a micrometer."""


def make_scenario_snapshot(scenario: Scenario, view: WorldView, *, name: str, about: str = "") -> Scenario:
    """Return a scenario in which everything is where it is in a view, for every seed.

    Parameters
    ----------
    scenario
        The scenario of the world.
    view
        The world as it stands.
    name
        Name of the new scenario.
    about
        What it is about; that of `scenario` if empty.

    Returns
    -------
    Scenario
        Robots, objects and obstacles are at the places of the view. Robots carry what they carry; those that have
        failed fail at once, and others in the time that they have left. Sources of food
        have what they had at first; where those of a class differ, each world draws between the least and the most.
        Objects that come and go, and the pointer, stay as they are in `scenario`.
    """
    placed = replace(
        scenario,
        name=name,
        about=about or scenario.about,
        obstacles=tuple(_obstacles(scenario, view)),
        objects=tuple(_place_objects(thing, view) for thing in scenario.objects),
        robots=tuple(_robots(view)),
    )
    return remove_markers(placed)


def _at(*numbers: float) -> tuple[float, ...]:
    return tuple(round(float(number), PLACES) for number in numbers)


def _robots(view: WorldView) -> Iterator[RobotGroup]:
    """Yield the robots in order of their ids, those of one type and load together."""
    robots = view.robots

    def get_group(robot: int) -> tuple[int, int]:
        return int(robots.type[robot]), int(robots.stored[robot])

    for (kind, stored), group in groupby(range(len(robots)), key=get_group):
        rows = list(group)
        places = tuple(
            _at(robots.x[each], robots.y[each], degrees(robots.heading[each]) % 360) for each in rows
        )
        fails = tuple(_list_breakdowns(view, rows))
        yield RobotGroup(type=view.names.types[kind], at=places, stored=stored, fails=fails)


def _list_breakdowns(view: WorldView, rows: Sequence[int]) -> Iterator[Breakdown]:
    """Yield when those of some robots fail that are going to, or have failed, from the moment of the view on."""
    left: dict[float, list[int]] = {}
    for number, robot in enumerate(rows):
        fails_s = float(view.robots.fails_s[robot]) - view.time_s
        if view.robots.frozen[robot]:
            left.setdefault(0.0, []).append(number)
        elif fails_s > 0:  # not NaN: it is going to
            left.setdefault(round(fails_s, PLACES), []).append(number)
    for at_s, numbers in sorted(left.items()):
        yield Breakdown(at_s=at_s, robots=tuple(numbers))


def _place_objects(thing: ObjectClass, view: WorldView) -> ObjectClass:
    if thing.presence is not None or thing.name == MOUSE:
        return thing
    objects, kind = view.objects, view.names.classes.index(thing.name)
    here = [index for index in range(len(objects)) if objects.kind[index] == kind]
    amounts = sorted({int(objects.at_first[index]) for index in here})
    if not here:
        return replace(thing, count=0, at=UNSET, within=None, near=None, near_m=0.0)
    return replace(
        thing,
        count=UNSET,
        at=tuple(_at(objects.x[index], objects.y[index]) for index in here),
        within=thing.within if thing.pull is not None and thing.pull.respawn else None,
        near=None,
        near_m=0.0,
        amount=thing.amount
        if not any(amounts)
        else amounts[0]
        if len(amounts) == 1
        else (amounts[0], amounts[-1]),
    )


def _obstacles(scenario: Scenario, view: WorldView) -> Iterator[Obstacle]:
    """Yield the round obstacles, as high as those of the scenario that look the same, then the polygons."""
    discs = view.discs
    originals = {(each.radius, each.color): each for each in scenario.obstacles if each.radius is not None}

    def get_group(disc: int) -> tuple[float, str | None]:
        return round(float(discs.radius[disc]), PLACES), view.color(int(discs.color[disc]))

    for (radius, color), group in groupby(range(len(discs)), key=get_group):
        like = originals.get((radius, color), Obstacle(radius=radius, color=color))
        yield Obstacle(
            radius=radius,
            color=color,
            height=like.height,
            at=tuple(_at(discs.x[each], discs.y[each]) for each in group),
        )
    colors = [each.color for each in scenario.obstacles if each.points is not None]
    for index, corners in enumerate(view.polygons):
        x, y = corners.mean(axis=0)
        points = tuple((round(float(px - x), PLACES), round(float(py - y), PLACES)) for px, py in corners)
        yield Obstacle(
            points=points, at=(_at(x, y, 0.0),), color=colors[min(index, len(colors) - 1)] if colors else None
        )
