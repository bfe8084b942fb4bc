"""What is in training in other worlds: an evaluation on request, and the score after each press."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from msgspec import field

from understudy.addons.checks.falsification.lesson_score import Trend
from understudy.judging.baseline import LENIENCE
from understudy.judging.evaluation import Evaluation
from understudy.judging.intervals import interval_of_share
from understudy.judging.raised_range import describe_raised
from understudy.judging.rollout import Progress
from understudy.ui.controller.beside import Beside
from understudy.ui.controller.keep_going import BetterVersion
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.controller.status import StatusMessage
from understudy.ui.web.background import BackgroundRun
from understudy.ui.web.messages.base import Data

MOST_LISTED = 100
"""The greatest number of failed worlds that are listed."""


class FailedWorldData(Data, frozen=True, kw_only=True):
    """An unseen world in which the evaluated automaton did not succeed."""

    seed: int
    problem: str
    """What went wrong, and after how long."""


class EvaluationResultData(Data, frozen=True, kw_only=True):
    """The number of unseen worlds in which the automaton succeeded, and those in which it failed."""

    success: str
    """What counts as success, in words."""
    succeeded: int
    interval: tuple[float, float]
    """The 95 % interval of the share of worlds in which it succeeds."""
    first: int
    """The seed of the first world."""
    last: int
    """The seed of the last world."""
    failed: list[FailedWorldData]
    """Of the worlds in which it failed, the first hundred."""
    raised: str
    """Where the flag that counts was raised, beside where it was shown; empty without such a flag."""
    leaves_shown: bool
    """Whether it was raised where it was not shown, in any world."""


class EvaluationData(Data, frozen=True, kw_only=True):
    """An evaluation in unseen worlds of the automaton in training, as it was at the start."""

    behavior: str
    """The behavior and its targets, such as goto(station)."""
    edition: int
    """The edition of the lesson that it was learned from."""
    worlds: int
    finished: int
    """The number of worlds finished."""
    result: EvaluationResultData | None
    """Null while the evaluation runs, and if it failed with an error."""
    problem: str
    """The error that ended the evaluation; empty if there was none."""


class UnseenWorldsEvaluation(BackgroundRun[EvaluationResultData]):
    """An evaluation of the automaton in training in unseen worlds, beside the world on the page."""

    def __init__(
        self,
        called: str,
        edition: int,
        binding: Mapping[str, str],
        *,
        worlds: int,
        evaluate: Callable[[Progress], Evaluation],
        beside: Beside,
    ) -> None:
        self.behavior, self.edition, self.worlds = called, edition, worlds
        self.binding = binding
        """The targets with which it runs."""
        self._untold = True
        super().__init__(lambda progress: describe_evaluation(evaluate(progress)), beside)

    @property
    def data(self) -> EvaluationData:
        """The evaluation as the page shows it."""
        return EvaluationData.of(self)

    def take_status(self) -> StatusMessage | None:
        """Return the message about the finished evaluation on the first call after its end, else None."""
        if self.is_running or not self._untold:
            return None
        self._untold = False
        if self.result is None:
            return StatusMessage(self.problem, "error")
        worlds = f"{self.worlds} world{'s' * (self.worlds != 1)}"
        raised = f" ({self.result.raised})" if self.result.raised else ""
        return StatusMessage(
            f"{self.behavior} succeeded in {self.result.succeeded} of {worlds}{raised}",
            "error" if self.result.leaves_shown else "",
        )


def describe_evaluation(evaluation: Evaluation) -> EvaluationResultData:
    """Return the result of an evaluation in unseen worlds as the page shows it."""
    missed = "goal not reached" if evaluation.flag is None else f"not {evaluation.flag}"
    missed = missed if evaluation.goal is None else f"not so: {evaluation.goal},"
    rows = zip(
        evaluation.seeds, evaluation.taught.finished.tolist(), evaluation.taught.limit_s.tolist(), strict=True
    )
    failed = [
        FailedWorldData(seed=seed, problem=f"{missed} after {limit_s:.0f} s")
        for seed, finished, limit_s in rows
        if not finished
    ]
    succeeded = len(evaluation.seeds) - len(failed)
    return EvaluationResultData(
        success=_success(evaluation),
        succeeded=succeeded,
        interval=interval_of_share(succeeded, len(evaluation.seeds)),
        first=min(evaluation.seeds),
        last=max(evaluation.seeds),
        failed=failed[:MOST_LISTED],
        raised=describe_raised(evaluation.flag, evaluation.raised),
        leaves_shown=evaluation.raised is not None and evaluation.raised.leaves_shown,
    )


def _success(evaluation: Evaluation) -> str:
    if evaluation.goal is not None:
        return evaluation.goal
    wanted = f"the goal of {evaluation.world}" if evaluation.flag is None else evaluation.flag
    if evaluation.expert is not None:
        return f"{wanted} within {LENIENCE:g} times the time of a hand-written controller"
    return f"{wanted} within {evaluation.taught.limit_s[0]:.0f} s"


class OfferedGoalData(Data, frozen=True, kw_only=True):
    """A goal of which a person can pick one."""

    name: str
    """What it says, shortly."""
    claim: str
    """What is measured, exactly."""


class ScoreData(Data, frozen=True, kw_only=True):
    """The share of new worlds in which the automaton in training works, taken after each press."""

    text: str
    """The score in words, or why there is none; empty before the first press."""
    trend: Trend
    """What changed since the press before, by more than chance."""
    enabled: bool
    """Whether scores are taken."""
    is_running: bool = field(name="running")
    """Whether one is being taken."""
    goal: str
    """What success means, in words; empty if it is not known."""
    is_goal_chosen: bool = field(name="chosen")
    """Whether a person has chosen that."""
    offers: list[OfferedGoalData]
    """Goals of which a person can pick one."""
    worse_since: str
    """What was done since a version that works in more worlds, in words; empty if none is known."""


def describe_score(score: LessonScoreKeeper, better: BetterVersion | None) -> ScoreData:
    """Return the score, what success means, and what made it worse, as the page shows them."""
    return ScoreData.of(score, text=score.describe(), worse_since="" if better is None else better.since)
