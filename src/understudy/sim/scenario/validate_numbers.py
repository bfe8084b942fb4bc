"""Check the numbers in a scenario: sign, size and order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from math import isfinite
from typing import Any

import msgspec

from understudy.sim.scenario.scenario_errors import (
    AT_LEAST_1,
    CHANCE,
    GENERATOR,
    NOT_NEGATIVE,
    POSITIVE,
    SPARE,
    THINGS,
    TICK,
    Limit,
    ScenarioErrors,
)
from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    ArenaRegion,
    Breakdown,
    CaptureRule,
    Goal,
    ObjectClass,
    Obstacle,
    Placement,
    PullRule,
    RandomWalk,
    RobotGroup,
    RobotType,
    Scenario,
    SensorBase,
    TargetSpec,
)
from understudy.sim.scenario.skill_schema import SkillStandIn
from understudy.sim.scenario.squad_schema import (
    AssignmentSpec,
    CommsSpec,
    RoleSpec,
    SquadSpec,
    StatisticSpec,
    StrictStruct,
)
from understudy.sim.sensing.sensor_table import SENSORS

MOST = 1e9
"""The largest valid number; larger ones are mistakes, or lose precision."""


LIMITS: Mapping[type[StrictStruct], Mapping[str, Limit]] = {
    Scenario: {
        "size": POSITIVE,
        "tick_s": TICK,
        "limit_s": POSITIVE,
        "spare_objects": SPARE,
        "generator": GENERATOR,
    },
    ArenaRegion: {"radius": POSITIVE},
    Placement: {"count": THINGS, "apart": NOT_NEGATIVE, "near_m": NOT_NEGATIVE},
    Obstacle: {"radius": POSITIVE, "height": POSITIVE},
    ObjectClass: {"radius": NOT_NEGATIVE, "height": POSITIVE, "amount": NOT_NEGATIVE, "pushers": AT_LEAST_1},
    AppearanceSchedule: {"away_s": NOT_NEGATIVE, "first_s": NOT_NEGATIVE, "stays_s": NOT_NEGATIVE},
    CaptureRule: {"range": POSITIVE, "after_s": NOT_NEGATIVE},
    PullRule: {"robots": AT_LEAST_1},
    RandomWalk: {"speed": POSITIVE, "turn_s": POSITIVE},
    RobotType: {
        "radius": POSITIVE,
        "speed": NOT_NEGATIVE,
        "turning_deg": NOT_NEGATIVE,
        "acceleration": POSITIVE,
        "turning_acceleration_deg": POSITIVE,
        "noise_drive": NOT_NEGATIVE,
        "noise_turn": NOT_NEGATIVE,
        "height": POSITIVE,
        "capacity": NOT_NEGATIVE,
        "reach": NOT_NEGATIVE,
        "load_s": POSITIVE,
        "unload_s": POSITIVE,
    },
    SkillStandIn: {
        "duration_s": POSITIVE,
        "success": CHANCE,
        "within": NOT_NEGATIVE,
        "timeout_s": POSITIVE,
    },
    RobotGroup: {"stored": NOT_NEGATIVE},
    Breakdown: {"at_s": NOT_NEGATIVE, "count": NOT_NEGATIVE, "robots": NOT_NEGATIVE},
    TargetSpec: {"index": NOT_NEGATIVE, "within": POSITIVE},
    Goal: {"within": POSITIVE, "gathered": NOT_NEGATIVE},
    SquadSpec: {"count": AT_LEAST_1},
    RoleSpec: {"least": NOT_NEGATIVE, "preferred": AT_LEAST_1, "most": AT_LEAST_1},
    StatisticSpec: {"within_s": POSITIVE, "for_s": POSITIVE},
    AssignmentSpec: {"share": AT_LEAST_1},
    CommsSpec: {"delay_s": NOT_NEGATIVE, "loss": CHANCE},
    SensorBase: {"dropout": CHANCE, "rate_hz": POSITIVE},
    **{row.spec: row.limits for row in SENSORS},
}
"""The limits of fields by class; a subclass inherits those of its base."""

RANGES = ("count", "amount", "away_s", "first_s", "stays_s", "duration_s", "at_s")
"""The fields that are (least, most) if they have two numbers."""


def check_numbers(checker: ScenarioErrors) -> None:
    """Raise SettingError if a number in a scenario is not valid."""
    for part, path in list_parts(checker.scenario):
        for name in part.__struct_fields__:
            value, key = getattr(part, name), f"{path}.{name}" if path else name
            for number, at in list_numbers(value, key):
                _check_number(checker, at, number, find_limit(type(part), name))
            if name in RANGES and isinstance(value, tuple) and value[0] > value[1]:
                checker.fail(key, f"is {list(value)}", "give the least first, then the most")
    _check_times(checker)


def list_parts(part: StrictStruct, path: str = "") -> Iterator[tuple[StrictStruct, str]]:
    """Yield every part of a scenario with its key path."""
    yield part, path
    for name in part.__struct_fields__:
        key = f"{path}.{name}" if path else name
        for value, at in _leaves(getattr(part, name), key):
            if isinstance(value, StrictStruct):
                yield from list_parts(value, at)


def list_numbers(value: Any, key: str) -> Iterator[tuple[float, str]]:
    """Yield every number in a field that is not a part, with its key path."""
    for leaf, at in _leaves(value, key):
        if isinstance(leaf, int | float) and not isinstance(leaf, bool):
            yield leaf, at


@cache
def find_limit(part: type, name: str) -> Limit | None:
    """Return the limit of a field, from the part's class or a base of it; None if it has none."""
    limits = (LIMITS.get(base, {}).get(name) for base in part.__mro__)
    return next((limit for limit in limits if limit is not None), None)


def _leaves(value: Any, key: str) -> Iterator[tuple[Any, str]]:
    if isinstance(value, Mapping):
        for name, inside in value.items():
            yield from _leaves(inside, f"{key}.{name}")
    elif isinstance(value, tuple | list):
        for index, inside in enumerate(value):
            yield from _leaves(inside, f"{key}[{index}]")
    elif not isinstance(value, msgspec.UnsetType):
        yield value, key


def _check_number(checker: ScenarioErrors, key: str, number: float, limit: Limit | None) -> None:
    if not isfinite(number) or abs(number) > MOST:
        remedy = f"give {limit.words}" if limit else "give a finite number"
        checker.fail(key, f"is {number}", f"{remedy}{', at most 1e9' * (abs(number) > MOST)}")
    if limit is not None and not limit.holds(number):
        checker.fail(key, f"is {number}", f"give {limit.words}")


def _check_times(checker: ScenarioErrors) -> None:
    """Raise SettingError if loading does not take whole ticks, or a robot turns half a circle in one tick."""
    tick_s = checker.scenario.tick_s
    for name, robot_type in checker.scenario.types.items():
        for key, seconds in (("load_s", robot_type.load_s), ("unload_s", robot_type.unload_s)):
            ticks = seconds / tick_s
            if robot_type.capacity > 0 and (round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-6):
                checker.fail(
                    f"types.{name}.{key}", f"is {seconds} s", f"give a multiple of tick_s, {tick_s} s"
                )
        if robot_type.turning_deg * tick_s >= 180:
            problem = f"is {robot_type.turning_deg}: half a circle or more in a tick of {tick_s} s"
            checker.fail(f"types.{name}.turning_deg", problem, "give less, or a shorter tick_s")
