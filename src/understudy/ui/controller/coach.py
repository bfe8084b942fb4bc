"""The coach of a trainer: suggestions, situations that are set up on request, and questions about decisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from understudy.addons.checks.falsification.lesson_score import LessonScore, ScoreChange, find_wrong_decisions
from understudy.addons.checks.falsification.session_setup import SessionSetup
from understudy.addons.checks.verification.finding import Finding
from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.fast_forward import fast_forward
from understudy.coaching.give_advice import give_advice
from understudy.coaching.next_situation import find_next_situation, go_to_situation
from understudy.coaching.questions import QueryPolicy, Question, UncertaintyQueries
from understudy.coaching.quiet_situations import QuietSituations
from understudy.coaching.raised_elsewhere import find_raised_elsewhere
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.coaching.situation_setup import SetupResult, SituationSpec, set_up_situation
from understudy.errors import SessionError
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.body import Body, is_rewindable
from understudy.training.feature_values import list_steady_readings
from understudy.training.reaction_time import ReactionEstimate, estimate_reaction_time
from understudy.training.session import Session
from understudy.training.trainee import Mode
from understudy.ui.controller.explainer import DecisionExplainer
from understudy.ui.controller.lesson_check import check_lesson
from understudy.ui.controller.score_keeper import LessonScoreKeeper
from understudy.ui.controller.status import StatusMessage, keep_status

if TYPE_CHECKING:
    from understudy.ui.controller.trainer import Trainer

TURN = (QueryPolicy.NEVER, QueryPolicy.PAUSE, QueryPolicy.MARK)
WHEN_SAID = {
    QueryPolicy.NEVER: "It never asks",
    QueryPolicy.PAUSE: "It pauses and asks where it is unsure",
    QueryPolicy.MARK: "It marks moments at which it is unsure, and continues",
}
AS_GOOD_S = 0.2
"""A reaction time so near to what the lesson has is no news: every other estimate is off by nearly as much."""
OTHER_WORLDS = 4
"""The number of further worlds that are searched for a situation if the present one does not have it."""
SKIP_S = 60.0
"""The longest stretch of a run that is skipped at once, s: less than a second of waiting."""
SEARCHED_WORLDS = 40
"""The number of further worlds that are searched for the situation in which an answer matters most."""


class AdviceReport(NamedTuple):
    """The coach's report on a lesson: advice, most useful first, and an estimate of how late presses come."""

    lesson: Lesson
    advice: tuple[Advice, ...]
    late: ReactionEstimate | None
    tick_s: float = 0.0
    """How long the robot takes from a press to the tick at which it acts, at most, s."""
    findings: tuple[Finding, ...] = ()
    """Errors and warnings of the static check that no advice states, the most severe first."""

    @property
    def new_reaction_s(self) -> float | None:
        """The reaction time that the estimate speaks for, s; None if the lesson is set to about that.

        A press acts at the tick that follows it, so a tick of the delay is no reaction of the person.
        """
        late, now = self.late, self.lesson.options.reaction_s
        if late is None or late.least_s <= now <= late.most_s:
            return None
        reaction_s = round(max(0.0, late.reaction_s - self.tick_s), 3)
        return None if abs(reaction_s - now) <= AS_GOOD_S + 1e-9 else reaction_s


def _advised(
    lesson: Lesson,
    transitions: Mapping[str, Transition],
    library: Library,
    body: Body,
    meant: Mapping[int, float],
    scored: tuple[Library, SessionSetup, LessonScore] | None,
) -> AdviceReport:
    wrong = None if scored is None else find_wrong_decisions(*scored)
    advice = give_advice(lesson, transitions, kit=library.kit, meant=meant, wrong=wrong)
    return AdviceReport(
        lesson,
        advice,
        estimate_reaction_time(lesson, steady=list_steady_readings(body)),
        body.tick_s,
        check_lesson(lesson, transitions, library, body, advice=advice),
    )


