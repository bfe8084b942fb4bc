"""Rows of the sensor table for sonars, lidars and bumpers, which measure in directions around the robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from math import inf, nan, pi, radians, tau
from typing import Any, TypeAlias

import numpy as np

from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy.runtime.body import Reading
from understudy.sim.kernels import dtypes
from understudy.sim.scenario.scenario_errors import NOT_NEGATIVE, POSITIVE, Limit
from understudy.sim.scenario.schema import Bumper, Lidar, RobotType, Sonar
from understudy.sim.sensing.sectors import find_nearest_beam, make_sector, measure_widest_opening
from understudy.sim.sensing.sensor_row import (
    RangeArc,
    RangeScan,
    SensorChannel,
    SensorContext,
    SensorRow,
    SensorTopic,
)

Sectors: TypeAlias = Mapping[str, tuple[float, float]]

RANGE, SCAN = "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan"
BOOL = "std_msgs/msg/Bool"
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
    """Return the kinds of things that a sensor detects as the bits of `sees` of a STEP."""
    bits = {"walls": dtypes.WALLS, "obstacles": dtypes.OBSTACLES, "robots": dtypes.ROBOTS}
    return sum({bits[each] for each in sees})


def _list_sonar_channels(sensor: Sonar, context: SensorContext) -> Iterator[SensorChannel]:
    step = {"what": dtypes.SONAR, "range": sensor.range, "noise_a": sensor.noise}
    step |= {"sees": _combine_reflectors(sensor.sees)}
    for name, (low, high) in sensor.sectors.items():
        yield SensorChannel(((name, None),), step, sector=make_sector(radians(low), radians(high)))


def _sweep_sonar(sensor: Sonar, robot_type: RobotType) -> RangeScan:
    arcs = tuple(RangeArc(name, low, high) for name, (low, high) in sensor.sectors.items())
    names = tuple(sensor.sectors)
    return RangeScan(
        arcs, sensor.range, sensor.noise, sensor.sees, lambda far: dict(zip(names, far, strict=True))
    )


def _list_sonar_topics(sensor: Sonar, robot_type: RobotType) -> tuple[SensorTopic, ...]:
    """Return a topic of messages Range for each sector; ranges without an echo are infinite (REP 117)."""
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


def _aim_beams(sensor: Lidar) -> tuple[float, float]:
    """Return the direction of a lidar's first beam and the angle between beams, degrees; a single beam points ahead."""
    if sensor.beams == 1:
        return 0.0, sensor.view_deg
    if sensor.view_deg >= 360.0:
        return -180.0, 360.0 / sensor.beams
    return -sensor.view_deg / 2, sensor.view_deg / (sensor.beams - 1)


def _select_beams(sensor: Lidar, low: float, high: float) -> tuple[int, int] | None:
    """Return the first beam of a sector and their number; None if they are not a row of neighboring beams.

    A sector without width selects the nearest beam.
    """
    start, spacing = _aim_beams(sensor)
    same, width = 1e-9, high - low
    after = [(start + beam * spacing - low) % 360.0 for beam in range(sensor.beams)]
    after = [each - 360.0 if each > 360.0 - same else each for each in after]
    if width < same:
        away = [min(abs(each), 360.0 - abs(each)) for each in after]
        nearest = min(range(sensor.beams), key=away.__getitem__)
        return (nearest, 1) if away[nearest] <= spacing / 2 + same else None
    row = sorted((each, beam) for beam, each in enumerate(after) if each <= width + same)
    beams = [beam for _, beam in row]
    turns = sensor.view_deg >= 360.0
    follows = (b == a + 1 or (turns and (a, b) == (sensor.beams - 1, 0)) for a, b in pairwise(beams))
    return (beams[0], len(beams)) if beams and all(follows) else None


def _check_lidar(sensor: Lidar) -> Iterator[tuple[str, str, str]]:
    yield from _check_sectors(sensor.sectors)
    yield from _check_sees(sensor.sees)
    if sensor.sectors and sensor.clear > sensor.range:
        problem = f"is {sensor.clear:g}, and no beam reaches that far, since range is {sensor.range:g}"
        yield "clear", problem, "give the range at most"
    for name, (low, high) in sensor.sectors.items():
        if _select_beams(sensor, low, high) is None:
            problem = (
                f"is [{low}, {high}], which is not one row of beams in a view of {sensor.view_deg:g} degrees"
            )
            yield f"sectors.{name}", problem, "keep it within the view, widen it, or give more beams"


def _list_lidar_readings(sensor: Lidar) -> tuple[Reading, ...]:
    start, spacing = _aim_beams(sensor)
    far = "Distance to what is {}; the lidar's range if nothing."
    beams = [
        Reading(
            f"{sensor.name}_{k}", Continuous(), "m", doc=far.format(f"at {start + k * spacing:g} degrees")
        )
        for k in range(sensor.beams)
    ]
    sectors = [
        reading
        for name in sensor.sectors
        for reading in (
            Reading(name, Continuous(), "m", doc=far.format("nearest there")),
            Reading(f"{name}_bearing", Toroidal(), "rad", doc="Where that is: 0 ahead, then to the left."),
            Reading(
                f"{name}_width", Continuous(), "m", doc="How wide the widest opening there is; 0 if none."
            ),
        )
    ]
    return (*sectors, *beams)


