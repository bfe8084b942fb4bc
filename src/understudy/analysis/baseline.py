"""Controllers written by hand for a scenario, which behaviors are compared with; entry points find them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Protocol

from understudy.analysis.measurement import Progress, measure_outcomes, skip_progress
from understudy.analysis.outcomes import Outcomes
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

BASELINES = "understudy.baselines"
"""Entry points of this group are functions that take a scenario and return its `Baseline`, or None."""

LENIENCE = 3.0
"""The time limit of a taught robot, in multiples of the baseline's time."""


class Controller(Protocol):
    """The interface of a controller that decides for N robots at once; `keys` lists the readings that it needs."""

    keys: Sequence[ReadingKey]

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of this tick."""
        ...


@dataclass(frozen=True)
class Baseline:
    """A controller written by hand for a scenario.

    `make_controller` makes the controller for a world of this scenario.
    """

    scenario: Scenario
    make_controller: Callable[[World], Controller]
    limits_s: Callable[[World], Column]
    """A function that returns the time limit of the baseline in each world [B], in s, which should be ample."""


def find_baseline(scenario: Scenario) -> Baseline | None:
    """Return the baseline of a scenario from the installed entry points, or None if there is none."""
    found = (entry.load()(scenario) for entry in entry_points(group=BASELINES))
    return next((baseline for baseline in found if baseline is not None), None)


def measure_baseline(
    baseline: Baseline, seeds: Sequence[int], *, progress: Progress = skip_progress
) -> Outcomes:
    """Measure a baseline on one world per seed."""
    world = World(baseline.scenario, seeds)
    controller = baseline.make_controller(world)
    limits = baseline.limits_s(world)
    return measure_outcomes(world, controller.decide, controller.keys, limit_s=limits, progress=progress)
