"""A scripted teacher who teaches live: the robot acts by itself from the first press on, and is directed where it errs.

The teacher looks at one situation after the other. A lesson is finished when several in a row needed no press.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import cycle

import numpy as np

from understudy.model.lesson import LearnerOptions, Lesson
from understudy.model.library import Library
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, ReactionTime, SimulatedPerson, TryResult
from understudy_lab.teachers.teacher import (
    FIRST_SEED,
    LOOK_S,
    LessonPlan,
    MakesBody,
    Patience,
    Progress,
    Situation,
    TeachingCost,
    TeachingResult,
    ignore_progress,
    innermost,
)

FIDGETING_S = 4.0
"""A robot that switches `LessonPlan.fidgets` times in so many s is told what it should do there."""


PATIENCE = Patience()
MOST_FAILED = 30
"""The number of situations that may need presses before a lesson is discarded."""


class Expectations:
    """What a person expects of a robot: they direct a switch that they never showed, and others when overdue."""

    def __init__(self, topic: LessonPlan) -> None:
        self._topic = topic
        self._shown: set[tuple[str, str]] = set()
        self._state, self._switched = "", deque[float]([], maxlen=topic.fidgets)

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in; None if it may go on."""
        if self._switched and screen.time_s < self._switched[-1]:  # another world
            self._switched.clear()
        if screen.state != self._state:
            self._state = screen.state
            self._switched.append(screen.time_s)
        fidgets = (
            len(self._switched) == self._topic.fidgets and screen.time_s - self._switched[0] < FIDGETING_S
        )
        if fidgets and screen.flag is None and self._topic.settle is not None:
            return KEEP if (wanted := self._topic.settle(screen)) == screen.state else wanted
        wanted = self._topic.show(screen)
        if wanted is not None and (screen.state, wanted) not in self._shown:
            return wanted
        return (self._topic.complain_live or self._topic.complain)(screen)

    def note_press(self, state: str, wanted: str) -> None:
        """Note that a switch has been shown."""
        self._shown.add((state, wanted))
        self._switched.clear()


class LivePerson(SimulatedPerson):
    """A person who watches a robot that is taught live, and remembers what they have shown it."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime = ReactionTime()) -> None:
        super().__init__(draws, reaction)
        self._expected: Expectations | None = None

    def expect(self, expected: Expectations) -> None:
        """Take up a lesson."""
        self._expected = expected

    def _press(self, session: Session, wished: str) -> None:
        if self._expected is not None:
            self._expected.note_press(session.view().state, wished)
        super()._press(session, wished)


class LiveTeacher:
    """Teaches topics in turn, each as a possible state of the next. The same seed gives the same lessons."""

    def __init__(
        self,
        library: Library,
        make: MakesBody,
        seed: int,
        *,
        options: Mapping[str, LearnerOptions],
        reaction: ReactionTime = ReactionTime(),
        progress: Progress = ignore_progress,
        patience: Patience = PATIENCE,
    ) -> None:
        self.library = library
        self.accounts: dict[str, TeachingCost] = {}
        self._make, self._options, self._progress, self._patience = make, options, progress, patience
        self._draws = np.random.default_rng([seed, 1])
        self._person = LivePerson(self._draws, reaction)
        self._topics: dict[str, LessonPlan] = {}
        self._expected: dict[str, Expectations] = {}

    def teach(self, *topics: LessonPlan) -> TeachingResult:
        """Teach the topics, and return the library with them and the cost."""
        for topic in topics:
            self._topics[topic.name], self.accounts[topic.name] = topic, TeachingCost()
            lesson = topic.choose(self.library)
            lesson = replace(lesson, options=self._options.get(topic.name, lesson.options))
            for _ in range(self._patience.lessons):
                self.accounts[topic.name].lessons += 1
                self._expected[topic.name] = Expectations(topic)
                if self._teach(topic, lesson):
                    break
                self._progress(topic.name, "thrown away, taught again", self.accounts[topic.name])
            self._progress(topic.name, "learned", self.accounts[topic.name])
        return TeachingResult(self.library, self.accounts)

    def _teach(self, topic: LessonPlan, lesson: Lesson) -> bool:
        """Teach one lesson from its beginning, and return whether it succeeded."""
        passed = failed = 0
        for number, case in enumerate(self._list_situations(topic)):
            if passed >= topic.tries and number >= len(topic.cases[: topic.shown]):
                return True
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

    def _list_situations(self, topic: LessonPlan) -> Iterator[Situation]:
        """Yield the situations of a lesson, then others in the same worlds without end."""
        yield from topic.cases[: topic.shown]
        for case in cycle(topic.cases):
            yield Situation(case.practice, case.targets)

    def _see(self, topic: LessonPlan, session: Session, case: Situation) -> tuple[TryResult, bool]:
        """Watch the robot in one situation; return the outcome, and whether it did well without a press."""
        presses = self._person.presses
        verdict = self._watch(topic, session, case)
        well = verdict is TryResult.ENOUGH and self._person.presses == presses
        self._settle(topic.name, session, verdict.name.lower())
        return verdict, well

    def _watch(self, topic: LessonPlan, session: Session, case: Situation) -> TryResult:
        person, expected = self._person, self._expected[topic.name]
        person.expect(expected)
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

    def _correct_below(self, session: Session) -> None:
        """Teach the innermost automaton on in the situation where the robot is lost."""
        name, targets = innermost(self.library, session)
        if name == session.automaton.name or name not in self._topics:
            return
        topic, lesson = self._topics[name], self.library.taught[name].lesson
        if lesson is None:
            return
        below = Session(session.body, self.library, lesson, targets=targets)
        below.teach()
        verdict = self._watch(topic, below, Situation("here", targets))
        self._settle(name, below, verdict.name.lower())

    def _session(self, topic: LessonPlan, lesson: Lesson, case: Situation) -> Session:
        body = self._make(case.practice, FIRST_SEED + int(self._draws.integers(2**40)))
        session = Session(body, self.library, lesson, targets=case.targets)
        while not case.suits(session.view()):
            session.reset(FIRST_SEED + int(self._draws.integers(2**40)))
            self._person.seconds += LOOK_S
        session.teach()
        return session

    def _settle(self, name: str, session: Session, what: str) -> None:
        account, person = self.accounts[name], self._person
        account.seconds, account.presses = account.seconds + person.seconds, account.presses + person.presses
        person.seconds, person.presses = 0.0, 0
        taught = session.make_trained_automaton()
        account.examples = sum(example.is_from_press for example in session.examples)
        self.library = self.library.with_automaton(taught)
        self._progress(name, what, account)
