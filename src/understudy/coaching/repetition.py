"""Repetition: a robot that stays in one state and comes back to the same situation again and again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import FeatureDistances

AWAY = 3.0
"""The distance, in largest steps between two moments, beyond which the robot has left a situation."""


def find_repetition(values: NDArray[np.float64], distances: FeatureDistances) -> range | None:
    """Find the moments between which a robot has come back to its first situation for the second time.

    Whether it is back is judged by the largest step between two moments, so that no feature needs a threshold. A robot
    whose features hardly change does not repeat anything: it may well have to wait.

    Parameters
    ----------
    values
        The feature vectors [n, F] of successive moments, all in the same state.
    distances
        The distances between feature vectors.

    Returns
    -------
    range or None
        The indices of the moments of the second round; None if the robot does not come back twice.
    """
    if len(values) == 0:
        return None
    step = float(distances.compute(values[1:], values[:-1]).max(initial=0.0))
    first, away = None, False
    for moment, distance in enumerate(distances.compute(values, values[0]).tolist()):
        if distance > AWAY * step:
            away = True
        elif away and distance <= step:
            if first is not None:
                return range(first, moment)
            first, away = moment, False
    return None
