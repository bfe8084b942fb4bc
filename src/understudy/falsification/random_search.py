"""Search at random: runs in worlds that fresh seeds lay out, and an exact interval of the share that fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from time import monotonic

import numpy as np

from understudy.analysis.intervals import exact_interval_of_share
from understudy.analysis.process_pool import open_process_pool
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.trial import WORLDS_AT_ONCE, Measure, TrialResults
from understudy.sim.scenario.schema import Scenario

KEPT = 64
"""The number of worlds nearest to failing, and of failing ones, that are kept."""

FIRST_BATCH = 100
"""The number of worlds in the first batch, so that a result is there soon."""


@dataclass
class RandomSearch:
    """The results of a search at random so far.

    `failures` has seeds with their robustness, the worst first; `nearest` those of runs that came closest to failing.
    """

    runs: int = 0
    failed: int = 0
    failures: list[tuple[float, int]] = field(default_factory=list)
    nearest: list[tuple[float, int]] = field(default_factory=list)
    interrupted: bool = False

    @property
    def interval(self) -> tuple[float, float]:
        """The exact 95 % interval of the share of worlds that fail (Clopper and Pearson)."""
        return exact_interval_of_share(self.failed, self.runs) if self.runs else (0.0, 1.0)

    def add(self, seeds: Sequence[int], results: TrialResults) -> None:
        """Add the results of some worlds."""
        failed = results.failed
        self.runs += len(seeds)
        self.failed += int(failed.sum())
        values = results.robustness
        for chosen, kept in ((failed, self.failures), (~failed, self.nearest)):
            rows = np.flatnonzero(chosen)
            worst = rows[np.argsort(values[rows], kind="stable")][:KEPT].tolist()
            kept += [(float(values[row]), int(seeds[row])) for row in worst]
            kept.sort()
            del kept[KEPT:]


def search_at_random(
    measure: Measure,
    scenario: Scenario,
    *,
    first_seed: int,
    most_runs: int | None = None,
    seconds: float | None = None,
    jobs: int = 1,
    progress: Callable[[RandomSearch], None] = lambda found: None,
) -> RandomSearch:
    """Run a behavior in worlds of fresh seeds until a number of runs or a time is reached, or Ctrl-C.

    Parameters
    ----------
    measure
        Runs the behavior. With several jobs it must be possible to send it to another process.
    scenario
        The scenario.
    first_seed
        The seed of the first world; the others follow.
    most_runs
        The number of worlds. None: until the time is over.
    seconds
        The time, s. None: until all worlds were run.
    jobs
        The number of processes.
    progress
        Called after each batch with what was found so far.

    Returns
    -------
    RandomSearch
        What was found, also if it was interrupted.
    """
    found = RandomSearch()
    end = None if seconds is None else monotonic() + seconds
    batches = _list_batches(first_seed, most_runs)
    try:
        if jobs == 1:
            for seeds in batches:
                found.add(seeds, run_seeds(measure, scenario, seeds))
                progress(found)
                if end is not None and monotonic() >= end:
                    break
        else:
            _search_in_jobs(measure, scenario, batches, found, end=end, jobs=jobs, progress=progress)
    except KeyboardInterrupt:
        found.interrupted = True
    return found


def run_seeds(measure: Measure, scenario: Scenario, seeds: Sequence[int]) -> TrialResults:
    """Run a behavior in the worlds of these seeds."""
    return measure([Trial(scenario, seed) for seed in seeds])


def _list_batches(first_seed: int, most_runs: int | None) -> Iterator[range]:
    at, size = first_seed, FIRST_BATCH
    while most_runs is None or at < first_seed + most_runs:
        stop = at + size if most_runs is None else min(at + size, first_seed + most_runs)
        yield range(at, stop)
        at, size = stop, WORLDS_AT_ONCE


def _search_in_jobs(
    measure: Measure,
    scenario: Scenario,
    batches: Iterator[range],
    found: RandomSearch,
    *,
    end: float | None,
    jobs: int,
    progress: Callable[[RandomSearch], None],
) -> None:
    """Share the batches among processes; those that have begun are waited for when the time is over."""
    with open_process_pool(jobs) as pool:
        begun: dict[Future[TrialResults], range] = {}
        while True:
            while len(begun) < jobs + 1 and (end is None or monotonic() < end):
                seeds = next(batches, None)
                if seeds is None:
                    break
                begun[pool.submit(run_seeds, measure, scenario, seeds)] = seeds
            if not begun:
                return
            done, _ = wait(begun, return_when=FIRST_COMPLETED)
            for future in done:
                found.add(begun.pop(future), future.result())
                progress(found)
