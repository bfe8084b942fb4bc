"""Run properties in the worlds of a scenario, and say what the results prove."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np

from understudy.judging.criteria import Criteria, make_raised_reader
from understudy.judging.evaluate import find_flags, find_runners
from understudy.judging.evaluation_task import EvaluationTask
from understudy.judging.intervals import (
    LEVEL,
    count_fewest_trials,
    exact_interval_of_share,
    interval_of_share_at_any_time,
)
from understudy.judging.properties.condition import parse_condition
from understudy.judging.properties.monitor import PropertyOutcomes, find_flag, make_watch, monitor_property
from understudy.judging.raised_range import RaisedRange, describe_raised, find_shown_goal
from understudy.judging.rollout import WORLDS_AT_ONCE, Progress, skip_progress
from understudy.model.library import Library
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.runtime.link import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries

FEWEST_MORE = 50
"""The number of worlds that a sequential test begins with, and the least that it adds at a time."""


class Verdict(StrEnum):
    """What the runs of a property prove about its claim."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"  # the interval contains the claimed share


@dataclass(frozen=True)
class PropertyResult:
    """The result of testing a property.

    Parameters
    ----------
    tested
        The property.
    seeds
        The seeds of the worlds that were run, in order; empty from a stored moment.
    outcomes
        The results of those worlds; of the single run from a stored moment.
    problem
        Why it could not be tested; empty if it could.
    raised
        Where the flag was raised that the property demands in time, beside where it was shown. None: it demands
        something else, or nothing shown says where that is right.
    """

    tested: Property
    seeds: tuple[int, ...]
    outcomes: PropertyOutcomes
    problem: str = ""
    raised: RaisedRange | None = None

    @classmethod
    def from_problem(cls, tested: Property, problem: str) -> Self:
        """Make the result of a property that could not be tested."""
        return cls(tested, (), PropertyOutcomes(np.empty(0), np.empty(0), np.empty(0)), problem)

    @property
    def worlds(self) -> int:
        """The number of runs."""
        return len(self.outcomes.failed_s)

    @property
    def failures(self) -> int:
        """The number of runs in which it failed."""
        return int((~self.outcomes.held).sum())

    @property
    def failure_seeds(self) -> tuple[int, ...]:
        """The seeds of the worlds in which it failed, in order."""
        return tuple(seed for seed, held in zip(self.seeds, self.outcomes.held, strict=False) if not held)

    @property
    def is_sequential(self) -> bool:
        """True if the number of runs depended on their results."""
        return self.tested.at_least is not None

    @property
    def share_interval(self) -> tuple[float, float]:
        """The 95 % interval of the share of worlds in which it holds.

        It is exact for a fixed number of worlds (Clopper and Pearson 1934); in a sequential test it is valid at any
        time.
        """
        held = self.worlds - self.failures
        if self.is_sequential:
            return interval_of_share_at_any_time(held, self.worlds)
        return exact_interval_of_share(held, self.worlds)

    @property
    def failure_interval(self) -> tuple[float, float]:
        """The 95 % interval of the failure rate; with no failure in a fixed number of worlds, that of one side."""
        if not self.is_sequential and not self.failures:
            return 0.0, compute_failure_bound(self.worlds)
        low, high = self.share_interval
        return 1.0 - high, 1.0 - low

    @property
    def verdict(self) -> Verdict:
        """Whether the claim of the property is proven."""
        if self.problem:
            return Verdict.FAILS
        if self.tested.at_least is None:
            return Verdict.FAILS if self.failures else Verdict.HOLDS
        low, high = self.share_interval
        if low >= self.tested.at_least:
            return Verdict.HOLDS
        return Verdict.FAILS if high < self.tested.at_least else Verdict.UNDECIDED

    @property
    def was_met(self) -> bool:
        """True if it was tested and did not fail."""
        return self.verdict is not Verdict.FAILS

    @property
    def took_s(self) -> float | None:
        """The time until an "always" property held in a single run, s; None if there is no such time."""
        if self.problem or self.worlds != 1 or np.isnan(self.outcomes.reached_s[0]):
            return None
        return round(float(self.outcomes.reached_s[0]), 6)


def compute_failure_bound(worlds: int, *, level: float = LEVEL) -> float:
    """Compute the largest failure rate that is compatible with no failure in `worlds` worlds.

    A larger rate would have given a failure with a probability of more than `level` (the exact one-sided limit).
    """
    return 1.0 if worlds == 0 else float(1.0 - (1.0 - level) ** (1.0 / worlds))


def make_property_task(subject: Property, library: Library | Libraries, scenario: Scenario) -> EvaluationTask:
    """Make the task that runs a property's behavior in worlds of a scenario.

    Parameters
    ----------
    subject
        The property.
    library
        The library, whose behavior all robots run; or for a team the library of each sort of agents.
    scenario
        The scenario.

    Returns
    -------
    EvaluationTask
        The task. Its `make_run` makes runs for `monitor_property`, its criteria have the flags.

    Raises
    ------
    UnknownName
        If there is no such behavior or sort of agents.
    UnboundParameter
        If a parameter of the behavior is not bound to a target.
    """
    libraries, sort, behavior, own = find_runners(library, subject.behavior, scenario)
    link(own, behavior, subject.targets)
    criteria = Criteria(None, find_flags(own, behavior), {}, {})
    return EvaluationTask(libraries, sort, behavior, scenario, dict(subject.targets), criteria, None)


def check_property(subject: Property, task: EvaluationTask, scenario: Scenario) -> None:
    """Refuse a property that names what a scenario or behavior lacks; see `monitor_property` for the errors."""
    make_watch(subject, task.make_run(scenario, [0]), task.criteria.flags)


