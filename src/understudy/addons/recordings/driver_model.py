"""The driver: how the commands of a recording differ from what the driver aims at, estimated from the recording.

In each tick the command moves a share of the way to what the driver aims at, up to a largest step, and some ticks after
the reading that the driver reacts to. What remains is noise. All are estimated for each channel from ticks whose labels
are known; segmentation alternates between labels and estimates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from understudy.records.record import Floats

OUTLIERS = 0.01
"""The share of commands that no candidate explains although its label is right."""
FINEST = 0.005
"""The smallest noise, as a share of a channel's range: what a stick or a number in a file resolves."""
FAR = 0.2
"""The distance from an aim, as a share of a channel's range, from which on a command tells the gain for any noise."""
GAINS = (1.0, 0.8, 0.6, 0.45, 0.35, 0.25, 0.18, 0.13, 0.09)
"""The shares of the way to an aim that are tried."""


@dataclass(frozen=True, slots=True)
class DriverModel:
    """A model of how a driver's commands follow what the driver aims at, by channel.

    Parameters
    ----------
    noise
        Standard deviation of a command about what is expected, in the channel's unit, shape [C].
    gain
        Share of the way to an aim that the command moves in a tick, above 0, at most 1, shape [C].
    rate
        Farthest that the command moves in a tick, in the channel's unit, shape [C]; infinite if it has no limit.
    dead_ticks
        Ticks from what the driver sees to the first change of the command.
    extent
        Range of each channel, shape [C]; a command that nothing explains lies anywhere in it.
    """

    noise: Floats
    gain: Floats
    rate: Floats
    dead_ticks: int
    extent: Floats

    def expect_commands(self, aims: Floats, last: Floats) -> Floats:
        """Return the command that is expected after a tick, from aims [T, C] and the commands before [T, C]."""
        moved: Floats = last + np.clip(self.gain * (aims - last), -self.rate, self.rate)
        return moved

    def measure_fit(self, residuals: Floats) -> Floats:
        """Return the logarithm of the likelihood [...] of residuals [..., C]; NaN residuals count as unexplained."""
        anywhere = np.log(OUTLIERS / self.extent)
        with np.errstate(over="ignore"):
            near = (
                -0.5 * np.square(residuals / self.noise)
                - np.log(self.noise * np.sqrt(2 * np.pi))
                + np.log1p(-OUTLIERS)
            )
        near[np.isnan(near)] = -np.inf
        fit: Floats = np.logaddexp(near, anywhere).sum(axis=-1)
        return fit

    def measure_unexplained_fit(self, away: Floats) -> Floats:
        """Return the logarithm of the likelihood [T] of commands that nothing explains, by how far from rest they are.

        Each channel rests or lies anywhere, both as likely. Else candidates that leave other channels at rest, as most
        commands do, would explain a channel that they say nothing right about.
        """
        near = np.exp(-0.5 * np.square(away / self.noise)) / (self.noise * np.sqrt(2 * np.pi))
        fit: Floats = np.log(0.5 * near + 0.5 / self.extent).sum(axis=-1)
        return fit

    def weigh(self, residuals: Floats) -> Floats:
        """Return how probable it is that each residual [..., C] is noise rather than an outlier."""
        near = np.exp(-0.5 * np.square(residuals / self.noise)) / (self.noise * np.sqrt(2 * np.pi))
        weight: Floats = np.nan_to_num(near / (near + OUTLIERS / self.extent))
        return weight


def guess_driver(commands: Floats, predictions: Floats) -> DriverModel:
    """Make the driver to begin with: one that reacts at once, with much noise.

    Parameters
    ----------
    commands
        Commands, shape [T, C].
    predictions
        Commands that candidates would give, shape [X, T, C].

    Returns
    -------
    DriverModel
        The driver.
    """
    channels = commands.shape[1]
    every = np.concatenate([commands[None], predictions]).reshape(-1, channels)
    every = np.where(np.isnan(every), commands[:1], every)
    extent = np.ptp(every, axis=0)
    extent[extent <= 0] = 1.0
    return DriverModel(0.25 * extent, np.ones(channels), np.full(channels, np.inf), 0, extent)


def guess_still_driver(commands: Floats) -> DriverModel:
    """Guess a driver from commands that nothing explains: from most ticks to the next, only noise changes.

    Parameters
    ----------
    commands
        Commands, shape [T, C].

    Returns
    -------
    DriverModel
        The driver, whose commands follow at once.
    """
    driver = guess_driver(commands, np.empty((0, *commands.shape)))
    steps = np.median(np.abs(np.diff(commands, axis=0)), axis=0)
    # The median of the absolute value of a difference of two normal numbers is 0.954 standard deviations.
    return replace(driver, noise=np.maximum(steps / 0.954, FINEST * driver.extent))


def estimate_noise(driver: DriverModel, residuals: Floats) -> Floats:
    """Estimate the noise [C] from the residuals [n, C] of ticks whose labels are known, by the driver so far."""
    if not len(residuals):
        return driver.noise
    weight = driver.weigh(residuals)
    squares = (weight * np.square(np.nan_to_num(residuals))).sum(axis=0)
    mass = weight.sum(axis=0)
    noise = np.where(mass > 0, np.sqrt(squares / np.maximum(mass, 1e-300)), driver.noise)
    return np.maximum(noise, FINEST * driver.extent)


def estimate_gain(driver: DriverModel, aims: Floats, last: Floats, commands: Floats) -> Floats:
    """Estimate the share of the way [C] that the command moves in a tick, from ticks [n, C] whose aims are known."""
    gains = driver.gain.copy()
    for channel in range(len(gains)):
        ahead = aims[:, channel] - last[:, channel]
        moved = commands[:, channel] - last[:, channel]
        # Nearer to its aim, a command changes by noise, of which nothing follows.
        near = np.clip(
            4 * driver.noise[channel], 3 * FINEST * driver.extent[channel], FAR * driver.extent[channel]
        )
        telling = np.isfinite(ahead) & (np.abs(ahead) > near)
        if telling.sum() < 10:
            continue
        costs = []
        for gain in GAINS:
            apart = np.abs(moved - np.clip(gain * ahead, -driver.rate[channel], driver.rate[channel]))
            costs.append(np.minimum(apart[telling], 4 * driver.noise[channel]).mean())
        gains[channel] = GAINS[int(np.argmin(costs))]
    return gains
