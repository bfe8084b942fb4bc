"""The repertoire's measures on tracks made by hand, its worlds, and one cheap teaching beside what was published."""

from __future__ import annotations

from math import inf, nan, pi, tau

import numpy as np
import pytest

from understudy_lab.behavior_suite import (
    chase,
    figure_eight,
    random_rooms,
    scavenge,
    triangle,
    wall_following,
    waypoints,
)
from understudy_lab.behavior_suite.study import (
    EXPERIMENT,
    FEATS,
    TEACHINGS,
    describe_discarded_lessons,
    goals_of,
    summarize_teachings,
)
from understudy_lab.behavior_suite.task import make_expert_controller, share_done, worlds_of
from understudy_lab.behavior_suite.tracks import (
    GroundTruth,
    Table,
    count_reached_in_turn,
    count_turns,
    distance_to_line,
    has_held_for,
    length_of,
    measure_gain,
    medians,
    wrap_signed,
)
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of
from understudy_lab.teachers.teacher import FIRST_SEED

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


def tracks(x: Table, y: Table, objects: Table | None = None, tick_s: float = 1.0) -> GroundTruth:
    """Tracks of robots [T, N], and objects that stay [B, K, 2]."""
    things = np.zeros((x.shape[1], 0, 2)) if objects is None else objects
    stay = np.broadcast_to(things, (len(x), *things.shape))
    return GroundTruth(tick_s, x, y, stay[..., 0], stay[..., 1])


def column(*values: float) -> Table:
    return np.array(values, np.float64)[:, None]


# Measures


def test_turns_count_counter_clockwise_and_wrap() -> None:
    angle = np.linspace(0, 2.5 * tau, 200)[:, None]
    found = count_turns(np.cos(angle), np.sin(angle), np.zeros(1), np.zeros(1))
    assert found[-1, 0] == pytest.approx(2.5)
    assert count_turns(np.cos(angle), -np.sin(angle), np.zeros(1), np.zeros(1))[-1, 0] == pytest.approx(-2.5)
    assert abs(count_turns(np.cos(angle) + 5, np.sin(angle), np.zeros(1), np.zeros(1))[-1, 0]) < 0.1


def test_what_is_held_so_long() -> None:
    holds = column(1, 1, 0, 1, 1, 1, 1).astype(bool)
    assert has_held_for(holds, 2)[:, 0].tolist() == [False] * 5 + [True, True]


def test_what_is_gained_begins_anew_where_it_was_lost() -> None:
    gone, near = column(0, 1, 2, 3, 4, 5), column(1, 1, 0, 0, 1, 1).astype(bool)
    assert measure_gain(gone, near)[:, 0].tolist() == [0, 1, 0, 0, 0, 1]


def test_places_count_in_turn_only() -> None:
    reached = np.array([[[0, 1]], [[1, 0]], [[1, 0]], [[0, 1]], [[1, 1]]], np.bool_)
    assert count_reached_in_turn(reached)[:, 0].tolist() == [0, 1, 1, 2, 3]


LINES = [((1.0, -1.0), 1.0, 1.0), ((3.0, 1.0), 1.0, 3.0), ((1.0, 1.5), 0.5, 5.0), ((-3.0, -4.0), 5.0, 0.0)]


@pytest.mark.parametrize(("point", "far", "along"), LINES)
def test_distance_to_a_closed_line(point: tuple[float, float], far: float, along: float) -> None:
    found = distance_to_line(column(point[0]), column(point[1]), SQUARE)
    assert [each[0, 0] for each in found] == pytest.approx([far, along])
    assert length_of(SQUARE) == 8.0


def test_angles_are_signed() -> None:
    assert wrap_signed(np.array([0.1, tau - 0.1])) == pytest.approx([0.1, -0.1])


def test_the_hare_is_to_be_acquired_and_kept() -> None:
    x = np.stack([column(*[0] * 91)[:, 0], np.where(np.arange(91) < 20, 0.0, 9.0)], axis=1)
    found = chase.judge(tracks(x, np.zeros_like(x), np.array([[[0.5, 0.0]], [[0.5, 0.0]]])))
    assert found.seconds[0] == 0.0
    assert np.isnan(found.seconds[1])
    assert found.measures["share of time with it"][1] == pytest.approx(20 / 30)


def test_nobody_has_the_hare_before_it_can_be_reached() -> None:
    stands = tracks(np.zeros((99, 1)), np.zeros((99, 1)), np.array([[[5.6, 0.0]]]))
    assert chase.bound(stands)[0] == 10.0


def test_laps_take_every_post_in_turn() -> None:
    posts = np.array([[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]])
    x, y = column(0, 4, 4, 0, 0, 4, 4, 0), column(0, 0, 4, 4, 0, 0, 4, 4)
    assert waypoints.judge(tracks(x, y, posts)).seconds[0] == 7.0
    assert np.isnan(waypoints.judge(tracks(x[::-1], y[::-1], posts)).seconds[0])
    assert waypoints.bound(tracks(x, y, posts))[0] == pytest.approx((2 * 4 * 3.0 - 3.0) / 0.5)


def test_shortest_lines_to_nine_cans() -> None:
    cans = np.array([[[float(k + 1), 0.0] for k in range(10)]])
    assert scavenge.bound(tracks(column(0), column(0), cans))[0] == pytest.approx(9 * (1 - 0.7) / 0.5)


