"""Teaching of one variant with measurements throughout."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from understudy.judging.baseline import LENIENCE
from understudy.judging.behavior_run import ProgramRun
from understudy.judging.outcomes import measure_success
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.value_kinds import Column
from understudy.runtime.body import Body
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.forage import FORAGE_KIT, Forage, ForageSettings
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.hierarchy.forage_variants import LAYERS, OPTIONS
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_expert import evaluate_expert
from understudy_lab.tasks.servo_teacher import (
    FEATURES,
    FOUR_STATES,
    SIDES,
    ApproachAndStopTeacher,
    StatefulServoTeacher,
    show_approach_then_stop,
    topic,
)
from understudy_lab.tasks.soccer import ANYWHERE, Soccer
from understudy_lab.tasks.soccer import kit as soccer_kit
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson, TryResult, has_raised_flag
from understudy_lab.teachers.teacher import (
    LessonDesign,
    LessonPlan,
    MakesBody,
    Patience,
    ScriptedTeacher,
    Situation,
    TeachingCost,
)

Success: TypeAlias = Callable[[Library, int], float]
"""The share of unseen worlds in which a library succeeds; the number of earlier measurements selects the worlds."""

APART = 6
"""The number of new examples between two measurements; the lesson after a successful try is measured, too."""
HELD, WELL = 4, 0.9


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """A measurement during a teaching: examples in all lessons, time in s, and success so far."""

    examples: int
    seconds: float
    success: float


@dataclass
class LearningCurve:
    """The measurements of one teaching, made whenever its teacher reports something new."""

    whole: str
    success: Success
    points: list[CurvePoint] = field(default_factory=list)
    teacher: ScriptedTeacher | None = None

    def person(self, draws: np.random.Generator, reaction: ReactionTime) -> SimulatedPerson:
        """Return a person whose presses cause measurements."""
        return ObservedPerson(draws, reaction, self)

    def pressed(self, session: Session, seconds: float) -> None:
        """Measure after a press in the lesson of the whole task, `seconds` after the accounts were last updated."""
        if self.teacher is None or session.automaton.name != self.whole:
            return
        accounts = self.teacher.accounts
        examples = sum(account.examples for name, account in accounts.items() if name != self.whole)
        examples += sum(example.is_from_press for example in session.examples)
        if not self.points or examples - self.points[-1].examples >= APART:
            seconds += sum(account.seconds for account in accounts.values())
            self._look(
                self.teacher.library.with_automaton(session.make_trained_automaton()), examples, seconds
            )

    def went(self, name: str, what: str, account: TeachingCost) -> None:
        """Measure after a successful try, if there are new examples and the automaton of the whole task exists."""
        if what != "enough" or self.teacher is None or self.whole not in self.teacher.library.taught:
            return
        if not self.points or self._said(self.teacher) > self.points[-1].examples:
            self._look_at(self.teacher)

    def held(self, name: str) -> bool:
        """Measure a finished automaton until a test fails or four in a row succeed, and return whether four did.

        For an automaton that is only a part of the task, return True without a measurement.
        """
        if self.teacher is None or name != self.whole:
            return True
        while self._look_at(self.teacher) >= WELL and find_first_success(self.successes) is None:
            pass
        return find_first_success(self.successes) is not None

    @property
    def successes(self) -> list[float]:
        """The success at each measurement."""
        return [point.success for point in self.points]

    def _look_at(self, teacher: ScriptedTeacher) -> float:
        seconds = sum(account.seconds for account in teacher.accounts.values())
        return self._look(teacher.library, self._said(teacher), seconds)

    def _look(self, library: Library, examples: int, seconds: float) -> float:
        success = self.success(library, len(self.points))
        self.points.append(CurvePoint(examples, round(seconds, 1), success))
        return success

    @staticmethod
    def _said(teacher: ScriptedTeacher) -> int:
        return sum(account.examples for account in teacher.accounts.values())


class ObservedPerson(SimulatedPerson):
    """A person whose presses cause measurements of the learning curve."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime, curve: LearningCurve) -> None:
        super().__init__(draws, reaction)
        self._curve = curve
        self._looked = 0

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        if self.presses != self._looked:  # the last press has acted, or was settled and counting began again
            self._looked = self.presses
            self._curve.pressed(session, self.seconds)
        super()._consider(session, wished, now)


