"""Sense plans: what robots have to measure so that certain readings are there, as records for kernels.

A step is one measurement of one sensor; its parts are the readings it gives. Parts are numbered within their
sensor whether they are asked for or not, since their numbers key random draws.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from math import inf, radians, tan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import ReadingKey
from understudy.sim.kernels.dtypes import PART, STEP, TOUCH
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.schema import (
    Bumper,
    Camera,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    GripSensor,
    PoseSensor,
    RandomSensor,
    Scenario,
    Sensor,
    Sonar,
    StallSensor,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.sensing.sectors import SECTOR, make_sector
from understudy.sim.state import Records, WorldParams

(
    TO_CLASS, TO_OBJECT, TO_ROBOT, TO_UNCLAIMED, TO_CALLER, SONAR, CAMERA, BUMPER,
    OWN_X, OWN_Y, OWN_HEADING, OWN_SPEED, OWN_TURNING,
    STUCK, STORED, FOOD_HERE, FOOD_LEFT, STATION_HERE, HOLDING, ENOUGH, CHANCE, SINCE, CLAIMED,
) = range(23)  # fmt: skip
"""What a step measures; `_sense_kernels` has the same."""


WALLS, OBSTACLES, ROBOTS = 1, 2, 4
STREAMS = 65536
"""Streams of random draws for a sensor; the first are those of motion, the next those of placing."""
DISTURBING = ("noise_a", "noise_b", "misses", "ghosts")
ANYONE, TEAMMATE, OPPONENT, TEAM = 0, 1, 2, 3
"""Which robots a target means, as `_grid_kernels` has it; a team is TEAM + its index."""


class SensePlan(NamedTuple):
    """The steps of all types of robots; `width` is the number of columns, those asked for first."""

    steps: Records
    parts: Records
    sectors: Records
    """SECTOR of each part; a sonar's or bumper's."""
    of_type: NDArray[np.int64]
    """First step of each type, and one after its last [T, 2]."""
    width: int
    most_parts: int


@dataclass(frozen=True)
class _SensorChannel:
    """One measurement of a sensor that can be asked for: what it gives, and how."""

    keys: tuple[ReadingKey, ...]
    step: dict[str, Any]
    color: int = -1
    sector: Any = None


@dataclass(frozen=True)
class _SensorSteps:
    sensor: Sensor
    number: int
    parts: tuple[_SensorChannel, ...]


class SensePlanner:
    """Makes sense plans of a scenario: for a run those readings that it uses, for a session all."""

    def __init__(self, scenario: Scenario, rules: WorldParams, names: ScenarioNames) -> None:
        self.scenario, self.rules, self.names = scenario, rules, names
        self._by_type = [
            [
                _SensorSteps(each, number, tuple(self._parts(name, each)))
                for number, each in enumerate(kind.sensors)
            ]
            for name, kind in scenario.types.items()
        ]
        self._slots: dict[tuple[int, ReadingKey], int] = {}
        self.kept: tuple[ReadingKey, ...] = ()
        """Readings that have to be measured in every tick, since something remembers them."""
        self._remember()

    @property
    def slots(self) -> int:
        """H, how many numbers each robot remembers."""
        return max((slot for slot in self._slots.values()), default=-1) + 2 if self._slots else 0

    @property
    def reach(self) -> float:
        """How far the farthest sonar or bumper feels, m, from the center of its robot."""
        types = self.scenario.types.values()
        sonars = [sensor for kind in types for sensor in kind.sensors if isinstance(sensor, Sonar)]
        return max((TOUCH, *(sonar.range for sonar in sonars))) + max(kind.radius for kind in types)

    def keys(self) -> tuple[ReadingKey, ...]:
        """All readings that some robot has."""
        measures = (measure for measures in self._by_type for measure in measures)
        return tuple(
            dict.fromkeys(key for measure in measures for part in measure.parts for key in part.keys)
        )

    def plan(self, keys: Sequence[ReadingKey]) -> SensePlan:
        """The plan whose first columns are these readings."""
        columns: dict[ReadingKey, list[int]] = {}
        for at, key in enumerate(keys):  # two features may be of one reading
            columns.setdefault(key, []).append(at)
        needed = list(self.kept)
        for measures in self._by_type:
            for measure in measures:
                for part in measure.parts:
                    if isinstance(measure.sensor, ElapsedSensor) and (
                        part.keys[0] in columns or part.keys[0] in needed
                    ):
                        needed.append((measure.sensor.of, part.keys[0][1]))
        width = len(keys)
        for key in dict.fromkeys(needed):
            if key not in columns:
                columns[key] = [width]
                width += 1
        steps: list[dict[str, Any]] = []
        parts: list[tuple[int, int, int, int, int]] = []
        sectors: list[Any] = []
        of_type = []
        for kind, measures in enumerate(self._by_type):
            first = len(steps)
            for measure in sorted(measures, key=lambda each: isinstance(each.sensor, ElapsedSensor)):
                self._add(kind, measure, columns, steps, parts, sectors)
            of_type.append((first, len(steps)))
        made = np.zeros(len(steps), STEP)
        for row, step in zip(made, steps, strict=True):
            for name, value in step.items():
                row[name] = value
        return SensePlan(
            steps=made,
            parts=np.array(parts, PART) if parts else np.zeros(0, PART),
            sectors=np.array(sectors, SECTOR) if sectors else np.zeros(0, SECTOR),
            of_type=np.array(of_type, np.int64).reshape(-1, 2),
            width=width,
            most_parts=max([1, *(step["end"] - step["first"] for step in steps)]),
        )

    def _add(
        self, kind: int, measure: _SensorSteps, columns: dict[ReadingKey, list[int]], steps: list[dict[str, Any]],
        parts: list[tuple[int, int, int, int, int]], sectors: list[Any],
    ) -> None:  # fmt: skip
        """Add the steps of one sensor: one for all its parts where they are measured together."""
        together = isinstance(measure.sensor, Sonar | Camera | Bumper)
        opened = False
        for number, part in enumerate(measure.parts):
            found = [columns.get(key, []) for key in part.keys]
            step = {
                "place": -1,
                **part.step,
                "dropout": measure.sensor.dropout,
                "period": self._period(measure.sensor),
                "stream": STREAMS * (2 + measure.number),
                "noisy": measure.sensor.dropout > 0 or any(part.step.get(name, 0) for name in DISTURBING),
            }
            held = self._slots.get((kind, part.keys[0]), -1)
            for copy in zip_longest(*found, fillvalue=-1):
                if isinstance(measure.sensor, ElapsedSensor):
                    step["index"] = columns[measure.sensor.of, part.keys[0][1]][0]
                if not (together and opened):
                    steps.append({**step, "first": len(parts)})
                    opened = True
                parts.append((copy[0], copy[1] if len(copy) > 1 else -1, held, part.color, number))
                sectors.append(part.sector if part.sector is not None else np.zeros((), SECTOR)[()])
                steps[-1]["end"] = len(parts)

    def _period(self, sensor: Sensor) -> int:
        return 1 if sensor.rate_hz is None else max(1, round(1.0 / (sensor.rate_hz * self.scenario.tick_s)))

    def _remember(self) -> None:
        """Give memory to what is remembered: the answers of slow sensors, and when something was last there."""
        kept: dict[ReadingKey, None] = {}
        for kind, measures in enumerate(self._by_type):
            slot = 0
            for measure in measures:
                since = isinstance(measure.sensor, ElapsedSensor)
                if not since and self._period(measure.sensor) == 1:
                    continue
                for part in measure.parts:
                    self._slots[kind, part.keys[0]] = slot
                    slot += 2
                    kept.update((key, None) for key in part.keys)
        self.kept = tuple(kept)

    def _parts(self, type_name: str, sensor: Sensor) -> Iterator[_SensorChannel]:
        """What a sensor of a type of robots can give."""
        own = self.scenario.types[type_name]
        targets = self.scenario.targets
        match sensor:
            case Sonar():
                bits = {"walls": WALLS, "obstacles": OBSTACLES, "robots": ROBOTS}
                sees = sum({bits[each] for each in sensor.sees})
                step = {"what": SONAR, "range": sensor.range, "noise_a": sensor.noise, "sees": sees}
                for name, (low, high) in sensor.sectors.items():
                    yield _SensorChannel(
                        ((name, None),), step, sector=make_sector(radians(low), radians(high))
                    )
            case Bumper():
                for name, (low, high) in sensor.sectors.items():
                    yield _SensorChannel(
                        ((name, None),),
                        {"what": BUMPER, "sees": 7},
                        sector=make_sector(radians(low), radians(high)),
                    )
            case Camera():
                half = tan(radians(sensor.view_deg) / 2)
                step = {
                    "what": CAMERA, "range": inf if sensor.range is None else sensor.range, "tan_half": half,
                    "width_px": sensor.width_px, "height_px": sensor.height_px, "least_px": sensor.least_px,
                    "noise_a": sensor.noise_x, "noise_b": sensor.noise_size, "misses": sensor.misses,
                    "ghosts": sensor.ghosts, "nearest": sensor.choose == "nearest",
                }  # fmt: skip
                for name, target in targets.items():
                    color = self.names.color(self.color_of(target, type_name))
                    yield _SensorChannel((("blob_x", name), ("blob_size", name)), step, color=color)
            case TargetLocator():
                named = {
                    name
                    for each in own.sensors
                    if isinstance(each, TargetLocator)
                    for name in each.targets or ()
                }
                mine = (
                    sensor.targets
                    if sensor.targets is not None
                    else [name for name in targets if name not in named]
                )
                for name in mine:
                    step = self._locating(targets[name])
                    step |= {"range": inf if sensor.range is None else sensor.range}
                    step |= {"noise_a": sensor.noise_range, "noise_b": radians(sensor.noise_deg)}
                    yield _SensorChannel((("range", name), ("bearing", name)), step | {"what": step["place"]})
            case PoseSensor():
                noises = (
                    sensor.noise,
                    sensor.noise,
                    radians(sensor.noise_deg),
                    sensor.noise,
                    radians(sensor.noise_deg),
                )
                names = ("x", "y", "heading", "speed", "turning")
                for what, (name, noise) in enumerate(zip(names, noises, strict=True), OWN_X):
                    yield _SensorChannel(((name, None),), {"what": what, "noise_a": noise})
            case StallSensor():
                ticks = max(1, round(sensor.after_s / self.scenario.tick_s))
                yield _SensorChannel((("stuck", None),), {"what": STUCK, "ticks": ticks})
            case CargoSensor():
                for what, name in enumerate(
                    ("food_stored", "food_here", "food_left", "station_here"), STORED
                ):
                    yield _SensorChannel(((name, None),), {"what": what})
            case GripSensor():
                for what, name in ((HOLDING, "holding"), (ENOUGH, "enough")):
                    yield _SensorChannel(((name, None),), {"what": what})
            case ClaimSensor():
                claimed = {"what": CLAIMED, "within": sensor.range, "range": inf}
                for name in (
                    list_claimable_targets(self.scenario) if sensor.targets is None else sensor.targets
                ):
                    signal = {"signal": 1 + self.names.signals.index(sensor.signal)}
                    yield _SensorChannel(
                        ((sensor.name, name),), self._locating(targets[name]) | claimed | signal
                    )
            case RandomSensor():
                ticks = 1 if sensor.every_s is None else max(1, round(sensor.every_s / self.scenario.tick_s))
                yield _SensorChannel(((sensor.name, None),), {"what": CHANCE, "ticks": ticks})
            case ElapsedSensor():
                boolean = self._boolean(type_name, sensor.of)
                for of in self._targets_of(type_name, sensor.of):
                    yield _SensorChannel(((sensor.name, of),), {"what": SINCE, "nearest": boolean})

    def _targets_of(self, type_name: str, reading: str) -> tuple[str | None, ...]:
        """The targets that a reading of a type is of; (None,) where it is of none."""
        others = [
            each for each in self.scenario.types[type_name].sensors if not isinstance(each, ElapsedSensor)
        ]
        keys = [key for each in others for part in self._parts(type_name, each) for key in part.keys]
        return tuple(target for name, target in keys if name == reading)

    def _boolean(self, type_name: str, reading: str) -> bool:
        sensors = self.scenario.types[type_name].sensors
        bumpers = {name for each in sensors if isinstance(each, Bumper) for name in each.sectors}
        claims = {each.name for each in sensors if isinstance(each, ClaimSensor)}
        return reading in bumpers | claims | {"stuck", "food_left", "station_here", "holding", "enough"}

    def _locating(self, target: TargetSpec) -> dict[str, Any]:
        classes, signals = self.names.classes, self.names.signals
        if target.nearest is not None:
            index = classes.index(target.nearest)
            if target.unclaimed is None:
                return {"place": TO_CLASS, "index": index}
            claim = {"signal": 1 + signals.index(target.unclaimed), "within": target.within}
            return {"place": TO_UNCLAIMED, "index": index, **claim}
        if target.object is not None:
            first = int(self.rules.classes["first"][classes.index(target.object)])
            return {"place": TO_OBJECT, "index": first + target.index}
        relation = -1  # a color alone: nowhere in particular
        if target.team is not None:
            relation = TEAM + self.names.teams.index(target.team)
        elif target.robot is not None:
            relation = {"any": ANYONE, "teammate": TEAMMATE, "opponent": OPPONENT}[target.robot]
        if target.signal is not None:
            relation = max(relation, ANYONE)
            return {"place": TO_CALLER, "index": relation, "signal": 1 + signals.index(target.signal)}
        return {"place": TO_ROBOT, "index": relation}

    def color_of(self, target: TargetSpec, type_name: str) -> str | None:
        """The color by which a camera knows a target: its own, else that of what it stands for."""
        types = self.scenario.types
        if target.color is not None or target.signal is not None:  # no robot changes its color when it calls
            return target.color
        thing = target.nearest or target.object
        if thing is not None:
            return next((each.color for each in self.scenario.objects if each.name == thing), None)
        if target.team is not None:
            return next(
                (kind.color for name, kind in types.items() if (kind.team or name) == target.team), None
            )
        return types[type_name].color if target.robot == "teammate" else None


def list_claimable_targets(scenario: Scenario) -> tuple[str, ...]:
    """The targets that may be claimed or not: those that are objects, but for those that never are."""
    targets = {name: each for name, each in scenario.targets.items() if each.unclaimed is None}
    return tuple(name for name, each in targets.items() if each.nearest or each.object)
