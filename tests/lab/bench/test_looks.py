"""What is measured of looking at a lesson."""

from __future__ import annotations

from understudy_lab.bench.learning import GOAL_MS, looks, run_looks, two_hundred


def test_everything_that_looks_at_two_hundred_examples_is_measured() -> None:
    lesson = two_hundred()
    result = run_looks(rounds=1)
    assert len(lesson.examples) == result["examples"] == 200
    assert {row["what"] for row in result["looks"]} >= set(looks(lesson))
    assert all(row["passed"] is (row["ms"] <= GOAL_MS) for row in result["looks"])
