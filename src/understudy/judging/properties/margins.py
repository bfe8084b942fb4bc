"""Margins of conditions: how far each agent of a run is from the point where a condition begins or ceases to hold.

A margin lies between -1 and 1. It is positive where the condition holds, and near 0 where little would change that. For
a number x and a threshold t it is d / (s + |d|), where d is the difference on the side where the condition holds, and s
is |t|, or 1 in the unit of x if t is 0, or π for angles. For a region, d is the distance to its edge, and s its radius
or half its shorter side. Labels, flags and absence give 1 or -1; what is absent gives -1 wherever it is compared. "and"
takes the least margin, "or" the largest, as in signal temporal logic.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import reduce
from math import isfinite, pi
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName
from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.properties.condition import Clause, ClauseTest, Condition, convert_threshold
from understudy.judging.properties.free_space import UNITS, find_space
from understudy.judging.properties.thing_positions import (
    find_things,
    is_distance,
    make_distance,
    measure_depth,
    name_things,
)
from understudy.model.value_kinds import Categorical, Column, Toroidal
from understudy.sim.scenario.schema import Goal
from understudy.sim.world import World

Margin: TypeAlias = Callable[[], NDArray[np.float64]]
"""A function that returns the present margins [B, n], of n agents in each of B worlds."""

NEXT_TO_NOTHING = 1e-9
"""The least size of a margin, so that its sign always says whether the condition holds."""


def bind_condition(condition: Condition, run: BehaviorRun, flags: Collection[str]) -> Margin:
    """Make the function that computes a condition's margins during a run.

    Parameters
    ----------
    condition
        The condition.
    run
        The run.
    flags
        Names of the flags that the behavior can raise.

    Returns
    -------
    Margin
        Returns the present margins [B, n], of n agents in each of B worlds; n is 1 for what is not about agents.

    Raises
    ------
    UnknownName
        If the scenario, the robots or the behavior do not have something that the condition names.
    SettingError
        If a unit does not fit, or clauses are about different agents.
    """
    bound = [[_bind_clause(clause, run, flags) for clause in clauses] for clauses in condition.alternatives]
    widths = {each().shape[1] for clauses in bound for each in clauses} - {1}
    if len(widths) > 1:
        raise SettingError(
            where="condition",
            setting=repr(str(condition)),
            problem="joins statements about different agents",
            remedy="make it two properties",
        )

    def read() -> NDArray[np.float64]:
        least = [reduce(np.minimum, [each() for each in clauses]) for clauses in bound]
        return reduce(np.maximum, least)

    return read


def _bind_clause(clause: Clause, run: BehaviorRun, flags: Collection[str]) -> Margin:
    world = run.world
    if clause.comparison is ClauseTest.RAISED:
        return _bind_flag(clause, run, flags)
    if clause.comparison is ClauseTest.REACHED:
        return _bind_goal(clause, world)
    if clause.comparison is ClauseTest.IN:
        return _bind_region(clause, _simulated(world, clause))
    if is_distance(clause.subject):
        return _bind_distance(clause, _simulated(world, clause))
    if world is not None and clause.subject in COUNTS:
        return _bind_count(clause, world)
    if world is not None and (space := find_space(clause.subject, world, run.own_robots)) is not None:
        read, unit = space
        return _bind_number(clause, read, unit=unit, scale=None)
    return _bind_reading(clause, run)


def _simulated(world: World | None, clause: Clause) -> World:
    if world is None:
        raise _wrong(clause, "is about places, which only a simulated world knows", "use a reading")
    return world


def _wrong(clause: Clause, problem: str, remedy: str) -> SettingError:
    return SettingError(where="condition", setting=repr(str(clause)), problem=problem, remedy=remedy)


def _sign(holds: NDArray[np.bool_], *, negated: bool = False) -> NDArray[np.float64]:
    return np.where(holds != negated, 1.0, -1.0)


def _bind_flag(clause: Clause, run: BehaviorRun, flags: Collection[str]) -> Margin:
    if clause.subject not in flags:
        raise UnknownName(what="flag", name=clause.subject, where="the behavior", known=sorted(flags))
    return lambda: _sign(run.find_raised_agents(clause.subject), negated=clause.negated)


def _bind_goal(clause: Clause, world: World | None) -> Margin:
    if clause.subject != "goal":
        raise _wrong(clause, "is not a goal", "write 'goal is reached'")
    worlds, _ = check_goal(world)
    return lambda: _sign(worlds.state.finished[:, np.newaxis] >= 0, negated=clause.negated)


def check_goal(world: World | None) -> tuple[World, Goal]:
    """Return the worlds of a run, and their goal; SettingError if they have none."""
    if world is None or world.scenario.goal is None:
        name = "the robots' world" if world is None else f"scenario {world.scenario.name!r}"
        remedy = "give the scenario a [goal], or name a flag or a reading"
        raise SettingError(where=name, setting="goal", problem="is missing", remedy=remedy)
    return world, world.scenario.goal


def _bind_region(clause: Clause, world: World) -> Margin:
    regions = world.scenario.regions
    if clause.name not in regions:
        where = f"scenario {world.scenario.name!r}"
        raise UnknownName(what="region", name=clause.name, where=where, known=list(regions))
    things, region = find_things(clause.subject, world), regions[clause.name]

    def read() -> NDArray[np.float64]:
        depth, scale = measure_depth(things(), region)
        return _squash(-depth if clause.negated else depth, scale, strict=clause.negated)

    return read


def _bind_distance(clause: Clause, world: World) -> Margin:
    distance = make_distance(clause.subject, world)
    return _bind_number(clause, distance, unit="m", scale=None)


COUNTS = {"delivered": "units", "gathered": "boxes"}
"""Numbers of a whole world, with their units."""


def _bind_count(clause: Clause, world: World) -> Margin:
    def read() -> NDArray[np.float64]:
        counts = world.delivered if clause.subject == "delivered" else world.gathered
        return counts[:, np.newaxis].astype(np.float64)

    return _bind_number(clause, read, unit=COUNTS[clause.subject], scale=None)


def _bind_reading(clause: Clause, run: BehaviorRun) -> Margin:
    try:
        reading = run.find_reading(clause.subject)
    except UnknownName as error:
        world = run.world
        if error.what == "target" or world is None:
            raise
        names = [*error.known, *COUNTS, *UNITS, "distance(…, …)"]
        names += [f"{things} is in REGION" for things in name_things(world)] if world.scenario.regions else []
        raise UnknownName(
            what="feature or reading", name=clause.subject, where=error.where, known=names
        ) from None
    kind = reading.reading.kind
    if clause.comparison is ClauseTest.ABSENT:
        return lambda: _sign(np.isnan(reading.read()), negated=clause.negated)
    if isinstance(kind, Categorical):
        if clause.comparison.is_of_number:
            remedy = f"write '{clause.subject} is {kind.labels[-1]}'"
            raise _wrong(clause, f"compares {kind} with a number", remedy)
        if clause.name not in kind.labels:
            where = f"reading {clause.subject!r}"
            raise UnknownName(what="label", name=clause.name, where=where, known=kind.labels)
        wanted = float(kind.labels.index(clause.name))

        def read_label() -> NDArray[np.float64]:
            values = reading.read()
            return np.where(np.isnan(values), -1.0, _sign(values == wanted, negated=clause.negated))

        return read_label
    if not clause.comparison.is_of_number:
        example = "below 0.5" if not reading.reading.unit else f"below 0.5 {reading.reading.unit}"
        raise _wrong(clause, "compares a number with a word", f"write '{clause.subject} is {example}'")
    if not isinstance(kind, Toroidal):
        return _bind_number(clause, reading.read, unit=reading.reading.unit, scale=None)
    half = kind.period / 2
    limit = convert_threshold(clause.number, clause.unit, of=clause.subject, to=reading.reading.unit)
    if isfinite(limit) and abs(limit) > half * (1 + 1e-9):
        turn = "−180° to 180°" if reading.reading.unit == "rad" else f"{-half:g} to {half:g}"
        raise _wrong(clause, f"is about a value from {turn}", "give a limit in this range")

    def read_angle() -> Column:
        values: Column = np.mod(reading.read() + half, kind.period) - half
        return values

    return _bind_number(clause, read_angle, unit=reading.reading.unit, scale=pi * kind.period / (2 * pi))


def _bind_number(
    clause: Clause, read: Callable[[], NDArray[np.float64]], *, unit: str, scale: float | None
) -> Margin:
    if not clause.comparison.is_of_number:
        raise _wrong(clause, "compares a number with a word", f"write '{clause.subject} is below …'")
    limit = convert_threshold(clause.number, clause.unit, of=clause.subject, to=unit)
    size = scale if scale is not None else abs(limit) or 1.0
    upward = clause.comparison in (ClauseTest.AT_LEAST, ClauseTest.ABOVE)
    strict = clause.comparison in (ClauseTest.BELOW, ClauseTest.ABOVE)

    def margin() -> NDArray[np.float64]:
        values = read()
        return _squash(values - limit if upward else limit - values, size, strict=strict)

    return margin


def _squash(difference: NDArray[np.float64], scale: float, *, strict: bool) -> NDArray[np.float64]:
    """Return margins of differences, which are positive where the condition holds; at 0 it holds unless `strict`."""
    holds = difference > 0 if strict else difference >= 0
    with np.errstate(invalid="ignore"):
        size = np.maximum(np.abs(difference) / (scale + np.abs(difference)), NEXT_TO_NOTHING)
    size = np.where(np.isnan(size), 1.0, size)  # absent, or infinitely far
    return np.where(holds, size, -size)
