"""A simulated driver with an analog stick, which the hand moves late and inexactly to what the driver means."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class StickSettings:
    """Settings of a hand that moves a stick.

    Parameters
    ----------
    gain
        Share of the way to its aim that it moves in a tick.
    noise
        Standard deviation of its position, where full deflection is 1.
    dead_ticks
        Ticks from a decision to the first motion.
    overshoot
        By how much, as a share of the way, it goes too far when the aim changes, for `OVERSHOOT_TICKS`.
    slowest
        The smallest share of full speed at which the driver drives or turns; each episode has its own speed.
    """

    gain: float
    noise: float
    dead_ticks: int
    overshoot: float
    slowest: float


OVERSHOOT_TICKS = 2


def draw_stick_settings(seed: int) -> StickSettings:
    """Draw how one of the hands of the experiment moves a stick; the same seed gives the same hand."""
    random = np.random.default_rng([seed, 16])
    return StickSettings(
        gain=float(random.uniform(0.4, 1.0)),
        noise=float(random.uniform(0.01, 0.08)),
        dead_ticks=int(random.integers(0, 3)),
        overshoot=float(random.uniform(0.0, 0.2)),
        slowest=float(random.uniform(0.7, 1.0)),
    )


class Stick:
    """A stick with C axes that one driver holds in each of N worlds.

    Axes among `buttons` are buttons, which are pressed or not. To press one, drivers let the stick go, which springs to
    its center.
    """

    def __init__(
        self,
        hand: StickSettings,
        worlds: int,
        axes: int,
        random: np.random.Generator,
        *,
        buttons: Sequence[int] = (),
    ) -> None:
        self._hand, self._random, self._buttons = hand, random, list(buttons)
        self._speed = random.uniform(hand.slowest, 1.0, (worlds, 1))
        self._queue = deque([np.zeros((worlds, axes))] * hand.dead_ticks)
        self._aim, self._place = np.zeros((worlds, axes)), np.zeros((worlds, axes))
        self._jump, self._since = np.zeros((worlds, axes)), np.full((worlds, 1), OVERSHOOT_TICKS)

    def move(self, aims: Floats) -> Floats:
        """Move the stick toward aims [N, C], and return its position, between -1 and 1."""
        self._queue.append(aims * self._speed)
        aim = self._queue.popleft()
        changed = (aim != self._aim).any(axis=1, keepdims=True)
        self._jump = np.where(changed, aim - self._aim, self._jump)
        self._since = np.where(changed, 0, self._since + 1)
        self._aim = aim
        beyond = np.where(self._since < OVERSHOOT_TICKS, self._hand.overshoot * self._jump, 0.0)
        self._place = self._place + self._hand.gain * (aim + beyond - self._place)
        noise = self._hand.noise * self._random.standard_normal(aim.shape)
        commands: Floats = np.clip(self._place + noise, -1.0, 1.0)
        if self._buttons:
            pressed = (aim[:, self._buttons] > 0.0).astype(np.float64)
            free = pressed.any(axis=1)
            self._place[free] = commands[free] = 0.0
            commands[:, self._buttons] = pressed
        return commands