def _list_lidar_channels(sensor: Lidar, context: SensorContext) -> Iterator[SensorChannel]:
    start, spacing = _aim_beams(sensor)
    step = {
        "what": dtypes.LIDAR, "range": sensor.range, "noise_a": sensor.noise, "clear": sensor.clear,
        "sees": _combine_reflectors(sensor.sees), "beams": sensor.beams,
        "first_rad": radians(start), "spacing": radians(spacing),
    }  # fmt: skip
    for beam in range(sensor.beams):
        at = radians(start + beam * spacing)
        key = (f"{sensor.name}_{beam}", None)
        yield SensorChannel((key,), step, sector=make_sector(at, at), always=True)
    for name, (low, high) in sensor.sectors.items():
        beam, count = _select_beams(sensor, low, high) or (0, 0)
        row = {"beam": beam, "beams": count}
        nearest = {"of": dtypes.NEAREST_RETURN, **row}
        yield SensorChannel(((name, None), (f"{name}_bearing", None)), step, part=nearest)
        yield SensorChannel(((f"{name}_width", None),), step, part={"of": dtypes.WIDEST_OPENING, **row})


def _sweep_lidar(sensor: Lidar, robot_type: RobotType) -> RangeScan:
    start, spacing = _aim_beams(sensor)
    names = [f"{sensor.name}_{beam}" for beam in range(sensor.beams)]
    arcs = (RangeArc(name, at, at) for k, name in enumerate(names) for at in (start + k * spacing,))

    def summarize(far: Sequence[float]) -> Mapping[str, float]:
        values = dict(zip(names, far, strict=True))
        for name, (low, high) in sensor.sectors.items():
            first, count = _select_beams(sensor, low, high) or (0, 0)
            beam = find_nearest_beam(far, first, count, sensor.beams)
            hit = beam >= 0 and far[beam] < sensor.range
            values[name] = far[beam] if beam >= 0 else nan
            values[f"{name}_bearing"] = radians(start + beam * spacing) % tau if hit else nan
            values[f"{name}_width"] = nan if beam < 0 else measure_widest_opening(
                far, first, count, sensor.beams, radians(spacing), robot_type.radius, sensor.clear
            )  # fmt: skip
        return values

    return RangeScan(tuple(arcs), sensor.range, sensor.noise, sensor.sees, summarize)


def _list_lidar_topics(sensor: Lidar, robot_type: RobotType) -> tuple[SensorTopic, ...]:
    """Return a topic LaserScan from the robot's center; its robot file subtracts the robot's radius."""
    start, spacing = _aim_beams(sensor)
    readings: dict[str, dict[str, Any]] = {}
    for beam in range(sensor.beams):
        at = start + beam * spacing
        readings[f"{sensor.name}_{beam}"] = {"sector_deg": [at, at], "offset_m": robot_type.radius}
    for name, sector in sensor.sectors.items():
        of = {"sector_deg": list(sector), "offset_m": robot_type.radius}
        readings[name] = of
        readings[f"{name}_bearing"] = {"field": "bearing", **of}
        readings[f"{name}_width"] = {"field": "width", **of, "clear_m": sensor.clear}

    def make_fields(values: Mapping[str, float]) -> Mapping[str, Any]:
        far = np.array([values[f"{sensor.name}_{beam}"] for beam in range(sensor.beams)])
        return {
            "angle_min": radians(start), "angle_max": radians(start + (sensor.beams - 1) * spacing),
            "angle_increment": radians(spacing), "range_min": 0.0, "range_max": sensor.range + robot_type.radius,
            "ranges": np.where(far >= sensor.range, inf, far + robot_type.radius).astype(np.float32),
        }  # fmt: skip

    return (SensorTopic(f"scan/{sensor.name}", SCAN, readings, make_fields),)


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


def _list_bumper_topics(sensor: Bumper, robot_type: RobotType) -> tuple[SensorTopic, ...]:
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
        spec=Lidar,
        readings=_list_lidar_readings,
        channels=_list_lidar_channels,
        limits={
            "view_deg": Limit(lambda degrees: 0 < degrees <= 360, "more than 0 and up to 360 degrees"),
            "beams": Limit(lambda beams: 1 <= beams <= 2048, "1 to 2048 beams"),
            "range": POSITIVE,
            "noise": NOT_NEGATIVE,
            "clear": POSITIVE,
        },
        check=_check_lidar,
        in_one_step=True,
        kernels="ranging",
        reach=lambda lidar: lidar.range,
        scan=_sweep_lidar,
        topics=_list_lidar_topics,
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
"""The rows of the sensor table for sonars, lidars and bumpers."""
