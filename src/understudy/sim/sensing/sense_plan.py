"""Sense plans: the measurements that robots need for certain readings, as records for kernels.

A step is one measurement of one sensor; its parts are the readings that it gives. Parts are numbered within their
sensor whether or not they are needed, because their numbers key random draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import ReadingKey
from understudy.sim.kernels.dtypes import PART, STEP, TOUCH
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.schema import Scenario, Sensor
from understudy.sim.sensing.sectors import SECTOR
from understudy.sim.sensing.sensor_row import SensorChannel, SensorContext
from understudy.sim.sensing.sensor_table import find_sensor_row
from understudy.sim.state import Records, WorldParams

STREAMS = 65536
"""The number of streams of random draws per sensor; those of motion and of placing come first."""
NOWHERE = -1
"""The value for no column, no memory, no place and no color."""
DISTURBING = ("noise_a", "noise_b", "misses", "ghosts")


class SensePlan(NamedTuple):
    """The steps of all types of robots; `width` is the number of columns, of which the requested readings are first."""

    steps: Records
    parts: Records
    sectors: Records
    """The SECTOR of each part; meaningful for sonars, lidars and bumpers."""
    of_type: NDArray[np.int64]
    """The first step of each type, and one after its last [T, 2]."""
    width: int
    most_parts: int


@dataclass(frozen=True)
class _SensorSteps:
    sensor: Sensor
    number: int
    parts: tuple[SensorChannel, ...]


@dataclass
class _PlanRows:
    """The records of a plan during its construction, as their fields, and a sector for each part."""

    steps: list[dict[str, Any]] = field(default_factory=list)
    parts: list[dict[str, Any]] = field(default_factory=list)
    sectors: list[Any] = field(default_factory=list)


def _make_records(rows: Sequence[Mapping[str, Any]], dtype: np.dtype[Any]) -> Records:
    records = np.zeros(len(rows), dtype)
    for record, fields in zip(records, rows, strict=True):
        for name, value in fields.items():
            record[name] = value
    return records


class SensePlanner:
    """A maker of sense plans for a scenario: for the readings that a run uses, or for all in a session."""

    def __init__(self, scenario: Scenario, rules: WorldParams, names: ScenarioNames) -> None:
        self.scenario = scenario
        self._by_type = []
        for name, kind in scenario.types.items():
            context = SensorContext(scenario, rules, names, name)
            self._by_type.append(
                [
                    _SensorSteps(each, number, tuple(find_sensor_row(each).channels(each, context)))
                    for number, each in enumerate(kind.sensors)
                ]
            )
        self._slots: dict[tuple[int, ReadingKey], int] = {}
        self.kept: tuple[ReadingKey, ...] = ()
        """The readings that must be measured in every tick, because later readings depend on them."""
        self._remember()

    @property
    def slots(self) -> int:
        """H, the number of values that each robot's sensors remember."""
        return max((slot for slot in self._slots.values()), default=-1) + 2 if self._slots else 0

    @property
    def reach(self) -> float:
        """The largest range of a range sensor or bumper, m, from the center of its robot."""
        types = self.scenario.types.values()
        reached = [find_sensor_row(sensor).reach(sensor) for kind in types for sensor in kind.sensors]
        return max((TOUCH, *reached)) + max(kind.radius for kind in types)

    def keys(self) -> tuple[ReadingKey, ...]:
        """Return all readings that some robot has."""
        measures = (measure for measures in self._by_type for measure in measures)
        return tuple(
            dict.fromkeys(key for measure in measures for part in measure.parts for key in part.keys)
        )

    def plan(self, keys: Sequence[ReadingKey]) -> SensePlan:
        """Make the plan whose first columns are these readings."""
        columns: dict[ReadingKey, list[int]] = {}
        for at, key in enumerate(keys):  # two features may be of one reading
            columns.setdefault(key, []).append(at)
        needed = list(self.kept)
        for measures in self._by_type:
            for measure in measures:
                for part in measure.parts:
                    if part.timed is not None and (part.keys[0] in columns or part.keys[0] in needed):
                        needed.append(part.timed)
        width = len(keys)
        for key in dict.fromkeys(needed):
            if key not in columns:
                columns[key] = [width]
                width += 1
        rows = _PlanRows()
        of_type = []
        for kind, measures in enumerate(self._by_type):
            first = len(rows.steps)
            for measure in sorted(measures, key=lambda each: any(part.timed for part in each.parts)):
                self._add(kind, measure, columns, rows)
            of_type.append((first, len(rows.steps)))
        return SensePlan(
            steps=_make_records(rows.steps, STEP),
            parts=_make_records(rows.parts, PART),
            sectors=np.array(rows.sectors, SECTOR) if rows.sectors else np.zeros(0, SECTOR),
            of_type=np.array(of_type, np.int64).reshape(-1, 2),
            width=width,
            most_parts=max([1, *(step["end"] - step["first"] for step in rows.steps)]),
        )

    def _add(
        self, kind: int, measure: _SensorSteps, columns: dict[ReadingKey, list[int]], rows: _PlanRows
    ) -> None:
        """Add the steps of one sensor: a single one if all its parts are measured together."""
        together = find_sensor_row(measure.sensor).in_one_step
        is_needed = any(key in columns for part in measure.parts for key in part.keys)
        opened = False
        for number, part in enumerate(measure.parts):
            places = [columns.get(key, []) for key in part.keys]
            if part.always and is_needed and not any(places):
                places = [[NOWHERE]]
            step = {
                "place": NOWHERE,
                **part.step,
                "dropout": measure.sensor.dropout,
                "period": self._period(measure.sensor),
                "stream": STREAMS * (2 + measure.number),
                "noisy": measure.sensor.dropout > 0 or any(part.step.get(name, 0) for name in DISTURBING),
            }
            held = self._slots.get((kind, part.keys[0]), NOWHERE)
            for a, b in zip_longest(*places, *[()] * (2 - len(places)), fillvalue=NOWHERE):
                if part.timed is not None:
                    step["index"] = columns[part.timed][0]
                if not (together and opened):
                    rows.steps.append({**step, "first": len(rows.parts)})
                    opened = True
                rows.parts.append(
                    {"color": NOWHERE, **part.part, "a": a, "b": b, "held": held, "number": number}
                )
                rows.sectors.append(part.sector if part.sector is not None else np.zeros((), SECTOR)[()])
                rows.steps[-1]["end"] = len(rows.parts)

    def _period(self, sensor: Sensor) -> int:
        return 1 if sensor.rate_hz is None else max(1, round(1.0 / (sensor.rate_hz * self.scenario.tick_s)))

    def _remember(self) -> None:
        """Assign memory to the readings of slow sensors, and to the times when something was last present."""
        needed: dict[ReadingKey, None] = {}
        for kind, measures in enumerate(self._by_type):
            slot = 0
            for measure in measures:
                for part in measure.parts:
                    if part.timed is None and self._period(measure.sensor) == 1:
                        continue
                    self._slots[kind, part.keys[0]] = slot
                    slot += 2
                    needed.update((key, None) for key in part.keys)
        self.kept = tuple(needed)
