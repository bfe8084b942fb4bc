"""The model of a novice's teaching alone, with the coach, or live, with the learned automaton after each step.

A novice alone puts the robot into one situation after another and drives it. A coached novice does so once. Then two
actions alternate: let the robot try from the next situation and answer its questions, or read the first advice, let the
coach set up its situation, and demonstrate there.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.give_advice import give_advice
from understudy.coaching.pose_sampling import sample_posed_situations
from understudy.coaching.queries import QueryPolicy, UncertaintyQueries
from understudy.coaching.situation_setup import set_up_situation
from understudy.coaching.uncertainty import DoubtReason
from understudy.learning.fit import learn
from understudy.learning.mislabels import find_mislabels
from understudy.model.library import Library, TrainedAutomaton
from understudy.training.session import Session
from understudy_lab.coaching_benefit.tasks import CoachingTask
from understudy_lab.novices.novice import Novice
from understudy_lab.novices.teach_live import draw_seed, teach_live
from understudy_lab.teachers.live_teacher import LIVE
from understudy_lab.teachers.person import rebuild_screen
from understudy_lab.teachers.teacher import FIRST_SEED

ALONE, COACHED = "alone", "coached"
ASKED, CORRECTED = "asked", "corrected"
GOES_ON_S = 4.0
"""The time in s for which a novice goes on driving the robot after an answer."""
TWICE = 2
"""The largest number of times that a novice follows the same advice."""
ANSWER_S = 1.0
"""The time in s that an answer to a question takes; the world is paused."""
STEPS_IN_S = 1.0
"""The time in s for which a novice tolerates a wrong action before correcting it."""
LOOK_S = 2.0
"""The time in s spent on an example that may be a slip."""
MOST_QUESTIONS = 8
"""The largest number of questions in one try."""
STEPS = (6, 10, 15, 20, 25, 30, 40, 50, 60, 80, 100, 120, 150)
"""The numbers of examples after which the automaton is stored."""


@dataclass
class CoachedTeaching:
    """The result of one novice's teaching: the automaton after each of STEPS examples, and the session."""

    session: Session
    by_step: dict[int, TrainedAutomaton] = field(default_factory=dict)
    followed: Counter[str] = field(default_factory=Counter)
    """The number of times advice was followed, by kind and by sentence."""
    pressed: set[int] = field(default_factory=set)
    meant: dict[int, float] = field(default_factory=dict)
    """The doubt about each suspected slip that was judged, by example number."""

    @property
    def made(self) -> int:
        """The number of press-made examples so far, including deleted ones."""
        return len(self.pressed)

    @property
    def followed_kinds(self) -> dict[str, int]:
        """The number of times advice of each kind was followed, a question answered, or the robot corrected."""
        kinds = {*(kind.value for kind in AdviceKind), ASKED, CORRECTED}
        return {str(each): count for each, count in self.followed.items() if each in kinds}

    def look(self) -> None:
        """Store the present automaton for each step that is not exceeded yet."""
        self.pressed |= {example.number for example in self.session.examples if example.is_from_press}
        for step in STEPS:
            if self.made <= step:
                self.by_step[step] = self.session.make_trained_automaton()


def teach(novice: Novice, exercise: CoachingTask, way: str) -> CoachedTeaching:
    """Let a novice teach for the given time, alone, coached or live, and return the result."""
    session = Session(
        exercise.body(draw_seed(novice)),
        Library(exercise.kit),
        exercise.lesson(),
        targets=exercise.targets,
    )
    course, limit_s = CoachedTeaching(session), novice.habits.given_s
    if way == LIVE:
        teach_live(novice, session, exercise.placement, note=course.look)
        return course
    situations = _situations(exercise, session)
    put, turn = int(novice.draws.integers(len(novice.traits.situations))), 0
    while novice.seconds < limit_s:
        novice.seconds = min(limit_s, novice.seconds + novice.traits.carry_s)
        novice.look_afresh()
        coached, tries = way == COACHED and course.made > 0, turn % 2 > 0
        if coached:
            _mend(novice, course)
        first = _first(course, exercise, situations) if coached and not tries else None
        if first is None or first.kind is AdviceKind.NEVER_ENTERED:
            exercise.placement.put_down(
                novice, session, novice.traits.situations[put % len(novice.traits.situations)]
            )
            put += 1
            left_s = min(novice.traits.patience_s, limit_s - novice.seconds)
            if coached and tries:
                _try_out(novice, course, left_s)
            else:
                novice.show(session, novice.wish, until=novice.there, limit_s=left_s)
        else:
            course.followed[first.kind.value] += 1
            set_up_situation(session, first, draw=int(novice.draws.integers(2**30)))
            _answer(novice, course, first, limit_s - novice.seconds)
        course.look()
        turn += 1
    return course


