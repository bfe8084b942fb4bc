"""The measurement of segmentation runs; the number itself is `understudy bench segmentation`."""

from __future__ import annotations

import numpy as np

from understudy.addons.recordings.segment import segment
from understudy_lab.bench.segmentation import BEHAVIORS, GOAL_S, make_candidates, make_drive, run


def test_segmentation_is_measured() -> None:
    result = run(rounds=1, ticks=2000)
    assert result["behaviors"] == len(make_candidates()) == BEHAVIORS
    assert result["passed"] is (result["s"] <= GOAL_S)


def test_the_drive_has_the_behaviors_that_are_found() -> None:
    found = segment(make_drive(2000), make_candidates())
    switches = np.flatnonzero(np.diff(found.labels)) + 1
    assert len(switches) > 40
    assert np.minimum(switches % 40, 40 - switches % 40).max() <= 2
