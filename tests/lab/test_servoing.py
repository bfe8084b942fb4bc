"""One automaton of the servoing experiment beside what was published; its teachers and measures, by hand."""

from __future__ import annotations

from math import nan
from typing import Any

import pytest

from understudy.training.trainee import Mode, SessionView
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.servoing import study
from understudy_lab.servoing.trials import HAND, opposite, search_side, trials
from understudy_lab.tasks.servo_teacher import (
    ApproachAndStopTeacher,
    StatefulServoTeacher,
    StatelessServoTeacher,
    show_approach_then_stop,
    there,
)
from understudy_lab.teachers.teacher import FIRST_SEED


def make_view(state: str, x: float, size: float = 500.0) -> SessionView:
    """The screen of a robot in a state that sees the ball there; NaN: that does not see it."""
    features = {"blob_x(ball)": x, "blob_size(ball)": size if x == x else nan}
    return SessionView(0.0, Mode.TRAINING, state, (state,), None, features, (), {}, None, 0, None, None)


@pytest.mark.retrains
@pytest.mark.parametrize("method", [study.FOUR, HAND])
def test_the_first_is_as_published(method: str) -> None:
    known = load_published("servoing")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"method": method, "seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


FOUR = [  # state, ball's x, what the teacher of four states would have; None: content
    ("start", nan, "left"),
    ("start", 20.0, "forwardL"),
    ("start", 150.0, "forwardR"),
    ("forwardL", nan, "left"),
    ("forwardR", nan, "right"),
    ("forwardL", 85.0, None),  # hardly beyond the middle
    ("forwardL", 100.0, "forwardR"),
    ("forwardR", 60.0, "forwardL"),
    ("left", nan, None),
    ("left", 10.0, None),  # comes into the frame
    ("left", 40.0, "forwardL"),
    ("right", 100.0, "forwardR"),
]


@pytest.mark.parametrize(("state", "x", "wished"), FOUR)
def test_the_teacher_of_four_states(state: str, x: float, wished: str | None) -> None:
    found = StatefulServoTeacher("left")(make_view(state, x))
    assert found == wished or (wished is None and found == state)


POLICY = [  # state, x, without and with turning at the edge, for a teacher who searches to the right
    ("start", nan, "turn_right", "turn_right"),
    ("walk_forward", nan, "turn_right", "turn_right"),
    ("walk_forward", 10.0, "walk_forward", "turn_left"),
    ("walk_forward", 155.0, "walk_forward", "turn_right"),
    ("walk_forward", 80.0, "walk_forward", "walk_forward"),
    ("turn_right", 140.0, None, "turn_right"),
    ("turn_right", 100.0, "walk_forward", "walk_forward"),
]


@pytest.mark.parametrize(("state", "x", "plain", "edges"), POLICY)
def test_the_teachers_of_policies(state: str, x: float, plain: str | None, edges: str | None) -> None:
    if plain is not None:
        assert StatelessServoTeacher("right")(make_view(state, x)) == plain
    assert StatelessServoTeacher("right", 30.0)(make_view(state, x)) == edges


def test_stopping_in_one_automaton_and_in_two() -> None:
    near, far = make_view("forwardL", 70.0, 5000.0), make_view("forwardL", 70.0, 900.0)
    assert there(near)
    assert not there(far)
    stops = ApproachAndStopTeacher(StatefulServoTeacher("left"))
    assert [stops(near), stops(far), stops(make_view("done", 70.0, 5000.0))] == ["done", None, None]
    assert stops(make_view("done", 90.0, 900.0)) == "forwardR"
    assert show_approach_then_stop(make_view("approach", 70.0, 5000.0)) == "done"
    assert show_approach_then_stop(make_view("start", 70.0, 900.0)) == "approach"
    assert show_approach_then_stop(make_view("done", 70.0, 900.0)) == "approach"


def test_the_trials_of_a_seed() -> None:
    body, pushes = trials(5)
    assert body.seeds == tuple(range(500, 550))
    assert set(pushes) == set(range(30, 50))
    assert {push.turned_deg for push in pushes.values()} == {60.0, -60.0}
    assert max(body.seeds) < FIRST_SEED


def make_row(method: str, *, search: str, left: float, right: float | None) -> dict[str, Any]:
    """A row with these times from two positions, and others in which nothing depends on the side."""
    times = {
        "ball left": [left] * 10,
        "ball not visible": [20.0] * 10,
        "ball right": [right] * 10,
        "pushed left": [15.0] * 10,
        "pushed right": [25.0] * 10,
    }
    return {"task": {"method": method, "seed": 0}, "search": search, "times": times}


def test_what_is_summed_up() -> None:
    assert [search_side(seed) for seed in (4, 5)] == ["left", "right"]
    assert opposite("left") == ("ball right", "pushed left")  # pushed left, the ball is lost on the right
    row = make_row(study.FOUR, search="left", left=10.0, right=None)
    assert study.times(row, study.FACED) == [120.0] * 10  # failures count as the limit
    assert study.times(row, study.AWAY) == [15.0] * 10
    assert study.times(row, study.TOWARD) == [25.0] * 10
    assert study.medians([row], study.FOUR, study.EITHER) == [20.0]
    assert study.count_failures([row], study.FOUR) == (10, 50)


def test_a_comparison() -> None:
    rows = [make_row(study.FOUR, search="left", left=10.0, right=10.0 + k / 10) for k in range(20)]
    rows += [make_row(study.LOST, search="left", left=10.0, right=20.0 + k / 5) for k in range(20)]
    found = study.compare_methods(rows, study.FACED)
    assert [found[what] for what in ("ratio", "low", "high")] == pytest.approx([2.0] * 3)
    assert found["p"] < 1e-3
    assert study.compare_methods(rows, study.FACED, with_=study.FOUR, to=study.LOST)[
        "ratio"
    ] == pytest.approx(0.5)
