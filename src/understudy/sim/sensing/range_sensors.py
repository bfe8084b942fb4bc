"""Rows of the sensor table: sonars and bumpers, which measure in sectors around the robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import inf, pi, radians
from typing import Any, TypeAlias

from understudy.model.kinds import BOOLEAN, Continuous
from understudy.runtime.body import Reading
from understudy.sim.kernels import dtypes
from understudy.sim.scenario.scenario_errors import NOT_NEGATIVE, POSITIVE
from understudy.sim.scenario.schema import Bumper, RobotType, Sonar
from understudy.sim.sensing.sectors import make_sector
from understudy.sim.sensing.sensor_row import (
    RangeArc,
    RangeScan,
    SensorChannel,
    SensorContext,
    SensorRow,
    SensorTopic,
)

Sectors: TypeAlias = Mapping[str, tuple[float, float]]

RANGE, BOOL = "sensor_msgs/msg/Range", "std_msgs/msg/Bool"
ULTRASOUND = 0


def _check_sectors(sectors: Sectors) -> Iterator[tuple[str, str, str]]:
    for name, (first, last) in sectors.items():
        if not 0 <= last - first <= 360 or not (first >= -360 and last <= 360):
            remedy = "give (from, to) in degrees from -360 to 360, counter-clockwise from ahead, at most a full circle"
            yield f"sectors.{name}", f"is [{first}, {last}]", remedy


def _check_sector_list(sensor: Sonar | Bumper) -> Iterator[tuple[str, str, str]]:
    if not sensor.sectors:
        yield "sectors", "is empty", "give at least one sector"
    yield from _check_sectors(sensor.sectors)


def _check_sees(sees: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    if not sees:
        yield "sees", "is empty", "give what reflects: walls, obstacles, robots"


def _check_sonar(sensor: Sonar) -> Iterator[tuple[str, str, str]]:
    yield from _check_sector_list(sensor)
    yield from _check_sees(sensor.sees)


def _list_sonar_readings(sensor: Sonar) -> tuple[Reading, ...]:
    doc = "Distance to the nearest thing there; the sonar's range if none."
    return tuple(Reading(name, Continuous(), "m", doc=doc) for name in sensor.sectors)


def _combine_reflectors(sees: Sequence[str]) -> int:
    """What reflects, as the bits of a STEP."""
    bits = {"walls": dtypes.WALLS, "obstacles": dtypes.OBSTACLES, "robots": dtypes.ROBOTS}
    return sum({bits[each] for each in sees})


def _list_sonar_channels(sensor: Sonar, context: SensorContext) -> Iterator[SensorChannel]:
    step = {"what": dtypes.SONAR, "range": sensor.range, "noise_a": sensor.noise}
    step |= {"sees": _combine_reflectors(sensor.sees)}
    for name, (low, high) in sensor.sectors.items():
        yield SensorChannel(((name, None),), step, sector=make_sector(radians(low), radians(high)))


def _sweep_sonar(sensor: Sonar, kind: RobotType) -> RangeScan:
    arcs = tuple(RangeArc(name, low, high) for name, (low, high) in sensor.sectors.items())
    names = tuple(sensor.sectors)
    return RangeScan(
        arcs, sensor.range, sensor.noise, sensor.sees, lambda far: dict(zip(names, far, strict=True))
    )


def _list_sonar_topics(sensor: Sonar, kind: RobotType) -> tuple[SensorTopic, ...]:
    """A message Range for each sector; REP 117: infinite where nothing is in range."""
    return tuple(
        SensorTopic(
            f"sonar/{name}", RANGE, {name: {"unit": "m"}}, partial(_make_range_fields, name, sensor.range)
        )
        for name in sensor.sectors
    )


def _make_range_fields(name: str, limit: float, values: Mapping[str, float]) -> Mapping[str, Any]:
    far = inf if values[name] >= limit else values[name]
    return {
        "radiation_type": ULTRASOUND, "field_of_view": pi / 6, "min_range": 0.0, "max_range": limit, "range": far,
    }  # fmt: skip


def make_bool_fields(name: str, values: Mapping[str, float]) -> Mapping[str, Any]:
    """Make the fields of a message Bool from the value of a reading."""
    return {"data": values[name] > 0}


def _list_bumper_readings(sensor: Bumper) -> tuple[Reading, ...]:
    doc = "Whether something touches the robot there."
    return tuple(Reading(name, BOOLEAN, doc=doc) for name in sensor.sectors)


def _list_bumper_channels(sensor: Bumper, context: SensorContext) -> Iterator[SensorChannel]:
    for name, (low, high) in sensor.sectors.items():
        sector = make_sector(radians(low), radians(high))
        yield SensorChannel(((name, None),), {"what": dtypes.BUMPER, "sees": 7}, sector=sector)


def _list_bumper_topics(sensor: Bumper, kind: RobotType) -> tuple[SensorTopic, ...]:
    return tuple(
        SensorTopic(f"bumper/{name}", BOOL, {name: {"field": "data"}}, partial(make_bool_fields, name))
        for name in sensor.sectors
    )


RANGE_SENSORS: tuple[SensorRow[Any], ...] = (
    SensorRow(
        spec=Sonar,
        readings=_list_sonar_readings,
        channels=_list_sonar_channels,
        limits={"range": POSITIVE, "noise": NOT_NEGATIVE},
        check=_check_sonar,
        in_one_step=True,
        kernels="ranging",
        reach=lambda sonar: sonar.range,
        scan=_sweep_sonar,
        topics=_list_sonar_topics,
    ),
    SensorRow(
        spec=Bumper,
        readings=_list_bumper_readings,
        channels=_list_bumper_channels,
        check=_check_sector_list,
        in_one_step=True,
        kernels="ranging",
        reach=lambda _: dtypes.TOUCH,
        topics=_list_bumper_topics,
    ),
)
"""The rows of the sensor table for sonars and bumpers."""
