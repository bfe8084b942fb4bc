"""A scripted teacher for live teaching: the robot acts from the first press on, and is directed where it errs.

The teacher looks at one situation after the other. A lesson is finished when several in a row needed no press.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle, islice
from typing import TypeAlias

import numpy as np

from understudy.addons.checks.falsification.holding_test import HoldingResult, HoldingTest
from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.new_worlds import Mistake
from understudy.addons.checks.falsification.open_failure import find_moment
from understudy.coaching.fast_forward import fast_forward
from understudy.coaching.questions import Question, UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.judging.properties.run_property import Verdict
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.sim.scenario.schema import Scenario
from understudy.training.corrections import UNSEEN_S
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, ReactionTime, SimulatedPerson, TryResult
from understudy_lab.teachers.teacher import (
    LOOK_S,
    LessonPlan,
    MakesBody,
    Progress,
    ScriptedTeacher,
    Situation,
    ignore_progress,
)

LIVE = "live"
"""The method in which the robot acts from the first press on, and learns at every press."""
FIDGETING_S = 4.0
"""The time in s within which `LessonPlan.fidgets` switches make the teacher press what the robot should do there."""
TAKES_BACK_S = 0.6
"""The time in s within which a demonstrator takes a switch back, or lets it pass."""
MOST_LOOKS, MOST_IDLE = 4, 2
"""In how many worlds a demonstrator looks for something to press, and how often in vain, before they give up."""
MOST_PRESSES = 60
"""The number of presses after which a demonstrator no longer goes on where a behavior goes wrong."""
MOST_FAILED = 30
"""The number of situations that may need presses before a lesson is discarded."""

WatchesMistake: TypeAlias = Callable[[str, Mistake], None]
"""A function that watches a behavior, given by its name, in a world where it went wrong, and presses there."""


class Expectations:
    """The expectations of a demonstrator: which state a robot should be in.

    A switch that was never shown is directed at once; one that was shown, only when it is overdue.
    """

    def __init__(self, topic: LessonPlan) -> None:
        self._topic = topic
        self._alarm = topic.make_alarm()
        self.skips = False
        """Whether the demonstrator skips what goes well."""
        self._shown: set[tuple[str, str]] = set()
        self._state, self._switched = "", deque[float]([], maxlen=topic.fidgets)
        self._before = self._directed = ""
        self._seen: SessionView | None = None  # the last moment
        self._left: SessionView | None = None  # the last moment before the switch
        self._repeats = ""
        """The state in which the robot has said that it repeats itself."""

    def begin_again(self) -> Expectations:
        """Return what the same demonstrator expects of a robot that they have not watched so far."""
        expected = Expectations(self._topic)
        expected._shown = self._shown
        return expected

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in; None if it may go on."""
        if self._switched and screen.time_s < self._switched[-1]:  # another world
            self._switched.clear()
            self._state = self._before = self._directed = ""
        if screen.state != self._state:
            if screen.state == self._directed:  # that was no switch of its own
                self._before = ""
            elif not self._switched or screen.time_s - self._switched[-1] > UNSEEN_S + 1e-9:
                self._before, self._left = self._state, self._seen
            self._state = screen.state
            self._switched.append(screen.time_s)
            self._repeats = ""
        self._seen, self._directed = screen, ""
        fidgets = (
            len(self._switched) == self._topic.fidgets and screen.time_s - self._switched[0] < FIDGETING_S
        )
        if fidgets and screen.flag is None and self._topic.settle is not None:
            return KEEP if (wanted := self._topic.settle(screen)) == screen.state else wanted
        if self._is_too_early(screen):
            return self._before
        wanted = self._topic.show(screen)
        expected = (screen.state, wanted) in self._shown and not self._repeats
        if wanted not in (None, KEEP, screen.state) and not expected:
            return wanted
        return self._find_overdue(screen)

    def _is_too_early(self, screen: SessionView) -> bool:
        """Return whether the robot has just made a switch that came too early, as it was then and as it is now."""
        just = bool(self._switched) and screen.time_s - self._switched[-1] <= TAKES_BACK_S
        if not just or not self._before or self._left is None:
            return False
        then = replace(screen, features=self._left.features)
        return all(self._topic.takes_back(each, self._before) for each in (then, screen))

    def begin_situation(self, passed: int | None) -> None:
        """Begin a situation, after a number in a row without a press; None: a demonstration."""
        after = self._topic.skips_after
        self.skips = after == 0 or (after is not None and passed is not None and passed >= after)
        self._alarm = self._topic.make_alarm()
        self._repeats = ""

    def is_over(self, session: Session) -> bool:
        """Return whether nothing more is to be seen in this world, or something goes wrong."""
        screen = session.view()
        return self._alarm(screen) or self._topic.finished(screen)

    def find_right_state(self, screen: SessionView, question: Question) -> str | None:
        """Return the state that the robot should be in next; None if what it proposes will do.

        To stay will do until a switch that was shown is overdue. A robot that switches back and forth is told what to
        do, unless that is what it proposes. One that repeats itself is watched for a round, and told where it should do
        something else: it will not do that by itself.
        """
        proposed, settle = question.next, self._topic.settle
        if question.doubt.because is DoubtReason.FIDGETING and settle is not None:
            return None if self._topic.accepts(screen, proposed) else settle(screen)
        wanted = self._topic.show(screen)
        if wanted is None or wanted == KEEP:
            wanted = screen.state
        if question.doubt.because is DoubtReason.REPEATING:
            self._repeats = screen.state
            return None if wanted == screen.state else wanted
        stays = proposed == screen.state and (screen.state, wanted) in self._shown
        if (stays and self._find_overdue(screen) is None) or self._topic.accepts(screen, proposed):
            return None
        return None if wanted == proposed else wanted

    def _find_overdue(self, screen: SessionView) -> str | None:
        """Return the state to which a switch is overdue, KEEP once where the robot might wrongly switch, or None."""
        wanted = (self._topic.complain_live or self._topic.complain)(screen)
        return None if wanted == KEEP and (screen.state, KEEP) in self._shown else wanted

    def note_press(self, state: str, wanted: str) -> None:
        """Note that a switch has been shown."""
        self._shown.add((state, wanted))
        self._switched.clear()
        self._directed = wanted


