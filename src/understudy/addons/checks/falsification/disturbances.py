"""The disturbances of a scenario that a search can vary: noise, dropout and losses, and robots that fail.

Noise, dropout and losses become stronger or weaker, within limits. Robots fail as far as the scenario leaves to chance
how many and when.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.sim.params import count_robots, get_count_range
from understudy.sim.scenario.schema import Breakdown, Scenario
from understudy.sim.scenario.validate_places import replace_placed
from understudy.sim.view import WorldView

FACTOR = 2.0
"""The strongest disturbance that is tried, in multiples of the scenario's."""

MOST_SHARE = 0.95
"""The largest probability that is tried: readings that are never there tell nothing."""

MOTION = ("noise_drive", "noise_turn")
PROBABILITIES = ("dropout", "misses", "ghosts")
NOISES = ("noise", "noise_x", "noise_size", "noise_range", "noise_deg")
RADIO = ("delay_s", "loss")


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A noise or probability of a scenario, from 0 to `most`.

    `type` and `sensor` say which type of robots and which of its sensors has it; None for the robot's motion, and for
    the radio.
    """

    type: str | None
    sensor: int | None
    field: str
    usual: float
    most: float

    @property
    def name(self) -> str:
        """The key of the disturbance in the scenario."""
        if self.type is None:
            return f"radio.{self.field}"
        return (
            f"types.{self.type}."
            + (f"sensors[{self.sensor}]." if self.sensor is not None else "")
            + self.field
        )

    @property
    def default(self) -> float:
        """The number from 0 to 1 that means what the scenario has."""
        return self.usual / self.most


def list_disturbances(scenario: Scenario) -> Iterator[Disturbance]:
    """Yield the disturbances that a scenario has; those that are 0 stay so."""
    for name, kind in scenario.types.items():
        for word in MOTION:
            yield from _find_disturbance(kind, name, None, word)
        for index, sensor in enumerate(kind.sensors):
            for word in (*NOISES, *PROBABILITIES):
                yield from _find_disturbance(sensor, name, index, word)
    for word in RADIO:
        yield from _find_disturbance(scenario.radio, None, None, word)


def _find_disturbance(part: Any, kind: str | None, sensor: int | None, word: str) -> Iterator[Disturbance]:
    usual = float(getattr(part, word, 0.0))
    if usual > 0.0:
        is_share = word in PROBABILITIES or word == "loss"
        most = max(usual, min(FACTOR * usual, MOST_SHARE)) if is_share else FACTOR * usual
        yield Disturbance(kind, sensor, word, usual, most)


def apply_disturbances(scenario: Scenario, strengths: Mapping[Disturbance, float]) -> Scenario:
    """Return a scenario with these disturbances, each at a strength from 0 to 1 of the most."""
    for disturbance, strength in strengths.items():
        value = {disturbance.field: disturbance.most * strength}
        if disturbance.type is None:
            scenario = replace(scenario, radio=replace(scenario.radio, **value))
            continue
        kind = scenario.types[disturbance.type]
        if disturbance.sensor is None:
            kind = replace(kind, **value)
        else:
            sensors = list(kind.sensors)
            sensors[disturbance.sensor] = replace(sensors[disturbance.sensor], **value)
            kind = replace(kind, sensors=tuple(sensors))
        scenario = replace(scenario, types={**scenario.types, disturbance.type: kind})
    return scenario


TIMES_S = (100.0, 10.0, 1.0)
"""The steps to which the times of failures are rounded, the coarsest first, s."""


@dataclass(frozen=True, slots=True)
class BreakdownRange:
    """A number of robots that fail, or the time when they do, that each world draws.

    It is the entry `index` of the key `fails` of the group of robots number `group`. `is_time` tells which of the two.
    """

    group: int
    index: int
    is_time: bool
    least: float
    most: float

    @property
    def name(self) -> str:
        """The key in the scenario."""
        return f"robots[{self.group}].fails[{self.index}].{'at_s' if self.is_time else 'count'}"

    def choose(self, share: float) -> float:
        """Return the number, or the time in s, at a share of the way from the least to the most."""
        if self.is_time:
            return round(self.least + share * (self.most - self.least), 3)
        return min(self.most, self.least + int(share * (self.most - self.least + 1)))

    def find_share(self, scenario: Scenario, view: WorldView) -> float:
        """Return the share at which a world is that begins like a view."""
        first = sum(count_robots(each.count, each.at) for each in scenario.robots[: self.group])
        group = scenario.robots[self.group]
        times = view.robots.fails_s[first : first + count_robots(group.count, group.at)]
        failing = times[~np.isnan(times)]
        if not self.is_time:
            return float(np.clip((len(failing) - self.least + 0.5) / (self.most - self.least + 1), 0.0, 1.0))
        if not len(failing):
            return 0.5
        return float(np.clip((failing.mean() - self.least) / (self.most - self.least), 0.0, 1.0))


def list_breakdown_ranges(scenario: Scenario) -> Iterator[BreakdownRange]:
    """Yield what worlds of a scenario draw of robots that fail."""
    for group, robots in enumerate(scenario.robots):
        for index, breakdown in enumerate(robots.fails):
            least, most = get_count_range(breakdown.count)
            if breakdown.robots is None and least < most:
                yield BreakdownRange(group, index, False, least, most)
            if isinstance(breakdown.at_s, tuple) and breakdown.at_s[0] < breakdown.at_s[1]:
                yield BreakdownRange(group, index, True, *breakdown.at_s)


def apply_breakdowns(scenario: Scenario, shares: Mapping[BreakdownRange, float]) -> Scenario:
    """Return a scenario in which these numbers and times are given, each at a share of the way in its range."""
    for each, share in shares.items():
        chosen, breakdown = each.choose(share), scenario.robots[each.group].fails[each.index]
        breakdown = replace(breakdown, **({"at_s": chosen} if each.is_time else {"count": int(chosen)}))
        scenario = _replace_breakdown(scenario, each.group, each.index, breakdown)
    return scenario


def list_fewer_breakdowns(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario without any robot that fails, then without each, then with rounder times."""
    breakdowns = [
        (group, index, breakdown)
        for group, robots in enumerate(scenario.robots)
        for index, breakdown in enumerate(robots.fails)
    ]
    if breakdowns:
        robots = tuple(replace(each, fails=()) for each in scenario.robots)
        yield "no robot fails", replace(scenario, robots=robots)
    for group, index, breakdown in breakdowns:
        yield "a robot less fails", _replace_breakdown(scenario, group, index)
        for robot in breakdown.robots or ():
            others = tuple(each for each in breakdown.robots or () if each != robot)
            if others:
                fewer = replace(breakdown, robots=others)
                yield "a robot less fails", _replace_breakdown(scenario, group, index, fewer)
    for group, index, breakdown in breakdowns:
        if isinstance(breakdown.at_s, tuple):
            continue
        for step in TIMES_S:
            rounder = round(round(breakdown.at_s / step) * step, 3)
            if not (breakdown.at_s / step).is_integer():
                changed = replace(breakdown, at_s=rounder)
                yield f"a robot fails at {rounder:g} s", _replace_breakdown(scenario, group, index, changed)


def _replace_breakdown(scenario: Scenario, group: int, index: int, *breakdowns: Breakdown) -> Scenario:
    """Return a scenario with one or no other breakdown at a place in the list of a group of robots."""
    robots = scenario.robots[group]
    fails = (*robots.fails[:index], *breakdowns, *robots.fails[index + 1 :])
    return replace_placed(scenario, f"robots[{group}]", replace(robots, fails=fails))
