"""A scripted teacher: it teaches one automaton after the other, with a few demonstrations and then only corrections.

A lesson is finished when several tries in a row needed no correction. A lesson that does not succeed is discarded and
taught again. If the robot goes wrong in an automaton that was taught before, the teacher corrects that one on the spot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TypeAlias

import numpy as np

from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import ReactionTime, Seen, SimulatedPerson, TryResult, Wish

MakesBody: TypeAlias = Callable[[str, int], Body]
"""Makes a world for one robot to practice in, by the name of the practice and a seed; it can be reset."""

LooksBack: TypeAlias = Callable[[Session], None]
"""A function that is applied to a session before the robot tries by itself."""

Accepts: TypeAlias = Callable[[SessionView, str], bool]
"""A judgment of a state that a robot goes to, or comes from, other than the one that a demonstrator would choose."""

MakesPerson: TypeAlias = Callable[[np.random.Generator, ReactionTime], SimulatedPerson]
"""Makes the person who teaches, from what they draw from and how fast they react."""

LOOK_S = 1.0
"""The time in s to look at a new world and reject it."""

PATIENCE_S = 30.0
"""How long a person watches a robot go on in one and the same way before they step in, s."""

FIRST_SEED = 2**40
"""Worlds to practice in have seeds from here on, worlds to be judged in lower ones: no robot is judged where it was
taught."""


@dataclass(frozen=True, slots=True)
class Patience:
    """The limits of a teacher: corrections before a lesson is discarded, and lessons per automaton.

    `seconds` limits the time of all lessons of an automaton together.
    """

    corrections: int = 12
    lessons: int = 3
    seconds: float = inf


@dataclass(frozen=True, slots=True)
class LessonDesign:
    """The parts of a lesson in the paper's training, as `new_lesson` takes them."""

    states: Sequence[str]
    features: Sequence[str]
    flags: Sequence[str] = ()
    parameters: Sequence[str] = ()
    stateless: bool = False

    def make_lesson(self, library: Library, name: str) -> Lesson:
        """Make an empty lesson."""
        return new_lesson(
            library,
            name,
            states=self.states,
            features=self.features,
            flags=self.flags,
            parameters=self.parameters,
            stateless=self.stateless,
            live=False,
        )


@dataclass(frozen=True, slots=True)
class PushAway:
    """A disturbance: while it is in a state, the robot is driven away by a basic behavior for some time."""

    during: str
    behavior: str
    seconds: float
    within_s: float = inf


@dataclass(frozen=True, slots=True)
class Situation:
    """A situation to demonstrate: its practice, the start, the end, and the targets."""

    practice: str
    targets: Mapping[str, str] = field(default_factory=dict)
    suits: Seen = lambda screen: True
    enough: Seen = lambda screen: False
    again: bool = False  # from where it ended, once more
    push: PushAway | None = None


@dataclass(frozen=True, slots=True)
class LessonPlan:
    """The plan for teaching one automaton: its design, the demonstrations, the corrections, and the end of a try.

    The first `shown` of the cases are demonstrated before the first try (None: all). Tries use the practices of all
    cases. In live teaching, `complain_live` and `settle` say what to direct a robot to that errs, or that switches back
    and forth; `accepts` says whether a state that it asks about will do. After `skips_after` situations in a row
    without a press (None: never), the demonstrator skips to where they are needed: where the robot asks, or a property
    that `make_alarm` makes for each situation says that it goes wrong. With `tries_cases` the demonstrator is content
    only after the robot did well in the situations of the cases, one after the other, not anywhere in their practices.
    """

    name: str
    design: LessonDesign
    show: Wish
    complain: Wish
    finished: Seen
    cases: tuple[Situation, ...]
    tries: int
    limit_s: float
    shown: int | None = None
    patience_s: float = PATIENCE_S
    complain_live: Wish | None = None
    settle: Wish | None = None
    fidgets: int = 6
    accepts: Accepts = lambda screen, state: False
    takes_back: Accepts = lambda screen, before: False
    skips_after: int | None = None
    make_alarm: Callable[[], Seen] = lambda: lambda screen: False
    tries_cases: bool = False

    def choose(self, library: Library) -> Lesson:
        """Make the empty lesson."""
        return self.design.make_lesson(library, self.name)


@dataclass(slots=True)
class TeachingCost:
    """The cost of teaching one automaton so far, with discarded lessons; `examples` counts only those kept."""

    examples: int = 0
    presses: int = 0
    seconds: float = 0.0
    lessons: int = 0


@dataclass(frozen=True, slots=True)
class TeachingResult:
    """A taught library, and the cost by automaton."""

    library: Library
    accounts: Mapping[str, TeachingCost]

    @property
    def examples(self) -> int:
        """Press-made examples in all lessons together."""
        return sum(account.examples for account in self.accounts.values())

    @property
    def seconds(self) -> float:
        """Simulated teaching time, s."""
        return sum(account.seconds for account in self.accounts.values())


Progress: TypeAlias = Callable[[str, str, TeachingCost], None]
"""Called as teaching goes on: automaton, what happens, account so far."""


def ignore_progress(name: str, what: str, account: TeachingCost) -> None:
    """Do nothing: the `progress` of a teacher whose progress is not shown."""


