"""The table of sensors: for each kind its readings, limits, measurement in kernels, drawing, and ROS 2 topics.

A new kind of sensor needs a struct in `scenario/schema.py`, a row here or in `range_sensors.py`, and its measurement
in `kernels/sensing.py`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from math import inf, radians
from typing import Any

from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy.runtime.body import Reading
from understudy.sim.kernels import dtypes
from understudy.sim.kernels.angles import compute_cosine_and_sine
from understudy.sim.scenario.scenario_errors import CHANCE, NOT_NEGATIVE, PIXELS, POSITIVE, VIEW
from understudy.sim.scenario.schema import (
    Camera,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    GripSensor,
    PoseSensor,
    RandomSensor,
    RobotType,
    SensorBase,
    StallSensor,
    TargetLocator,
)
from understudy.sim.sensing.range_sensors import BOOL, RANGE_SENSORS, make_bool_fields
from understudy.sim.sensing.sensor_row import (
    RangeScan,
    SensorChannel,
    SensorContext,
    SensorRow,
    SensorTopic,
    find_target_color,
    list_claimable_targets,
)

FLOAT = "std_msgs/msg/Float64"

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


# Cameras and locators


def _list_camera_channels(sensor: Camera, context: SensorContext) -> Iterator[SensorChannel]:
    cosine, sine = compute_cosine_and_sine(radians(sensor.view_deg) / 2)
    step = {
        "what": dtypes.CAMERA, "range": inf if sensor.range is None else sensor.range,
        "tan_half": sine / cosine, "width_px": sensor.width_px, "height_px": sensor.height_px,
        "least_px": sensor.least_px, "noise_a": sensor.noise_x, "noise_b": sensor.noise_size,
        "misses": sensor.misses, "ghosts": sensor.ghosts, "nearest": sensor.choose == "nearest",
    }  # fmt: skip
    for name, target in context.scenario.targets.items():
        color = context.names.color(find_target_color(context.scenario, target, context.type_name))
        yield SensorChannel((("blob_x", name), ("blob_size", name)), step, part={"color": color})


def _list_locator_channels(sensor: TargetLocator, context: SensorContext) -> Iterator[SensorChannel]:
    locators = [each for each in context.robot_type.sensors if isinstance(each, TargetLocator)]
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


def _make_float_fields(name: str, values: Mapping[str, float]) -> Mapping[str, Any]:
    return {"data": values[name]}


def _list_cargo_topics(sensor: CargoSensor, robot_type: RobotType) -> tuple[SensorTopic, ...]:
    def make_topic(reading: Reading) -> SensorTopic:
        is_number = bool(reading.unit)
        settings = {"field": "data", "unit": reading.unit} if is_number else {"field": "data"}
        fields = partial(_make_float_fields if is_number else make_bool_fields, reading.name)
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
    """Yield the channels of a sensor of the time since another reading was last present.

    There is one for each target of that reading, or a single one if it has no targets.
    """
    others = [each for each in context.robot_type.sensors if not isinstance(each, ElapsedSensor)]
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
            step = {"what": dtypes.SINCE, "nearest": is_yes_or_no}
            yield SensorChannel(((sensor.name, target),), step, timed=(name, target))


SENSORS: tuple[SensorRow[Any], ...] = (
    *RANGE_SENSORS,
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
"""The rows of the table, one for each kind of sensor."""

_BY_SPEC: Mapping[type, SensorRow[Any]] = {row.spec: row for row in SENSORS}


def find_sensor_row(sensor: SensorBase) -> SensorRow[Any]:
    """Return how sensors of this one's kind are described, listed in channels and computed: its row of `SENSORS`."""
    return _BY_SPEC[type(sensor)]


def list_range_scans(robot_type: RobotType) -> list[RangeScan]:
    """Return the arcs of all range sensors of a type of robots, in order."""
    rows = ((find_sensor_row(sensor).scan, sensor) for sensor in robot_type.sensors)
    return [scan(sensor, robot_type) for scan, sensor in rows if scan is not None]