class CoachController:
    """Advice on one session's lesson, computed again only when the lesson or its score changed.

    At first, a lesson that is taught live marks where it is unsure, and any other does not ask.
    """

    def __init__(self, session: Session, why: DecisionExplainer, score: LessonScoreKeeper) -> None:
        live = session.lesson.options.live
        self.asking = UncertaintyQueries(session, QueryPolicy.MARK if live else QueryPolicy.NEVER)
        self.chosen_policy: QueryPolicy | None = None
        self.skipping = UncertaintyQueries(session)
        self.quiet = QuietSituations()
        self._session, self._explainer, self._score = session, why, score
        self.last_report: AdviceReport | None = None  # last
        self._made_for: tuple[Lesson, ScoreChange | None] | None = None
        self._making: Future[AdviceReport] | None = None
        self._meant: dict[int, float] = {}
        self._next = 0
        self._question: Question | None = None

    # What the lesson lacks

    def compute_report(
        self, beside: Executor | None = None, *, patience_s: float | None = None
    ) -> AdviceReport | None:
        """Compute the report on the current lesson.

        This takes a while for a large lesson. With an executor, `beside`, it waits for at most `patience_s`, and
        returns None until the report is ready.
        """
        lesson, transitions = self._explainer.learn_lesson()
        made_for = lesson, None if self._score.is_running else self._score.change
        if self._made_for is None or any(
            new is not old for new, old in zip(made_for, self._made_for, strict=True)
        ):
            self._made_for, self._making, self.last_report = made_for, None, None
        if self.last_report is not None:
            return self.last_report
        session, meant = self._session, dict(self._meant)
        inputs = lesson, transitions, session.library, session.body, meant, self._score.find_scored()
        if beside is None:
            self.last_report = _advised(*inputs)
        else:
            if self._making is None:
                self._making = beside.submit(_advised, *inputs)
            else:
                patience_s = 0.0  # that was waited for already
            try:
                self.last_report = self._making.result(patience_s)
            except TimeoutError:
                return None
        self._next = 0
        return self.last_report

    def advice(self) -> tuple[Advice, ...]:
        """List what the current lesson lacks, most useful first."""
        report = self.compute_report()
        return () if report is None else report.advice

    def next_place(self) -> Advice:
        """Return the next advice that has a situation, in turn; SessionError if there is none."""
        places = [each for each in self.advice() if each.region is not None]
        if not places:
            sentences = [each.sentence for each in self.advice()] or ["the lesson is consistent"]
            raise SessionError(f"there is no situation to set up: {sentences[0]}")
        self._next += 1
        return places[(self._next - 1) % len(places)]

    def confirm_press(self, number: int) -> None:
        """Note that a press that looks like a slip was intended; it is asked about again only if the doubt grows."""
        advice = () if self.last_report is None else self.last_report.advice
        doubts = {each.examples[0]: each.doubt for each in advice if each.kind is AdviceKind.SLIP}
        if number not in doubts:
            raise SessionError(f"example {number} is not in question")
        self._meant[number] = doubts[number]
        self.last_report = self._making = None

    # Asking

    def cycle_query_policy(self) -> str:
        """Change to the next way of asking, and return its name."""
        self.choose_query_policy(TURN[(TURN.index(self.asking.when) + 1) % len(TURN)])
        return WHEN_SAID[self.asking.when]

    def choose_query_policy(self, when: QueryPolicy) -> None:
        """Change what happens at uncertain decisions, also in later sessions of this person."""
        self.asking.when = self.chosen_policy = when

    def describe_new_mark(self, before: Sequence[Question]) -> str:
        """Return the sentence of the newest marked question if it is new and the robot repeats itself; empty otherwise.

        `before` are the questions that were marked before. A robot that repeats itself goes on doing so, so its
        demonstrator has a whole round to press what it should do.
        """
        newest = self.asking.marked[-1:]
        repeats = newest and newest[0].doubt.because is DoubtReason.REPEATING
        is_new = newest and (not before or newest[0] is not before[0])
        return newest[0].sentence if repeats and is_new else ""

    @property
    def question(self) -> Question | None:
        """The question that waits for an answer: until a press comes, or the run continues."""
        question, session = self._question, self._session
        if question is None or not session.paused or session.mode is Mode.TRAINING:
            return None
        view = session.view()
        if not is_rewindable(session.body):  # it stands, and what it reads goes on
            return question if view.state == question.state else None
        now = (view.time_s, view.state, tuple(view.features.values()))
        return question if repr(now) == repr((question.time_s, question.state, question.values)) else None

    @question.setter
    def question(self, question: Question) -> None:
        self._question = question


def set_up_advised_situation(trainer: Trainer, wanted: SituationSpec | None = None) -> SetupResult:
    """Set up the situation of advice or a finding (None: of the next advice that has one); nothing is recorded."""
    chosen = trainer.coach.next_place() if wanted is None else wanted
    if trainer.driving:
        trainer.drive()
    staged = set_up_situation(trainer.session, chosen, seeds=trainer.take_next_seeds(OTHER_WORLDS))
    trainer.seed = trainer.seed if staged.seed is None else staged.seed
    sentence = chosen.sentence if staged.there else f"{chosen.sentence} {staged.sentence}"
    trainer.note_moved(sentence.removesuffix("."))
    return staged


