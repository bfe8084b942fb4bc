"""Views: one world of many as plain columns, which stay as they are while the world goes on."""

from __future__ import annotations

import sys
from types import FrameType

import numpy as np
from tests.make.run_frames import SQUARE, make_crossing, make_scenario, make_state

from understudy.sim.params import collect_names, make_world_params
from understudy.sim.view import make_world_view


def test_a_world_of_two() -> None:
    made = make_scenario(3)
    rules, names, state = make_world_params(made), collect_names(made), make_state(made)
    empty, full = (make_world_view(state, rules, names, world) for world in (0, 1))
    assert (full.width, full.height, full.time_s) == (12.0, 8.0, 0.0)
    assert np.array_equal(full.robots.x, state.robots["x"][3:])
    assert full.robots.radius.tolist() == [0.2, 0.2, 0.3]
    assert [full.color(color) for color in full.robots.color.tolist()] == ["red", "red", None]
    assert [names.teams[team] for team in full.robots.team.tolist()] == ["scout", "scout", "other"]
    assert full.robots.capacity.tolist() == [5, 5, 0]
    kinds = [names.classes[kind] for kind in full.objects.kind.tolist()]
    assert kinds == ["food", "food", "base", "box"]
    assert full.objects.amount.tolist() == [3, 4, 0, 0]
    assert full.objects.home.tolist() == [False, False, True, False]
    assert full.objects.solid.tolist() == full.objects.pushable.tolist() == [False, False, False, True]
    assert len(full.discs) == len(full.walls) == 1
    assert [polygon.tolist() for polygon in full.polygons] == [[list(corner) for corner in SQUARE]]
    assert len(empty.objects) == len(empty.discs) == len(empty.walls) == len(empty.polygons) == 0


def test_two_polygons_are_told_apart() -> None:
    made = make_scenario(2)
    state = make_state(made)
    state.segments[1, 1] = (1.0, 1.0, 2.0, 1.0, 0)
    state.segments[1, 2] = (2.0, 1.0, 1.0, 2.0, 0)
    state.segments[1, 3] = (1.0, 2.0, 1.0, 1.0, 0)
    triangle, open_line = (
        make_world_view(state, make_world_params(made), collect_names(made), 1),
        state.segments[1, 4],
    )
    assert [len(polygon) for polygon in triangle.polygons] == [3]
    assert triangle.edges[3].tolist() == list(open_line)[:4], "what does not close is an edge all the same"


def test_a_view_stays_as_it_was() -> None:
    first = make_crossing(5)[0].view
    made = make_scenario(3)
    again = make_world_view(make_state(made), make_world_params(made), collect_names(made), 1)
    for part in ("robots", "objects", "discs"):
        for name in getattr(first, part).__slots__:
            one, two = (getattr(getattr(view, part), name) for view in (first, again))
            assert np.array_equal(one, two, equal_nan=one.dtype.kind == "f")


def test_ten_thousand_robots_cost_no_more_than_their_columns() -> None:
    """As many functions are called for ten thousand as for ten."""
    assert count_calls(10_000) == count_calls(10) > 0


def count_calls(robots: int) -> int:
    """How many functions, of Python and in C, are called for a view of so many robots."""
    made, calls = make_scenario(robots), 0
    rules, names, state = make_world_params(made), collect_names(made), make_state(made)

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        make_world_view(state, rules, names, 1)
    finally:
        sys.setprofile(before)
    return calls