def find_first_success(successes: Sequence[float]) -> int | None:
    """Return the index of the first of four measurements in a row with at least 90 % success, or None."""
    well = [success >= WELL for success in successes]
    starts = (first for first in range(len(well) - HELD + 1) if all(well[first : first + HELD]))
    return next(starts, None)


def success_at(points: Sequence[Sequence[float]], upto: float, what: int) -> float:
    """Return the last success measured by `upto` examples (`what` 0) or seconds (1); 0 before the first."""
    before = [point[2] for point in points if point[what] <= upto]
    return before[-1] if before else 0.0


NAME = "approach_and_stop"
TRIES, SHOWN = 6, 3
LIMIT_S = 60.0
NEAR_M = 0.5
"""The largest distance in m from the ball's center at which stopping counts: 25 cm from rim to rim."""


def topics(search: str) -> Mapping[str, tuple[LessonPlan, ...]]:
    """Return the lesson plans by variant: one automaton for all, or an approach and an automaton above it.

    The teacher first turns to the side `search`, "left" or "right".
    """
    shown, complained = StatefulServoTeacher(search), StatefulServoTeacher(search, 15.0)
    approach = topic(shown, complained, stateful=True, tries=0)
    approach = replace(approach, cases=approach.cases[:SHOWN])  # the rest is tried out in the whole task
    whole = LessonPlan(
        NAME,
        LessonDesign(states=FOUR_STATES, flags=["done"], features=FEATURES),
        ApproachAndStopTeacher(shown),
        ApproachAndStopTeacher(complained),
        has_raised_flag,
        cases=approach.cases,
        tries=TRIES,
        limit_s=LIMIT_S,
    )
    above = LessonPlan(
        NAME,
        LessonDesign(states=["approach"], flags=["done"], features=["blob_size(ball)"]),
        show_approach_then_stop,
        show_approach_then_stop,
        has_raised_flag,
        cases=(Situation("anywhere", suits=_seen), Situation("anywhere", suits=_seen)),
        tries=TRIES,
        limit_s=LIMIT_S,
    )
    return {"one automaton": (whole,), "two automata": (approach, above)}


def _seen(screen: SessionView) -> bool:
    size = screen.features.get("blob_size(ball)", float("nan"))
    return size == size


def success(library: Library, seeds: range) -> float:
    """Return the share of worlds in which the robot stops beside the ball."""
    body = Soccer(seeds, ANYWHERE)
    engine = Engine.from_program(body, link(library, NAME))
    for _ in range(round(LIMIT_S / body.tick_s)):
        engine.tick()
    distance = np.array([_to_ball(body, world) for world in range(len(seeds))])
    said = np.array([engine.path(world)[-1] == "done" for world in range(len(seeds))])
    return float((said & (distance <= NEAR_M)).mean())


def _to_ball(body: Soccer, world: int) -> float:
    view = body.view(world)
    return float(np.hypot(view.robots.x[0] - view.objects.x[0], view.robots.y[0] - view.objects.y[0]))


MOST = 20
"""The largest number of corrections of one part at one failed try."""


