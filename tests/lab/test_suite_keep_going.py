"""A teacher goes on with a behavior of the repertoire where its goal is not reached, at the level that goes wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import nan

import numpy as np
import pytest

from understudy.judging.properties.run_property import Verdict
from understudy.model.library import Library
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite import scavenge, triangle
from understudy_lab.behavior_suite.keep_going import Complaint, PersistentTeacher, TaskWorlds
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


SETTLING = [  # the state, the distance to A (m), the state that leads out of a dead end
    ("forward", 5.0, None),
    ("forward", 9.1, "face"),  # it drives away
    ("backward", 1.0, None),
    ("backward", 0.42, "face"),  # it pushes
    ("done", 2.1, None),
    ("done", 2.2, "face"),  # it stands where the angles are wrong
    ("face", 2.2, None),
]


@pytest.mark.parametrize(("state", "distance", "out"), SETTLING)
def test_a_robot_of_the_triangle_that_would_never_get_on_is_seen(
    state: str, distance: float, out: str | None
) -> None:
    assert triangle.find_way_out(make_screen(state, {"distance_to(A)": distance})) == out


SCAVENGING = [  # the time (s), the state, how long (s), the place of a can in the image, the state that leads out
    (150.0, "search", 5.6, nan, "wander"),
    (150.0, "search", 5.6, 80.0, None),
    (150.0, "search", 5.4, nan, None),
    (150.0, "wander", 5.6, nan, None),
    (50.0, "search", 5.6, nan, None),
]


@pytest.mark.parametrize(("now", "state", "passed", "blob", "out"), SCAVENGING)
def test_a_scavenger_that_goes_in_circles_is_seen(
    now: float, state: str, passed: float, blob: float, out: str | None
) -> None:
    features = {"blob_x(can)": blob, "time_in_state": passed}
    assert scavenge.find_way_out(replace(make_screen(state, features), time_s=now)) == out


def make_screen(state: str, features: Mapping[str, float]) -> SessionView:
    library = Library(CHASE.kit)
    body, lesson = CHASE.practice("chase", 1), CHASE.topics[0].choose(library)
    session = Session(body, library, lesson, targets={"A": "hare"})
    return replace(session.view(), state=state, features=features)


def test_a_dead_end_is_shown_first_and_while_the_robot_is_paused() -> None:
    """It drives forward and nothing else; a way out of that is named, so this is pressed and nothing else is seen."""
    teacher = make_teacher()
    task = replace(CHASE, dead_ends={"chase": lambda view: "wait" if view.state == "forward" else None})
    teacher._task = task
    result = teacher.tested.test(teacher.library, "chase", [{}])
    looked = list[tuple[int, str | None]]()

    def look(_: object, drivers: object, complaint: Complaint, *__: object) -> None:
        looked.append((complaint.agent, complaint.wished))
        teacher.accounts["chase"].presses += 1

    teacher._look_closer = look  # type: ignore[method-assign,assignment]
    teacher.watch_whole_world("chase", result.mistakes[0])
    assert [wished for _, wished in looked] == ["wait"]
