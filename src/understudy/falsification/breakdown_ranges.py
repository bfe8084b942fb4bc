"""Robots that fail, as far as a scenario leaves to chance how many and when, as numbers that a search can vary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from understudy.sim.params import count_robots, get_count_range
from understudy.sim.scenario.schema import Breakdown, Scenario
from understudy.sim.view import WorldView

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
    groups = [list(robots.fails) for robots in scenario.robots]
    for each, share in shares.items():
        chosen = each.choose(share)
        breakdown = groups[each.group][each.index]
        groups[each.group][each.index] = (
            replace(breakdown, at_s=chosen) if each.is_time else replace(breakdown, count=int(chosen))
        )
    return _replace_breakdowns(scenario, groups)


def list_fewer_breakdowns(scenario: Scenario) -> Iterator[tuple[str, Scenario]]:
    """Yield the scenario without any robot that fails, then without each, then with rounder times."""
    groups = [list(robots.fails) for robots in scenario.robots]
    if not any(groups):
        return
    yield "no robot fails", _replace_breakdowns(scenario, [[] for _ in groups])
    for group, breakdowns in enumerate(groups):
        for index, breakdown in enumerate(breakdowns):
            rest = [*breakdowns[:index], *breakdowns[index + 1 :]]
            yield (
                "a robot less fails",
                _replace_breakdowns(scenario, [*groups[:group], rest, *groups[group + 1 :]]),
            )
            for robot in breakdown.robots or ():
                others = tuple(each for each in breakdown.robots or () if each != robot)
                if others:
                    yield (
                        "a robot less fails",
                        _replace_breakdown(scenario, group, index, replace(breakdown, robots=others)),
                    )
    for group, breakdowns in enumerate(groups):
        for index, breakdown in enumerate(breakdowns):
            if isinstance(breakdown.at_s, tuple):
                continue
            for step in TIMES_S:
                rounder = round(round(breakdown.at_s / step) * step, 3)
                if not (breakdown.at_s / step).is_integer():
                    yield (
                        f"a robot fails at {rounder:g} s",
                        _replace_breakdown(scenario, group, index, replace(breakdown, at_s=rounder)),
                    )


def _replace_breakdown(scenario: Scenario, group: int, index: int, breakdown: Breakdown) -> Scenario:
    groups = [list(robots.fails) for robots in scenario.robots]
    groups[group][index] = breakdown
    return _replace_breakdowns(scenario, groups)


def _replace_breakdowns(scenario: Scenario, groups: list[list[Breakdown]]) -> Scenario:
    robots = tuple(
        replace(each, fails=tuple(fails)) for each, fails in zip(scenario.robots, groups, strict=True)
    )
    return replace(scenario, robots=robots)
