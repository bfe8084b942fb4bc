"""Three searches for a failing world, and the number of runs that each needs until it finds the first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from understudy.addons.checks.falsification.directed_search import (
    FIRST_SPREAD,
    RUNS_PER_START,
    DirectedSearch,
    run_vectors,
    search_directed,
)
from understudy.addons.checks.falsification.random_search import measure_seeds
from understudy.addons.checks.falsification.search_space import SearchSpace
from understudy.addons.checks.falsification.trial import Measure

RANDOM, CMA_ES, CROSS_ENTROPY = "random", "cma_es", "cross_entropy"
AT_ONCE = 100
"""The number of fresh worlds that run side by side."""
POPULATION, ELITE = 40, 4
"""The number of worlds in a generation of the cross-entropy method, and of those from which it learns."""
SMOOTHING = 0.7
"""The weight of the new mean and spread against the former ones (de Boer et al. 2005)."""


def search_by_cross_entropy(
    measure: Measure, space: SearchSpace, *, seed: int, most_runs: int
) -> DirectedSearch:
    """Search for a failing world by the cross-entropy method.

    All numbers of a vector are drawn from normal distributions, each independently. The mean and the spread of each
    then move towards those of the worlds that came nearest to failing. Like the directed search, it is restarted from
    time to time.

    Parameters
    ----------
    measure
        Runs the behavior.
    space
        The worlds.
    seed
        The seed of all draws; the same seed gives the same search.
    most_runs
        The largest number of runs.

    Returns
    -------
    DirectedSearch
        What was found until the end of the first generation with a failing world, or the last run.

    Notes
    -----
    The method is that of Rubinstein (1999), with the smoothing of de Boer, Kroese, Mannor and Rubinstein (A Tutorial on
    the Cross-Entropy Method, 2005).
    """
    rng, search = np.random.default_rng(seed), DirectedSearch()
    while True:
        mean, spread = np.full(len(space), 0.5), np.full(len(space), FIRST_SPREAD)
        begun = search.runs
        while search.runs < begun + RUNS_PER_START:
            drawn = rng.normal(mean, spread, (POPULATION, len(space)))
            vectors = np.clip(drawn, 0.0, np.nextafter(1.0, 0.0))[: most_runs - search.runs]
            robustness = run_vectors(measure, space, list(vectors), rng, search)
            if search.failures or search.runs >= most_runs:
                return search
            elite = vectors[np.argsort(robustness, kind="stable")[:ELITE]]
            mean += SMOOTHING * (elite.mean(axis=0) - mean)
            spread += SMOOTHING * (elite.std(axis=0) - spread)


CountedSearch: TypeAlias = Callable[..., int | None]
"""A function that counts the runs until a search finds a failing world; None if none of `most_runs` fails."""


def count_random_runs(measure: Measure, space: SearchSpace, *, seed: int, most_runs: int) -> int | None:
    """Count the fresh worlds, from that of `seed` on, until the first that fails."""
    for first in range(0, most_runs, AT_ONCE):
        seeds = range(seed + first, seed + min(first + AT_ONCE, most_runs))
        failed = np.flatnonzero(measure_seeds(measure, space.scenario, seeds) < 0)
        if len(failed):
            return first + int(failed[0]) + 1
    return None


def count_cma_es_runs(measure: Measure, space: SearchSpace, *, seed: int, most_runs: int) -> int | None:
    """Count the runs of the directed search, with no worlds to start from, in whole generations."""
    search = search_directed(measure, space, seed=seed, most_runs=most_runs)
    return search.runs if search.failures else None


def count_cross_entropy_runs(
    measure: Measure, space: SearchSpace, *, seed: int, most_runs: int
) -> int | None:
    """Count the runs of the cross-entropy method, in whole generations."""
    search = search_by_cross_entropy(measure, space, seed=seed, most_runs=most_runs)
    return search.runs if search.failures else None


METHODS: Mapping[str, CountedSearch] = MappingProxyType(
    {RANDOM: count_random_runs, CMA_ES: count_cma_es_runs, CROSS_ENTROPY: count_cross_entropy_runs}
)
"""The searches that are compared."""
