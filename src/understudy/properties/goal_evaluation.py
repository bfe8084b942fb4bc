"""Evaluation of a behavior by the goal that a person has chosen for it, in many worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.evaluation import Evaluation
from understudy.analysis.rollout import WORLDS_AT_ONCE, Outcomes, Progress, skip_progress
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.properties.monitor import PropertyOutcomes, monitor_property
from understudy.properties.run_property import make_property_task
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries


def evaluate_goal(
    goal: Property,
    library: Library | Libraries,
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress = skip_progress,
) -> Evaluation:
    """Evaluate a behavior by a chosen goal in one world per seed.

    Parameters
    ----------
    goal
        The goal.
    library
        The library, whose behavior all robots run; or for a team the library of each sort of agents.
    behavior
        Name of the behavior.
    scenario
        The scenario.
    seeds
        Seeds of the worlds.
    binding
        Name of a target by parameter of the behavior.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the evaluation.

    Returns
    -------
    Evaluation
        The results. The time of a success is when the goal was reached, or how long it held.

    Raises
    ------
    UnderstudyError
        If the behavior cannot be run there, or the goal names something that the scenario or the behavior lacks.
    """
    subject = replace(goal, behavior=behavior, targets=Binding(dict(binding)))
    task = make_property_task(subject, library, scenario)
    done, counts = list[PropertyOutcomes](), list[tuple[NDArray[np.int64], NDArray[np.int64]]]()
    for first in range(0, len(seeds), WORLDS_AT_ONCE):

        def report(through: int, _: int, first: int = first) -> None:
            progress(first + through, len(seeds))

        run = task.make_run(scenario, seeds[first : first + WORLDS_AT_ONCE])
        done.append(monitor_property(subject, run, task.criteria.flags, progress=report))
        counts.append((run.get_world().delivered, run.get_world().gathered))
    found = PropertyOutcomes.concatenate(done)
    limit_s = goal.seconds if goal.is_timed else goal.start.limit_s
    limits = np.full(len(seeds), scenario.limit_s if limit_s is None else limit_s)
    took = np.where(np.isnan(found.reached_s), limits, found.reached_s)
    delivered, gathered = (np.concatenate([each[part] for each in counts]) for part in (0, 1))
    outcomes = Outcomes(np.where(found.held, took, np.nan), limits, delivered, gathered)
    return Evaluation(behavior, scenario.name, tuple(seeds), outcomes, None, goal=goal.name or goal.claim)
