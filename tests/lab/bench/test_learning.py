"""The measurements run and say what they should; the numbers themselves are `make bench`."""

from __future__ import annotations

import pytest

from understudy_lab.bench import learning


def test_the_bench_measures_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learning, "SIZES", {20: 2, 100: 2})
    result = learning.run()
    assert [size["examples"] for size in result["sizes"]] == [20, 100]
    assert all(size["ours_ms"] > 0 and size["sklearn_ms"] > 0 for size in result["sizes"])
    assert [goal["goal_ms"] for goal in result["goals"]] == [10.0, 25.0]
