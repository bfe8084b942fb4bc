"""One teaching in one of the ways, looked at all along."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple
from functools import lru_cache
from typing import Any

import numpy as np

from understudy.analysis.evaluation import LENIENCE, measure_program_outcomes
from understudy.model.kinds import Column
from understudy.model.lesson import LearnerOptions, Lesson
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.runtime.program import link
from understudy.sim.forage import FORAGE_KIT, Forage, ForageSettings
from understudy.training.session import Session
from understudy_lab.forage.teach import make_practice, worlds_of
from understudy_lab.hierarchy.forage_variants import LAYERS, OPTIONS
from understudy_lab.hierarchy.learning_curves import LearningCurve
from understudy_lab.hierarchy.servo_variants import NAME, success, topics
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_expert import evaluate_expert
from understudy_lab.tasks.servo_teacher import SIDES
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.tasks.soccer import kit as soccer_kit
from understudy_lab.teachers.person import TryResult
from understudy_lab.teachers.teacher import LessonPlan, MakesBody, Patience, ScriptedTeacher

MOST = 20
"""So many corrections of one part are borne at one look."""


class PartwiseTeacher(ScriptedTeacher):
    """Where a try is lost, tries every part on the spot, in the order taught; corrects it, or shows it again.

    The innermost automaton alone is often not to blame: a Harvest that leaves its food too early looks like a GoTo.
    Where no part goes wrong on the spot, the one that was running is shown again. Who is content is told whether what
    they taught `held` in worlds that they do not see; where not, they go on with tries until they are content again.
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
        """Put right every part of the automaton in this session; whether that helps."""
        running = session.automaton.state(session.view().path[0]).behavior
        wrong = False
        for name, topic in self._topics.items():
            if name != session.automaton.name:
                for targets in _targets(topic):
                    wrong = self._put_right(topic, session.body, targets) or wrong
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
    """What its parameters stood for when it was shown, each once."""
    return list({tuple(case.targets.items()): case.targets for case in topic.cases}.values())


WORLDS, MOST_LOOKS = 30, 1_000
"""Unseen worlds of each look, and more looks than any teaching has."""
BESIDE = 10 * WORLDS
"""So many worlds the yardstick is put to at once, which takes it little longer than those of one look."""
MOST_CORRECTIONS, MOST_S = 150, 2_400.0
"""A teacher corrects a lesson until it comes right, or has had enough: about 400 examples, 40 minutes."""

FORAGING, SERVOING = tuple(LAYERS), ("one automaton", "two automata")


def measure_teaching(way: str, seed: int) -> dict[str, Any]:
    """One teaching: its learning curve, what it took in the end, and its lessons."""
    return _forager(way, seed) if way in FORAGING else _servo(way, seed)


def _forager(way: str, seed: int) -> dict[str, Any]:
    return _looked_at(
        "forage", foraging_success, Library(FORAGE_KIT), make_practice, seed, LAYERS[way], OPTIONS
    )


def _servo(way: str, seed: int) -> dict[str, Any]:
    chosen = topics(SIDES[seed % 2])[way]
    return _looked_at(NAME, success, Library(soccer_kit), lambda _, world: Soccer([world]), seed, chosen, {})


def choose_unseen_worlds(seed: int, look: int) -> range:
    """The worlds of one look at the teaching of this seed: no two looks share one, nor with `worlds_of`."""
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
    """The share of worlds that are foraged in time."""
    first = seeds.start % BESIDE
    limits = _limits(seeds.start - first)[first : first + len(seeds)]
    return measure_program_outcomes(Forage(seeds), link(library, "forage"), limit_s=limits).success


@lru_cache(maxsize=4)
def _limits(first: int) -> Column:
    """How long a robot may take, s, in this world and the next ones [BESIDE]."""
    expert = evaluate_expert(ForageSettings(), range(first, first + BESIDE))
    limits: Column = LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s)
    return limits
