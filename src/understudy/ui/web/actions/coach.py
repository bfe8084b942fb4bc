"""Handle messages about the coach: send advice, set up situations, go back to uncertain moments, correct slips."""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from understudy.addons.checks.verification.finding import Finding, Severity
from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.pose_sampling import Placeable
from understudy.coaching.situation_setup import SituationSpec
from understudy.errors import SessionError
from understudy.ui.controller import coach
from understudy.ui.controller.coach import AdviceReport
from understudy.ui.controller.lesson_check import locate_finding
from understudy.ui.controller.status import StatusMessage
from understudy.ui.controller.trainer import Trainer
from understudy.ui.web.messages import review as m
from understudy.ui.web.messages.base import Data
from understudy.ui.web.rewind import RewindPoint
from understudy.ui.web.session_host import SessionHost

PATIENCE_S = 0.05
"""How long to wait for the advice (s) before the page is told to ask again."""


class SlipData(Data, frozen=True, kw_only=True):
    """The state and the next state of a press."""

    state: str
    next: str


class AdviceData(Data, frozen=True, kw_only=True):
    """One piece of advice about a lesson."""

    kind: AdviceKind
    sentence: str
    evidence: str
    """In how many new worlds the behavior went wrong for that; empty if in none."""
    weight: float
    """The importance from 0 to 1; advice above 0.5 is clearly worth following."""
    examples: list[int]
    slip: SlipData | None
    """The press that is probably a slip; null for other advice."""
    can_set_up: bool
    """Whether the situation can be set up."""


class FindingData(Data, frozen=True, kw_only=True):
    """One error or warning of the static check of the automaton in training."""

    error: bool
    """Whether it is an error; else it is a warning."""
    sentence: str
    remedy: str
    """What to show or change."""
    assumptions: list[str]
    """What is assumed, in one sentence each; the finding is certain if empty."""
    examples: list[int]
    """The numbers of the examples behind it."""
    can_set_up: bool
    """Whether the situation can be set up."""


class ReactionEstimateData(Data, frozen=True, kw_only=True):
    """The estimated reaction time of the demonstrator (s), with the evidence for it."""

    reaction_s: float
    sentence: str


class AdviceReply(Data, frozen=True, kw_only=True):
    """The advice about the lesson, most useful first; or `later`, if the page is to ask again in a moment."""

    later: bool | UnsetType = UNSET
    advice: list[AdviceData] | UnsetType = UNSET
    findings: list[FindingData] | UnsetType = UNSET
    """What the static check found, the most severe first."""
    reaction: ReactionEstimateData | UnsetType | None = UNSET


class SituationReply(Data, frozen=True, kw_only=True):
    """A description of the situation that was set up, and the number of the run that begins there."""

    sentence: str
    run: int


def handle_advise(host: SessionHost, _: m.RequestAdvice) -> AdviceReply:
    """Return advice, what the check found, and the estimated reaction time; or `later` if this takes longer."""
    trainer = host.active_trainer
    report = trainer.coach.compute_report(host.beside.in_turn, patience_s=PATIENCE_S)
    if report is None:
        return AdviceReply(later=True)
    return AdviceReply(
        advice=[_advice(trainer, each) for each in report.advice],
        findings=[_finding(trainer, each) for each in report.findings],
        reaction=_late(report),
    )


def _advice(trainer: Trainer, advice: Advice) -> AdviceData:
    return AdviceData.of(
        advice,
        weight=round(advice.weight, 3),
        slip=_says(trainer, advice) if advice.kind is AdviceKind.SLIP else None,
        can_set_up=advice.region is not None and isinstance(trainer.session.body, Placeable),
    )


def _finding(trainer: Trainer, finding: Finding) -> FindingData:
    situation = locate_finding(finding, trainer.session.lesson)
    return FindingData.of(
        finding,
        error=finding.severity is Severity.ERROR,
        can_set_up=situation is not None and isinstance(trainer.session.body, Placeable),
    )


def _says(trainer: Trainer, advice: Advice) -> SlipData:
    return SlipData.of(next(each for each in trainer.session.examples if each.number == advice.examples[0]))


def _late(report: AdviceReport) -> ReactionEstimateData | None:
    late, reaction_s, now = report.late, report.new_reaction_s, report.lesson.options.reaction_s
    if late is None or reaction_s is None:
        return None
    but = f", not {now:g} s" if now else ""
    seems = (
        f"You seem to react within {reaction_s:g} s{but}."
        if reaction_s
        else "Your presses seem to be on time."
    )
    return ReactionEstimateData(reaction_s=reaction_s, sentence=f"{seems} {late.evidence}")


def handle_set_up_situation(host: SessionHost, message: m.SetUpSituation) -> SituationReply:
    """Put the robot into the situation that a piece of advice or a finding is about, and pause there."""
    trainer = host.active_trainer
    report = trainer.coach.last_report
    situations = list[SituationSpec]()
    if report is not None and report.lesson.automaton is trainer.session.automaton:
        places = (locate_finding(each, report.lesson) for each in report.findings)
        situations = [*report.advice, *(each for each in places if each is not None)]
    wanted = next((each for each in situations if each.sentence == message.sentence), None)
    if wanted is None:
        raise SessionError("this suggestion is out of date: the lesson has changed since")
    staged = coach.set_up_advised_situation(trainer, wanted)
    host.pause(True)
    trainer.status = StatusMessage("The situation is set up; nothing recorded")
    host.clear_rewind()
    return SituationReply(sentence=staged.sentence, run=host.run.number)


def handle_go_to_next_situation(host: SessionHost, _: m.GoToNextSituation) -> None:
    """Go to the situation of further worlds in which an answer would change most, and pause there."""
    coach.go_to_next_situation(host.active_trainer)
    host.clear_rewind()


def handle_go_to_uncertain(host: SessionHost, message: m.GoToUncertain) -> None:
    """Go back to a marked moment and ask its question there."""
    trainer = host.active_trainer
    mark = host.unsure.find(message.number)
    question = mark.question
    if question.instant is None:  # pragma: no cover - worlds can be rewound
        raise SessionError("the readings of this moment were not kept")
    if mark.run == host.run.number:
        host.rewind(RewindPoint(question.time_s, question.instant, 0))
    else:
        host.go_back(question.instant)
    coach.pause_for_question(trainer, question)
