"""Runs until a goal of one's own is reached, with metrics at the end of each world: side by side or one by one.

Where goals and metrics are named, the worlds of a scenario run side by side. Functions are given the run of one world,
so then, and with bodies of one's own, worlds run one by one. The results are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.behavior_run import BehaviorRun, RunReading
from understudy.analysis.measurement import (
    TICKS_AT_ONCE,
    AtEnd,
    Progress,
    measure_program_outcomes,
    measure_worlds,
    skip_progress,
)
from understudy.analysis.named_reading import YES, check_yes_or_no, find_reading
from understudy.analysis.outcomes import Outcomes
from understudy.analysis.raised_range import RaisedRange, RaisedReader
from understudy.analysis.world_run import (
    ABSENT,
    Goal,
    Metric,
    TickRecorder,
    WorldRun,
    average,
    compute_metrics,
    describe_problem,
    format_exception,
    name_value,
)
from understudy.errors import SettingError, UnknownName
from understudy.learning.shown_ranges import ShownRange
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.runtime.program import Program
from understudy.sim.world import World


@dataclass(frozen=True)
class Criteria:
    """How runs are judged and measured.

    Parameters
    ----------
    goal
        When a world has finished. None: when it has reached the scenario's goal.
    flags
        The flags that the behavior can raise; a goal of such a name is the flag.
    metrics
        What is computed at the end of each world, by name.
    record
        What is recorded in each tick, by name.
    shown
        At which values of a feature the flag that is the goal was pressed; they are compared with those at which it is
        raised. None: nothing is compared.
    """

    goal: Goal | None
    flags: frozenset[str]
    metrics: Mapping[str, Metric]
    record: Mapping[str, Metric]
    shown: ShownRange | None = None

    @property
    def are_names(self) -> bool:
        """Whether there are only names, no functions, so that worlds can run side by side."""
        given = [*([] if self.goal is None else [self.goal]), *self.metrics.values()]
        return not self.record and all(isinstance(each, str) for each in given)

    @property
    def flag(self) -> str | None:
        """The flag that counts as success."""
        return self.goal if isinstance(self.goal, str) and self.goal in self.flags else None

    @property
    def are_plain(self) -> bool:
        """Whether nothing is to be read from the runs but the scenario's goal or a flag."""
        judged = self.goal is None or self.flag is not None
        return judged and not self.metrics and not self.record


@dataclass(frozen=True)
class Part:
    """The results of some worlds: outcomes, metrics by name [n], a sentence for each absent one, and raised flags."""

    outcomes: Outcomes
    metrics: Mapping[str, Column] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    raised: RaisedRange | None = None


def find_goal(run: BehaviorRun, goal: str, flags: frozenset[str]) -> Callable[[], NDArray[np.bool_]]:
    """Return a function that tells in which worlds [B] a goal given by its name is reached now: by all its agents."""
    if goal in flags:
        return partial(run.find_raised, goal)
    try:
        found = run.find_reading(goal)
    except UnknownName as error:
        if error.what == "target":
            raise
        known = [*sorted(flags), *error.known]
        raise UnknownName(
            what="flag, feature or reading", name=error.name, where=error.where, known=known
        ) from None
    check_yes_or_no(found.reading, where="evaluation")

    def is_reached() -> NDArray[np.bool_]:
        reached: NDArray[np.bool_] = (found.read() == YES).all(axis=1)
        return reached

    return is_reached


def run_many_ticks(
    world: World,
    program: Program,
    library: Library,
    binding: Mapping[str, str],
    criteria: Criteria,
    limits: float | Column,
    progress: Progress = skip_progress,
) -> Part:
    """Run one program on all robots, many ticks at once, where only time and success are asked for."""

    def find(text: str) -> RunReading:
        found = find_reading(text, library, world, binding=binding, where="the robots")
        return RunReading(found, lambda: world.sense(found.keys), world.worlds)

    reader = make_raised_reader(criteria, find, is_alone=world.robots == 1)
    outcomes = measure_program_outcomes(
        world,
        program,
        limit_s=limits,
        flag=criteria.flag,
        progress=progress,
        look=None if reader.shown is None else reader.look,
    )
    return Part(outcomes, raised=reader.finish(outcomes.finished))


def run_side_by_side(
    run: BehaviorRun,
    seeds: Sequence[int],
    criteria: Criteria,
    limits: float | Column,
    progress: Progress = skip_progress,
) -> Part:
    """Run simulated worlds side by side until each has finished or reached its limit; goals and metrics are names."""
    world = _get_world(run.body)
    readings = {name: run.find_reading(str(metric)) for name, metric in criteria.metrics.items()}
    values = {name: np.full(world.worlds, np.nan) for name in readings}
    reader, look = _make_look(run, criteria)

    def at_end(through: NDArray[np.bool_]) -> None:
        for name, reading in readings.items():
            rows = reading.read()[through]
            values[name][through] = [average(row) for row in rows]

    if criteria.goal is None:
        at_once = TICKS_AT_ONCE if run.is_fused else 1
        outcomes = measure_worlds(
            world,
            run.advance,
            lambda: world.finished_s,
            limits,
            at_once=at_once,
            progress=progress,
            at_end=at_end,
        )
    else:
        outcomes = _run_to_goal(
            run,
            find_goal(run, str(criteria.goal), criteria.flags),
            limits,
            progress=progress,
            at_end=at_end,
            look=look,
        )
    problems = [
        describe_problem(seed, name, ABSENT)
        for row, seed in enumerate(seeds)
        for name, column in values.items()
        if np.isnan(column[row])
    ]
    return Part(outcomes, values, tuple(problems), reader.finish(outcomes.finished))


