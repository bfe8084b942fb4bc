"""Evaluation of a behavior in many worlds: success, time to finish, and food per second relative to a baseline.

A behavior that can raise the flag `done`, or a single other one, is finished when it raises it; any other when the
scenario's goal is reached.

A world that has a baseline has a time limit of three times the baseline's time; any other has the scenario's limit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from understudy.analysis.baseline import LENIENCE, find_baseline, measure_baseline
from understudy.analysis.evaluation import Evaluation
from understudy.analysis.measurement import Progress, measure_program_outcomes, measure_team_outcomes
from understudy.analysis.outcomes import Outcomes
from understudy.errors import SettingError
from understudy.model.binding import NOTHING_BOUND
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.program import Program, link
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, list_running_sorts, make_team
from understudy.sim.world import World

SUCCESS_FLAG, FAILURE_FLAG = "done", "failed"
"""The flags that a behavior raises when it has succeeded, and when it has given up."""

WORLDS_AT_ONCE = 5_000
"""The largest number of worlds that are simulated together, to bound memory."""


def evaluate(
    library: Library,
    behavior: str,
    world: Scenario | Path | str,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Evaluate a behavior of a library in one world per seed, in which all robots run it.

    A behavior that can raise the flag `done` succeeds if all robots raise it in time, any other if the scenario's
    goal is reached in time. If the goal counts and the scenario has a baseline, the limit is three times the
    baseline's time; otherwise it is the scenario's.

    Parameters
    ----------
    library
        The library.
    behavior
        Name of the basic behavior or automaton to evaluate.
    world
        The scenario, or its name or path.
    seeds
        Seeds of the worlds, at least one.
    binding
        Name of a target by parameter of the behavior.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the evaluation. None: no reports.

    Returns
    -------
    Evaluation
        The results by world, and those of the baseline if there is one.

    Raises
    ------
    SettingError
        If `seeds` is empty or no list, or neither a goal nor the flag `done` defines success.
    UnknownName
        If there is no such behavior or scenario.
    UnboundParameter
        If a parameter of the behavior is not bound to a target.
    FileError
        If `world` is the path of a file that cannot be read or is no scenario.
    """
    scenario = world if isinstance(world, Scenario) else find_scenario(world)
    seeds = _read_seeds(seeds)
    program = link_for_evaluation(library, behavior, scenario, binding)
    flag = find_success_flag(library, behavior)

    def measure(batch: Sequence[int], limits: float | Column, report: Progress) -> Outcomes:
        return measure_program_outcomes(
            World(scenario, batch), program, limit_s=limits, flag=flag, progress=report
        )

    return _evaluate(behavior, scenario, seeds, measure, flag=flag, progress=progress)


def evaluate_team(
    libraries: Libraries,
    sort: str,
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    progress: Progress | None = None,
) -> Evaluation:
    """Evaluate a behavior of coordinators, or of one of several types of robots, in one world per seed.

    Success is defined as in `evaluate`. An automaton is run by all agents of the given `sort`, a basic behavior by
    all robots that have it. Agents below a coordinator follow its orders.
    """
    seeds = _read_seeds(seeds)
    link_for_evaluation(libraries[sort], behavior, scenario, binding)
    flag = find_success_flag(libraries[sort], behavior)
    roots = dict.fromkeys(list_running_sorts(libraries, sort, behavior), (behavior, binding))

    def measure(batch: Sequence[int], limits: float | Column, report: Progress) -> Outcomes:
        team = make_team(scenario, batch, libraries, roots)
        return measure_team_outcomes(team, roots, limit_s=limits, flag=flag, progress=report)

    return _evaluate(behavior, scenario, seeds, measure, flag=flag, progress=progress)


def _read_seeds(seeds: Sequence[int]) -> list[int]:
    try:
        seeds = list(seeds)
    except TypeError:  # one number, say
        remedy = "give a list of whole numbers, one for each world: [5]"
        raise SettingError(
            where="evaluation", setting="seeds", problem=f"are {seeds!r:.60}", remedy=remedy
        ) from None
    if not seeds:
        raise SettingError(
            where="evaluation", setting="seeds", problem="are none", remedy="give at least one"
        )
    return seeds


def _evaluate(
    behavior: str,
    scenario: Scenario,
    seeds: Sequence[int],
    measure: Callable[[Sequence[int], float | Column, Progress], Outcomes],
    *,
    flag: str | None,
    progress: Progress | None,
) -> Evaluation:
    """Evaluate in batches of worlds with the function `measure`, and the baseline too if the goal counts as success."""
    baseline = find_baseline(scenario) if flag is None else None
    taught, expert = list[Outcomes](), list[Outcomes]()
    for first, batch in _batches(seeds):

        def report(through: int, _: int, first: int = first) -> None:
            if progress is not None:
                progress(first + through, len(seeds))

        limits: float | Column = scenario.limit_s
        if baseline is not None:
            by_hand = measure_baseline(baseline, batch, progress=lambda *_: report(0, 0))
            expert.append(by_hand)
            limits = LENIENCE * np.where(by_hand.finished, by_hand.seconds, by_hand.limit_s)
        taught.append(measure(batch, limits, report))
    joined = Outcomes.concatenate(expert) if expert else None
    return Evaluation(behavior, scenario.name, tuple(seeds), Outcomes.concatenate(taught), joined, flag)


def find_success_flag(library: Library, behavior: str) -> str | None:
    """Return the flag by which a behavior is judged: `done`, or else its only one besides `failed`.

    None if it has no such flag, and the scenario's goal counts.
    """
    found = library.taught.get(behavior)
    flags = set() if found is None else {*found.automaton.flags}
    goals = flags & {SUCCESS_FLAG} or flags - {FAILURE_FLAG}
    return goals.pop() if len(goals) == 1 else None


def link_for_evaluation(
    library: Library, behavior: str, scenario: Scenario, binding: Mapping[str, str] = NOTHING_BOUND
) -> Program:
    """Link the program that `evaluate` runs; refuse a behavior for whose success the scenario defines no goal."""
    if scenario.goal is None and find_success_flag(library, behavior) is None:
        raise SettingError(
            where=f"scenario {scenario.name!r}",
            setting="goal",
            problem="is missing, and a run cannot be evaluated without it",
            remedy="give it a [goal], or watch it with understudy run",
        )
    return link(library, behavior, binding)


def _batches(seeds: Sequence[int]) -> Iterator[tuple[int, list[int]]]:
    """Yield batches of seeds to simulate together, each with the number of seeds before it."""
    for first in range(0, len(seeds), WORLDS_AT_ONCE):
        yield first, list(seeds[first : first + WORLDS_AT_ONCE])
