"""Novices with the coach, without, and live: one as published, and when trials succeed from then on."""

from __future__ import annotations

from typing import Any

import pytest

from understudy_lab.coaching_benefit import study
from understudy_lab.coaching_benefit.tasks import ALONE, COACHED, STEPS
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.study import StudyPlan
from understudy_lab.teachers.live_teacher import LIVE


@pytest.mark.retrains
@pytest.mark.parametrize("way", [ALONE, COACHED, LIVE])
def test_one_is_as_published(way: str) -> None:
    known = load_published("coached")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"exercise": "goto", "way": way, "seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


def row(*good: int) -> dict[str, Any]:
    """A robot whose trials all succeed after these numbers of examples."""
    return {"by_step": [float(step in good) for step in STEPS]}


def test_enough_is_where_trials_succeed_from_then_on() -> None:
    assert study.count_examples_needed([row(*STEPS[3:])]) == STEPS[3]
    assert study.count_examples_needed([row(*STEPS[3:5], *STEPS[6:])]) == STEPS[6]
    assert study.count_examples_needed([row(*STEPS[:-1])]) is None
    assert study.count_examples_needed([row(*STEPS)] * 8 + [row(), row()]) is None
    assert study.count_examples_needed([row(*STEPS)] * 9 + [row()]) == STEPS[0]


def test_all_ways_are_the_same_novices() -> None:
    made = study.EXPERIMENT.tasks(StudyPlan(study.SEEDS[:2]))
    assert {(task["way"], task["seed"]) for task in made} == {
        (way, seed) for way in (ALONE, COACHED, LIVE) for seed in study.SEEDS[:2]
    }
