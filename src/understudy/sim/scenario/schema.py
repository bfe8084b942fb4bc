"""Scenarios: descriptions of worlds as frozen values, written as TOML files or in Python.

Lengths are in m, times in s, speeds in m/s. Angles are in radians everywhere except in scenarios, whose keys end in
`_deg` for degrees. The arena spans [0, width] x [0, height].
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

from msgspec import UNSET, UnsetType, field

from understudy.sim.scenario.skill_schema import SkillStandIn
from understudy.sim.scenario.squad_schema import CommsSpec, SquadSpec, StrictStruct

ArenaPoint: TypeAlias = tuple[float, float]
Range: TypeAlias = tuple[float, float]
CountSpec: TypeAlias = int | tuple[int, int]
"""A whole number, or (least, most) from which each world draws one."""

VERSION = 1
MOUSE = "mouse"
"""The class of the object for the mouse pointer, which is absent until a program places it."""


class ArenaRegion(StrictStruct, frozen=True, kw_only=True):
    """A named part of the arena, in which things can be placed: a box (x0, y0, x1, y1), or a circle."""

    box: tuple[float, float, float, float] | None = None
    center: ArenaPoint | None = None
    radius: float | None = None


class Wall(StrictStruct, frozen=True, kw_only=True):
    """A wall along a line of points; `closed` connects the last point with the first."""

    points: tuple[ArenaPoint, ...]
    closed: bool = False


class Placement(StrictStruct, frozen=True, kw_only=True):
    """The places of things: `at` given places, or `count` random places, free of everything placed before.

    A place is (x, y), or (x, y, rotation in degrees). `within` names the region of random centers; `apart` (m) is the
    free space around each thing beyond its radius. `near` names a class of objects: the things are then beside its
    first object, `near_m` from center to center, on the side of the arena's center; 0 is at the same place.
    """

    count: CountSpec | UnsetType = UNSET
    at: tuple[tuple[float, ...], ...] | UnsetType = UNSET
    within: str | None = None
    apart: float = 0.0
    near: str | None = None
    near_m: float = 0.0


class Obstacle(Placement, frozen=True, kw_only=True):
    """A solid thing that does not move: round (`radius`), or a polygon (`points` around its place, rotated at random).

    Cameras detect the `color` of round ones, which are `height` high (2 radii by default); that of a polygon is only
    for pictures.
    """

    radius: float | None = None
    points: tuple[ArenaPoint, ...] | None = None
    color: str | None = None
    height: float | None = None


class AppearanceSchedule(StrictStruct, frozen=True, kw_only=True):
    """The times when an object is there: absent for a time from `away_s`, present for one from `stays_s`.

    Each time it appears at a new free place. `first_s` is the time of its first appearance (by default as `away_s`);
    without `stays_s` it stays until it is captured.
    """

    away_s: Range
    first_s: Range | None = None
    stays_s: Range | None = None


class CaptureRule(StrictStruct, frozen=True, kw_only=True):
    """The rule by which an object vanishes `after_s` after a robot came within `range` (center to center)."""

    range: float
    after_s: float = 0.0


class RandomWalk(StrictStruct, frozen=True, kw_only=True):
    """The motion of an object that walks at `speed` in a new random direction every `turn_s`."""

    speed: float
    turn_s: float = 5.0


class PullRule(StrictStruct, frozen=True, kw_only=True):
    """A box that robots hold by the command `load`; when at least `robots` hold it, it moves as they drive.

    It is gathered when its center is in a home; with `respawn` it then appears again at a free place.
    """

    robots: int = 1
    respawn: bool = False


class ObjectClass(Placement, frozen=True, kw_only=True):
    """Objects of one class, such as food, a ball, boxes, markers, waypoints or the home base.

    `amount` makes them sources with units of food to load, and `home` a place to unload it. `solid` objects stop
    robots, range sensors and cameras; `pushable` ones are solid and move when at least `pushers` robots drive into
    them. Objects with a `pull` stop nothing, and move with the robots that hold them. `height` is the visible one for
    cameras, 2 radii by default; objects that hang `aloft` are never hidden.
    """

    name: str
    radius: float = 0.1
    height: float | None = None
    color: str | None = None
    amount: CountSpec = 0
    home: bool = False
    solid: bool = False
    pushable: bool = False
    pushers: int = 1
    pull: PullRule | None = None
    aloft: bool = False
    presence: AppearanceSchedule | None = None
    capture: CaptureRule | None = None
    walk: RandomWalk | None = None


class SensorBase(StrictStruct, frozen=True, kw_only=True):
    """The settings of all sensors.

    `dropout` is the probability that a measurement gives no reading; `rate_hz` the number of measurements per second
    (by default one per tick), between which the last reading is kept.
    """

    dropout: float = 0.0
    rate_hz: float | None = None


class Sonar(SensorBase, frozen=True, kw_only=True, tag="sonar", tag_field="kind"):
    """A sensor of the distance from the robot's rim to the nearest thing in each sector; `range` if there is none.

    `sectors` maps a reading's name to (from, to) in degrees, counter-clockwise from ahead; equal angles are a single
    beam. `sees` lists what reflects; pushable and other solid objects count as obstacles.
    """

    sectors: Mapping[str, tuple[float, float]]
    range: float = 3.0
    noise: float = 0.0
    sees: tuple[Literal["walls", "obstacles", "robots"], ...] = ("walls", "obstacles", "robots")


class Lidar(SensorBase, frozen=True, kw_only=True, tag="lidar", tag_field="kind"):
    """A sensor of distances from the robot's rim along `beams`, evenly spread over its view and symmetric.

    Readings are `{name}_0` to `{name}_{beams - 1}`, counter-clockwise; `range` if nothing is hit. `sectors` maps a
    name to (from, to) in degrees as for a sonar, and each gives three readings: under its name the nearest distance,
    `{name}_bearing` its direction, absent if nothing is hit, and `{name}_width` the width (m) of the widest opening,
    a row of beams that reach at least `clear`. `sees` lists what reflects, as for a sonar.
    """

    view_deg: float = 360.0
    beams: int = 36
    range: float = 5.0
    noise: float = 0.0
    sectors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    clear: float = 1.0
    name: str = "beam"
    sees: tuple[Literal["walls", "obstacles", "robots"], ...] = ("walls", "obstacles", "robots")


class Camera(SensorBase, frozen=True, kw_only=True, tag="camera", tag_field="kind"):
    """A camera that detects blobs of color: `blob_x` (pixels from the left edge) and `blob_size` (pixels) of a target.

    Both are absent if the target has no color or is not seen. Of several blobs of a color, `choose` selects the
    largest or the nearest. `misses` is the probability that a blob is not seen, `ghosts` that one is seen where there
    is none. Noise is in pixels for x, and a share of the size.
    """

    view_deg: float = 60.0
    width_px: int = 160
    height_px: int = 120
    range: float | None = None
    choose: Literal["largest", "nearest"] = "largest"
    least_px: float = 1.0
    noise_x: float = 0.0
    noise_size: float = 0.0
    misses: float = 0.0
    ghosts: float = 0.0


class TargetLocator(SensorBase, frozen=True, kw_only=True, tag="locator", tag_field="kind"):
    """A sensor of `range` and `bearing` of a target, from center to center, through everything, up to its `range`.

    It measures the `targets` it names; by default all that no other locator of the type names.
    """

    targets: tuple[str, ...] | None = None
    range: float | None = None
    noise_range: float = 0.0
    noise_deg: float = 0.0


class PoseSensor(SensorBase, frozen=True, kw_only=True, tag="pose", tag_field="kind"):
    """A sensor of the robot's own `x`, `y`, `heading`, `speed` and `turning`."""

    noise: float = 0.0
    noise_deg: float = 0.0


