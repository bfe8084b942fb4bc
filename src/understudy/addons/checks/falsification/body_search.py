"""Falsification on bodies of one's own: a search at random over their seeds, and the decision before a failure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from understudy.addons.checks.falsification.failure_replay import describe_failing_decision
from understudy.addons.checks.falsification.falsify import (
    AT_RANDOM,
    FIRST_SEED,
    Falsification,
    Report,
    skip_report,
)
from understudy.addons.checks.falsification.random_search import RandomSearch, search_at_random
from understudy.clock import REAL_TIME
from understudy.judging.evaluation_task import EvaluationTask
from understudy.judging.explain_run import DecisionReason, explain_answer
from understudy.judging.rollout import skip_progress
from understudy.judging.tracing import TracedRun
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body

MISSED = -1.0
"""The robustness of a run that did not reach its goal: how near it came is not known of a body."""

NOT_VARIED = (
    "the worlds of a body of your own are known by their seeds only, so nothing in them can be varied"
)


@dataclass(frozen=True)
class BodyMeasure:
    """Runs of a behavior on a body of one's own, and their robustness.

    Parameters
    ----------
    task
        The behavior, the function that makes the body, and the goal with its limit.
    """

    task: EvaluationTask

    def __call__(self, seeds: Sequence[int]) -> Column:
        """Run the behavior once for each seed; return the share of the limit that was left, -1 without the goal."""
        outcomes = self.task.run(seeds, skip_progress).taught
        left: Column = np.where(
            outcomes.finished, (outcomes.limit_s - outcomes.seconds) / outcomes.limit_s, MISSED
        )
        return left


def falsify_on_body(
    task: EvaluationTask,
    *,
    seed: int = 0,
    seconds: float = 60.0,
    worlds: int | None = None,
    jobs: int = 1,
    report: Report = skip_report,
    clock: Callable[[], float] = REAL_TIME,
) -> Falsification:
    """Search at random for a seed with which a behavior fails on a body of one's own.

    Parameters
    ----------
    task
        The behavior, the function that makes the body, and the goal with its limit, from `make_evaluation_task`.
    seed
        The seed of the search.
    seconds
        The time of the search, s.
    worlds
        The number of seeds, however long they take. None: until the time is over.
    jobs
        The number of processes.
    report
        Called with the progress.
    clock
        What tells the time, s.

    Returns
    -------
    Falsification
        What was found, also if it was interrupted. Nothing is made simpler.

    Raises
    ------
    EvaluationFailed
        If the body or a goal raises an error.
    """
    began_s = clock()

    def progress(search: RandomSearch) -> None:
        report("Worlds at random", search.runs, search.failed)

    random = search_at_random(
        BodyMeasure(task),
        first_seed=FIRST_SEED * (seed + 1),
        most_runs=worlds,
        seconds=None if worlds is not None else seconds,
        jobs=jobs,
        first_batch=1,
        progress=progress,
        clock=clock,
    )
    return Falsification(
        random,
        found_by=AT_RANDOM if random.failed else None,
        interrupted=random.interrupted,
        seconds=clock() - began_s,
        notes=[] if random.failed else [NOT_VARIED],
    )


class BodyReplay:
    """A run of a behavior on a body of one's own that is explained when it is over.

    Parameters
    ----------
    body
        The body, before the first tick.
    task
        The behavior and its goal.
    limit_s
        The time limit, s.
    """

    def __init__(self, body: Body, task: EvaluationTask, limit_s: float) -> None:
        self._body, self._task, self._limit_s = body, task, limit_s
        self._began_s = body.time_s
        self._run = TracedRun.from_program(body, task.program)
        for agent in range(body.agents):
            self._run.follow(agent)

    def tick(self) -> None:
        """Let all agents sense, decide and act once."""
        self._run.tick()

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """The active states of each agent, outermost first; of a basic behavior, its name."""
        return [self._run.path(agent) or (self._task.behavior,) for agent in range(self._body.agents)]

    @property
    def has_ended(self) -> bool:
        """True if the body says that the episodes of all agents have ended."""
        return bool(np.all(getattr(self._body, "is_over", False)))

    @property
    def is_over(self) -> bool:
        """True if the episodes have ended, or the next tick would end after the limit."""
        past_s = self._body.time_s - self._began_s
        return self.has_ended or past_s + self._body.tick_s > self._limit_s + 1e-9

    def explain(self) -> tuple[str, ...]:
        """Describe how the run ended, and the last decision of the agent that is explained, in sentences."""
        past_s = self._body.time_s - self._began_s
        ended = (
            f"The episode ended at {past_s:.1f} s, without the goal."
            if self.has_ended
            else f"The goal was not reached within {self._limit_s:.1f} s."
        )
        agent = self._choose_agent()
        which = [f"Agent {agent} did not reach it."] if self._body.agents > 1 else []
        return (ended, *which, *describe_failing_decision(self._find_last_switch(agent)))

    def _choose_agent(self) -> int:
        """Choose the first agent that has not raised the flag that counts; the first one if the goal is no flag."""
        flag = self._task.criteria.flag
        return 0 if flag is None else int(np.argmin(self._run.find_raised(flag)))

    def _find_last_switch(self, agent: int) -> DecisionReason | None:
        """Return the last switch of an agent; None if it never switched."""
        switches = [
            (each.machine, each.query)
            for each in self._run.list_active(agent)
            if each.query is not None and each.query.is_switch
        ]
        latest = switches[0] if switches else self._run.last_switches.get(agent)
        if latest is None:
            return None
        return explain_answer(*latest, self._task.library.taught)