def make_raised_reader(
    criteria: Criteria, find: Callable[[str], RunReading], *, is_alone: bool
) -> RaisedReader:
    """Make what reads where a flag is raised, if it is known where it was shown; `find` finds a reading by name."""
    shown = criteria.shown
    read = find_nothing if shown is None else find(str(shown.feature)).read
    return RaisedReader(str(criteria.goal), shown, read, is_alone)


def _make_look(run: BehaviorRun, criteria: Criteria) -> tuple[RaisedReader, Callable[[], None]]:
    """Make what reads where a flag is raised, and the function that lets it read after each tick of a run."""
    reader = make_raised_reader(criteria, run.find_reading, is_alone=False)

    def look() -> None:
        if reader.shown is not None:
            reader.look(run.find_raised_agents(reader.flag))

    return reader, look


def find_nothing() -> Column:
    """Return no values."""
    return np.empty((0, 1))


def run_one_world(run: BehaviorRun, seed: int, criteria: Criteria, limit_s: float) -> Part:
    """Run one world, of a scenario or a body of one's own, until it has finished or reached its limit."""
    alone, goal = WorldRun(run, seed, limit_s), criteria.goal
    recorder = TickRecorder(alone, criteria.record)
    for metric in criteria.metrics.values():
        if isinstance(metric, str):
            alone.read(metric)  # a wrong name is refused before the run
    if isinstance(goal, str):
        is_reached = find_goal(run, goal, criteria.flags)
    elif goal is not None:
        function = goal

        def is_reached() -> NDArray[np.bool_]:
            return np.array([_ask(function, alone)])

    else:
        world = _get_world(run.body)

        def is_reached() -> NDArray[np.bool_]:
            return ~np.isnan(world.finished_s)

    reader, look = _make_look(run, criteria)

    def observe() -> NDArray[np.bool_]:
        recorder.record()
        look()
        return is_reached()

    if isinstance(run.body, World):
        if goal is None and not criteria.record:
            at_once = TICKS_AT_ONCE if run.is_fused else 1
            world = run.body
            outcomes = measure_worlds(
                world, run.advance, lambda: world.finished_s, limit_s, at_once=at_once, progress=skip_progress
            )
        else:
            outcomes = _run_to_goal(run, observe, limit_s)
    else:
        outcomes = _run_body(run, observe, limit_s)
    alone.finished, alone.recorded = bool(outcomes.finished[0]), recorder.rows
    found, problems = compute_metrics(alone, criteria.metrics)
    values = {name: np.array([value]) for name, value in found.items()}
    return Part(outcomes, values, tuple(problems), reader.finish(outcomes.finished))


def _ask(goal: Callable[[WorldRun], Any], run: WorldRun) -> bool:
    """Return what a user's function says of a run; SettingError if it raises an error."""
    try:
        return bool(np.all(goal(run)))
    except Exception as error:
        raise SettingError(
            where=f"the world of seed {run.seed}",
            setting=f"goal {name_value(goal)}",
            problem=f"raised {format_exception(error)} after {run.seconds:.1f} s",
            remedy="let it return whether the run has succeeded",
        ) from error


def _run_to_goal(
    run: BehaviorRun,
    is_reached: Callable[[], NDArray[np.bool_]],
    limits: float | Column,
    *,
    progress: Progress = skip_progress,
    at_end: AtEnd | None = None,
    look: Callable[[], None] = lambda: None,
) -> Outcomes:
    """Run simulated worlds tick by tick until each has reached a goal for the first time, or its limit."""
    world = _get_world(run.body)
    reached_s = np.full(world.worlds, np.nan)

    def advance(ticks: int) -> None:
        for _ in range(ticks):
            run.tick()

    def finished_s() -> Column:
        reached_s[np.isnan(reached_s) & is_reached()] = world.time_s
        return reached_s

    return measure_worlds(
        world, advance, finished_s, limits, at_once=1, progress=progress, at_end=at_end, look=look
    )


def _run_body(run: BehaviorRun, is_reached: Callable[[], NDArray[np.bool_]], limit_s: float) -> Outcomes:
    """Run a body of one's own until it has reached the goal, or the next tick would end after the limit."""
    body, nothing = run.body, np.zeros(1, np.int64)
    began_s = now_s = body.time_s
    while True:
        past_s = now_s - began_s
        reached = bool(is_reached()[0]) and past_s <= limit_s + 1e-9  # a tick can be longer than it should be
        if reached or past_s + body.tick_s > limit_s + 1e-9:
            taken = np.array([past_s if reached else np.nan])
            return Outcomes(taken, np.array([limit_s]), nothing, nothing)
        run.tick()
        if not body.time_s > now_s:
            raise SettingError(
                where="the body",
                setting="time_s",
                problem=f"stood still at {now_s} s during a tick",
                remedy="let `act` advance it",
            )
        now_s = body.time_s


def _get_world(body: Body) -> World:
    if not isinstance(body, World):
        raise TypeError("a body that is not simulated has no goal of a scenario")
    return body