class Bumper(SensorBase, frozen=True, kw_only=True, tag="bumper", tag_field="kind"):
    """A sensor of contact in each sector, (from, to) in degrees; the readings are named after the sectors."""

    sectors: Mapping[str, tuple[float, float]] = field(default_factory=lambda: {"bumper": (-180.0, 180.0)})


class StallSensor(SensorBase, frozen=True, kw_only=True, tag="stuck", tag_field="kind"):
    """A sensor of the reading `stuck`: whether the robot has commanded motion for `after_s` without moving."""

    after_s: float = 1.0


class CargoSensor(SensorBase, frozen=True, kw_only=True, tag="cargo", tag_field="kind"):
    """A sensor of food: `food_stored`, `food_here`, `food_left` and `station_here`.

    `food_here` is the food of the nearest source, if within reach; `station_here` is whether a home is within reach.
    """


class GripSensor(SensorBase, frozen=True, kw_only=True, tag="holding", tag_field="kind"):
    """A sensor of boxes to pull: `holding` (whether the robot holds one), `enough` (whether enough robots hold it)."""


class ClaimSensor(SensorBase, frozen=True, kw_only=True, tag="claimed", tag_field="kind"):
    """A sensor of whether another robot within `range` of an object raises a signal; `name` is the reading.

    It covers all targets that are objects, or the `targets` it names.
    """

    signal: str
    range: float
    name: str = "claimed"
    targets: tuple[str, ...] | None = None


class RandomSensor(SensorBase, frozen=True, kw_only=True, tag="random", tag_field="kind"):
    """A reading of random numbers in [0, 1), drawn every `every_s` (by default every tick)."""

    name: str = "random"
    every_s: float | None = None


class ElapsedSensor(SensorBase, frozen=True, kw_only=True, tag="since", tag_field="kind"):
    """A sensor of the time (s) since the reading `of` was last present (a blob, a range) or last true (a bumper).

    Its reading `name` is of a target if `of` is; it is absent if `of` was never present.
    """

    name: str
    of: str