def run_property(
    subject: Property,
    library: Library | Libraries,
    scenario: Scenario,
    *,
    progress: Progress = skip_progress,
) -> PropertyResult:
    """Test a property in the worlds of its seeds.

    Without `at_least` all worlds are run. Otherwise they are run in parts, until an interval that is valid at any time
    lies on one side of that share, or there are no more seeds.

    Parameters
    ----------
    subject
        The property, which starts in seeded worlds.
    library
        The library, whose behavior all robots run; or for a team the library of each sort of agents.
    scenario
        The scenario that `subject.start.world` names.
    progress
        Function called repeatedly with the number of completed worlds and their total.

    Returns
    -------
    PropertyResult
        The result.

    Raises
    ------
    UnknownName
        If the property names something that the scenario, the robots or the behavior do not have.
    SettingError
        If a unit does not fit, or the property needs a goal and the scenario has none.
    UnboundParameter
        If a parameter of the behavior is not bound to a target.
    """
    if not isinstance(subject.start, SeededWorlds):
        raise TypeError("a property from a stored moment has no seeds")
    task = make_property_task(subject, library, scenario)
    flag = _find_demanded_flag(subject)
    shown_range = find_shown_goal(task.library, task.behavior, flag)
    seeds, done, raised = subject.start.seeds, list[PropertyOutcomes](), list[RaisedRange]()
    last = 0
    for first, last in _divide(subject, len(seeds)):

        def report(through: int, _: int, first: int = first) -> None:
            progress(first + through, len(seeds))

        run = task.make_run(scenario, seeds[first:last])
        reader = make_raised_reader(run, Criteria(flag, task.criteria.flags, {}, {}, shown_range))
        also = [] if reader is None else [reader]
        done.append(monitor_property(subject, run, task.criteria.flags, also=also, progress=report))
        if reader is not None:
            raised.append(reader.finish(~np.isnan(done[-1].reached_s)))
        if (
            subject.at_least is not None
            and _join(subject, seeds[:last], done).verdict is not Verdict.UNDECIDED
        ):
            break
    joined = _join(subject, seeds[:last], done)
    return replace(joined, raised=RaisedRange.concatenate(raised)) if raised else joined


def _find_demanded_flag(subject: Property) -> str | None:
    """Return the flag that a property demands in time, and nothing else; None if it demands something else."""
    return find_flag(parse_condition(subject.what)) if subject.kind is PropertyKind.ALWAYS else None


def _join(subject: Property, seeds: tuple[int, ...], parts: list[PropertyOutcomes]) -> PropertyResult:
    return PropertyResult(subject, seeds, PropertyOutcomes.concatenate(parts))


def _divide(subject: Property, total: int) -> Iterator[tuple[int, int]]:
    """Yield the parts of the seeds that are run together: first and one after the last."""
    first = 0
    fewest = 0 if subject.at_least is None else count_fewest_trials(subject.at_least)
    while first < total:
        size = WORLDS_AT_ONCE
        if first < fewest:  # failures may decide already; then the first time that none at all do
            size = min(max(FEWEST_MORE, first), fewest - first)
        elif subject.at_least is not None:
            size = max(FEWEST_MORE, first // 4)
        last = min(total, first + min(size, WORLDS_AT_ONCE))
        yield first, last
        first = last


def describe_result(result: PropertyResult) -> Iterator[str]:
    """Yield sentences about the result of a property in seeded worlds: what was seen, and what that proves."""
    if result.problem:
        yield f"could not be tested: {result.problem}"
        return
    worlds, failures = result.worlds, result.failures
    many = f"{worlds} world{'s' * (worlds != 1)}"
    low, high = result.failure_interval
    at_least = result.tested.at_least
    if failures == 0 and at_least is None:
        yield f"no failure in {many}: it fails in at most {_percent(high)} of worlds, at 95 %"
    else:
        counted = (
            f"no failure in {many}"
            if not failures
            else f"{failures} of {many} failed ({_percent(failures / worlds)})"
        )
        kind = "95 % interval at any time" if result.is_sequential else "exact 95 % interval"
        yield f"{counted}; {kind} of failures: {_percent(low)} to {_percent(high)}"
    if at_least is not None:
        yield _describe_decision(result, at_least)
    if failures:
        yield _describe_failures(result)
    flag = _find_demanded_flag(result.tested)
    if flag is not None:
        yield describe_raised(flag, result.raised)


def _describe_decision(result: PropertyResult, at_least: float) -> str:
    start = result.tested.start
    most = len(start.seeds) if isinstance(start, SeededWorlds) else 1
    saved = f", decided after {result.worlds} of {most}" if result.worlds < most else ""
    if result.verdict is Verdict.HOLDS:
        return f"it holds in at least {_percent(at_least)} of worlds{saved}"
    if result.verdict is Verdict.FAILS:
        return f"it holds in less than {_percent(at_least)} of worlds{saved}"
    fewest = count_fewest_trials(at_least)
    more = f": give at least {fewest} seeds" if most < fewest else ": give more seeds"
    return f"undecided whether it holds in at least {_percent(at_least)} of worlds{more}"


MOST_SEEDS = 5


def _describe_failures(result: PropertyResult) -> str:
    places = [
        f"seed {seed} after {result.outcomes.failed_s[row]:.1f} s"
        for row, seed in enumerate(result.seeds)
        if not result.outcomes.held[row]
    ]
    more = f", and {len(places) - MOST_SEEDS} more" if len(places) > MOST_SEEDS else ""
    return f"failed with {', '.join(places[:MOST_SEEDS])}{more}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