class PartwiseTeacher(ScriptedTeacher):
    """A teacher who, after a failed try, tests each part where the robot stands and corrects it or shows it again.

    The innermost automaton is often not the cause: a Harvest that leaves its food too early looks like a failing GoTo.
    If no part fails on the spot, the part that was running is shown again. When the teacher is content, `held` tests
    the lesson in unseen worlds; if it fails there, the teacher makes further tries.
    """

    def __init__(self, *arguments: Any, held: Callable[[str], bool], **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._held = held
        self._shown_again: Counter[str] = Counter()

    def _try(self, topic: LessonPlan, lesson: Lesson) -> bool:
        content = super()._try(topic, lesson)
        while not self._held(topic.name) and content and not self._had_enough(topic):
            content = super()._try(topic, self.library.taught[topic.name].lesson or lesson)
        return content

    def _correct_below(self, session: Session) -> bool:
        """Correct every part of the automaton in this session, and return whether anything was corrected or shown."""
        running = session.automaton.state(session.view().path[0]).behavior
        wrong = False
        for name, plan in self._topics.items():
            if name != session.automaton.name:
                for targets in _targets(plan):
                    wrong = self._put_right(plan, session.body, targets) or wrong
        if not wrong and running in self._topics:
            self._show_again(self._topics[running])  # it goes wrong at times only
            return True
        return wrong

    def _put_right(self, topic: LessonPlan, body: Body, targets: Mapping[str, str]) -> bool:
        lesson = self.library.taught[topic.name].lesson
        if lesson is None:
            return False
        part = Session(body, self.library, lesson, targets=targets)
        if targets and any(value != value for value in part.view().features.values()):
            return False  # its target is not there
        for corrections in range(MOST):
            verdict = self._test(topic, part)
            if verdict is TryResult.CORRECTED:
                continue
            if verdict is TryResult.LOST:
                self._show_again(topic)
            return corrections > 0 or verdict is TryResult.LOST
        return True

    def _show_again(self, topic: LessonPlan) -> None:
        lesson = self.library.taught[topic.name].lesson
        if lesson is not None:
            case = topic.cases[self._shown_again[topic.name] % len(topic.cases)]
            self._shown_again[topic.name] += 1
            self._show_case(topic, case, lesson)


def _targets(topic: LessonPlan) -> list[Mapping[str, str]]:
    """Return the distinct bindings of a topic's parameters in its demonstrations."""
    return list({tuple(case.targets.items()): case.targets for case in topic.cases}.values())


WORLDS, MOST_LOOKS = 30, 1_000
"""The number of unseen worlds in each test, and an upper bound on the tests of a teaching."""
BESIDE = 10 * WORLDS
"""The number of worlds in which the baseline is measured at once."""
MOST_CORRECTIONS, MOST_S = 150, 2_400.0
"""The corrections and seconds after which a teacher gives up on a lesson."""

FORAGING, SERVOING = tuple(LAYERS), ("one automaton", "two automata")


def measure_teaching(way: str, seed: int) -> dict[str, Any]:
    """Return the learning curve of one teaching, its final success and cost, and its lessons."""
    return _forager(way, seed) if way in FORAGING else _servo(way, seed)


def _forager(way: str, seed: int) -> dict[str, Any]:
    return _looked_at(
        "forage", foraging_success, Library(FORAGE_KIT), make_practice, seed, LAYERS[way], OPTIONS
    )


def _servo(way: str, seed: int) -> dict[str, Any]:
    chosen = topics(SIDES[seed % 2])[way]
    return _looked_at(NAME, success, Library(soccer_kit), lambda _, world: Soccer([world]), seed, chosen, {})


def choose_unseen_worlds(seed: int, look: int) -> range:
    """Return the worlds of one test; neither another test nor `worlds_of` uses them."""
    first = WORLDS * (MOST_LOOKS * seed + look)
    return range(first, first + WORLDS)


def _looked_at(
    whole: str,
    success: Callable[[Library, range], float],
    library: Library,
    make: MakesBody,
    seed: int,
    chosen: Sequence[LessonPlan],
    options: Mapping[str, LearnerOptions],
) -> dict[str, Any]:
    curve = LearningCurve(whole, lambda library, look: success(library, choose_unseen_worlds(seed, look)))
    patience = Patience(MOST_CORRECTIONS, lessons=1, seconds=MOST_S)
    teacher = PartwiseTeacher(
        library,
        make,
        seed,
        held=curve.held,
        options=options,
        progress=curve.went,
        patience=patience,
        person=curve.person,
    )
    curve.teacher = teacher
    teaching = teacher.teach(*chosen)
    return {
        "points": [astuple(point) for point in curve.points],
        "success": success(teaching.library, worlds_of(seed)),
        "examples": teaching.examples,
        "presses": sum(account.presses for account in teaching.accounts.values()),
        "teaching_seconds": round(teaching.seconds, 1),
        "lessons": lessons_of(teaching),
    }


def foraging_success(library: Library, seeds: range) -> float:
    """Return the share of worlds in which all food is brought home in time."""
    first = seeds.start % BESIDE
    limits = _limits(seeds.start - first)[first : first + len(seeds)]
    run = ProgramRun(Forage(seeds), link(library, "forage"), library, {})
    return measure_success(run, limits).success


@lru_cache(maxsize=4)
def _limits(first: int) -> Column:
    """Return the time limit in s for this world and the following ones [BESIDE]."""
    expert = evaluate_expert(ForageSettings(), range(first, first + BESIDE))
    limits: Column = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    return limits
