"""What a row of the sensor table says of one kind of sensor, and what it is told of the scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, Literal, TypeVar

from understudy.model.features import ReadingKey
from understudy.runtime.body import Reading
from understudy.sim.kernels import dtypes
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.scenario_errors import Limit
from understudy.sim.scenario.schema import RobotType, Scenario, SensorBase, TargetSpec
from understudy.sim.state import WorldParams

S = TypeVar("S", bound=SensorBase)


@dataclass(frozen=True)
class SensorContext:
    """The scenario that a sensor is part of, and the type of robots that carries it."""

    scenario: Scenario
    rules: WorldParams
    names: ScenarioNames
    type_name: str

    @property
    def kind(self) -> RobotType:
        """The type of robots that carries the sensor."""
        return self.scenario.types[self.type_name]

    def locate(self, target: TargetSpec) -> dict[str, Any]:
        """The fields of a STEP that say what a kernel has to locate."""
        classes, signals = self.names.classes, self.names.signals
        if target.nearest is not None:
            index = classes.index(target.nearest)
            if target.unclaimed is None:
                return {"place": dtypes.TO_CLASS, "index": index}
            claim = {"signal": 1 + signals.index(target.unclaimed), "within": target.within}
            return {"place": dtypes.TO_UNCLAIMED, "index": index, **claim}
        if target.object is not None:
            first = int(self.rules.classes["first"][classes.index(target.object)])
            return {"place": dtypes.TO_OBJECT, "index": first + target.index}
        relation = -1  # a color alone: nowhere in particular
        if target.team is not None:
            relation = dtypes.TEAM + self.names.teams.index(target.team)
        elif target.robot is not None:
            relation = {"any": dtypes.ANYONE, "teammate": dtypes.TEAMMATE, "opponent": dtypes.OPPONENT}[
                target.robot
            ]
        if target.signal is not None:
            relation = max(relation, dtypes.ANYONE)
            signal = 1 + signals.index(target.signal)
            return {"place": dtypes.TO_CALLER, "index": relation, "signal": signal}
        return {"place": dtypes.TO_ROBOT, "index": relation}

    def count_ticks(self, seconds: float) -> int:
        """A time as whole ticks, one at least."""
        return max(1, round(seconds / self.scenario.tick_s))


@dataclass(frozen=True)
class SensorChannel:
    """One measurement that can be asked of a sensor: the one or two readings it gives, and how a kernel makes them.

    `step` and `part` are fields of the records STEP and PART, `sector` is a SECTOR.
    """

    keys: tuple[ReadingKey, ...]
    step: Mapping[str, Any]
    part: Mapping[str, int] = field(default_factory=dict)
    sector: Any = None
    always: bool = False
    """Whether it is measured even if nothing asks for its readings, because other channels of the sensor need it."""
    timed: ReadingKey | None = None
    """The reading of another sensor since which it measures the time, and which is measured before it."""


@dataclass(frozen=True)
class RangeArc:
    """An arc in which a range sensor measures the nearest distance: degrees, counter-clockwise from ahead."""

    reading: str
    from_deg: float
    to_deg: float


@dataclass(frozen=True)
class RangeScan:
    """What a range sensor sweeps; for pictures, and for physics, which casts rays in the arcs.

    Distances (m) are from the robot's rim; `range` where nothing is hit. `summarize` makes the sensor's readings
    from the distances in its arcs.
    """

    arcs: tuple[RangeArc, ...]
    range: float
    noise: float
    sees: tuple[Literal["walls", "obstacles", "robots"], ...]
    summarize: Callable[[Sequence[float]], Mapping[str, float]]


@dataclass(frozen=True)
class SensorTopic:
    """A ROS 2 topic on which a simulated robot publishes readings of a sensor.

    `readings` gives for each reading what its table in a robot file says beside the topic and its type;
    `make_fields` makes the fields of a message, but for its header, from the values of these readings.
    """

    name: str
    type: str
    readings: Mapping[str, Mapping[str, Any]]
    make_fields: Callable[[Mapping[str, float]], Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class SensorRow(Generic[S]):
    """Everything that sets one kind of sensor apart from the others."""

    spec: type[S]
    """Its settings in a scenario; `kind` there is the struct's tag."""
    readings: Callable[[S], tuple[Reading, ...]]
    channels: Callable[[S, SensorContext], Iterator[SensorChannel]]
    limits: Mapping[str, Limit] = field(default_factory=dict)
    check: Callable[[S], Iterator[tuple[str, str, str]]] = lambda sensor: iter(())
    """What is wrong with its settings beside numbers beyond their limits: key, problem and remedy."""
    in_one_step: bool = False
    """Whether a kernel measures all its channels at once."""
    kernels: Literal["camera", "ranging"] | None = None
    """The optional part of the kernels that it needs, which worlds without such sensors are compiled without."""
    reach: Callable[[S], float] = lambda sensor: 0.0
    """How far beyond the rim it feels what stands or drives there, m."""
    scan: Callable[[S, RobotType], RangeScan] | None = None
    topics: Callable[[S, RobotType], tuple[SensorTopic, ...]] = lambda sensor, kind: ()


def find_target_color(scenario: Scenario, target: TargetSpec, type_name: str) -> str | None:
    """The color by which a type's camera knows a target: its own, else that of what it stands for."""
    types = scenario.types
    if target.color is not None or target.signal is not None:  # no robot changes its color when it calls
        return target.color
    thing = target.nearest or target.object
    if thing is not None:
        return next((each.color for each in scenario.objects if each.name == thing), None)
    if target.team is not None:
        return next((kind.color for name, kind in types.items() if (kind.team or name) == target.team), None)
    return types[type_name].color if target.robot == "teammate" else None


def list_claimable_targets(scenario: Scenario) -> tuple[str, ...]:
    """The targets that may be claimed or not: those that are objects, but for those that never are."""
    targets = {name: each for name, each in scenario.targets.items() if each.unclaimed is None}
    return tuple(name for name, each in targets.items() if each.nearest or each.object)