@keep_status
def pause_for_question(trainer: Trainer, question: Question) -> StatusMessage:
    """Pause at a question; resuming is an answer, too."""
    if not trainer.paused:
        trainer.pause()
    trainer.coach.question = question
    return StatusMessage(f"{question.sentence} Space continues", "correction")


@keep_status
def skip_ahead(trainer: Trainer) -> StatusMessage:
    """Skip to the next moment at which the person is needed, and pause there; nothing is learned on the way."""
    if trainer.pace.live:
        raise SessionError("real robots cannot skip ahead: their time is yours")
    if trainer.driving:
        trainer.drive()
    skipped = fast_forward(trainer.session, queries=trainer.coach.skipping, limit_s=SKIP_S)
    trainer.memory.clear()
    trainer.explainer.clear()
    trainer.refresh_view()
    if not trainer.paused:
        trainer.pause()
    sentence = f"{skipped.seconds:.0f} s later. {skipped.sentence} Space continues"
    if skipped.question is None:
        return StatusMessage(sentence)
    trainer.coach.question = skipped.question
    return StatusMessage(sentence, "correction")


@keep_status
def go_to_next_situation(trainer: Trainer) -> StatusMessage:
    """Go to the situation of further worlds in which an answer would change most, and pause there with the question."""
    if trainer.driving:
        trainer.drive()
    seeds = trainer.take_next_seeds(SEARCHED_WORLDS)
    queries = trainer.coach.skipping
    session, situation = trainer.session, None
    if session.mode is not Mode.TRAINING:
        situation = find_raised_elsewhere(session, seeds=seeds, queries=queries)
    if situation is None:
        situation = find_next_situation(session, seeds=seeds, queries=queries)
    else:
        queries.note_asked(situation.question)
    if situation is None:
        taught = (
            "every doubt was asked about already" if trainer.session.examples else "nothing was taught yet"
        )
        raise SessionError(f"{taught}: press a state first")
    if situation.question.doubt.because is DoubtReason.REPEATING:
        queries.note_asked(situation.question)
    go_to_situation(trainer.session, situation)
    trainer.seed = situation.seed
    trainer.note_moved("")
    if not trainer.paused:
        trainer.pause()
    trainer.coach.question = situation.question
    return StatusMessage(f"{situation.sentence} Space continues", "correction")


def press_or_answer(trainer: Trainer, state: str | None) -> bool:
    """Direct the robot to a state (None: confirm the present one); return whether this answered an open question."""
    is_answer = trainer.coach.question is not None
    if is_answer:
        answer_question(trainer, state)
    elif state is None:
        trainer.confirm()
    else:
        trainer.press(state)
    return is_answer


@keep_status
def answer_question(trainer: Trainer, state: str | None) -> StatusMessage:
    """Answer the waiting question: record the press (None: confirm), and continue testing or live teaching.

    The automaton continues where it is. The answer takes effect from the next tick on.
    """
    session, mode = trainer.session, trainer.session.mode
    if state is None:
        trainer.confirm()
    else:
        trainer.press(state)
    trainer.step()
    former = trainer.status
    if mode is Mode.LIVE:
        pass  # it goes on by itself
    elif is_rewindable(session.body):
        there = session.capture()
        session.test()
        session.rewind(there._replace(mode=Mode.TESTING))
    else:
        session.test(afresh=False)
        trainer.note(trainer.robot, step="resume")
    trainer.refresh_view()
    trainer.pause()
    return former


@keep_status
def change_reaction_time(trainer: Trainer, reaction_s: float) -> StatusMessage:
    """Change the assumed reaction time, s; examples are computed again from the record."""
    trainer.session.change_design(options=replace(trainer.session.lesson.options, reaction_s=reaction_s))
    trainer.note_lesson_change()
    return StatusMessage(f"Reaction time is {reaction_s:g} s from now on; undo reverts this")


@keep_status
def correct_slip(trainer: Trainer, number: int, next: str) -> StatusMessage:
    """Correct a press to the state that was intended."""
    trainer.session.correct_slip(number, next)
    trainer.note_lesson_change()
    return StatusMessage(f"Example {number} goes to {next} now; undo reverts this")


@keep_status
def confirm_doubted_press(trainer: Trainer, number: int) -> StatusMessage:
    """Confirm a press that looks like a slip."""
    trainer.coach.confirm_press(number)
    return StatusMessage(f"Example {number} is kept as it is")


@keep_status
def change_query_policy(trainer: Trainer, when: QueryPolicy) -> StatusMessage:
    """Change what happens at uncertain decisions."""
    trainer.coach.choose_query_policy(when)
    return StatusMessage(WHEN_SAID[when])
