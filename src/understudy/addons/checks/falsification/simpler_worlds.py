"""Scenarios that are simpler than a given one in one respect, the simplest first."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from typing import TypeVar

from msgspec import UNSET
from msgspec.structs import replace

from understudy.addons.checks.falsification.disturbances import apply_disturbances, list_disturbances
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import TrialMeasure
from understudy.sim.params import get_count_range
from understudy.sim.scenario.files import remove_markers
from understudy.sim.scenario.schema import ObjectClass, Obstacle, Placement, RobotGroup, Scenario
from understudy.sim.scenario.validate_places import list_placed, replace_placed
from understudy.sim.scenario_snapshot import make_scenario_snapshot
from understudy.sim.view import WorldView
from understudy.sim.world import World

BEFORE_S = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0)
"""The times before the last progress from which a shorter run may start, s."""

GRIDS_M = (1.0, 0.5, 0.1, 0.01, 0.001)
ANGLES_DEG = (90.0, 45.0, 15.0, 5.0, 1.0, 0.1)
"""The steps to which places and headings are rounded, the coarsest first."""

MOST_ROUNDED = 12
"""The largest number of things that are rounded one by one."""

Thing = TypeVar("Thing", bound=Placement)


def make_explicit(trial: Trial) -> Scenario:
    """Return the scenario of a trial with all places given; amounts are still drawn by the seed."""
    world = World(trial.scenario, [trial.seed])
    return _place_like(trial.scenario, world.view(), keep_amounts=True)


def _place_like(scenario: Scenario, view: WorldView, *, keep_amounts: bool) -> Scenario:
    placed = make_scenario_snapshot(scenario, view, name=scenario.name)
    if not keep_amounts:
        return placed
    amounts = {thing.name: thing.amount for thing in scenario.objects}
    objects = tuple(replace(thing, amount=amounts.get(thing.name, thing.amount)) for thing in placed.objects)
    return replace(placed, objects=objects)


def list_without_obstacles(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario without any obstacles, then without each of them."""
    if scenario.obstacles:
        yield "all obstacles left out", replace(scenario, obstacles=())
    for _, fewer in _leave_out_each(scenario, Obstacle):
        yield "an obstacle left out", fewer


