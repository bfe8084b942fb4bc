"""A robot that comes back to its first situation twice in one state repeats itself, as a table."""

from __future__ import annotations

from math import nan, tau

import numpy as np
import pytest

from understudy.coaching.lesson_analysis import FeatureDistances
from understudy.coaching.repetition import find_repetition
from understudy.coaching.situation_text import make_feature_phrases
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Toroidal

HEADING = BoundFeature(Feature("heading", Toroidal(), "heading", unit="rad"))

TURNING = [0.5 * step % tau for step in range(30)]  # 12.6 steps a turn


CASES: list[tuple[list[float], range | None]] = [
    (TURNING, range(12, 25)),  # the second round
    (TURNING[:20], None),  # only one round
    ([2.0] * 30, None),  # it waits
    ([nan] * 30, None),  # it sees nothing
    ([3.0 + 0.2 * (step % 2) for step in range(30)], None),  # it trembles
    ([0.01 * step for step in range(30)], None),  # it gets on
    ([], None),
    ([1.0], None),
]


@pytest.mark.parametrize(("angles", "expected"), CASES)
def test_repetition(angles: list[float], expected: range | None) -> None:
    values = np.array(angles, np.float64).reshape(-1, 1)
    distances = FeatureDistances(make_feature_phrases([HEADING], values), None)
    assert find_repetition(values, distances) == expected
