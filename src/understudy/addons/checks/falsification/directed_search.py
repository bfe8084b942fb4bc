"""Directed search: CMA-ES moves worlds towards those in which a behavior nearly fails (extra `falsify`).

CMA-ES is the evolution strategy with covariance matrix adaptation of Hansen (The CMA Evolution Strategy: A Tutorial,
2016), from the package cma. It is restarted from time to time, because near a world that does not fail, there is often
none that does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain, count
from math import nan
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.search_space import SearchSpace
from understudy.addons.checks.falsification.trial import Measure
from understudy.clock import REAL_TIME
from understudy.errors import SettingError
from understudy.extras import import_cma
from understudy.model.value_kinds import Column

FIRST_SPREAD = 0.3
"""The standard deviation of all numbers of a vector in the first worlds after a start."""

RUNS_PER_START = 300
"""The number of runs after which the search is restarted."""


@dataclass
class DirectedSearch:
    """The results of a directed search so far: the failing trials with their robustness, in order."""

    runs: int = 0
    failures: list[tuple[float, Trial]] = field(default_factory=list)
    nearest: float = np.inf
    """The least robustness so far."""
    interrupted: bool = False


def search_directed(
    measure: Measure,
    space: SearchSpace,
    *,
    seed: int,
    start: Sequence[Column] = (),
    most_runs: int | None = None,
    seconds: float | None = None,
    most_failures: int = 1,
    progress: Callable[[DirectedSearch], None] = lambda search: None,
    clock: Callable[[], float] = REAL_TIME,
) -> DirectedSearch:
    """Search for failing worlds near those that came nearest to failing, until enough, the time, or Ctrl-C.

    Parameters
    ----------
    measure
        Runs the behavior.
    space
        The worlds.
    seed
        The seed of all draws; the same seed gives the same search.
    start
        Vectors [d] to start from in turn, such as those of the worst worlds of a search at random; then random ones.
    most_runs
        The largest number of runs. None: until the time is over.
    seconds
        The time, s. None: until all runs are done.
    most_failures
        The number of failing worlds after which the search ends.
    progress
        Called after each generation with what was found so far.
    clock
        What tells the time, s.

    Returns
    -------
    DirectedSearch
        What was found, also if it was interrupted.

    Raises
    ------
    ExtraMissing
        If the package cma is not installed.
    """
    import_cma()
    rng, search = np.random.default_rng(seed), DirectedSearch()
    end = None if seconds is None else clock() + seconds

    def is_over() -> bool:
        is_late = end is not None and clock() >= end
        return is_late or len(search.failures) >= most_failures or search.runs == most_runs

    try:
        for first in chain(start, (rng.random(len(space)) for _ in count())):
            strategy = _start_strategy(first, rng)
            begun = search.runs
            while search.runs < begun + RUNS_PER_START and not strategy.stop():
                vectors = strategy.ask()
                some = vectors if most_runs is None else vectors[: most_runs - search.runs]
                robustness = run_vectors(measure, space, some, rng, search)
                progress(search)
                if is_over():
                    return search
                strategy.tell(vectors, robustness)
    except KeyboardInterrupt:
        search.interrupted = True
    return search


def _start_strategy(first: Column, rng: np.random.Generator) -> Any:
    """Start CMA-ES at a vector, with draws of its own instead of NumPy's global ones."""
    cma = import_cma()
    settings = {
        "bounds": [0.0, float(np.nextafter(1.0, 0.0))],
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": nan,
        "verbose": -9,
    }
    with catch_warnings():
        simplefilter("ignore")
        return cma.CMAEvolutionStrategy(first, FIRST_SPREAD, settings)


def run_vectors(
    measure: Measure,
    space: SearchSpace,
    vectors: Sequence[Column],
    rng: np.random.Generator,
    search: DirectedSearch,
) -> list[float]:
    """Run the worlds of some vectors, and add the runs and the failing worlds to the results of a search.

    Parameters
    ----------
    measure
        Runs the behavior.
    space
        The worlds.
    vectors
        The vectors [d], in [0, 1).
    rng
        Draws the seeds, which decide about what the vectors do not vary.
    search
        The results of the search so far, which are changed.

    Returns
    -------
    list[float]
        The robustness in the world of each vector; 1 where things found no place.
    """
    trials, rows = list[Trial](), list[int]()
    for row, vector in enumerate(vectors):
        with suppress(SettingError):
            trials.append(Trial(space.decode(np.asarray(vector)), int(rng.integers(2**31))))
            rows.append(row)
    search.runs += len(vectors)
    robustness = [1.0] * len(vectors)
    results = measure(trials).robustness.tolist() if trials else []
    for row, trial, each in zip(rows, trials, results, strict=True):
        robustness[row] = each
        search.nearest = min(search.nearest, each)
        if each < 0:
            search.failures.append((each, trial))
    return robustness
