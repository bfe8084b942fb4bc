"""The speed of each episode: by hand, and found in drives of drivers who never drive at full speed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import understudy
from understudy.addons.recordings.driver_model import DriverModel, estimate_gain
from understudy.addons.recordings.speed_share import estimate_shares, scale_aims
from understudy.records.record import Episode, Record
from understudy.runtime.body import Channel

BEHAVIORS = {"forward": {"drive": 1.0}, "back": {"drive": -1.0}, "wait": {"drive": 0.0}}


def make_drive(*episodes: list[float], rest: float = 0.0) -> Record:
    """A drive with one channel, whose commands are given by episode."""
    ends = np.cumsum([0, *map(len, episodes)]).tolist()
    return Record(
        np.arange(ends[-1]) / 10,
        {},
        np.concatenate(episodes)[:, None],
        (Channel("drive", rest),),
        (),
        (),
        0.1,
        tuple(Episode(f"drive {k}", a, b) for k, (a, b) in enumerate(pairwise(ends))),
    )


SHARES = [  # gain, noise, command before, answer, share: (10 gain * moved + prior) / (10 gain^2 + prior), by hand
    (1.0, 0.1, 0.0, 0.7, (7.0 + 0.25) / (10.0 + 0.25)),
    (1.0, 0.001, 0.0, 0.7, 0.7),
    (0.5, 0.1, 0.8, 0.8, (2.0 + 0.25) / (2.5 + 0.25)),  # as far as it gets: moved is 0.8 - 0.5 * 0.8 = 0.4
    (1.0, 0.1, 0.0, 0.1, 0.5),  # never below the slowest
]


@pytest.mark.parametrize(("gain", "noise", "last", "answer", "share"), SHARES)
def test_a_share_by_hand(gain: float, noise: float, last: float, answer: float, share: float) -> None:
    drive, one = make_drive([answer] * 10, [1.0] * 5), np.ones(1)
    driver = DriverModel(noise * one, gain * one, np.inf * one, 0, one)
    columns = np.full((10, 1), last), np.full((10, 1), answer)
    found = estimate_shares(drive, driver, np.arange(10), np.ones((10, 1)), columns)
    assert found[:10, 0] == pytest.approx(share, abs=1e-4)
    assert found[10:, 0] == pytest.approx(1.0)  # nothing is known of the second episode


def test_aims_are_scaled_from_rest() -> None:
    drive = make_drive([0.0], rest=0.2)
    assert scale_aims(drive, np.array([[1.0]]), np.array([[0.5]])) == pytest.approx(0.6)


@given(st.lists(st.floats(0.6, 1.0), min_size=2, max_size=4), st.integers(0, 99))
def test_slow_drivers_are_not_taken_for_slow_hands(speeds: list[float], seed: int) -> None:
    """Labels are right, and neither the hand's gain nor its noise is what the speed alone explains."""
    random = np.random.default_rng(seed)
    truth = np.repeat([0, 2, 1, 0], 25)
    aims = np.array([1.0, -1.0, 0.0])[truth]
    drive = make_drive(*(speed * aims + 0.02 * random.normal(size=100) for speed in speeds))
    library = understudy.Library(understudy.make_drive_kit(drive, BEHAVIORS))
    found = understudy.segment(drive, understudy.make_candidates(library, drive))
    assert (found.labels == np.tile(truth, len(speeds))).mean() >= 0.99
    assert found.driver.gain[0] >= 0.8
    assert found.driver.noise[0] <= 0.05


def test_noise_about_an_aim_says_nothing_about_how_fast_a_hand_is() -> None:
    """A hand goes 60 % of the way to each of twelve aims, with noise; between, it stays for long."""
    random, place = np.random.default_rng(0), 0.0
    rows: list[tuple[float, float, float]] = []
    for tick in range(3600):
        aim, last = float(tick // 300 % 2), rows[-1][2] if rows else 0.0
        place += 0.6 * (aim - place)
        rows.append((aim, last, place + 0.02 * random.standard_normal()))
    aims, before, commands = (np.array(column)[:, None] for column in zip(*rows, strict=True))
    one = np.ones(1)
    driver = DriverModel(0.02 * one, one, np.inf * one, 0, one)
    assert estimate_gain(driver, aims, before, commands) == pytest.approx(0.6)
