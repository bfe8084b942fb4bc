"""The measurements run and say what they should; the numbers themselves are `make bench`."""

from __future__ import annotations

import pytest

from understudy_lab.bench import learning
from understudy_lab.bench.wall_following import ACTIONS, FARTHEST_M, drive_along_walls


def test_the_bench_measures_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learning, "SIZES", {20: 2, 100: 2})
    monkeypatch.setattr(learning, "drive_along_walls", lambda: drive_along_walls(300))
    monkeypatch.setattr(learning, "WALL_ROUNDS", 1)
    result = learning.run()
    assert [size["examples"] for size in result["sizes"]] == [20, 100]
    assert all(size["ours_ms"] > 0 and size["sklearn_ms"] > 0 for size in result["sizes"])
    assert [goal["goal_ms"] for goal in result["goals"]] == [10.0, 25.0]
    assert result["wall_following"]["ratio"] > 0
    assert all(0.5 < share <= 1 for share in result["wall_following"]["accuracy"].values())


def test_the_wall_follower_shows_all_actions_and_hits_no_wall() -> None:
    values, actions = drive_along_walls(1500)
    assert set(actions.tolist()) == set(range(len(ACTIONS)))
    assert 0.15 < values.min() < 0.5
    assert values.max() == FARTHEST_M