Sensor: TypeAlias = (
    Sonar
    | Lidar
    | Camera
    | TargetLocator
    | PoseSensor
    | Bumper
    | StallSensor
    | CargoSensor
    | GripSensor
    | ClaimSensor
    | RandomSensor
    | ElapsedSensor
)


class RobotType(StrictStruct, frozen=True, kw_only=True):
    """A type of robot: a disc on two wheels, with its sensors and basic behaviors.

    Lengths are in m. `speed` (m/s) and `turning_deg` (degrees/s) are those of the commands drive = 1 and turn = 1; the
    accelerations (per s²), if given, limit how fast they are reached. Noise is a share of the motion in each tick. A
    robot carries up to `capacity` units of food, and loads or unloads one in `load_s` or `unload_s` within `reach`,
    standing still. A behavior maps channels to their commanded values, and `signal` to the signal that it raises while
    it runs. `skills` are what robots of this type can do by themselves.
    """

    radius: float = 0.2
    speed: float = 0.5
    turning_deg: float = 60.0
    acceleration: float | None = None
    turning_acceleration_deg: float | None = None
    noise_drive: float = 0.0
    noise_turn: float = 0.0
    color: str | None = None
    team: str | None = None
    height: float | None = None
    capacity: int = 0
    reach: float = 0.5
    load_s: float = 1.0
    unload_s: float = 1.0
    collides: bool = True
    sensors: tuple[Sensor, ...] = ()
    behaviors: Mapping[str, Mapping[str, float | str]] = field(default_factory=dict)
    skills: Mapping[str, SkillStandIn] = field(default_factory=dict)


class Breakdown(StrictStruct, frozen=True, kw_only=True):
    """Robots of a group that fail for good, `at_s` after the start: they neither sense nor move any more.

    They are `robots`, numbered within the group, or else as many as `count`, drawn in each world. The time of each is
    drawn between two.
    """

    at_s: float | Range
    count: CountSpec = 1
    robots: tuple[int, ...] | None = None


class RobotGroup(Placement, frozen=True, kw_only=True):
    """Robots of one type; headings that are not given are drawn at random.

    `stored` is the food that each carries at first, and `fails` says which of them fail, and when.
    """

    type: str
    stored: int = 0
    fails: tuple[Breakdown, ...] = ()


class TargetSpec(StrictStruct, frozen=True, kw_only=True):
    """The meaning of a target's name, given by one of its fields.

    `nearest` object of a class (of food: with food left), the first `object` of a class, the nearest robot of this
    `team`, or the nearest robot that is a "teammate", an "opponent" or "any"; a `color` alone, for cameras. A
    `signal`, alone or with `team` or `robot`, restricts it to robots that raise it. With `unclaimed`, `nearest` omits
    objects that another robot `within` this distance claims by raising this signal.
    """

    nearest: str | None = None
    object: str | None = None
    index: int = 0
    team: str | None = None
    robot: Literal["teammate", "opponent", "any"] | None = None
    color: str | None = None
    signal: str | None = None
    unclaimed: str | None = None
    within: float | None = None
    doc: str = ""


class FeatureSpec(StrictStruct, frozen=True, kw_only=True):
    """A feature under a name of its own; it replaces the usual feature of the same `reading`."""

    reading: str
    doc: str = ""


class Goal(StrictStruct, frozen=True, kw_only=True):
    """The condition that finishes a world: all food `delivered`, enough boxes `gathered`, or robots at a `target`.

    The target is a class of objects, and any of them counts, from center to center `within` this distance; one robot
    must be there, or with `all` every one.
    """

    delivered: bool = False
    gathered: int = 0
    target: str | None = None
    within: float = 0.5
    all: bool = False


class Scenario(StrictStruct, frozen=True, kw_only=True):
    """The complete description of a world, except for the seed: plain data, in m, s and degrees.

    `World` checks it, and raises a SettingError that names the key. A function that makes a scenario may be called in
    any thread, as often as worlds are listed or opened, and makes the same one each time.
    """

    name: str = "scenario"
    about: str = ""
    size: tuple[float, float]
    tick_s: float = 0.1
    limit_s: float = 600.0
    walls: tuple[Wall, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    regions: Mapping[str, ArenaRegion] = field(default_factory=dict)
    objects: tuple[ObjectClass, ...] = ()
    types: Mapping[str, RobotType]
    robots: tuple[RobotGroup, ...]
    targets: Mapping[str, TargetSpec] = field(default_factory=dict)
    features: Mapping[str, FeatureSpec] = field(default_factory=dict)
    squads: Mapping[str, SquadSpec] = field(default_factory=dict)
    radio: CommsSpec = CommsSpec()
    goal: Goal | None = None
    spare_objects: int = 16
    generator: int = 2
