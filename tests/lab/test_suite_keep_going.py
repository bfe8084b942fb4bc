"""A teacher goes on with a behavior of the repertoire where its goal is not reached, at the level that goes wrong."""

from __future__ import annotations

import numpy as np

from understudy.properties.run_property import Verdict
from understudy.training.session import Session
from understudy_lab.behavior_suite.keep_going import PersistentTeacher, TaskWorlds
from understudy_lab.behavior_suite.study import FEATS
from understudy_lab.teachers.live_teacher import Expectations
from understudy_lab.teachers.teacher import TeachingCost

CHASE = FEATS["chase"]


def make_teacher() -> PersistentTeacher:
    """Make a teacher of chase, who has shown to drive forward and nothing else."""
    teacher, topic = PersistentTeacher(CHASE, 3), CHASE.topics[0]
    lesson = topic.choose(teacher.library)
    session = Session(CHASE.practice("chase", 1), teacher.library, lesson, targets={"A": "hare"})
    session.direct("forward")
    session.tick()
    teacher.library = teacher.library.with_automaton(session.make_trained_automaton())
    teacher._topics, teacher.accounts = {topic.name: topic}, {topic.name: TeachingCost()}
    teacher._expected = {topic.name: Expectations(topic)}
    return teacher


def test_worlds_are_judged_by_the_goal_of_the_task() -> None:
    library = make_teacher().library
    result = TaskWorlds(CHASE, range(5, 9)).run(library, "chase", {})
    assert not result.works.any()
    assert np.isnan(result.seconds).all()
    assert [each.seed for each in result.mistakes] == [5, 6, 7, 8]
    assert result.mistakes[0].why == f"not: {CHASE.measured}"


def test_the_teacher_presses_where_it_goes_wrong() -> None:
    """It drives away from the hare: it is shown to turn, or to wait."""
    teacher = make_teacher()
    result = teacher.tested.test(teacher.library, "chase", [{}])
    assert result.verdict is Verdict.FAILS
    teacher.watch_whole_world("chase", result.mistakes[0])
    lesson = teacher.library.taught["chase"].lesson
    assert lesson is not None
    shown = {(each.state, each.next) for each in lesson.examples if each.is_shown}
    assert teacher.presses > 0
    assert shown & {("forward", "rotate_left"), ("forward", "rotate_right"), ("forward", "wait")}
