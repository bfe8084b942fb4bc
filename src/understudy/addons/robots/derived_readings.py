"""Readings that are not in any message: the sensors "since", "random" and "stuck" of a robot type."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from math import floor, hypot, isnan, nan

import numpy as np

from understudy.model.features import ReadingKey
from understudy.model.value_kinds import BOOLEAN, Continuous
from understudy.runtime.body import Reading
from understudy.sim.scenario.schema import ElapsedSensor, RandomSensor, RobotType, StallSensor
from understudy.sim.sensing.sensor_table import STUCK

NOWHERE = 0.1
"""The share of the commanded distance below which a robot counts as stuck, as in simulated worlds."""


class DerivedReadings:
    """The readings of the sensors "since", "random" and "stuck" of a robot type; call `compute` once per tick.

    A reading that the robot offers itself by such a name takes precedence. Different seeds give different random
    numbers.
    """

    def __init__(
        self,
        robot_type: RobotType | None,
        offered: Sequence[Reading],
        targets: Sequence[str],
        *,
        seed: int = 0,
    ) -> None:
        names = {each.name for each in offered}
        sensors = () if robot_type is None else robot_type.sensors
        self.random_sensors = [
            each for each in sensors if isinstance(each, RandomSensor) and each.name not in names
        ]
        stuck = (each for each in sensors if isinstance(each, StallSensor) and STUCK[0].name not in names)
        self.stall_sensor = next(stuck, None)
        own = (
            *(Reading(each.name, Continuous()) for each in self.random_sensors),
            *(STUCK if self.stall_sensor else ()),
        )
        of_targets = {each.name: each.of_targets for each in (*offered, *own)}
        self.elapsed_sensors = [
            each
            for each in sensors
            if isinstance(each, ElapsedSensor) and each.of in of_targets and each.name not in names
        ]
        self._yes = {each.name for each in (*offered, *own) if each.kind == BOOLEAN}
        self._targets, self._of_targets = targets, of_targets
        self._last: dict[ReadingKey, float] = {}
        self._random, self._drawn = np.random.default_rng(seed), dict[str, tuple[int, float]]()
        self._track: deque[tuple[float, float, float, float]] = deque()
        self.readings: Sequence[Reading] = (
            *(Reading(each.name, Continuous(), "s", of_targets[each.of]) for each in self.elapsed_sensors),
            *own,
        )

    def compute(
        self, now: float, values: Mapping[ReadingKey, float], asked_m_s: float
    ) -> dict[ReadingKey, float]:
        """Compute the readings at time `now` (s).

        `values` has all other readings, and `asked_m_s` is the commanded speed in m/s.
        """
        derived: dict[ReadingKey, float] = {}
        for chance in self.random_sensors:
            derived[chance.name, None] = self._draw(chance, now)
        if self.stall_sensor is not None:
            derived["stuck", None] = self._is_stuck(now, values, asked_m_s, self.stall_sensor.after_s)
        of = {**values, **derived}
        for since in self.elapsed_sensors:
            for target in self._targets if self._of_targets[since.of] else (None,):
                value = of.get((since.of, target), nan)
                if not isnan(value) and (since.of not in self._yes or value > 0):
                    self._last[since.name, target] = now
                derived[since.name, target] = now - self._last.get((since.name, target), nan)
        return derived

    def _draw(self, chance: RandomSensor, now: float) -> float:
        period = floor(now / chance.every_s) if chance.every_s else -1
        before = self._drawn.get(chance.name)
        if before is None or period < 0 or before[0] != period:
            self._drawn[chance.name] = before = period, float(self._random.random())
        return before[1]

    def _is_stuck(
        self, now: float, values: Mapping[ReadingKey, float], asked_m_s: float, after_s: float
    ) -> float:
        """Return 1 if the robot was commanded to drive for `after_s` and hardly moved, else 0; NaN without odometry."""
        x, y = values.get(("x", None), nan), values.get(("y", None), nan)
        if isnan(x) or isnan(y):
            self._track.clear()
            return nan
        if asked_m_s == 0.0:
            self._track.clear()
        self._track.append((now, x, y, abs(asked_m_s)))
        while len(self._track) > 1 and now - self._track[1][0] >= after_s:
            self._track.popleft()
        since, x0, y0, _ = self._track[0]
        if now - since < after_s:
            return 0.0
        wanted = sum(each[3] for each in self._track) / len(self._track) * (now - since)
        # The farthest, not the last place: a robot that drives in a circle comes back, and is not stuck.
        farthest = max(hypot(each[1] - x0, each[2] - y0) for each in self._track)
        return float(farthest < NOWHERE * wanted)
