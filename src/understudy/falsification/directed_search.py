"""Directed search: an evolution strategy that varies worlds towards those in which a behavior nearly fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from time import monotonic

import numpy as np

from understudy.errors import SettingError
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.search_space import SearchSpace
from understudy.falsification.trial import Measure
from understudy.model.kinds import Column

PARENTS, CHILDREN = 8, 8
"""The number of worlds from which new ones are made, and of new ones that are run side by side."""

STEPS = (0.3, 0.1, 0.03, 0.01, 0.003)
"""The sizes of mutations, one of which is drawn for each new world."""

FRESH = 0.2
"""The share of new worlds that are drawn at random."""

CROSSED = 0.3
"""The share of the other new worlds that take some of their numbers from a second parent."""


@dataclass
class DirectedSearch:
    """What a directed search has found so far: the failing trials with their robustness, in order."""

    runs: int = 0
    failures: list[tuple[float, Trial]] = field(default_factory=list)
    nearest: float = np.inf
    """The least robustness so far."""
    interrupted: bool = False


@dataclass
class _Individual:
    vector: Column
    closeness: float


def search_directed(
    measure: Measure,
    space: SearchSpace,
    *,
    seed: int,
    start: Sequence[Column] = (),
    most_runs: int | None = None,
    seconds: float | None = None,
    most_failures: int = 1,
    progress: Callable[[DirectedSearch], None] = lambda found: None,
) -> DirectedSearch:
    """Search for failing worlds by varying those that came nearest to failing, until enough, the time, or Ctrl-C.

    Parameters
    ----------
    measure
        Runs the behavior.
    space
        The worlds.
    seed
        The seed of all draws; the same seed gives the same search.
    start
        Vectors [d] to begin with, such as those of the worst worlds of a search at random.
    most_runs
        The largest number of runs. None: until the time is over.
    seconds
        The time, s. None: until all runs are done.
    most_failures
        The number of failing worlds after which the search ends.
    progress
        Called after each generation with what was found so far.

    Returns
    -------
    DirectedSearch
        What was found, also if it was interrupted.
    """
    rng, found = np.random.default_rng(seed), DirectedSearch()
    end = None if seconds is None else monotonic() + seconds
    parents: list[_Individual] = []
    vectors = [*start] or [rng.random(len(space)) for _ in range(CHILDREN)]
    try:
        while True:
            if most_runs is not None:
                vectors = vectors[: most_runs - found.runs]
            made = _run_vectors(measure, space, vectors, rng, found)
            parents = sorted([*parents, *made], key=lambda each: each.closeness)[:PARENTS]
            progress(found)
            is_over = end is not None and monotonic() >= end
            if is_over or len(found.failures) >= most_failures or found.runs == most_runs:
                return found
            vectors = [_make_child(parents, rng, len(space)) for _ in range(CHILDREN)]
    except KeyboardInterrupt:
        found.interrupted = True
    return found


def _run_vectors(
    measure: Measure,
    space: SearchSpace,
    vectors: Sequence[Column],
    rng: np.random.Generator,
    found: DirectedSearch,
) -> list[_Individual]:
    """Run the worlds of some vectors; leave out those in which things find no place."""
    trials, known = list[Trial](), list[Column]()
    for vector in vectors:
        try:
            trials.append(Trial(space.decode(vector), int(rng.integers(2**31))))
        except SettingError:
            continue
        known.append(vector)
    found.runs += len(vectors)
    if not trials:
        return []
    results = measure(trials)
    for trial, robustness in zip(trials, results.robustness.tolist(), strict=True):
        found.nearest = min(found.nearest, robustness)
        if robustness < 0:
            found.failures.append((robustness, trial))
    closeness = results.closeness.tolist()
    return [_Individual(vector, close) for vector, close in zip(known, closeness, strict=True)]


def _make_child(parents: Sequence[_Individual], rng: np.random.Generator, size: int) -> Column:
    """Return a new vector: a mutation of one of the parents, sometimes crossed with another, or a random one."""
    if not parents or rng.random() < FRESH:
        return rng.random(size)
    first, second = (parents[int(rng.integers(len(parents)) * rng.random())] for _ in range(2))
    vector = first.vector.copy()
    if rng.random() < CROSSED:
        taken = rng.random(size) < 0.5
        vector[taken] = second.vector[taken]
    moved = rng.random(size) < max(0.25, 2.0 / size)
    moved[rng.integers(size)] = True
    vector[moved] += STEPS[int(rng.integers(len(STEPS)))] * rng.standard_normal(int(moved.sum()))
    reflected: Column = 1.0 - np.abs(1.0 - np.abs(vector) % 2.0)
    return np.clip(reflected, 0.0, np.nextafter(1.0, 0.0))
