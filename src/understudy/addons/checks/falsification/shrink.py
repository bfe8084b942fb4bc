"""Shrink a failing world: fewer things, less food, nearer to the usual, from shortly before the mistake, rounder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from understudy.addons.checks.falsification.disturbances import list_fewer_breakdowns
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.simpler_worlds import (
    list_earlier_starts,
    list_less_disturbed,
    list_rounder,
    list_smaller_amounts,
    list_without_objects,
    list_without_obstacles,
    list_without_robots,
    make_explicit,
)
from understudy.addons.checks.falsification.trial import TICKS_AT_ONCE, TrialMeasure, TrialResults
from understudy.clock import REAL_TIME
from understudy.errors import SettingError
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.validation import check_scenario

MOST_RUNS = 1_500
"""The largest number of runs that shrinking may take."""

FIRST_CANDIDATES = 4
"""The number of candidates that are run side by side first; then twice as many each time."""

ROUNDS = 3
"""The largest number of times that all passes are repeated."""

Candidate: TypeAlias = tuple[str, Scenario]
"""A sentence about what is simpler, and the simpler scenario."""


@dataclass
class Shrinking:
    """A failing world as it gets simpler.

    `steps` says what was made simpler. `results` are those of the present trial.
    """

    trial: Trial
    results: TrialResults
    runs: int = 0
    steps: list[str] = field(default_factory=list)
    interrupted: bool = False

    @property
    def progress_s(self) -> float:
        """The time of the last progress in the present world, s."""
        return float(self.results.progress_s[0])


def shrink_failure(
    measure: TrialMeasure,
    usual: Scenario,
    trial: Trial,
    *,
    most_runs: int = MOST_RUNS,
    seconds: float | None = None,
    progress: Callable[[Shrinking], None] = lambda shrinking: None,
    clock: Callable[[], float] = REAL_TIME,
) -> Shrinking:
    """Make a failing world simpler as long as it still fails, no later, and in no other states than before.

    Numbers of objects and amounts stay within what the scenario can draw. Obstacles are left out, because that makes a
    world easier, and so are robots where each could do the task alone.

    Parameters
    ----------
    measure
        Runs the behavior.
    usual
        The scenario that was searched.
    trial
        A failing world of it.
    most_runs
        The largest number of runs.
    seconds
        The time, s. None: until nothing can be made simpler.
    progress
        Called after each simplification.
    clock
        What tells the time, s.

    Returns
    -------
    Shrinking
        The simplest failing world found, also if it was interrupted.
    """
    shrinking = Shrinking(trial, measure([trial]))
    shrinking.runs = 1
    end = None if seconds is None else clock() + seconds

    def count_left() -> int:
        return 0 if end is not None and clock() >= end else most_runs - shrinking.runs

    try:
        explicit = make_explicit(trial)
        if _accept_first(measure, shrinking, [("", explicit)], count_left):
            shrinking.steps.pop()
        passes: Sequence[Callable[[Trial], Iterator[Candidate]]] = (
            lambda now: list_without_obstacles(now.scenario),
            lambda now: list_without_objects(now.scenario, usual),
            lambda now: list_without_robots(now.scenario),
            lambda now: list_fewer_breakdowns(now.scenario),
            lambda now: list_less_disturbed(now.scenario, usual),
            lambda now: list_smaller_amounts(now.scenario, usual),
            lambda now: list_earlier_starts(measure, now, shrinking.progress_s),
            lambda now: list_rounder(now.scenario),
        )
        for _ in range(ROUNDS):
            before = len(shrinking.steps)
            for list_candidates in passes:
                while _accept_first(measure, shrinking, list(list_candidates(shrinking.trial)), count_left):
                    progress(shrinking)
            if len(shrinking.steps) == before or count_left() <= 0:
                break
    except KeyboardInterrupt:
        shrinking.interrupted = True
    return shrinking


def _accept_first(
    measure: TrialMeasure,
    shrinking: Shrinking,
    candidates: Sequence[Candidate],
    count_left: Callable[[], int],
) -> bool:
    """Take the first candidate that fails as early and ends in the same states; return whether there is one.

    `count_left` returns how many may still be run.
    """
    possible = [each for each in candidates if each[1] != shrinking.trial.scenario and _is_possible(each[1])]
    first, size = 0, FIRST_CANDIDATES
    while first < len(possible) and (left := count_left()) > 0:
        if _accept_any(measure, shrinking, possible[first : first + min(size, left)]):
            return True
        first, size = first + size, 2 * size
    return False


def _accept_any(measure: TrialMeasure, shrinking: Shrinking, possible: Sequence[Candidate]) -> bool:
    """Run candidates side by side, and take the first that fails as early and ends in the same states."""
    trials = [Trial(scenario, shrinking.trial.seed) for _, scenario in possible]
    try:
        results = measure(trials)
    except SettingError:  # one of them is too crowded for this seed
        return False
    shrinking.runs += len(trials)
    tick_s = shrinking.trial.scenario.tick_s
    latest = shrinking.progress_s + TICKS_AT_ONCE * tick_s + 1e-9
    for row, (step, _) in enumerate(possible):
        ends_alike = results.last_states[row] <= shrinking.results.last_states[0]
        if results.robustness[row] < 0 and results.progress_s[row] <= latest and ends_alike:
            shrinking.trial, shrinking.results = trials[row], results.select([row])
            shrinking.steps.append(step)
            return True
    return False


def _is_possible(scenario: Scenario) -> bool:
    try:
        check_scenario(scenario)
    except SettingError:
        return False
    return True
