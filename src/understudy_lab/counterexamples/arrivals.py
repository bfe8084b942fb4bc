"""Runs of GoTo in many worlds: whether the robot arrives, and when it went wrong where it does not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot
from types import MappingProxyType

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import LEAST_BADNESS, WORLDS_AT_ONCE, TrialResults
from understudy.judging.behavior_run import ProgramRun
from understudy.model.library import Library
from understudy.runtime.link import link
from understudy.sim.forage import make_practice_worlds
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy_lab.coaching_benefit.tasks import LIMIT_S, REACHED_M

BEHAVIOR = "goto"
TARGETS: Mapping[str, str] = MappingProxyType({"A": "station"})
SCENARIO: Scenario = make_practice_worlds()["an arena"].scenario()
"""The world in which GoTo is taught and tested in the experiment `coached`."""
RANGE = ("range", "station")
TICKS_AT_ONCE = 5
NEARER_M = 0.01
"""The least decrease of the distance that counts as progress, m."""


@dataclass(frozen=True, slots=True)
class ArrivalMeasure:
    """A measure of GoTo for searches: a run fails unless the robot is done in time and near the station.

    The robustness of a run that succeeds is the share of the limit that was left; otherwise it is minus the distance
    at which the robot said that it is done, or to which it came, as a share of the world's diagonal. A run went wrong
    when the robot said so, or where it came no nearer.
    """

    library: Library

    def __call__(self, trials: Sequence[Trial]) -> TrialResults:
        """Run GoTo in the given worlds of `SCENARIO`."""
        seeds = [trial.seed for trial in trials]
        parts = [
            self._run_together(seeds[first : first + WORLDS_AT_ONCE])
            for first in range(0, len(seeds), WORLDS_AT_ONCE)
        ]
        return TrialResults.concatenate(parts)

    def count_failures(self, seeds: Sequence[int]) -> int:
        """Return in how many worlds of these seeds the robot fails."""
        return int(self([Trial(SCENARIO, seed) for seed in seeds]).failed.sum())

    def _run_together(self, seeds: Sequence[int]) -> TrialResults:
        world = World(SCENARIO, seeds)
        program = link(self.library, BEHAVIOR, TARGETS)
        run = ProgramRun(world, program, self.library, TARGETS)
        least_m, progress_s = np.full(len(seeds), np.inf), np.zeros(len(seeds))
        distance_m = world.sense([RANGE])[RANGE]
        ticks = round(LIMIT_S / world.tick_s)
        for tick in range(0, ticks, TICKS_AT_ONCE):
            run.advance(min(TICKS_AT_ONCE, ticks - tick))
            distance_m = world.sense([RANGE])[RANGE]
            nearer = distance_m < least_m - NEARER_M
            least_m[nearer], progress_s[nearer] = distance_m[nearer], world.time_s
            if run.find_raised("done").all():
                break
        done_s = run.find_raised_s("done")[:, 0]  # a robot that is done stays where it is
        arrived = ~np.isnan(done_s) & (distance_m < REACHED_M)
        missed_m = np.where(np.isnan(done_s), least_m, distance_m)
        share = np.maximum(missed_m / hypot(*SCENARIO.size), LEAST_BADNESS)
        states = np.empty(len(seeds), np.object_)
        states[:] = [frozenset[str]()] * len(seeds)
        return TrialResults(
            robustness=np.where(arrived, (LIMIT_S - np.nan_to_num(done_s)) / LIMIT_S, -share),
            failed_s=np.where(arrived, np.nan, LIMIT_S),
            progress_s=np.where(np.isnan(done_s), progress_s, done_s),
            last_states=states,
        )
