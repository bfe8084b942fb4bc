"""Failing worlds: a flag counts only where it was shown, and a chosen goal counts instead of it."""

from __future__ import annotations

import numpy as np
import pytest
from tests.falsification.test_chosen_goal import ARENA, MOVES, TOUCHES, teach
from tests.falsification.test_lesson_score import FORAGE, LIBRARY, teach_distances

from understudy.addons.checks.falsification.joint_worlds import Trial
from understudy.addons.checks.falsification.property_measure import PropertyMeasure, make_success_measure
from understudy.addons.checks.falsification.trial import GoalMeasure, TrialResults
from understudy.judging.evaluate import make_evaluation_task
from understudy.model.library import Library

STATION = {"A": "station"}
TRIALS = [Trial(FORAGE, seed) for seed in range(5, 11)]


def measure(library: Library) -> tuple[GoalMeasure, TrialResults]:
    made = GoalMeasure(make_evaluation_task(library, "goto", FORAGE, binding=STATION), 60.0)
    return made, made(TRIALS)


def test_where_it_was_shown_the_flag_counts_as_before() -> None:
    _, plain = measure(LIBRARY)  # without a lesson
    _, shown = measure(teach_distances(0.1, 0.2, 0.3, beside=0.5))
    assert not plain.failed.any()
    assert shown.robustness.tolist() == plain.robustness.tolist()


def test_a_world_fails_where_the_flag_is_raised_elsewhere() -> None:
    """It was shown to stop within 5 cm, and stops at 0.3 m: it went wrong a tick before, a quarter of a meter away."""
    _, plain = measure(LIBRARY)
    made, results = measure(teach_distances(0.01, 0.02, 0.03, beside=0.05))
    assert results.failed.all()
    assert results.failed_s.tolist() == plain.progress_s.tolist(), "that is when the flag was raised"
    assert ((results.robustness > -0.25) & (results.robustness < -0.1)).all()
    for row, trial in enumerate(TRIALS[:2]):
        raised_s = float(results.failed_s[row])
        moment = made.find_wrong_moment(trial, until_s=60.0)
        assert (moment.tick, moment.label) == (round(raised_s / 0.1) - 1, "done elsewhere")
        assert moment.sentence.startswith(f"At {raised_s:.1f} s it was done where distance_to(A) was 0.")
        assert moment.sentence.endswith("m, shown at 0.01 to 0.03 m.")


@pytest.mark.parametrize("goal", [TOUCHES, MOVES])
def test_a_chosen_goal_counts(goal: object) -> None:
    made = make_success_measure(teach("rotate_left", goal), "go", ARENA)  # type: ignore[arg-type]
    assert isinstance(made, PropertyMeasure)
    results = made([Trial(ARENA, seed) for seed in range(4)])
    assert results.failed.tolist() == [goal is MOVES] * 4
    assert np.isnan(results.failed_s).all() == (goal is TOUCHES)
