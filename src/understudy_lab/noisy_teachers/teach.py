"""Teaching with faults, recording the learned automaton after each correction, with and without unlearning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from understudy.learning.mislabels import find_mislabels
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.body import Body
from understudy.sim.forage import Forage, make_practice_worlds
from understudy.training.feature_values import list_steady_readings
from understudy.training.reaction_time import estimate_reaction_time
from understudy.training.session import Session
from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.noisy_teachers.slipping_person import SlippingPerson
from understudy_lab.novices.traits import ALIKE, RANGES
from understudy_lab.servoing.trials import search_side
from understudy_lab.tasks.forage_teacher import GOTO
from understudy_lab.tasks.servo_teacher import topics
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.teachers.person import ReactionTime
from understudy_lab.teachers.teacher import LessonPlan, Patience, ScriptedTeacher, TeachingCost

CLEAN, PLAIN, BY_ITSELF, ASKED, UNHURRIED = (
    "no faults",
    "corrected",
    "unlearns by itself",
    "asked",
    "asked, answers without slips",
)
WAYS = (PLAIN, BY_ITSELF, ASKED, UNHURRIED)
MOST = 24
"""The number of corrections after which a teacher gives up."""
IN_A_ROW = 8
"""The number of tries in a row without a correction after which a teacher is content."""


@dataclass(frozen=True)
class NoisyTask:
    """A task: the lesson plan for a seed, and the practice worlds."""

    topic: Callable[[int], LessonPlan]
    make: Callable[[str, int], Body]


TASKS: Mapping[str, NoisyTask] = MappingProxyType(
    {
        "goto": NoisyTask(
            lambda seed: GOTO, lambda practice, world: Forage([world], make_practice_worlds()[practice])
        ),
        "servoing": NoisyTask(
            lambda seed: topics(search_side(seed))["four states"], lambda practice, world: Soccer([world])
        ),
    }
)


@dataclass
class NoisyTeaching:
    """The result of one teaching: the automaton after each number of corrections, and counts."""

    taught: list[TrainedAutomaton] = field(default_factory=list)
    corrections: int = 0
    asked: int = 0
    slipped: int = 0
    held: int = 0


def teach(name: str, way: str, seed: int, chance: float) -> NoisyTeaching:
    """Teach until enough tries in a row need no correction, or the teacher gives up."""
    task, course = TASKS[name], NoisyTeaching()
    topic = replace(task.topic(seed), tries=IN_A_ROW)
    draws = np.random.default_rng([seed, 5])
    people: list[SlippingPerson] = []

    def person(others: np.random.Generator, reaction: ReactionTime) -> SlippingPerson:
        slips = 0.0 if way == CLEAN else chance
        people.append(SlippingPerson(others, reaction, slips, 0.0 if way == UNHURRIED else slips))
        return people[0]

    def looks_back(session: Session) -> None:
        if way in (ASKED, UNHURRIED):
            _ask(session, people[0], topic)
        if way in (ASKED, UNHURRIED, BY_ITSELF):
            _press_earlier(session)
        course.taught[course.corrections :] = [session.make_trained_automaton()]

    def progress(automaton: str, what: str, account: TeachingCost) -> None:
        course.corrections += what in ("corrected", "lost")

    ScriptedTeacher(
        Library(EXERCISES[name].kit),
        task.make,
        seed,
        options={topic.name: LearnerOptions(unlearning=way == BY_ITSELF)},
        reaction=ReactionTime(ALIKE.least_s, 0.0, ALIKE.least_s) if way == CLEAN else _late(draws),
        progress=progress,
        patience=Patience(corrections=MOST, lessons=1),
        person=person,
        looks_back=looks_back,
    ).teach(topic)
    course.asked, course.slipped = people[0].asked, people[0].slipped
    lesson = course.taught[-1].lesson
    course.held = sum(bool(example.quarantined) for example in lesson.examples) if lesson else 0
    return course


def _late(draws: np.random.Generator) -> ReactionTime:
    """Draw a reaction time as slow as a novice's."""
    least, most, _ = RANGES["reaction_s"]
    mean_s = float(draws.uniform(least, most))
    return ReactionTime(mean_s, ALIKE.spread * mean_s, ALIKE.least_s)


def _ask(session: Session, person: SlippingPerson, topic: LessonPlan) -> None:
    """Ask about each suspected slip, the most doubtful first, and correct the example or record that it is right."""
    while odd := find_mislabels(session.lesson, meant=person.meant, most=1):
        example = odd[0].example
        answer = person.answer(odd[0], session.automaton, topic.show)
        if answer != example.next:
            session.correct_slip(example.number, answer)


def _press_earlier(session: Session) -> None:
    """Set the lesson's reaction time to the one estimated from its own examples."""
    estimate = estimate_reaction_time(session.lesson, steady=list_steady_readings(session.body))
    options = session.lesson.options
    if estimate is not None and estimate.least_s > options.reaction_s:
        session.change_design(options=replace(options, reaction_s=estimate.reaction_s))