def test_eights_pass_behind_each_pole_in_turn() -> None:
    objects = np.full((1, figure_eight.slot_of("blue") + 1, 2), nan)
    objects[0, figure_eight.slot_of("red")], objects[0, figure_eight.slot_of("blue")] = (-2, 0), (2, 0)
    angle = np.linspace(pi / 2, pi / 2 + tau, 41)[:-1] + 0.05
    left = np.stack([-2 + np.cos(angle), np.sin(angle)])  # counter-clockwise around the red pole
    whole = np.concatenate([left, -left * [[1], [-1]]], axis=1)
    x, y = (np.tile(each, 3)[:, None] for each in whole)
    found = figure_eight.judge(tracks(x, y, objects))
    assert found.measures["eights"][0] == 2.5
    assert found.seconds[0] == 170.0
    assert np.isnan(figure_eight.judge(tracks(x, -y, objects)).seconds[0])
    assert figure_eight.bound(tracks(x, y, objects))[0] == 4 * 4 / 0.5


def test_a_triangle_is_right_where_sides_and_angles_are() -> None:
    x, y = np.tile([0.0, 2.0, 1.0], (9, 1)), np.tile([0.0, 0.0, 3**0.5], (9, 1))
    assert triangle.judge(tracks(x, y)).seconds[0] == 5.0
    assert np.isnan(triangle.judge(tracks(1.3 * x, 1.3 * y)).seconds[0])
    flat = triangle.judge(tracks(x, 0.5 * y))
    assert np.isnan(flat.seconds[0])
    assert np.degrees(triangle.angles(np.array([3.0, 4.0, 5.0]))) == pytest.approx(
        [36.87, 53.13, 90.0], abs=0.01
    )


def test_around_the_hull() -> None:
    dented = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [2.0, 2.0], [0.0, 2.0]])
    assert length_of(wall_following.hull(dented)) == 8.0


def test_what_a_room_saves_at_its_corners() -> None:
    assert wall_following.compute_corner_savings(SQUARE) == pytest.approx(8 * wall_following.AT_WALL_M)
    assert wall_following.compute_corner_savings(random_rooms.rotate_corners(SQUARE, 1.0)) == pytest.approx(
        8 * wall_following.AT_WALL_M
    )


@pytest.mark.parametrize("make", [random_rooms.room, random_rooms.convex, random_rooms.concave])
@pytest.mark.parametrize("seed", range(5))
def test_plots(make: object, seed: int) -> None:
    plot = make(seed)  # type: ignore[operator]
    assert random_rooms.is_inside(plot.corners, 0.0, 0.0)
    far, _ = distance_to_line(column(plot.x), column(plot.y), plot.corners)
    assert random_rooms.is_inside(plot.corners, plot.x, plot.y) == (make is random_rooms.room)
    assert 0.5 < far[0, 0] < inf
    assert np.abs(plot.corners).max() < random_rooms.WIDE_M / 2


# Teachings

CHEAP = ("chase", "triangle")


@pytest.mark.retrains
@pytest.mark.parametrize("name", CHEAP)
def test_the_first_teaching_is_as_published(name: str) -> None:
    known = load_published("repertoire")
    assert known is not None
    row = row_of(EXPERIMENT, {"behavior": name, "seed": TEACHINGS[0]})
    assert differences([row], known, EXPERIMENT) == []


@pytest.mark.retrains
@pytest.mark.parametrize("name", ["eight", "around_convex"])
def test_the_yardstick_does_it(name: str) -> None:
    trial = FEATS[name].trial(range(10))
    found = make_expert_controller(trial, FEATS[name])
    judged = trial.judge(found)
    assert share_done(judged) >= 0.9
    assert np.nanmin(judged.seconds / trial.bound(found)) >= 1.0


def test_no_robot_is_judged_where_it_was_taught() -> None:
    assert worlds_of(2**30).stop < FIRST_SEED
    assert not set(worlds_of(3)) & set(worlds_of(4))


def test_a_miss_is_said() -> None:
    of = {"success": {"median": 0.9}, "ratio": {"median": 0.9}, "examples": {"median": 61.0}}
    assert [goal.measured for goal in goals_of("wall_left", of) if not goal.held] == ["90%", "61"]


def test_both_criteria_and_lessons_thrown_away() -> None:
    known = load_published("repertoire")
    assert known is not None
    rows = [row for row in known.rows if row["task"]["behavior"] == "patrol"]
    fast, slow, anew = {"ratio": 0.9}, {"ratio": 0.8}, {"lessons": [{"attempts": 2}]}
    found = summarize_teachings([{**rows[0], **what, "success": 0.96} for what in (fast, slow, slow)])
    assert (found["teachings_reaching_95"], found["teachings_reaching_both"]) == (3, 1)
    assert "in 0 of 1 teachings." in describe_discarded_lessons([{**rows[0], "lessons": [{"attempts": 1}]}])
    assert "in 1 of 2 teachings (patrol, " in describe_discarded_lessons([rows[0], {**rows[0], **anew}])


def test_medians_of_what_was_there() -> None:
    columns = np.array([[1.0, np.nan, np.nan], [3.0, 2.0, np.nan], [5.0, 8.0, np.nan]])
    assert medians(columns).tolist()[:2] == [3.0, 5.0]
    assert np.isnan(medians(columns)[2])
