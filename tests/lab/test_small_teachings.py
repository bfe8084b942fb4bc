"""One small teaching of each study, which always runs: it goes as published, as far as its row says.

The tests that retrain and judge whole rows are marked `retrains` (`conftest.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import msgspec
import pytest

from understudy.model.learner_options import TreeOptions
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT
from understudy_lab.ablation.evaluate import PATIENCE
from understudy_lab.ablation.variants import BASE, VARIANTS
from understudy_lab.ablation.variants import kit as ablation_kit
from understudy_lab.baselines.demonstrations import record_libraries
from understudy_lab.baselines.tasks import EXERCISES
from understudy_lab.behavior_suite import task as behavior_suite
from understudy_lab.behavior_suite.study import FEATS
from understudy_lab.coaching_benefit import tasks as coaching_tasks
from understudy_lab.coaching_benefit.tasks import ALONE, COACHED, teach
from understudy_lab.counterexamples.study import teach_by_failures
from understudy_lab.forage.teach import METHODS, make_practice
from understudy_lab.hierarchy.teach import topics as servo_topics
from understudy_lab.lesson_stats import describe_lesson, lessons_of
from understudy_lab.mixed_teams import study as mixed_teams
from understudy_lab.noisy_teachers import study as noisy_teachers
from understudy_lab.novices.novice import MINUTES_S, Novice, draw_traits
from understudy_lab.patrol import practice as patrol
from understudy_lab.recordings.study import BEHAVIORS
from understudy_lab.results import load_published
from understudy_lab.searches.rare_failures import find_arrival_tests
from understudy_lab.servoing import trials as servoing
from understudy_lab.study import QUESTIONS, Row
from understudy_lab.swarm import practice as swarm
from understudy_lab.tasks.forage_teacher import GOTO, WATCHED
from understudy_lab.tasks.servo_teacher import SIDES
from understudy_lab.tasks.soccer import Soccer
from understudy_lab.tasks.soccer import kit as soccer_kit
from understudy_lab.teachers.live_teacher import LIVE, LiveTeacher
from understudy_lab.teachers.teacher import LessonPlan, ScriptedTeacher, TeachingResult
from understudy_lab.teams import TeamCourse
from understudy_lab.unlearning.datasets import draw_sparse_lesson
from understudy_lab.unlearning.study import LEARNERS, SETTINGS, compare_with_unlearning

Parts = Mapping[str, Any]
"""What a teaching gave, by the name that it has in the published row."""


def find_row(name: str, **task: Any) -> Row:
    """The first published row of these parameters."""
    known = load_published(name)
    assert known is not None
    return next(row for row in known.rows if row["task"].items() >= task.items())


def teach_goto_live(seed: int) -> TeachingResult:
    return LiveTeacher(Library(FORAGE_KIT), make_practice, seed, options=METHODS[LIVE]).teach(GOTO)


def teach_first(teacher: ScriptedTeacher, topic: LessonPlan) -> list[dict[str, Any]]:
    """The lesson of a topic, which is taught first, so that it does not depend on the topics that follow."""
    return lessons_of(teacher.teach(topic))


def teach_first_of_team(course: TeamCourse, row: Row) -> dict[str, list[dict[str, Any]]]:
    """The first lesson of the first type of robots of a team."""
    kind, topics = next(iter(course.topics.items()))
    return {kind: lessons_of(course.teach(row["task"]["seed"], {kind: topics[:1]}).by_sort[kind])}


def teach_forage(row: Row) -> Parts:
    return {"examples": {**row["examples"], "goto": teach_goto_live(row["seed"]).examples}}


def teach_repertoire(row: Row) -> Parts:
    teaching = behavior_suite.teach(FEATS["chase"], row["task"]["seed"])
    return {"lessons": [{**lesson, "attempts": 1} for lesson in lessons_of(teaching)]}


def teach_servoing(row: Row) -> Parts:
    return {"lessons": lessons_of(servoing.teach(row["task"]["seed"], row["task"]["method"]))}


def teach_as_novice(row: Row) -> Parts:
    seed = row["task"]["seed"]
    novice = Novice(draw_traits(seed), seed)
    return {"lessons": [describe_lesson(novice.teach(), MINUTES_S)], "presses": novice.presses}


def teach_coached(row: Row) -> Parts:
    seed, exercise = row["task"]["seed"], coaching_tasks.EXERCISES[row["task"]["exercise"]]
    course = teach(exercise.person(draw_traits(seed), seed), exercise, row["task"]["way"])
    return {"examples": course.made, "followed": course.followed_kinds}


def teach_by_order(row: Row) -> Parts:
    learner = TreeOptions(order=row["task"]["order"])
    options = {name: replace(each, learner=learner) for name, each in METHODS[LIVE].items()}
    teacher = LiveTeacher(Library(FORAGE_KIT), make_practice, row["task"]["seed"], options=options)
    return {"goto_presses": teacher.teach(GOTO).accounts["goto"].presses}


def teach_hierarchy(row: Row) -> Parts:
    seed = row["task"]["seed"]
    topic, _ = servo_topics(SIDES[seed % 2])[row["task"]["way"]]
    teacher = ScriptedTeacher(Library(soccer_kit), lambda _, world: Soccer([world]), seed, options={})
    return {"lessons": [*teach_first(teacher, topic), *row["lessons"][1:]]}


def teach_learner(row: Row) -> Parts:
    last = record_libraries(EXERCISES["goto"], row["task"]["seed"])[-1]
    known = row["learners"]["understudy"]
    found = {"seconds": [*known["seconds"][:-1], round(last.seconds, 1)], "decisions": last.decisions}
    return {"learners": {"understudy": known | found}}


def teach_ablation(row: Row) -> Parts:
    base = VARIANTS[BASE]
    teacher = ScriptedTeacher(
        Library(ablation_kit), make_practice, row["task"]["seed"], options=base.options, patience=PATIENCE
    )
    return {"lessons": [*teach_first(teacher, base.topics[0]), *row["lessons"][1:]]}


def teach_patrol(row: Row) -> Parts:
    return {"lessons": [*teach_first_of_team(patrol.COURSE, row)["pioneer"], *row["lessons"][1:]]}


def teach_roles(row: Row) -> Parts:
    first = teach_first_of_team(mixed_teams.COURSE, row)
    return {"lessons": row["lessons"] | {kind: first[kind] + row["lessons"][kind][1:] for kind in first}}


def teach_swarm(row: Row) -> Parts:
    first = teach_first_of_team(swarm.COURSE, row)
    return {"lessons": row["lessons"] | {kind: first[kind] + row["lessons"][kind][1:] for kind in first}}


def unlearn(row: Row) -> Parts:
    first = SETTINGS[0]
    lesson = draw_sparse_lesson(*first[:3], row["task"]["seed"])
    found = compare_with_unlearning(lesson, LEARNERS[first.learner])
    return {"outcomes": [found, *row["outcomes"][1:]]}


def teach_with_slips(row: Row) -> Parts:
    task = row["task"]
    course = noisy_teachers.teach(task["task"], task["way"], task["seed"], task["chance"])
    return {name: getattr(course, name) for name in ("corrections", "slipped", "asked", "held")}


def teach_for_transfer(row: Row) -> Parts:
    teacher = ScriptedTeacher(Library(FORAGE_KIT), make_practice, row["task"]["seed"], options=WATCHED)
    return {"examples": teacher.teach(GOTO).examples}


def learn_from_recordings(row: Row) -> Parts:
    scores = BEHAVIORS["goto"].learn(row["task"]["seed"]).hits.score()
    return {name: round(scores[name], 4) for name in ("ticks", "answered", "switches")}


def teach_by_counterexamples(row: Row) -> Parts:
    seed, exercise = row["task"]["seed"], coaching_tasks.EXERCISES["goto"]
    traits = draw_traits(seed)
    taught = teach(exercise.person(traits, seed), exercise, ALONE).session.make_trained_automaton()
    library = Library(exercise.kit).with_automaton(taught)
    by_failures = teach_by_failures(exercise.person(traits, seed), library, seed)
    presses = {**row["presses"], "counterexamples": by_failures.presses}
    return {"found": by_failures.found, "presses": presses}


def teach_before_search(row: Row) -> Parts:
    library = teach_goto_live(row["task"]["seed"]).library
    return {"taught": find_arrival_tests(library.taught["goto"].automaton)}


def teach_small(row: Row) -> Parts:
    seed = row["task"]["seed"]
    teacher = ScriptedTeacher(Library(FORAGE_KIT), make_practice, seed, options=WATCHED)
    first, *others = row["lessons"]
    return {"lessons": [{**first, **teach_first(teacher, GOTO)[0]}, *others]}


SMALL: list[tuple[str, dict[str, Any], Callable[[Row], Parts]]] = [
    ("forage", {"method": LIVE}, teach_forage),
    ("repertoire", {"behavior": "chase"}, teach_repertoire),
    ("servoing", {"method": "four states"}, teach_servoing),
    ("novices", {}, teach_as_novice),
    ("coached", {"exercise": "goto", "way": COACHED}, teach_coached),
    ("hierarchy", {"way": "two automata"}, teach_hierarchy),
    ("learners", {"task": "goto", "with": "understudy"}, teach_learner),
    ("ablation", {"variant": BASE}, teach_ablation),
    ("patrol", {}, teach_patrol),
    ("roles", {}, teach_roles),
    ("swarm", {}, teach_swarm),
    ("wrong_feature", {"order": "flags first"}, teach_by_order),
    ("unlearning", {}, unlearn),
    ("slips", {"task": "goto", "way": "corrected"}, teach_with_slips),
    ("transfer", {"behavior": "GoTo"}, teach_for_transfer),
    ("recordings", {"behavior": "goto"}, learn_from_recordings),
    ("counterexamples", {}, teach_by_counterexamples),
    ("searches", {}, teach_before_search),
    ("small", {"source": "forage", "way": "watched"}, teach_small),
]
IN_REAL_TIME = ("networks",)
"""Studies of which nothing is published that a second teaching gives just so."""


@pytest.mark.parametrize(("name", "task", "work"), SMALL, ids=[name for name, _, _ in SMALL])
def test_a_small_teaching_is_as_published(
    name: str, task: dict[str, Any], work: Callable[[Row], Parts]
) -> None:
    row = find_row(name, **task)
    found = msgspec.json.decode(msgspec.json.encode(work(row)))
    assert found == {key: row[key] for key in found}
    assert found


def test_every_study_has_a_small_teaching() -> None:
    assert sorted([*(name for name, _, _ in SMALL), *IN_REAL_TIME]) == sorted(QUESTIONS)
