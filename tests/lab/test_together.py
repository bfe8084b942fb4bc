"""Judging four patrols together: by hand, and a whole teaching in a few short worlds."""

from __future__ import annotations

import numpy as np
import pytest

from understudy_lab.patrol.four_patrols import (
    HOMES,
    TOP,
    goal,
    make_guarding_team,
    summarize_four_patrols,
    table,
    teach_four_patrols,
)
from understudy_lab.patrol.metrics import captures, cycles
from understudy_lab.patrol.practice import SQUAD
from understudy_lab.patrol.tracks import (
    ATTACK,
    DISPERSE,
    HOME,
    OTHER,
    ObjectTrack,
    OrderedActivity,
    PatrolTracks,
    watch,
)

A, D, H = ATTACK, DISPERSE, HOME
GONE = 2  # the first tick without the intruder

CYCLES = [  # what two squads are told in each tick (of 10 s), where their robots are: complete or not
    ((A, A, A, H, D), (A, A, A, H, D), (0.0, 9.0), [True]),
    ((A, A, A, H, D), (A, A, A, H, D), (9.0, 0.0), [False]),  # each at the other's home
    (
        (A, A, H, D, D),
        (D, D, H, H, D),
        (0.0, 9.0),
        [True],
    ),  # one joins in no attack, and the other waits for it
    (
        (A, A) + (D,) * 16,
        (A, A) + (H,) * 14 + (D, D),
        (0.0, 9.0),
        [False],
    ),  # one hunts, the other is long in coming
    ((D, D, D, D, D), (D, D, D, D, D), (0.0, 9.0), []),  # nobody attacked it
    ((A, A, H, H, H) + (H,) * 12 + (D,), (A, A, H, H, H) + (H,) * 12 + (D,), (0.0, 9.0), [False]),  # too late
]


def tracks(first: tuple[int, ...], second: tuple[int, ...], x: tuple[float, float]) -> PatrolTracks:
    """One world with two squads of one robot each, whose homes are 9 m apart; ticks of 10 s."""
    doing = np.array([first, second], np.int8).T[:, None]
    nothing, place = np.zeros(doing.shape, np.bool_), np.zeros(doing.shape[:2], np.float32)
    there = np.arange(len(doing))[:, None] < GONE
    return PatrolTracks(
        tick_s=10.0,
        doing=doing,
        x=np.broadcast_to(np.array(x, np.float32), doing.shape),
        y=np.zeros(doing.shape, np.float32),
        heading=np.zeros(doing.shape, np.float32),
        sees=nothing,
        sees_boss=nothing,
        intruder=ObjectTrack(there, place, place),
        boss=ObjectTrack(~there & False, place, place),
        home=np.array([[0.0, 0.0], [9.0, 0.0]]),
        firsts=np.array([0, 1]),
        obstacles=np.zeros((1, 0, 3)),
    )


@pytest.mark.parametrize(("first", "second", "x", "complete"), CYCLES)
def test_cycles(
    first: tuple[int, ...], second: tuple[int, ...], x: tuple[float, float], complete: list[bool]
) -> None:
    seen = tracks(first, second, x)
    assert captures(seen) == [(0, GONE)]
    assert [cycle.complete for cycle in cycles(seen)] == complete


@pytest.mark.retrains
def test_taught_patrols_hunt_and_gather_together() -> None:
    """And whatever their coordinators have robots do while all are to gather, they are on their way home."""
    taught = teach_four_patrols(210)
    assert sum(taught.by_sort[sort].examples for sort in (SQUAD, TOP)) <= 40
    found = summarize_four_patrols(watch(make_guarding_team(taught.libraries, range(3)), 2400, homes=HOMES))
    assert found["cycles"] >= 6
    assert found["complete"] >= 0.8
    team = make_guarding_team(taught.libraries, [5])
    told = OrderedActivity(team, 1, HOMES)
    assert told.squad.tolist() == [0] * 4 + [1] * 4 + [2] * 4 + [3] * 4
    seen = set()
    for _ in range(900):
        team.tick()
        doing = told.now()
        (state,) = team.layer(TOP).runner.path(0)
        seen.add((state, *np.unique(doing).tolist()))
        assert (doing == HOME).all() == (state == "gather")
    assert {("hunt", DISPERSE), ("gather", HOME)} <= seen
    assert seen <= {("gather", HOME)} | {
        ("hunt", *each) for each in ((D,), (A,), (D, A), (OTHER, D), (OTHER, A), (OTHER, D, A), (OTHER,))
    }


def test_it_is_told() -> None:
    lesson = {"name": "hunt", "examples": 12}
    rows = [
        {
            "together": {
                "complete": share,
                "cycles": 400,
                "cycle_s": [30.0, 70.0],
                "captures_per_hour": 60.0,
                "attackers": 12.0,
                "false_captures": 0.0,
            },
            "lessons": [lesson, {**lesson, "name": "guard", "examples": 7}],
        }
        for share in (0.5, 0.91, 0.99)
    ]
    told = {row[0]: row[1] for row in table(rows).rows}
    assert told["cycles completed"] == "91.0 % (50.0–99.0)"
    assert told["from capture to all told to hunt again, s"] == "30.0 (30.0–30.0)"
    assert told["examples for hunt and guard"] == "19 (19–19)"
    assert goal(rows).held
    assert not goal(rows[:1]).held
