"""How fast a driver drives: the share of each behavior's command that the stick is moved to, estimated by episode.

A behavior such as forward commands full speed, but people drive at some speed of their own, which differs from drive to
drive. Were their commands compared with full speed, the difference would count as noise, and as slowness of the hand.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from understudy.addons.recordings.driver_model import DriverModel
from understudy.records.record import Floats, Ints, Record

USUAL_SPREAD = 0.2
"""Standard deviation, before an episode is seen, of the share of full speed at which a driver drives, about 1."""
SLOWEST, FASTEST = 0.5, 1.25
"""The smallest and the largest share of full speed that is searched for."""


def make_full_shares(drive: Record) -> Floats:
    """Return shares [T, C] of 1: each behavior at the speed that it commands."""
    return np.ones(drive.commands.shape)


def scale_aims(drive: Record, aims: Floats, shares: Floats) -> Floats:
    """Return aims [T, C] of which the distance from rest is scaled by shares [T, C]."""
    rest = np.array([each.rest for each in drive.channels])
    scaled: Floats = rest + shares * (aims - rest)
    return scaled


def widen_noise(driver: DriverModel) -> DriverModel:
    """Return a driver model whose noise also covers how much the speeds of drivers differ."""
    return replace(driver, noise=np.hypot(driver.noise, USUAL_SPREAD * driver.extent))


def estimate_shares(
    drive: Record, driver: DriverModel, ticks: Ints, aims: Floats, answers: tuple[Floats, Floats]
) -> Floats:
    """Estimate the share of each episode and channel from ticks whose labels are known.

    It is the mean of the share's distribution if commands have Gaussian noise, and shares are spread about 1.

    Parameters
    ----------
    drive
        The drive.
    driver
        The driver so far.
    ticks
        Ticks whose labels are known, shape [n].
    aims
        What the driver aims at in these ticks, at full speed, shape [n, C].
    answers
        The commands before the driver's answers to these ticks, and the answers, shape [n, C] each.

    Returns
    -------
    array, shape [T, C]
        The share at each tick, which is the same in all ticks of an episode.
    """
    rest = np.array([each.rest for each in drive.channels])
    last, answer = answers
    lever = driver.gain * (aims - rest)
    moved = answer - rest - (1.0 - driver.gain) * (last - rest)
    finite = np.isfinite(lever) & np.isfinite(moved)
    lever, moved = np.where(finite, lever, 0.0), np.where(finite, moved, 0.0)
    shares, prior = make_full_shares(drive), np.square(driver.noise / USUAL_SPREAD)
    for episode in drive.episodes:
        mine = (ticks >= episode.first) & (ticks < episode.end)
        along = (lever[mine] * moved[mine]).sum(axis=0) + prior
        shares[episode.ticks] = along / (np.square(lever[mine]).sum(axis=0) + prior)
    return np.clip(shares, SLOWEST, FASTEST)
