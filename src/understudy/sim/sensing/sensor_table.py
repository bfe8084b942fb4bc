"""The table of sensors: for each kind its readings, limits, measurement in kernels, drawing, and ROS 2 topics.

A new kind of sensor is a struct in `scenario/schema.py`, a row here, and its measurement in `kernels/sensing.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import inf, pi, radians, tan
from typing import Any, TypeAlias

from understudy.model.kinds import BOOLEAN, Continuous, Toroidal
from understudy.runtime.body import Reading
from understudy.sim.kernels import dtypes
from understudy.sim.scenario.scenario_errors import CHANCE, NOT_NEGATIVE, PIXELS, POSITIVE, VIEW
from understudy.sim.scenario.schema import (
    Bumper,
    Camera,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    GripSensor,
    PoseSensor,
    RandomSensor,
    RobotType,
    SensorBase,
    Sonar,
    StallSensor,
    TargetLocator,
)
from understudy.sim.sensing.sectors import make_sector
from understudy.sim.sensing.sensor_row import (
    RangeArc,
    RangeScan,
    SensorChannel,
    SensorContext,
    SensorRow,
    SensorTopic,
    find_target_color,
    list_claimable_targets,
)

Sectors: TypeAlias = Mapping[str, tuple[float, float]]

BLOBS = (
    Reading(
        "blob_x", Continuous(), "px", of_targets=True, doc="Where in the picture it is, from the left edge."
    ),
    Reading("blob_size", Continuous(), "px", of_targets=True, doc="How many pixels its color covers."),
)
LOCATIONS = (
    Reading("range", Continuous(), "m", of_targets=True, doc="How far the target is; absent if none."),
    Reading("bearing", Toroidal(), "rad", of_targets=True, doc="Where it is: 0 ahead, then to the left."),
)
POSE = (
    Reading("x", Continuous(), "m", doc="Where the robot is, from the left edge of the arena."),
    Reading("y", Continuous(), "m", doc="Where the robot is, from the lower edge of the arena."),
    Reading("heading", Toroidal(), "rad", doc="Where the robot looks: 0 along x, then to the left."),
    Reading("speed", Continuous(), "m/s", doc="How fast it drives, negative backwards."),
    Reading("turning", Continuous(), "rad/s", doc="How fast it turns, to the left positive."),
)
STUCK = (Reading("stuck", BOOLEAN, doc="Whether it has been driving without getting anywhere."),)
CARGO = (
    Reading("food_here", Continuous(), "units", doc="Food in the nearest source, if within reach."),
    Reading("food_stored", Continuous(), "units", doc="Food the robot carries."),
    Reading("food_left", BOOLEAN, doc="Whether any source still has food."),
    Reading("station_here", BOOLEAN, doc="Whether a home is within reach, so that unloading works."),
)
GRIP = (
    Reading("holding", BOOLEAN, doc="Whether the robot holds a box."),
    Reading("enough", BOOLEAN, doc="Whether so many hold the box it holds that they can pull it."),
)


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


# Sonar and bumpers


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


RANGE, BOOL, FLOAT = "sensor_msgs/msg/Range", "std_msgs/msg/Bool", "std_msgs/msg/Float64"
ULTRASOUND = 0


def _make_range_fields(name: str, limit: float, values: Mapping[str, float]) -> Mapping[str, Any]:
    far = inf if values[name] >= limit else values[name]
    return {
        "radiation_type": ULTRASOUND, "field_of_view": pi / 6, "min_range": 0.0, "max_range": limit, "range": far,
    }  # fmt: skip


def _make_bool_fields(name: str, values: Mapping[str, float]) -> Mapping[str, Any]:
    return {"data": values[name] > 0}


def _make_float_fields(name: str, values: Mapping[str, float]) -> Mapping[str, Any]:
    return {"data": values[name]}


def _list_bumper_readings(sensor: Bumper) -> tuple[Reading, ...]:
    doc = "Whether something touches the robot there."
    return tuple(Reading(name, BOOLEAN, doc=doc) for name in sensor.sectors)


def _list_bumper_channels(sensor: Bumper, context: SensorContext) -> Iterator[SensorChannel]:
    for name, (low, high) in sensor.sectors.items():
        sector = make_sector(radians(low), radians(high))
        yield SensorChannel(((name, None),), {"what": dtypes.BUMPER, "sees": 7}, sector=sector)


def _list_bumper_topics(sensor: Bumper, kind: RobotType) -> tuple[SensorTopic, ...]:
    return tuple(
        SensorTopic(f"bumper/{name}", BOOL, {name: {"field": "data"}}, partial(_make_bool_fields, name))
        for name in sensor.sectors
    )


# Cameras and locators


def _list_camera_channels(sensor: Camera, context: SensorContext) -> Iterator[SensorChannel]:
    step = {
        "what": dtypes.CAMERA, "range": inf if sensor.range is None else sensor.range,
        "tan_half": tan(radians(sensor.view_deg) / 2), "width_px": sensor.width_px, "height_px": sensor.height_px,
        "least_px": sensor.least_px, "noise_a": sensor.noise_x, "noise_b": sensor.noise_size,
        "misses": sensor.misses, "ghosts": sensor.ghosts, "nearest": sensor.choose == "nearest",
    }  # fmt: skip
    for name, target in context.scenario.targets.items():
        color = context.names.color(find_target_color(context.scenario, target, context.type_name))
        yield SensorChannel((("blob_x", name), ("blob_size", name)), step, part={"color": color})


def _list_locator_channels(sensor: TargetLocator, context: SensorContext) -> Iterator[SensorChannel]:
    locators = [each for each in context.kind.sensors if isinstance(each, TargetLocator)]
    named = {name for each in locators for name in each.targets or ()}
    targets = context.scenario.targets
    if sensor.targets is None:
        mine: Sequence[str] = [name for name in targets if name not in named]
    else:
        mine = sensor.targets
    for name in mine:
        step = context.locate(targets[name])
        step |= {"what": step["place"], "range": inf if sensor.range is None else sensor.range}
        step |= {"noise_a": sensor.noise_range, "noise_b": radians(sensor.noise_deg)}
        yield SensorChannel((("range", name), ("bearing", name)), step)


# The robot's own state


def _list_pose_channels(sensor: PoseSensor, context: SensorContext) -> Iterator[SensorChannel]:
    turned = radians(sensor.noise_deg)
    measured = {
        "x": (dtypes.OWN_X, sensor.noise),
        "y": (dtypes.OWN_Y, sensor.noise),
        "heading": (dtypes.OWN_HEADING, turned),
        "speed": (dtypes.OWN_SPEED, sensor.noise),
        "turning": (dtypes.OWN_TURNING, turned),
    }
    for name, (what, noise) in measured.items():
        yield SensorChannel(((name, None),), {"what": what, "noise_a": noise})


def _list_stall_channels(sensor: StallSensor, context: SensorContext) -> Iterator[SensorChannel]:
    step = {"what": dtypes.STUCK, "ticks": context.count_ticks(sensor.after_s)}
    yield SensorChannel((("stuck", None),), step)


def _list_cargo_channels(sensor: CargoSensor, context: SensorContext) -> Iterator[SensorChannel]:
    measured = {
        "food_stored": dtypes.STORED,
        "food_here": dtypes.FOOD_HERE,
        "food_left": dtypes.FOOD_LEFT,
        "station_here": dtypes.STATION_HERE,
    }
    for name, what in measured.items():
        yield SensorChannel(((name, None),), {"what": what})


def _list_cargo_topics(sensor: CargoSensor, kind: RobotType) -> tuple[SensorTopic, ...]:
    def make_topic(reading: Reading) -> SensorTopic:
        is_number = bool(reading.unit)
        settings = {"field": "data", "unit": reading.unit} if is_number else {"field": "data"}
        fields = partial(_make_float_fields if is_number else _make_bool_fields, reading.name)
        return SensorTopic(
            f"readings/{reading.name}", FLOAT if is_number else BOOL, {reading.name: settings}, fields
        )

    return tuple(make_topic(reading) for reading in CARGO)


def _list_grip_channels(sensor: GripSensor, context: SensorContext) -> Iterator[SensorChannel]:
    for name, what in {"holding": dtypes.HOLDING, "enough": dtypes.ENOUGH}.items():
        yield SensorChannel(((name, None),), {"what": what})


# Claims, chance and time


def _list_claim_readings(sensor: ClaimSensor) -> tuple[Reading, ...]:
    doc = f"Whether another robot near it raises {sensor.signal}."
    return (Reading(sensor.name, BOOLEAN, of_targets=True, doc=doc),)


def _list_claim_channels(sensor: ClaimSensor, context: SensorContext) -> Iterator[SensorChannel]:
    claimed = {"what": dtypes.CLAIMED, "within": sensor.range, "range": inf}
    claimed |= {"signal": 1 + context.names.signals.index(sensor.signal)}
    targets = list_claimable_targets(context.scenario) if sensor.targets is None else sensor.targets
    for name in targets:
        place = context.locate(context.scenario.targets[name])
        yield SensorChannel(((sensor.name, name),), place | claimed)


def _list_random_readings(sensor: RandomSensor) -> tuple[Reading, ...]:
    return (Reading(sensor.name, Continuous(), doc="A random number from 0 to 1."),)


def _list_random_channels(sensor: RandomSensor, context: SensorContext) -> Iterator[SensorChannel]:
    ticks = 1 if sensor.every_s is None else context.count_ticks(sensor.every_s)
    yield SensorChannel(((sensor.name, None),), {"what": dtypes.CHANCE, "ticks": ticks})


def _list_elapsed_channels(sensor: ElapsedSensor, context: SensorContext) -> Iterator[SensorChannel]:
    """One for each target that the reading it is about is of; without a target, where that is of none."""
    others = [each for each in context.kind.sensors if not isinstance(each, ElapsedSensor)]
    channels = (part for each in others for part in find_sensor_row(each).channels(each, context))
    keys = [key for part in channels for key in part.keys]
    is_yes_or_no = any(
        reading.kind == BOOLEAN
        for each in others
        for reading in find_sensor_row(each).readings(each)
        if reading.name == sensor.of
    )
    for name, target in keys:
        if name == sensor.of:
            yield SensorChannel(((sensor.name, target),), {"what": dtypes.SINCE, "nearest": is_yes_or_no})


SENSORS: tuple[SensorRow[Any], ...] = (
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
        spec=Camera,
        readings=lambda _: BLOBS,
        channels=_list_camera_channels,
        limits={
            "view_deg": VIEW,
            "width_px": PIXELS,
            "height_px": PIXELS,
            "range": POSITIVE,
            "least_px": NOT_NEGATIVE,
            "noise_x": NOT_NEGATIVE,
            "noise_size": NOT_NEGATIVE,
            "misses": CHANCE,
            "ghosts": CHANCE,
        },
        in_one_step=True,
        kernels="camera",
    ),
    SensorRow(
        spec=TargetLocator,
        readings=lambda _: LOCATIONS,
        channels=_list_locator_channels,
        limits={"range": POSITIVE, "noise_range": NOT_NEGATIVE, "noise_deg": NOT_NEGATIVE},
    ),
    SensorRow(
        spec=PoseSensor,
        readings=lambda _: POSE,
        channels=_list_pose_channels,
        limits={"noise": NOT_NEGATIVE, "noise_deg": NOT_NEGATIVE},
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
    SensorRow(
        spec=StallSensor,
        readings=lambda _: STUCK,
        channels=_list_stall_channels,
        limits={"after_s": POSITIVE},
    ),
    SensorRow(
        spec=CargoSensor,
        readings=lambda _: CARGO,
        channels=_list_cargo_channels,
        topics=_list_cargo_topics,
    ),
    SensorRow(spec=GripSensor, readings=lambda _: GRIP, channels=_list_grip_channels),
    SensorRow(
        spec=ClaimSensor,
        readings=_list_claim_readings,
        channels=_list_claim_channels,
        limits={"range": POSITIVE},
    ),
    SensorRow(
        spec=RandomSensor,
        readings=_list_random_readings,
        channels=_list_random_channels,
        limits={"every_s": POSITIVE},
    ),
    SensorRow(spec=ElapsedSensor, readings=lambda _: (), channels=_list_elapsed_channels),
)
"""One row for each kind of sensor."""

_BY_SPEC: Mapping[type, SensorRow[Any]] = {row.spec: row for row in SENSORS}


def find_sensor_row(sensor: SensorBase) -> SensorRow[Any]:
    """The row of the table for a sensor's kind."""
    return _BY_SPEC[type(sensor)]


def list_range_scans(kind: RobotType) -> list[RangeScan]:
    """What the range sensors of a type of robots sweep, in their order."""
    rows = ((find_sensor_row(sensor).scan, sensor) for sensor in kind.sensors)
    return [scan(sensor, kind) for scan, sensor in rows if scan is not None]
