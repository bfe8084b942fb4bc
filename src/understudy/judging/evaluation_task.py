"""What is to be evaluated, as plain data that other processes can receive, and how it is run in some of the worlds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from understudy.errors import SettingError, UnderstudyError
from understudy.judging.baseline import LENIENCE, find_baseline, measure_baseline
from understudy.judging.behavior_run import BehaviorRun, ProgramRun, TeamRun
from understudy.judging.criteria import Criteria, JudgedRuns, find_goal, judge_runs
from understudy.judging.evaluation import Evaluation, join_evaluations
from understudy.judging.outcomes import Outcomes
from understudy.judging.rollout import WORLDS_AT_ONCE, Progress
from understudy.judging.world_run import SuccessRule, format_exception, name_value
from understudy.model.library import Library
from understudy.model.value_kinds import Column
from understudy.runtime.body import BODY_ATTRIBUTES, Body, close_body
from understudy.runtime.link import Program, link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, list_running_sorts, make_team
from understudy.sim.world import World

MakeBody: TypeAlias = Callable[[int], Body]
"""A function that makes a body of one's own, given the seed of its world."""


class EvaluationFailed(UnderstudyError, json_type="EvaluationFailed"):
    """An evaluation that ended before all worlds were run; `part` has the results of those that were, or None."""

    exit_code = 1

    def __init__(self, *, problem: str, part: Evaluation | None = None) -> None:
        self.problem, self.part = problem, part
        rest = "" if part is None else f"; `part` of this error has the results of {len(part.seeds)} worlds"
        super().__init__(f"{problem}{rest}")


class _WorldFailed(Exception):
    """The run of one world that raised an error."""

    def __init__(self, seed: int, error: Exception) -> None:
        self.seed, self.error = seed, error
        super().__init__(seed)


