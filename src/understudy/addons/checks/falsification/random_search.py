"""Search at random: runs in worlds that fresh seeds lay out, and an exact interval of the share that fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf
from typing import TypeAlias

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.trial import WORLDS_AT_ONCE, Measure
from understudy.clock import REAL_TIME
from understudy.judging.intervals import exact_interval_of_share
from understudy.judging.process_pool import LOADING_S, share_calls
from understudy.model.value_kinds import Column
from understudy.sim.scenario.schema import Scenario

KEPT = 64
"""The number of worlds nearest to failing, and of failing ones, that are kept."""

FIRST_BATCH = 20
"""The number of worlds in the first batch, so that a result is there soon."""

BATCH_S = 5.0
"""The time that a later batch takes at most, as far as that of former ones tells, s."""

GROWTH = 10
"""The factor by which a batch is larger than those before at most."""

SeedMeasure: TypeAlias = Callable[[Sequence[int]], Column]
"""A function that runs a behavior in the worlds of some seeds and returns the robustness of each [n]."""


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

    def add(self, seeds: Sequence[int], values: Column) -> None:
        """Add the robustness of some worlds [n]."""
        failed = values < 0
        self.runs += len(seeds)
        self.failed += int(failed.sum())
        for chosen, listed in ((failed, self.failures), (~failed, self.nearest)):
            rows = np.flatnonzero(chosen)
            worst = rows[np.argsort(values[rows], kind="stable")][:KEPT].tolist()
            listed += [(float(values[row]), int(seeds[row])) for row in worst]
            listed.sort()
            del listed[KEPT:]


def measure_seeds(measure: Measure, scenario: Scenario, seeds: Sequence[int]) -> Column:
    """Run a behavior in the worlds of a scenario that these seeds lay out; return the robustness of each."""
    return measure([Trial(scenario, seed) for seed in seeds]).robustness


def search_at_random(
    measure: SeedMeasure,
    *,
    first_seed: int,
    most_runs: int | None = None,
    seconds: float | None = None,
    jobs: int = 1,
    first_batch: int = FIRST_BATCH,
    progress: Callable[[RandomSearch], None] = lambda search: None,
    clock: Callable[[], float] = REAL_TIME,
) -> RandomSearch:
    """Run a behavior in worlds of fresh seeds until a number of runs or a time is reached, or Ctrl-C.

    Parameters
    ----------
    measure
        Runs the behavior, such as `measure_seeds` in a scenario. With several jobs it must be possible to send it to
        another process.
    first_seed
        The seed of the first world; the others follow.
    most_runs
        The number of worlds. None: until the time is over.
    seconds
        The time, s. None: until all worlds were run.
    jobs
        The largest number of processes; there are never more than cores, and none for what takes a short time.
    first_batch
        The number of worlds after which the time that they take is known.
    progress
        Called after each batch with what was found so far.
    clock
        What tells the time, s.

    Returns
    -------
    RandomSearch
        What was found, also if it was interrupted.
    """
    search = RandomSearch()
    end = None if seconds is None else clock() + seconds
    batches = SeedBatches(first_seed, most_runs, end=end, first_batch=first_batch, clock=clock)
    try:
        calls = _list_calls(measure, batches, None if jobs > 1 else clock)
        for _, batch in share_calls(calls, jobs=jobs, estimate_left_s=batches.estimate_left_s):
            seeds, values, took_s = batch.result()
            batches.note(len(seeds), took_s)
            search.add(seeds, values)
            progress(search)
    except KeyboardInterrupt:
        search.interrupted = True
    return search


class SeedBatches:
    """Seeds in batches whose size fits the time that worlds take; the seeds do not depend on it.

    Parameters
    ----------
    first_seed
        The first seed; the others follow.
    most_runs
        The number of seeds. None: without end.
    end
        The time of `clock` after which there are no more, s. None: never.
    first_batch
        The number of seeds in the first batch.
    clock
        What tells the time, s.
    """

    def __init__(
        self,
        first_seed: int,
        most_runs: int | None,
        *,
        end: float | None,
        first_batch: int = FIRST_BATCH,
        clock: Callable[[], float] = REAL_TIME,
    ) -> None:
        self._begun = self._next = first_seed
        self._end, self._clock = end, clock
        self._stop = None if most_runs is None else first_seed + most_runs
        self._size = first_batch
        self._world_s: float | None = None

    def take(self) -> range:
        """Return the next batch, an empty one if there is none."""
        if self._end is not None and self._clock() >= self._end:
            return range(0)
        stop = self._next + self._size
        seeds = range(self._next, stop if self._stop is None else min(stop, self._stop))
        self._begun, self._next = self._next, seeds.stop
        return seeds

    def note(self, worlds: int, seconds: float) -> None:
        """Take note that a batch of so many worlds took a time, s."""
        left_s = BATCH_S if self._end is None else min(BATCH_S, max(0.0, self._end - self._clock()))
        loading_s = LOADING_S if self._world_s is None else 0.0
        self._world_s = max(0.0, seconds - loading_s) / max(1, worlds)
        fitting = int(left_s * worlds / max(seconds, 1e-9))
        self._size = max(1, min(fitting, GROWTH * worlds, WORLDS_AT_ONCE))

    def estimate_left_s(self) -> float:
        """Estimate how long the batch that was taken last and those after it take in one process, s; 0 before any."""
        if self._world_s is None:
            return 0.0
        left_s = inf if self._end is None else max(0.0, self._end - self._clock())
        if self._stop is None:
            return left_s
        return min(left_s, self._world_s * (self._stop - self._begun))


def _list_calls(
    measure: SeedMeasure, batches: SeedBatches, clock: Callable[[], float] | None
) -> Iterator[Callable[[], tuple[range, Column, float]]]:
    """Yield the runs of all batches; those that have begun are waited for when the time is over."""
    while seeds := batches.take():
        yield partial(_run_seeds, measure, seeds, clock or REAL_TIME)


def _run_seeds(measure: SeedMeasure, seeds: range, clock: Callable[[], float]) -> tuple[range, Column, float]:
    """Run a behavior in the worlds of these seeds; return them, the robustness of each, and the time it took, s."""
    began_s = clock()
    values = measure(seeds)
    return seeds, values, clock() - began_s
