"""Examples of conditions: one for each thing that a scenario and a behavior have, to begin a condition with."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations_with_replacement

from understudy.errors import UnderstudyError, UnknownName
from understudy.judging.named_reading import NamedReading, find_reading
from understudy.judging.properties.margins import COUNTS
from understudy.judging.properties.thing_positions import OBSTACLE, ROBOT, name_things
from understudy.judging.raised_range import find_shown_goal
from understudy.model.library import Library
from understudy.model.property import GOAL, RAISED
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.sim.world import World


@dataclass(frozen=True, slots=True)
class ConditionExample:
    """A condition of one clause, and the heading under which it is listed."""

    heading: str
    text: str


def list_condition_examples(
    world: World, library: Library, flags: Collection[str], behavior: str = ""
) -> tuple[ConditionExample, ...]:
    """List a condition about each goal, flag, region, distance and reading that there is.

    Parameters
    ----------
    world
        The world.
    library
        The library of the robots in it, whose kit has the features.
    flags
        Names of the flags that the behavior can raise.
    behavior
        Name of the behavior. What its presses for a flag had in common comes first. Empty: nothing was shown.

    Returns
    -------
    tuple[ConditionExample, ...]
        The conditions, those with the same heading one after the other.
    """
    examples = [
        ConditionExample("As it was shown", f"{flag}{RAISED} and {shown_range.condition}")
        for flag in flags
        if (shown_range := find_shown_goal(library, behavior, flag)) is not None
    ]
    examples += [ConditionExample("Goal and flags", f"{flag}{RAISED}") for flag in flags]
    goal = world.scenario.goal
    if goal is not None:
        examples.append(ConditionExample("Goal and flags", GOAL))
        counts = [
            name
            for name, is_counted in zip(COUNTS, (goal.delivered, goal.gathered), strict=True)
            if is_counted
        ]
        examples += [
            ConditionExample("Goal and flags", f"{name} is at least 1 {COUNTS[name]}") for name in counts
        ]
    things = [name for name in name_things(world) if name != OBSTACLE or world.state.discs.shape[1]]
    if len(world.names.types) == 1:  # all robots are of it
        things = [name for name in things if name not in world.names.types or name == ROBOT]
    movable = [name for name in things if name != OBSTACLE]
    examples += [
        ConditionExample("Regions", f"{name} is in {region}")
        for region in world.scenario.regions
        for name in movable
    ]
    examples += [
        ConditionExample("Distances", f"distance({one}, {other}) is below 0.3 m")
        for one, other in combinations_with_replacement(things, 2)
        if one != OBSTACLE and (one != other or (one == ROBOT and world.agents > world.worlds))
    ]
    examples += [ConditionExample("Readings", text) for text in _list_readings(world, library)]
    return tuple(examples)


def _list_readings(world: World, library: Library) -> Iterator[str]:
    names: tuple[str, ...] = ()
    try:
        find_reading("", library, world, binding={}, where="the world")
    except UnknownName as error:
        names = error.known
    for name in names:
        for text in (name, *(f"{name}({target})" for target in world.targets)):
            with suppress(UnderstudyError):  # it needs a target, or takes none, or not this one
                yield _compare(text, find_reading(text, library, world, binding={}, where="the world"))


def _compare(text: str, reading: NamedReading) -> str:
    if isinstance(reading.kind, Categorical):
        return f"{text} is {reading.kind.labels[-1]}"
    if isinstance(reading.kind, Toroidal) and reading.unit == "rad":
        return f"{text} is between -30° and 30°"
    return f"{text} is below 1 {reading.unit}".rstrip()