def list_without_objects(scenario: Scenario, usual: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario with fewer objects, of each class as many as the usual scenario has at least."""
    least = {thing.name: _get_least(thing) for thing in usual.objects}
    for thing, fewer in _leave_out_each(scenario, ObjectClass):
        if isinstance(thing.at, tuple) and len(thing.at) > least.get(thing.name, 0):
            yield f"one {thing.name} left out", fewer


def list_without_robots(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario with one robot less, where each could do the task alone."""
    together = any(
        thing.pushers > 1 or (thing.pull is not None and thing.pull.robots > 1) for thing in scenario.objects
    )
    count = sum(len(group.at) for group in scenario.robots if isinstance(group.at, tuple))
    if not (scenario.squads or together or count < 2):
        for _, fewer in _leave_out_each(scenario, RobotGroup):
            yield "one robot left out", fewer


def _leave_out_each(scenario: Scenario, kind: type[Thing]) -> Iterator[tuple[Thing, Scenario]]:
    """Yield the scenario without each single thing of a kind at a given place, with the things that it was one of."""
    for key, things, _ in list_placed(scenario):
        if not (isinstance(things, kind) and isinstance(things.at, tuple)):
            continue
        # A scenario keeps the name of a class without objects.
        none: Placement | None = replace(things, at=UNSET, count=0) if kind is ObjectClass else None
        for number in range(len(things.at)):
            places = (*things.at[:number], *things.at[number + 1 :])
            fewer = replace(things, at=places) if places else none
            yield things, replace_placed(scenario, key, fewer)


def list_less_disturbed(scenario: Scenario, usual: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario with a noise or probability as the usual scenario has it."""
    for disturbance in list_disturbances(usual):
        undisturbed = apply_disturbances(scenario, {disturbance: disturbance.default})
        yield f"{disturbance.name} as usual", undisturbed


def list_smaller_amounts(scenario: Scenario, usual: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario with less food in each source, from the least that the usual scenario draws."""
    ranges = {thing.name: get_count_range(thing.amount) for thing in usual.objects}
    for key, thing, _ in list_placed(scenario):
        if isinstance(thing, ObjectClass):
            least, most = ranges.get(thing.name, (0, 0))
            now = get_count_range(thing.amount)[1] if isinstance(thing.amount, int) else most + 1
            for amount in range(least, min(now, most + 1)):
                less = replace_placed(scenario, key, replace(thing, amount=amount))
                yield f"{amount} units in each {thing.name}", less


def list_earlier_starts(
    measure: TrialMeasure, trial: Trial, progress_s: float
) -> Iterator[tuple[str, Scenario]]:
    """Yield scenarios that begin as the trial's world stands shortly before its last progress, the latest first."""
    tick_s = trial.scenario.tick_s
    starts = [round((progress_s - before) / tick_s) for before in BEFORE_S]
    views: dict[int, WorldView] = {}
    run = measure.start([trial])
    for tick in sorted(each for each in starts if each > 0):
        run.advance(tick - run.ticks)
        views[tick] = run.get_world().view()
    for tick in sorted(views, reverse=True):
        for shorter in _start_from(trial.scenario, views[tick]):
            yield f"begins {tick * tick_s:.1f} s later", shorter


def _start_from(scenario: Scenario, view: WorldView) -> Iterator[Scenario]:
    """Yield scenarios that begin as in a view: sources that are empty are left out, others have equal amounts."""
    placed = _place_like(scenario, view, keep_amounts=False)
    objects, left = list[ObjectClass](), list[int]()
    for thing in placed.objects:
        kind = view.names.classes.index(thing.name)
        rows = [row for row in range(len(view.objects)) if view.objects.kind[row] == kind]
        if not any(view.objects.food[row] for row in rows) or not isinstance(thing.at, tuple):
            objects.append(thing)
            continue
        full = [number for number, row in enumerate(rows) if view.objects.amount[row] > 0]
        left += [int(view.objects.amount[rows[number]]) for number in full]
        places = tuple(thing.at[number] for number in full)
        objects.append(replace(thing, at=places) if places else replace(thing, at=UNSET, count=0))
    for amount in sorted(set(left)) or [0]:
        changed = tuple(
            replace(thing, amount=amount) if amount and get_count_range(thing.amount)[1] else thing
            for thing in objects
        )
        yield replace(placed, objects=changed)


def list_rounder(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario with rounder places and headings: of everything, then of each of a few things."""
    keys = list(_list_places(scenario))
    groups = [("all places", "all headings", frozenset(keys))]
    if len(keys) <= MOST_ROUNDED:
        groups += [(one, f"heading of {one}", frozenset([one])) for one in keys]
    for place, heading, chosen in groups:
        for grid in GRIDS_M:
            yield f"{place} rounded to {grid:g} m", _map_places(scenario, chosen, partial(_snap, grid=grid))
        for angle in ANGLES_DEG:
            yield (
                f"{heading} rounded to {angle:g}°",
                _map_places(scenario, chosen, partial(_turn, angle=angle)),
            )


def _snap(place: tuple[float, ...], *, grid: float) -> tuple[float, ...]:
    if _digits(place[:2]) <= _digits((grid,)):
        return place
    return (*(round(round(each / grid) * grid, 6) for each in place[:2]), *place[2:])


def _turn(place: tuple[float, ...], *, angle: float) -> tuple[float, ...]:
    if len(place) < 3 or (place[2] / angle).is_integer():
        return place
    return (*place[:2], round(round(place[2] / angle) * angle % 360.0, 6))


def _digits(numbers: Sequence[float]) -> int:
    """Return the most digits after the point, and -1 for numbers that are whole."""
    return max((len(f"{each:.6f}".rstrip("0").partition(".")[2]) or -1) for each in numbers)


def _list_places(scenario: Scenario) -> Iterator[str]:
    """Yield the keys of all given places."""
    for key, things, _ in list_placed(scenario):
        yield from (
            f"{key}.at[{number}]" for number in range(len(things.at) if isinstance(things.at, tuple) else 0)
        )


def _map_places(
    scenario: Scenario, chosen: Collection[str], change: Callable[[tuple[float, ...]], tuple[float, ...]]
) -> Scenario:
    """Return the scenario with the places of the chosen keys changed."""
    for key, things, _ in list_placed(scenario):
        if isinstance(things.at, tuple):
            places = tuple(
                change(place) if f"{key}.at[{number}]" in chosen else place
                for number, place in enumerate(things.at)
            )
            scenario = replace_placed(scenario, key, replace(things, at=places))
    return scenario


def _get_least(thing: ObjectClass) -> int:
    if isinstance(thing.at, tuple):
        return len(thing.at)
    return get_count_range(thing.count)[0] if isinstance(thing.count, int | tuple) else 1


def strip_for_file(scenario: Scenario, *, name: str, about: str) -> Scenario:
    """Return a scenario as it is written to a file, with a name and what it is about."""
    return remove_markers(replace(scenario, name=name, about=about))
