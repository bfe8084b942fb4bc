"""Falsification: a search at random, then a directed one, and the failing world made as simple as possible."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from understudy.addons.checks.falsification.directed_search import DirectedSearch, search_directed
from understudy.addons.checks.falsification.failing_world import (
    FailingWorld,
    FailureFacts,
    write_failing_world,
)
from understudy.addons.checks.falsification.failure_replay import compute_end_hash, replay_failure
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.random_search import RandomSearch, measure_seeds, search_at_random
from understudy.addons.checks.falsification.search_space import ASPECTS, SearchSpace
from understudy.addons.checks.falsification.shrink import Shrinking, shrink_failure
from understudy.addons.checks.falsification.simpler_worlds import strip_for_file
from understudy.addons.checks.falsification.trial import TrialMeasure
from understudy.clock import REAL_TIME
from understudy.errors import SettingError
from understudy.extras import ExtraMissing, import_cma
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World

AT_RANDOM, DIRECTED = "random", "directed"

FIRST_SEED = 1_000_000_000
"""The first seed of the worlds of search 0, and the number of seeds that each search has; lessons use lower seeds."""

RANDOM_SHARE = 0.5
"""The share of the time for the search at random."""

STARTS = 8
"""The number of worlds, the closest to failing, from which the directed search starts."""

Report: TypeAlias = Callable[[str, int, int], None]
"""A function that is called with what is done, and the numbers of runs and of failures so far."""


def skip_report(doing: str, runs: int, failed: int) -> None:
    """Ignore a report."""


@dataclass
class Falsification:
    """The result of a falsification.

    `directed` is None if the search at random found a failing world already, or nothing can be varied. `shrinking` is
    None if no world failed.
    """

    random: RandomSearch
    directed: DirectedSearch | None = None
    found_by: str | None = None
    shrinking: Shrinking | None = None
    interrupted: bool = False
    seconds: float = 0.0
    notes: list[str] = field(default_factory=list)


def falsify(
    measure: TrialMeasure,
    scenario: Scenario,
    *,
    seed: int = 0,
    seconds: float = 60.0,
    worlds: int | None = None,
    jobs: int = 1,
    vary: Collection[str] = ASPECTS,
    report: Report = skip_report,
    clock: Callable[[], float] = REAL_TIME,
) -> Falsification:
    """Search for a world of a scenario in which a behavior fails, and make it as simple as possible.

    Half of the time goes to fresh worlds at random, all of which are run, so that the share that fails has an exact
    interval. If none failed, the rest goes to a directed search.

    Parameters
    ----------
    measure
        Runs the behavior.
    scenario
        The scenario.
    seed
        The seed of the search.
    seconds
        The time for both searches, and as much again to make the world simpler, s.
    worlds
        The number of worlds to run at random, however long it takes, as for making one simpler. None: half of the time.
    jobs
        The number of processes for the search at random.
    vary
        What the directed search varies, of `ASPECTS`.
    report
        Called with the progress.
    clock
        What tells the time, s.

    Returns
    -------
    Falsification
        What was found, also if it was interrupted.
    """
    began_s = clock()
    random = search_at_random(
        partial(measure_seeds, measure, scenario),
        first_seed=FIRST_SEED * (seed + 1),
        most_runs=worlds,
        seconds=None if worlds is not None else RANDOM_SHARE * seconds,
        jobs=jobs,
        progress=lambda search: report("Worlds at random", search.runs, search.failed),
        clock=clock,
    )
    falsification = Falsification(random, interrupted=random.interrupted)
    trial = Trial(scenario, random.failures[0][1]) if random.failures else None
    if trial is not None:
        falsification.found_by = AT_RANDOM
    elif not falsification.interrupted:
        trial = _search_directed(
            measure,
            scenario,
            falsification,
            seed=seed,
            seconds=seconds,
            vary=vary,
            report=report,
            clock=clock,
        )
    if trial is not None:
        if falsification.interrupted:
            falsification.shrinking = Shrinking(trial, measure([trial]), 1)
        else:
            falsification.shrinking = shrink_failure(
                measure,
                scenario,
                trial,
                seconds=None if worlds is not None else seconds,
                progress=lambda now: report("Making it simpler", now.runs, 1),
                clock=clock,
            )
            falsification.interrupted = falsification.shrinking.interrupted
    falsification.seconds = clock() - began_s
    return falsification


def _search_directed(
    measure: TrialMeasure,
    scenario: Scenario,
    falsification: Falsification,
    *,
    seed: int,
    seconds: float,
    vary: Collection[str],
    report: Report,
    clock: Callable[[], float],
) -> Trial | None:
    """Search from the worlds that came closest to failing; return the first failing one, None if there is none."""
    try:
        space = SearchSpace(scenario, vary)
        import_cma()
    except (SettingError, ExtraMissing) as error:
        falsification.notes.append(str(error))
        return None
    rng = np.random.default_rng(seed)
    nearest = [world for _, world in falsification.random.nearest[:STARTS]]
    start = [space.encode(World(scenario, [world]).view(), rng) for world in nearest]
    falsification.directed = search_directed(
        measure,
        space,
        seed=seed,
        start=start,
        seconds=(1.0 - RANDOM_SHARE) * seconds,
        progress=lambda now: report("Directed search", now.runs, len(now.failures)),
        clock=clock,
    )
    falsification.interrupted = falsification.directed.interrupted
    if not falsification.directed.failures:
        return None
    falsification.found_by = DIRECTED
    return falsification.directed.failures[0][1]


def keep_failure(
    folder: Path | str,
    shrinking: Shrinking,
    measure: TrialMeasure,
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
    *,
    about: str,
    command: str,
    found_by: str = AT_RANDOM,
) -> FailingWorld:
    """Explain a failing world, and write it to a new folder.

    Parameters
    ----------
    folder
        A folder that does not exist. FileError if it cannot be written.
    shrinking
        The world, as simple as it was made.
    measure
        Runs the behavior.
    libraries
        The library of each sort of agents.
    roots
        What each sort of agents runs by itself: the same behavior with the same targets.
    about
        What the file of the scenario says about it.
    command
        The command that runs it again.
    found_by
        The search that found it.

    Returns
    -------
    FailingWorld
        The failing world.
    """
    behavior, binding = next(iter(roots.values()))
    scenario = shrinking.trial.scenario
    trial = Trial(strip_for_file(scenario, name=scenario.name, about=about), shrinking.trial.seed)
    replay = replay_failure(measure, trial, libraries, roots, progress_s=shrinking.progress_s)
    facts = FailureFacts(
        behavior=behavior,
        binding=dict(binding),
        seed=trial.seed,
        limit_s=measure.get_limit(trial.scenario),
        robustness=float(shrinking.results.robustness[0]),
        wrong_s=replay.wrong_s,
        end_hash=compute_end_hash(measure, trial),
        robot=replay.robot,
        property=measure.name_in_file,
        place=replay.place,
        states=replay.states,
        found_by=found_by,
        steps=tuple(shrinking.steps),
        why=replay.sentences,
    )
    return write_failing_world(folder, trial, facts, replay, command=command)