@dataclass(frozen=True)
class EvaluationTask:
    """A behavior, where it is run, and how it is judged.

    Parameters
    ----------
    libraries
        The library of all robots, or that of each sort of agents in a team.
    sort
        The sort of agents that the behavior belongs to. None: all robots run it.
    behavior
        Name of the behavior.
    world
        The scenario, or the function that makes a body.
    binding
        The target of each parameter of the behavior.
    criteria
        How the runs are judged and measured.
    limit_s
        The time limit, s. None: the scenario's, or three times the baseline's time.
    """

    libraries: Library | Libraries
    sort: str | None
    behavior: str
    world: Scenario | MakeBody
    binding: Mapping[str, str]
    criteria: Criteria
    limit_s: float | None

    @cached_property
    def library(self) -> Library:
        """The library that the behavior belongs to."""
        return self.libraries if isinstance(self.libraries, Library) else self.libraries[str(self.sort)]

    @cached_property
    def program(self) -> Program:
        """The behavior, ready to run."""
        return link(self.library, self.behavior, self.binding)

    @cached_property
    def roots(self) -> dict[str, tuple[str, Mapping[str, str]]]:
        """What each sort of agents runs by itself, with its targets; nothing if all robots run the behavior."""
        if self.sort is None or isinstance(self.libraries, Library):
            return {}
        sorts = list_running_sorts(self.libraries, self.sort, self.behavior)
        return dict.fromkeys(sorts, (self.behavior, self.binding))

    def check_names(self, seed: int) -> None:
        """Refuse goals and metrics whose names the robots or the team of a scenario do not have."""
        if not isinstance(self.world, Scenario) or self.criteria.are_plain:
            return
        run = self.make_run(self.world, [seed])
        if isinstance(self.criteria.goal, str):
            find_goal(run, self.criteria.goal, self.criteria.flags)
        elif isinstance(self.criteria.goal, SuccessRule):
            self.criteria.goal.make_monitor(run, self.criteria.flags)
        for metric in (*self.criteria.metrics.values(), *self.criteria.record.values()):
            if isinstance(metric, str):
                run.find_reading(metric)

    def run(self, seeds: Sequence[int], progress: Progress) -> Evaluation:
        """Run the behavior in one world per seed.

        If a function or body of the user's own raises an error, this raises EvaluationFailed with the results of the
        worlds before.
        """
        done = list[Evaluation]()
        try:
            for part in self._run_parts(seeds, progress):
                done.append(part)
        except _WorldFailed as failed:
            error = failed.error
            if isinstance(error, UnderstudyError) and not done:
                raise error from None
            which = f"the world of seed {failed.seed}"
            problem = str(error) if isinstance(error, UnderstudyError) else format_exception(error)
            raise EvaluationFailed(
                problem=problem if which in problem else f"{which} ended with {problem}",
                part=join_evaluations(done) if done else None,
            ) from error
        return join_evaluations(done)

    def _run_parts(self, seeds: Sequence[int], progress: Progress) -> Iterator[Evaluation]:
        """Run all worlds in order; yield the results of one or more at a time."""
        if not isinstance(self.world, Scenario):
            for through, seed in enumerate(seeds):
                progress(through, len(seeds))
                yield self._evaluated([seed], self._run_one(seed, self._get_limit()), None)
            progress(len(seeds), len(seeds))
            return
        for first in range(0, len(seeds), WORLDS_AT_ONCE):
            batch = list(seeds[first : first + WORLDS_AT_ONCE])

            def report(through: int, _: int, first: int = first) -> None:
                progress(first + through, len(seeds))

            expert = self._measure_baseline(self.world, batch, report)
            limits: float | Column = self._get_limit()
            if expert is not None and self.limit_s is None:
                limits = LENIENCE * expert.spent_s
            if self.criteria.are_names:
                run = self.make_run(self.world, batch)
                part = judge_runs(run, batch, self.criteria, limits, progress=report)
                yield self._evaluated(batch, part, expert)
                continue
            limits = np.broadcast_to(limits, len(batch))
            for row, seed in enumerate(batch):
                report(row, len(batch))
                part = self._run_one(seed, float(limits[row]))
                yield self._evaluated([seed], part, None if expert is None else expert.select([row]))
            report(len(batch), len(batch))

    def _get_limit(self) -> float:
        if self.limit_s is not None:
            return self.limit_s
        if not isinstance(self.world, Scenario):
            return np.inf
        goal = self.criteria.goal
        return goal.find_limit(self.world) if isinstance(goal, SuccessRule) else self.world.limit_s

    def _measure_baseline(
        self, scenario: Scenario, batch: Sequence[int], report: Progress
    ) -> Outcomes | None:
        """Measure the baseline in the same worlds, if there is one and the scenario's goal counts as success."""
        baseline = find_baseline(scenario) if self.criteria.goal is None else None
        if baseline is None:
            return None
        return measure_baseline(baseline, batch, progress=lambda *_: report(0, 0))

    def make_run(self, scenario: Scenario, batch: Sequence[int]) -> BehaviorRun:
        """Make the run of the behavior in new worlds of a scenario, one for each seed of a batch."""
        if self.roots and not isinstance(self.libraries, Library):
            libraries = self.libraries
            return TeamRun(make_team(scenario, batch, libraries, self.roots), libraries, self.roots)
        world = World(scenario, batch)
        return ProgramRun(world, self.program, self.library, self.binding)

    def _run_one(self, seed: int, limit_s: float) -> JudgedRuns:
        """Run one world by itself."""
        body: Body | None = None
        try:
            if isinstance(self.world, Scenario):
                run = self.make_run(self.world, [seed])
            else:
                body = self.world(seed)
                check_body_attributes(body, name_value(self.world))
                run = ProgramRun(body, self.program, self.library, self.binding)
            return judge_runs(run, [seed], self.criteria, limit_s)
        except Exception as error:  # of a body or function of the user's own, or about their names
            raise _WorldFailed(seed, error) from error
        finally:
            close_body(body)

    def _evaluated(self, seeds: Sequence[int], part: JudgedRuns, expert: Outcomes | None) -> Evaluation:
        goal = self.criteria.goal
        in_scenario = isinstance(self.world, Scenario)
        return Evaluation(
            self.behavior,
            self.world.name if isinstance(self.world, Scenario) else name_value(self.world),
            tuple(seeds),
            part.outcomes,
            expert,
            self.criteria.flag,
            None if goal is None or self.criteria.flag is not None else name_value(goal),
            dict(part.metrics),
            part.problems,
            in_scenario,
            part.raised,
        )


def check_body_attributes(body: object, maker: str) -> None:
    """Refuse what is no body, with SettingError that names the function that made it."""
    missing = [name for name in BODY_ATTRIBUTES if not hasattr(body, name)]
    if missing:
        raise SettingError(
            where="evaluation",
            setting=f"what {maker} made",
            problem=f"is a {type(body).__name__} without {missing[0]!r}",
            remedy="let it return a body, as the protocol understudy.Body says",
        )
