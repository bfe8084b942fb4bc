"""Lessons in failing worlds: one novice as published, robots that fail by hand, and factors by hand."""

from __future__ import annotations

from dataclasses import replace
from math import hypot
from typing import Any

import numpy as np
import pytest
from tests.make.goto_sessions import make_goto_session

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT
from understudy.sim.world import World
from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.counterexamples import study
from understudy_lab.counterexamples.study import (
    LESSONS,
    RANGE,
    SCENARIO,
    ArrivalMeasure,
    teach_at_random,
    teach_by_failures,
)
from understudy_lab.novices.novice import UNDERSTOOD, draw_traits
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of

SEEDS = range(20)
DONE_AT_ONCE = (("start", "done", "directive", 5.0, 0.0),)


def learn(lesson: Lesson) -> Library:
    """A library with what a lesson teaches."""
    return Library(FORAGE_KIT).with_automaton(TrainedAutomaton(learn_automaton(lesson), lesson))


@pytest.mark.retrains
def test_the_first_is_as_published() -> None:
    known = load_published("counterexamples")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


FAILING = [  # rows of the lesson, when the robot went wrong
    (DONE_AT_ONCE, 0.1),  # it says so in the first tick
    ((), 0.5),  # it never moves: no progress after the first look
]


@pytest.mark.parametrize(("rows", "wrong_s"), FAILING)
def test_a_robot_fails_by_its_distance_where_it_went_wrong(rows: Any, wrong_s: float) -> None:
    distance_m = World(SCENARIO, SEEDS).sense([RANGE])[RANGE]
    found = ArrivalMeasure(learn(make_goto_session(rows)))([Trial(SCENARIO, seed) for seed in SEEDS])
    far = distance_m >= 0.6
    assert found.failed[far].all()
    assert found.robustness[far] == pytest.approx(-distance_m[far] / hypot(8.0, 8.0))
    assert found.progress_s[far] == pytest.approx(wrong_s)


@pytest.mark.retrains
def test_a_lesson_in_a_failing_world_corrects_it() -> None:
    exercise = EXERCISES["goto"]
    slip = Example(0, "start", (5.0, 0.0), "done", ExampleKind.DIRECTIVE)
    library = learn(replace(exercise.lesson(), examples=(slip,)))
    careful = replace(draw_traits(0), slips=0.0, lapses=0.0, misjudged=0.0, mistake=UNDERSTOOD)
    by_failures = teach_by_failures(exercise.person(careful, 0), library, 0)
    assert len(by_failures.presses) == len(by_failures.found) == LESSONS
    assert by_failures.found[0] > 900
    assert (
        by_failures.found[-1] < 900
    )  # never shown anything else, it learns from five worlds, slowly: the slip stays
    before = ArrivalMeasure(library).count_failures(SEEDS)
    assert ArrivalMeasure(by_failures.library).count_failures(SEEDS) < before
    at_random = teach_at_random(exercise.person(careful, 0), library, by_failures.presses)
    assert at_random.presses == by_failures.presses


FALLS = [  # failures before, after, factor
    (199, 9, 21.0),
    (99, 0, 199.0),
    (0, 0, 1.0),
    (7, 14, 7.5 / 14.5),
]


@pytest.mark.parametrize(("before", "after", "factor"), FALLS)
def test_by_which_factor_failures_fall(before: int, after: int, factor: float) -> None:
    row = {"failures": {study.BEFORE: before, study.FAILURES: after}}
    assert study.compute_fall(row, study.FAILURES) == pytest.approx(factor)


def test_robots_without_a_failing_world_do_not_count() -> None:
    known = load_published("counterexamples")
    assert known is not None
    failing = study.select_failing(known.rows)
    assert all(row["found"][0] for row in failing)
    median = np.median([study.compute_fall(row, study.FAILURES) for row in failing])
    assert known.findings.numbers["falls"][study.FAILURES] == pytest.approx(median, abs=1e-4)