class ScriptedTeacher:
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
        patience: Patience = Patience(),
        person: MakesPerson = SimulatedPerson,
        looks_back: LooksBack = lambda session: None,
    ) -> None:
        self.library = library
        self.accounts: dict[str, TeachingCost] = {}
        self._make, self._options, self._progress = make, options, progress
        self._looks_back = looks_back
        self._draws = np.random.default_rng([seed, 1])
        self._person, self._patience = person(self._draws, reaction), patience
        self._topics: dict[str, LessonPlan] = {}

    def teach(self, *topics: LessonPlan) -> TeachingResult:
        """Teach the topics, and return the library with them and the cost."""
        for topic in topics:
            self._topics[topic.name] = topic
            self.accounts[topic.name] = TeachingCost()
            lesson = topic.choose(self.library)
            lesson = replace(lesson, options=self._options.get(topic.name, lesson.options))
            while not self._teach(topic, lesson) and self._goes_on(topic):
                self._progress(topic.name, "thrown away, taught again", self.accounts[topic.name])
            self._progress(topic.name, "learned", self.accounts[topic.name])
        return TeachingResult(self.library, self.accounts)

    def _goes_on(self, topic: LessonPlan) -> bool:
        account, patience = self.accounts[topic.name], self._patience
        return account.lessons < patience.lessons and not self._had_enough(topic)

    def _had_enough(self, topic: LessonPlan) -> bool:
        return self.accounts[topic.name].seconds >= self._patience.seconds

    def _teach(self, topic: LessonPlan, lesson: Lesson) -> bool:
        """Teach one lesson from its beginning, and return whether it succeeded."""
        self.accounts[topic.name].lessons += 1
        for case in topic.cases[: topic.shown]:
            lesson = self._show_case(topic, case, lesson)
        return self._try(topic, lesson)

    def _show_case(self, topic: LessonPlan, case: Situation, lesson: Lesson) -> Lesson:
        session = self._session(topic, lesson, case)
        self._show(topic, case, session)
        if case.again:
            session.restart()
            self._show(topic, case, session)
        return session.lesson

    def _show(self, topic: LessonPlan, case: Situation, session: Session) -> None:
        push = case.push
        if push is not None:
            self._person.show(
                session,
                topic.show,
                until=lambda screen: screen.state == push.during,
                limit_s=min(topic.limit_s, push.within_s),
            )
            self._person.drive(session, push.behavior, push.seconds)
        self._person.show(
            session,
            topic.show,
            until=lambda screen: topic.finished(screen) or case.enough(screen),
            limit_s=topic.limit_s,
        )
        self._settle(topic.name, session, "shown")

    def _try(self, topic: LessonPlan, lesson: Lesson) -> bool:
        passed = corrections = tried = 0
        session = self._session(topic, lesson, self._anywhere(topic, tried))
        while passed < topic.tries:
            verdict = self._test(topic, session)
            if verdict is TryResult.CORRECTED:
                passed, corrections = 0, corrections + 1
                if corrections > self._patience.corrections or self._had_enough(topic):
                    return False
                continue  # from where it is
            passed = passed + 1 if verdict is TryResult.ENOUGH else 0
            tried += 1
            lesson = session.lesson
            if verdict is TryResult.LOST:
                corrections += 1
                if corrections > self._patience.corrections or self._had_enough(topic):
                    return False
                if not self._correct_below(session):
                    lesson = self._show_case(topic, topic.cases[tried % len(topic.cases)], lesson)
            session = self._session(topic, lesson, self._anywhere(topic, tried))
        return True

    def _test(self, topic: LessonPlan, session: Session) -> TryResult:
        self._looks_back(session)
        verdict = self._person.test(
            session, topic.complain, until=topic.finished, limit_s=topic.limit_s, patience_s=topic.patience_s
        )
        self._settle(topic.name, session, verdict.name.lower())
        return verdict

    def _correct_below(self, session: Session) -> bool:
        """Correct the innermost automaton in a lesson of its own, and return whether that was needed."""
        name, targets = innermost(self.library, session)
        if name == session.automaton.name or name not in self._topics:
            return False
        topic, lesson = self._topics[name], self.library.taught[name].lesson
        if lesson is None:
            return False
        below = Session(session.body, self.library, lesson, targets=targets)
        for corrections in range(self._patience.corrections):
            if self._test(topic, below) is not TryResult.CORRECTED:
                return corrections > 0
        return True

    def _session(self, topic: LessonPlan, lesson: Lesson, case: Situation) -> Session:
        """Make a session that continues a lesson in a new world for the case."""
        body = self._make(case.practice, self._seed())
        session = Session(body, self.library, lesson, targets=case.targets)
        while not case.suits(session.view()):
            session.reset(self._seed())
            self._person.seconds += LOOK_S
        return session

    @staticmethod
    def _anywhere(topic: LessonPlan, tried: int) -> Situation:
        case = topic.cases[tried % len(topic.cases)]
        return Situation(case.practice, case.targets)

    def _seed(self) -> int:
        return FIRST_SEED + int(self._draws.integers(2**40))

    def _settle(self, name: str, session: Session, what: str) -> None:
        """Add the cost of a session, and put the automaton into the library."""
        account, person = self.accounts[name], self._person
        account.seconds, account.presses = account.seconds + person.seconds, account.presses + person.presses
        person.seconds, person.presses = 0.0, 0
        taught = session.make_trained_automaton()
        account.examples = sum(example.is_from_press for example in session.examples)
        self.library = self.library.with_automaton(taught)
        self._progress(name, what, account)


def innermost(library: Library, session: Session) -> tuple[str, Binding]:
    """Return the innermost running automaton and its targets."""
    automaton, binding = session.automaton, Binding(session.view().targets)
    for state_name in session.view().path:
        state = automaton.state(state_name)
        if state.behavior is None or state.behavior not in library.taught:
            break
        automaton, binding = library.automaton(state.behavior), state.binding.substitute(binding)
    return automaton.name, binding if automaton.parameters else NOTHING_BOUND
