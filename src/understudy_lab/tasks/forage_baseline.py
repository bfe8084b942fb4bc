"""The baseline of the foraging scenario: the forager written by hand, with ample time."""

from __future__ import annotations

from collections.abc import Sequence

from understudy.analysis.evaluation import Baseline, Outcomes, measure_baseline
from understudy.sim.forage_settings import ForageSettings, settings_of
from understudy.sim.scenario.schema import Scenario
from understudy_lab.tasks.forage_expert import HandForager, lower_bound


def find_forage_baseline(scenario: Scenario) -> Baseline | None:
    """Make the baseline of a scenario that differs from the foraging scenario in numbers only; else None."""
    settings = settings_of(scenario)
    return None if settings is None else make_baseline(settings)


def make_baseline(settings: ForageSettings) -> Baseline:
    """Make the baseline of foraging worlds with these settings."""
    return Baseline(
        settings.scenario(),
        make_controller=lambda world: HandForager(world.agents, settings),
        limits_s=lambda world: 10.0 * lower_bound(world) + 60.0,
    )


def judge_expert(settings: ForageSettings, seeds: Sequence[int]) -> Outcomes:
    """Measure the forager written by hand on one world per seed."""
    return measure_baseline(make_baseline(settings), seeds)
