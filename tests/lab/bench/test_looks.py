"""What is measured of looking at a lesson."""

from __future__ import annotations

from understudy.training.trainee import Mode
from understudy_lab.bench.learning import (
    CHECK,
    PRESS,
    looks,
    make_live_session,
    press_repeatedly,
    run_looks,
    two_hundred,
)


def test_everything_that_looks_at_two_hundred_examples_is_measured() -> None:
    lesson = two_hundred()
    result = run_looks(rounds=1)
    assert len(lesson.examples) == result["examples"] == 200
    assert {row["what"] for row in result["looks"]} >= {*looks(lesson), PRESS, CHECK}
    assert all(row["passed"] is (row["ms"] <= row["goal_ms"]) for row in result["looks"])


def test_a_live_press_is_learned_from_and_decided_by() -> None:
    session = make_live_session(two_hundred())
    press = press_repeatedly(session)
    for _ in range(3):
        before = session.view().examples
        press()
        assert session.mode is Mode.LIVE
        assert session.view().examples > before
