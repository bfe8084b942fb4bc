"""The measurement of reading a bag runs; the number itself is `understudy bench reading`."""

from __future__ import annotations

import pytest

from understudy_lab.bench.reading import GOAL_S, MAPPED, run


def test_reading_is_measured() -> None:
    pytest.importorskip("mcap")
    pytest.importorskip("rosbags")
    result = run(rounds=1, ticks=200)
    assert (result["ticks"], result["topics"], result["mapped"]) == (200, 40, len(MAPPED))
    assert result["passed"] is (result["s"] <= GOAL_S)