class LivePerson(SimulatedPerson):
    """A simulated person who teaches live, with a memory of the switches that were shown."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._expected: Expectations | None = None
        self._queries: UncertaintyQueries | None = None

    def expect(self, expected: Expectations, session: Session) -> None:
        """Take up a lesson in a session."""
        self._expected, self._queries = expected, UncertaintyQueries(session)

    def _go_on(self, session: Session, wished: str | None, now: float) -> float:
        """Answer a question, or skip to where they are needed, or let a tick pass."""
        expected, queries = self._expected, self._queries
        if expected is None or queries is None:
            return super()._go_on(session, wished, now)
        if wished is None and expected.skips:
            self.seconds += LOOK_S
            skipped = fast_forward(session, queries=queries, until=expected.is_over)
            if skipped.question is not None:
                self._answer(session, skipped.question, expected)
            if skipped.seconds > 0.0:
                return skipped.seconds
        elif (question := queries.find_question()) is not None:
            self._answer(session, question, expected)
        return super()._go_on(session, wished, now)

    def _answer(self, session: Session, question: Question, expected: Expectations) -> None:
        """Press what is right at a question, while the robot waits; nothing if it would do that."""
        self.seconds += LOOK_S
        right = expected.find_right_state(session.view(), question)
        if right is None:
            return
        expected.note_press(question.state, right)
        self.press_paused(session, right)

    def press_paused(self, session: Session, right: str) -> None:
        """Press what is right while the robot is paused."""
        session.paused = True
        if right == session.view().state:
            session.confirm()
        else:
            session.direct(right)
        session.paused = False
        self.presses, self._due = self.presses + 1, None

    def _press(self, session: Session, wished: str) -> None:
        if self._expected is not None:
            self._expected.note_press(session.view().state, wished)
        super()._press(session, wished)


class LiveTeacher(ScriptedTeacher):
    """A teacher who teaches live. The same seed gives the same lessons."""

    _person: LivePerson

    def __init__(
        self,
        library: Library,
        make: MakesBody,
        seed: int,
        *,
        options: Mapping[str, LearnerOptions],
        progress: Progress = ignore_progress,
    ) -> None:
        super().__init__(library, make, seed, options=options, progress=progress, person=LivePerson)
        self._expected: dict[str, Expectations] = {}

    def _teach(self, topic: LessonPlan, lesson: Lesson) -> bool:
        self.accounts[topic.name].lessons += 1
        self._expected[topic.name] = Expectations(topic)
        passed = failed = 0
        shown = len(topic.cases[: topic.shown])
        for number, case in enumerate(self._list_situations(topic)):
            if passed >= topic.tries and number >= shown:
                return True
            self._expected[topic.name].begin_situation(passed if number >= shown else None)
            session = self._session(topic, lesson, case)
            verdict, well = self._see(topic, session, case)
            if case.again:
                session.restart()
                verdict, again = self._see(topic, session, case)
                well = well and again
            lesson = session.lesson
            passed, failed = (passed + 1, failed) if well else (0, failed + 1)
            if failed > MOST_FAILED:
                break
            if verdict is TryResult.LOST:
                self._correct_below(session)
        return False

    def go_on(
        self,
        topic: LessonPlan,
        tested: HoldingTest,
        bindings: Sequence[Mapping[str, str]],
        *,
        watch: WatchesMistake,
        most_presses: int = MOST_PRESSES,
    ) -> HoldingResult:
        """Go on with a topic where it goes wrong in new worlds, until it works in the wanted share of them.

        Where presses made it worse by more than chance, the teacher goes back to the best version, and to another of
        its mistakes. In the end the best version is kept. Presses that were taken back count.

        Parameters
        ----------
        topic
            The topic, which was taught before.
        tested
            Tests whether it holds.
        bindings
            The targets that it is tested with.
        watch
            Watches the behavior where it went wrong, and presses there.
        most_presses
            The number of presses after which it ends.

        Returns
        -------
        HoldingResult
            The result of the version that is kept.
        """
        began, idle = self.presses, 0
        left = dict[HoldingResult, Iterator[Mistake]]()
        while True:
            result = tested.test(self.library, topic.name, bindings)
            ends = idle >= MOST_IDLE or self.presses - began >= most_presses
            ends = ends or result.verdict is Verdict.HOLDS or not result.mistakes
            result = (tested.best if ends else tested.find_better(result)) or result
            if result.library is not self.library:
                self._go_back(result.library)
            if ends:
                said = "learned" if result.verdict is Verdict.HOLDS else "does not hold yet"
                self._progress(topic.name, said, self.accounts[topic.name])
                return result
            before = self.presses
            for mistake in islice(left.setdefault(result, iter(result.mistakes)), MOST_LOOKS):
                watch(topic.name, mistake)
                if self.presses > before:
                    break
            idle = idle + 1 if self.presses == before else 0

    def _go_back(self, library: Library) -> None:
        """Go back to the automata of a former library; what was pressed since remains counted."""
        self.library = library
        for name, account in self.accounts.items():
            taught = library.taught.get(name)
            if taught is not None and taught.lesson is not None:
                account.examples = sum(example.is_from_press for example in taught.lesson.examples)

    @property
    def presses(self) -> int:
        """The number of presses of all lessons."""
        return sum(account.presses for account in self.accounts.values())

    def watch_mistake(self, scenario: Scenario, behavior: str, mistake: Mistake) -> None:
        """Watch the automaton that ran at a mistake, from shortly before it on, and press where it is wrong."""
        moment = find_moment(
            Trial(scenario, mistake.seed),
            self.library,
            behavior,
            binding=mistake.binding,
            wrong_s=mistake.wrong_s,
        )
        session = moment.open_session()
        self._expected[moment.name].begin_situation(None)
        self._see(self._topics[moment.name], session, Situation("", moment.targets))

    def _list_situations(self, topic: LessonPlan) -> Iterator[Situation]:
        """Yield the situations of a lesson, then others like them, or in the same practices, without end."""
        yield from topic.cases[: topic.shown]
        for case in cycle(topic.cases):
            anywhere = Situation(case.practice, case.targets)
            yield replace(anywhere, suits=case.suits) if topic.tries_cases else anywhere

    def _see(self, topic: LessonPlan, session: Session, case: Situation) -> tuple[TryResult, bool]:
        """Watch the robot in one situation; return the outcome, and whether it did well without a press."""
        presses = self._person.presses
        verdict = self._watch(topic, session, case)
        well = verdict is TryResult.ENOUGH and self._person.presses == presses
        self._settle(topic.name, session, verdict.name.lower())
        return verdict, well

    def _watch(self, topic: LessonPlan, session: Session, case: Situation) -> TryResult:
        person, expected = self._person, self._expected[topic.name]
        person.expect(expected, session)
        push = case.push
        if push is not None:
            limit_s = min(topic.limit_s, push.within_s)
            person.show(
                session, expected.wish, until=lambda screen: screen.state == push.during, limit_s=limit_s
            )
            person.drive(session, push.behavior, push.seconds)
        return person.watch(
            session,
            expected.wish,
            until=lambda screen: topic.finished(screen) or case.enough(screen),
            limit_s=topic.limit_s,
            patience_s=topic.patience_s,
        )

    def _test(self, topic: LessonPlan, session: Session) -> TryResult:
        session.teach()  # the automaton that was taught before
        targets = session.view().targets
        return self._see(topic, session, Situation("here", targets))[0]

    def _session(self, topic: LessonPlan, lesson: Lesson, case: Situation) -> Session:
        session = super()._session(topic, lesson, case)
        session.teach()
        return session


def choose_teacher(method: str) -> type[ScriptedTeacher]:
    """Return the class of the teacher of a method: `LIVE`, or any other, by the paper's training."""
    return LiveTeacher if method == LIVE else ScriptedTeacher
