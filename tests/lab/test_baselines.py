"""What flat learners are given, checked by hand; who shows them what; and a piece beside what was published."""

from __future__ import annotations

from math import nan, pi

import numpy as np
import pytest

from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy_lab.baselines import study
from understudy_lab.baselines.compare import BUDGETS, LEARNERS, WITH, worlds_of
from understudy_lab.baselines.demonstrations import RESTING, RecordedTicks, record_demonstrations
from understudy_lab.baselines.flat_learners import (
    CLASSICAL,
    Inputs,
    InputSpec,
    LabeledTicks,
    Policy,
    lesson_of,
)
from understudy_lab.baselines.flat_teachers import head_for
from understudy_lab.baselines.tasks import EXERCISES
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.teachers.teacher import FIRST_SEED

TICKS = RecordedTicks(
    raw=np.array([[0.0], [1.0], [2.0], [3.0], [4.0]]),
    wanted=np.array([0, 0, 1, 0, 1]),
    before=np.array([RESTING, 0, 0, RESTING, 0]),
    decisions=np.array([1, 1, 2, 3, 4]),
    episode=np.array([0, 0, 0, 1, 1]),
    seconds=np.arange(5.0),
)


def test_ticks_until_the_next_press() -> None:
    assert len(TICKS.upto(1)) == 2
    assert len(TICKS.upto(2)) == 3
    assert len(TICKS.upto(9)) == 5


def test_labels_are_taken_earlier_within_a_world_only() -> None:
    assert TICKS.advanced(1).tolist() == [0, 1, 1, 1, 1]


def test_inputs() -> None:
    raw = np.array([[1.0, 0.0, pi / 2], [3.0, 1.0, nan]])
    found = Inputs([Continuous(), BOOLEAN, Toroidal()], raw)(raw)
    assert found == pytest.approx(np.array([[-1, -1, 1, 0, 0], [1, 1, 0, 0, 1]]))  # sine, cosine, absent


def test_inputs_of_chosen_readings_only() -> None:
    raw = np.array([[1.0, 0.0], [nan, 1.0]])
    assert Inputs([Continuous(), BOOLEAN], raw, [1])(raw).tolist() == [[-1], [1]]


CHOSEN = [  # task, of how many readings those are that its lessons are about
    ("goto", [0, 2], 8),  # range and bearing of the station
    ("forage", list(range(8)), 8),
    ("servoing", [0, 1], 2),
    ("walls", [0, 1], 3),  # sonars to the left and ahead
]


@pytest.mark.parametrize(("name", "chosen", "of"), CHOSEN)
def test_what_was_chosen(name: str, chosen: list[int], of: int) -> None:
    assert (EXERCISES[name].chosen, len(EXERCISES[name].kinds)) == (chosen, of)


def test_earlier_ticks_are_of_the_same_world() -> None:
    found = lesson_of(TICKS, [Continuous()], InputSpec(lags=(2,), before=True), basics=2)
    now, earlier = found.x[:, 0], found.x[:, 1]
    assert earlier.tolist() == [now[0], now[0], now[0], now[3], now[3]]
    assert found.x[:, 2:].argmax(axis=1).tolist() == [2, 0, 0, 2, 0]  # resting is last


def test_a_policy_remembers_what_it_saw_and_did() -> None:
    seen: list[list[float]] = []

    def classify(inputs: np.ndarray) -> np.ndarray:
        seen.append(inputs[0].tolist())
        return np.array([[0.0, 1.0]])

    lesson = LabeledTicks(
        np.zeros((1, 1)),
        np.zeros(1, np.int64),
        np.ones(1),
        np.array([0, 1]),
        Inputs([BOOLEAN], np.zeros((1, 1))),
    )
    policy = Policy(lesson, classify, InputSpec(lags=(1,), before=True), basics=2)
    for reading in (0.0, 1.0, 1.0):
        assert policy.decide(np.array([[reading]])).tolist() == [1]
    assert seen == [[-1, -1, 0, 0, 1], [1, -1, 0, 1, 0], [1, 1, 0, 1, 0]]