def _try_out(novice: Novice, course: CoachedTeaching, left_s: float) -> None:
    """Let the robot try for `left_s` seconds; answer its questions while the world is paused, and correct errors."""
    session, until = course.session, novice.seconds + left_s
    session.test()
    asking, questions, repeats = UncertaintyQueries(session, QueryPolicy.PAUSE), 0, ""
    while novice.seconds < until:
        question, screen = asking.find_question(), session.view()
        repeats = repeats if screen.state == repeats else ""
        if question is not None and question.doubt.because is DoubtReason.REPEATING:
            repeats = question.state
            if novice.wish(screen) in (None, screen.state):  # they watch a round, and press later
                novice.seconds += ANSWER_S
                continue
        if question is not None and questions < MOST_QUESTIONS:
            questions += 1
            course.followed[ASKED] += 1
            wished = novice.wish(screen) or screen.state
            novice.say(session, None if wished == screen.state else wished)
            novice.seconds += session.body.tick_s + ANSWER_S
            course.look()
            session.test()
        elif novice.there(screen):
            break
        elif novice.notice(session, 0.0 if repeats else STEPS_IN_S):
            course.followed[CORRECTED] += 1
            novice.show(
                session, novice.wish, until=novice.there, limit_s=min(GOES_ON_S, until - novice.seconds)
            )
            course.look()
            session.test()
        else:
            session.tick()
            novice.seconds += session.body.tick_s
    session.train()


def _situations(exercise: CoachingTask, session: Session) -> NDArray[np.float64]:
    """Return feature vectors that the robot may meet, sampled from a world like the one of the lesson."""
    body = exercise.body(FIRST_SEED)
    return sample_posed_situations(body, session.automaton.features, exercise.targets)


def _mend(novice: Novice, course: CoachedTeaching) -> None:
    """Judge each suspected slip, the most doubtful first, and correct those that were not intended."""
    session = course.session
    while novice.seconds < novice.habits.given_s and (
        odd := find_mislabels(session.lesson, meant=course.meant)
    ):
        example = odd[0].example
        wished = novice.wish(rebuild_screen(example, session.automaton)) or example.state
        course.meant[example.number] = odd[0].doubt
        course.followed[AdviceKind.SLIP.value] += 1
        novice.seconds += LOOK_S
        if wished != example.next:
            session.correct_slip(example.number, wished)


def _first(course: CoachedTeaching, exercise: CoachingTask, situations: NDArray[np.float64]) -> Advice | None:
    """Return the first advice on a situation to show that was not followed twice already, or None."""
    lesson = course.session.lesson
    for each in give_advice(
        lesson, learn(lesson), kit=exercise.kit, situations=situations, meant=course.meant
    ):
        if each.kind is AdviceKind.SLIP:
            continue
        place = each.region is not None or each.kind in (AdviceKind.NEVER_LEFT, AdviceKind.NEVER_ENTERED)
        if place and course.followed[each.sentence] < TWICE:
            course.followed[each.sentence] += 1
            return each
    return None


def _answer(novice: Novice, course: CoachedTeaching, advised: Advice, left_s: float) -> None:
    """Demonstrate in the advised situation: direct the robot or confirm, and delete examples that contradict it."""
    session = course.session
    screen = session.view()
    wished = novice.wish(screen) or screen.state
    if advised.kind in (AdviceKind.CONTRADICTION, AdviceKind.DISAGREEMENT, AdviceKind.SINGLE):
        wrong = [
            example.number
            for example in session.examples
            if example.number in advised.examples and example.next != wished
        ]
        if wrong:
            session.delete(*wrong)
        if len(wrong) < len(advised.examples) and advised.kind is not AdviceKind.SINGLE:
            return  # what remains says it
    novice.say(session, None if wished == screen.state else wished)
    novice.seconds += session.body.tick_s
    novice.show(session, novice.wish, until=novice.there, limit_s=min(GOES_ON_S, left_s))
