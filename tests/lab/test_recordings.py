"""One hand of the experiment on recordings beside what was published, its driver by hand, and its goals."""

import numpy as np
import pytest

from understudy_lab.recordings import study
from understudy_lab.recordings.driven_goto import FORWARD, LEFT, RIGHT, WAIT, intend
from understudy_lab.recordings.stick_driver import Stick, StickSettings
from understudy_lab.results import differences, load_published
from understudy_lab.runner import row_of


def test_the_first_is_as_published() -> None:
    known = load_published("recordings")
    assert known is not None
    row = row_of(study.EXPERIMENT, {"seed": study.SEEDS[0]})
    assert differences([row], known, study.EXPERIMENT) == []


INTENTS = [  # meant before, distance, bearing, meant after
    (WAIT, 3.0, 0.0, FORWARD),
    (WAIT, 3.0, 1.0, LEFT),
    (FORWARD, 3.0, -0.6, RIGHT),
    (FORWARD, 3.0, 0.4, FORWARD),
    (LEFT, 3.0, 0.4, LEFT),
    (LEFT, 3.0, 0.1, FORWARD),
    (RIGHT, 3.0, -0.1, FORWARD),
    (FORWARD, 0.3, 0.0, WAIT),
]


@pytest.mark.parametrize(("before", "distance", "bearing", "after"), INTENTS)
def test_the_driver(before: int, distance: float, bearing: float, after: int) -> None:
    intent = np.array([before])
    intend(intent, np.array([distance]), np.array([bearing]))
    assert intent.tolist() == [after]


def test_the_hand_is_late_and_overshoots() -> None:
    hand = StickSettings(gain=0.5, noise=0.0, dead_ticks=1, overshoot=0.2, slowest=1.0)
    stick = Stick(hand, 1, 1, np.random.default_rng(0))
    places = [float(stick.move(np.array([[0.5]]))[0, 0]) for _ in range(4)]
    assert places == pytest.approx([0.0, 0.3, 0.45, 0.475])