HEADING = [  # bearing, what it does now, what they press
    (0.1, "start", "forward"),
    (0.4, "start", "rotate_left"),
    (-0.4, "load_food", "rotate_right"),
    (0.4, "forward", "forward"),
    (0.7, "forward", "rotate_left"),
    (0.4, "rotate_left", None),
    (0.1, "rotate_left", "forward"),
    (2 * pi - 0.4, "rotate_right", None),
    (0.4, "rotate_right", "forward"),  # past it
]


@pytest.mark.parametrize(("bearing", "state", "pressed"), HEADING)
def test_heading_for_something(bearing: float, state: str, pressed: str | None) -> None:
    assert head_for(bearing, state) == pressed


def test_a_flat_demonstration_has_basic_behaviors_and_few_presses() -> None:
    ticks = record_demonstrations(EXERCISES["forage"], 7, 12)
    assert set(ticks.wanted.tolist()) <= set(range(5))
    assert ticks.decisions[-1] > 12
    assert len(ticks) > 10 * ticks.decisions[-1]
    assert (np.diff(ticks.decisions) >= 0).all()
    assert (np.diff(ticks.seconds) >= 0).all()


@pytest.mark.parametrize("name", CLASSICAL)
def test_each_learns_what_a_threshold_tells(name: str) -> None:
    x = np.linspace(-1, 1, 200)[:, None]
    lesson = LabeledTicks(
        x, (x[:, 0] > 0).astype(np.int64), np.ones(200), np.array([0, 1]), Inputs([Continuous()], x)
    )
    shares = CLASSICAL[name](lesson, 0)(np.array([[-0.7], [0.7]]))
    assert shares.argmax(axis=1).tolist() == [0, 1]


def test_nets_learn_each_their_own() -> None:
    pytest.importorskip("torch")
    from understudy_lab.baselines.flat_learners import fit_nets

    x = np.linspace(-1, 1, 200)[:, None]
    up, down = (x[:, 0] > 0).astype(np.int64), (x[:, 0] < 0).astype(np.int64)
    both = [LabeledTicks(x, y, np.ones(200), np.array([0, 1]), Inputs([Continuous()], x)) for y in (up, down)]
    found = [net(np.array([[-0.7], [0.7]])).argmax(axis=1).tolist() for net in fit_nets(both, 0, steps=200)]
    assert found == [[0, 1], [1, 0]]


AFTER = [(29.0, 0.0), (30.0, 0.5), (100.0, 0.5), (500.0, 1.0)]


@pytest.mark.parametrize(("seconds", "success"), AFTER)
def test_success_after_so_many_seconds(seconds: float, success: float) -> None:
    assert study.get_success_at_seconds({"success": [0.5, 1.0], "seconds": [30.0, 101.0]}, seconds) == success


def test_no_learner_is_judged_where_it_was_shown_anything() -> None:
    assert worlds_of(2**30).stop < FIRST_SEED
    assert not set(worlds_of(3)) & set(worlds_of(4))


@pytest.mark.retrains
def test_a_piece_is_as_published() -> None:
    known = load_published("learners")
    assert known is not None
    task = {"task": "goto", "with": "understudy", "seed": study.TEACHINGS[0]}
    assert differences([row_of(study.EXPERIMENT, task)], known, study.EXPERIMENT) == []


def test_findings_without_what_is_not_installed() -> None:
    known = load_published("learners")
    assert known is not None
    alone = study.EXPERIMENT.conclude([row for row in known.rows if row["task"]["with"] == "understudy"])
    assert alone.goals == ()
    assert "nothing to compare" in alone.headline


def test_the_published_learners_are_all_there() -> None:
    known = load_published("learners")
    assert known is not None
    assert {row["task"]["with"] for row in known.rows} == set(WITH)
    learners = {name for row in known.rows for name in row["learners"]}
    assert learners == set(LEARNERS)
    assert all(
        len(each["success"]) == len(BUDGETS) for row in known.rows for each in row["learners"].values()
    )
