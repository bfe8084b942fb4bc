"""The types of the sensor table: a row that describes one kind of sensor, and the context that it is used in."""

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
    """The scenario that contains a sensor, and the type of robots that carries it."""

    scenario: Scenario
    rules: WorldParams
    names: ScenarioNames
    type_name: str

    @property
    def robot_type(self) -> RobotType:
        """The type of robots that carries the sensor."""
        return self.scenario.types[self.type_name]

    def locate(self, target: TargetSpec) -> dict[str, Any]:
        """Return the fields of a STEP that describe which thing a kernel has to locate for a target."""
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
        """Return a time in s as a whole number of ticks, at least one."""
        return max(1, round(seconds / self.scenario.tick_s))


@dataclass(frozen=True)
class SensorChannel:
    """One measurement of a sensor: the one or two readings that it yields, and how a kernel computes them.

    `step`, `part` and `sector` are the content of the records STEP, PART and SECTOR (`sim/kernels/dtypes.py`) that the
    kernel reads.
    """

    keys: tuple[ReadingKey, ...]
    step: Mapping[str, Any]
    part: Mapping[str, int] = field(default_factory=dict)
    sector: Any = None
    always: bool = False
    """Whether it is measured even if none of its readings is needed, because other channels of the sensor need it."""
    timed: ReadingKey | None = None
    """The reading, of another sensor, since whose presence it measures the time; that is measured before it."""


@dataclass(frozen=True)
class RangeArc:
    """An arc in which a range sensor measures the least distance: degrees, counter-clockwise from ahead."""

    reading: str
    from_deg: float
    to_deg: float


@dataclass(frozen=True)
class RangeScan:
    """The arcs of a range sensor, for pictures and for physics, which casts rays in them.

    Distances (m) are from the robot's rim, and `range` if nothing is hit. `summarize` computes the sensor's readings
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

    `readings` gives the settings of each reading in a robot file, without the topic and its type. `make_fields` makes
    the fields of a message, without its header, from the values of these readings.
    """

    name: str
    type: str
    readings: Mapping[str, Mapping[str, Any]]
    make_fields: Callable[[Mapping[str, float]], Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class SensorRow(Generic[S]):
    """The description of one kind of sensor: its settings, readings, measurements, limits and topics."""

    spec: type[S]
    """The class of its settings in a scenario; its tag is `kind` in the file."""
    readings: Callable[[S], tuple[Reading, ...]]
    channels: Callable[[S, SensorContext], Iterator[SensorChannel]]
    limits: Mapping[str, Limit] = field(default_factory=dict)
    check: Callable[[S], Iterator[tuple[str, str, str]]] = lambda sensor: iter(())
    """A function that yields key, problem and remedy of each invalid setting, except numbers beyond limits."""
    in_one_step: bool = False
    """Whether a kernel measures all its channels at once."""
    kernels: Literal["camera", "ranging"] | None = None
    """The optional part of the kernels that it needs, which is not compiled for worlds without such sensors."""
    reach: Callable[[S], float] = lambda sensor: 0.0
    """A function that returns the largest distance from the robot's rim at which a sensor detects things, m."""
    scan: Callable[[S, RobotType], RangeScan] | None = None
    topics: Callable[[S, RobotType], tuple[SensorTopic, ...]] = lambda sensor, robot_type: ()


def find_target_color(scenario: Scenario, target: TargetSpec, type_name: str) -> str | None:
    """Return the color by which a type's camera detects a target: its own, else that of what it refers to."""
    types = scenario.types
    if target.color is not None or target.signal is not None:  # no robot changes its color when it calls
        return target.color
    thing = target.nearest or target.object
    if thing is not None:
        return next((each.color for each in scenario.objects if each.name == thing), None)
    if target.team is not None:
        return next((each.color for name, each in types.items() if (each.team or name) == target.team), None)
    return types[type_name].color if target.robot == "teammate" else None


def list_claimable_targets(scenario: Scenario) -> tuple[str, ...]:
    """Return the targets that robots can claim: objects, except targets that exclude claimed ones."""
    targets = {name: each for name, each in scenario.targets.items() if each.unclaimed is None}
    return tuple(name for name, each in targets.items() if each.nearest or each.object)
