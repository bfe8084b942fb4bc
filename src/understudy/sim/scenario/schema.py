"""Scenarios: what a world is made of - a frozen value that a TOML file, or Python, spells out.

Lengths in m, times in s, speeds in m/s. Angles are radians in Python and everywhere else; only a scenario spells
them in degrees, and says so in the key (`_deg`). The arena spans [0, width] x [0, height].
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

from msgspec import UNSET, UnsetType, field

from understudy.sim.scenario.squad_schema import CommsSpec, SquadSpec, StrictStruct

ArenaPoint: TypeAlias = tuple[float, float]
Range: TypeAlias = tuple[float, float]
CountSpec: TypeAlias = int | tuple[int, int]
"""A whole number, or (least, most) to draw from for each world."""

VERSION = 1
MOUSE = "mouse"
"""The object that stands for the mouse pointer: absent until a program puts it somewhere."""


class ArenaRegion(StrictStruct, frozen=True, kw_only=True):
    """A part of the arena by name, to place things in: a box (x0, y0, x1, y1), or a circle."""

    box: tuple[float, float, float, float] | None = None
    center: ArenaPoint | None = None
    radius: float | None = None


class Wall(StrictStruct, frozen=True, kw_only=True):
    """A wall along a line of points; `closed` joins the last to the first."""

    points: tuple[ArenaPoint, ...]
    closed: bool = False


class Placement(StrictStruct, frozen=True, kw_only=True):
    """Where things are: `at` these places, or `count` of them at random, free of everything placed before.

    A place is (x, y), or (x, y, how far it is turned in degrees). `within` names the region of the centers of the
    random ones; `apart` (m) is the free space around each, beside its radius. `near` names a class of objects: they
    are beside its first one, `near_m` from center to center, on the side of the arena's center; 0 is right there.
    """

    count: CountSpec | UnsetType = UNSET
    at: tuple[tuple[float, ...], ...] | UnsetType = UNSET
    within: str | None = None
    apart: float = 0.0
    near: str | None = None
    near_m: float = 0.0


class Obstacle(Placement, frozen=True, kw_only=True):
    """Something solid that stays: round (`radius`), or a polygon (`points` around its place, turned at random).

    Cameras see the `color` of round ones, `height` high (2 radii if left out); that of a polygon is for pictures.
    """

    radius: float | None = None
    points: tuple[ArenaPoint, ...] | None = None
    color: str | None = None
    height: float | None = None


class AppearanceSchedule(StrictStruct, frozen=True, kw_only=True):
    """An object that comes and goes: absent for a time drawn from `away_s`, then there for one from `stays_s`.

    Each time it appears at a new free place. `first_s` is when it first appears (as `away_s` if left out);
    without `stays_s` it stays until it is captured.
    """

    away_s: Range
    first_s: Range | None = None
    stays_s: Range | None = None


class CaptureRule(StrictStruct, frozen=True, kw_only=True):
    """An object that is removed `after_s` once a robot has come within `range` (center to center)."""

    range: float
    after_s: float = 0.0


class RandomWalk(StrictStruct, frozen=True, kw_only=True):
    """An object that wanders by itself at `speed`, in a new direction every `turn_s`."""

    speed: float
    turn_s: float = 5.0


class PullRule(StrictStruct, frozen=True, kw_only=True):
    """A box that robots take hold of by loading: with `robots` hands at least, it moves as they drive.

    Once its center is in a home it is gathered; where `respawn`, it appears again at a free place.
    """

    robots: int = 1
    respawn: bool = False


class ObjectClass(Placement, frozen=True, kw_only=True):
    """Things of one class: food, a ball, boxes, markers, waypoints, the home base.

    `amount` makes them sources of food that robots load; `home` a place where they unload. `solid` ones stop
    robots, sonar and sight; `pushable` ones are solid and moved by robots that drive into them, `pushers` of
    them at least. Those with a `pull` are in nobody's way, and moved by robots that hold them. `height` is what
    a camera sees of it, 2 radii if left out; nothing hides what hangs `aloft`.
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
    """What every sensor has: `dropout` is the chance of no answer in a measurement; `rate_hz` how often it
    measures (every tick if left out), keeping its last answer in between.
    """

    dropout: float = 0.0
    rate_hz: float | None = None


class Sonar(SensorBase, frozen=True, kw_only=True, tag="sonar", tag_field="kind"):
    """Distances from the robot's rim to what is nearest in each sector; `range` where nothing is hit.

    `sectors` maps a reading's name to (from, to) in degrees, counter-clockwise from ahead; from = to is a beam.
    `sees` says what reflects; pushable and other solid objects count as obstacles.
    """

    sectors: Mapping[str, tuple[float, float]]
    range: float = 3.0
    noise: float = 0.0
    sees: tuple[Literal["walls", "obstacles", "robots"], ...] = ("walls", "obstacles", "robots")


class Lidar(SensorBase, frozen=True, kw_only=True, tag="lidar", tag_field="kind"):
    """Distances from the robot's rim along `beams` that are evenly spread over its view, symmetric about ahead.

    Readings `{name}_0` to `{name}_{beams - 1}`, counter-clockwise; `range` where nothing is hit. `sectors` maps a
    name to (from, to) in degrees as a sonar does, and the beams in it give three readings: by that name the nearest
    distance, `{name}_bearing` the direction of that, absent where nothing is hit, and `{name}_width` how wide (m) the
    widest opening is, which is a row of beams that reach `clear` at least. `sees` says what reflects, as for a sonar.
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
    """Blobs of color in a frame: readings `blob_x` (pixels from the left edge) and `blob_size` (pixels), of a
    target with a color; absent together.

    Of several blobs of a color the largest or the nearest counts. `misses` is the chance that a blob is not
    seen, `ghosts` that one is seen where there is none. Noise is in pixels for x, a share of it for size.
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
    """Readings `range` and `bearing` of a target, center to center, through everything, up to `range`.

    Of all targets but those that another locator of the type names, or of the `targets` it names itself.
    """

    targets: tuple[str, ...] | None = None
    range: float | None = None
    noise_range: float = 0.0
    noise_deg: float = 0.0


class PoseSensor(SensorBase, frozen=True, kw_only=True, tag="pose", tag_field="kind"):
    """The robot's own readings `x`, `y`, `heading`, `speed` and `turning`."""

    noise: float = 0.0
    noise_deg: float = 0.0


class Bumper(SensorBase, frozen=True, kw_only=True, tag="bumper", tag_field="kind"):
    """Whether the robot touches something in each sector: readings as the sectors are named, (from, to) degrees."""

    sectors: Mapping[str, tuple[float, float]] = field(default_factory=lambda: {"bumper": (-180.0, 180.0)})


class StallSensor(SensorBase, frozen=True, kw_only=True, tag="stuck", tag_field="kind"):
    """The reading `stuck`: whether for `after_s` the robot has been driving without getting anywhere."""

    after_s: float = 1.0


class CargoSensor(SensorBase, frozen=True, kw_only=True, tag="cargo", tag_field="kind"):
    """Readings of food: `food_stored`, `food_here` (in the nearest source, if within reach), `food_left`,
    `station_here` (whether unloading works here).
    """


class GripSensor(SensorBase, frozen=True, kw_only=True, tag="holding", tag_field="kind"):
    """Readings of boxes to pull: `holding` (whether the robot holds one), `enough` (whether enough robots hold it)."""


class ClaimSensor(SensorBase, frozen=True, kw_only=True, tag="claimed", tag_field="kind"):
    """The reading `name` of an object as target: whether another robot within `range` of it raises the signal.

    Of all targets that are objects, or of the `targets` it names.
    """

    signal: str
    range: float
    name: str = "claimed"
    targets: tuple[str, ...] | None = None


class RandomSensor(SensorBase, frozen=True, kw_only=True, tag="random", tag_field="kind"):
    """A reading in [0, 1), drawn anew every `every_s` (every tick if left out)."""

    name: str = "random"
    every_s: float | None = None


class ElapsedSensor(SensorBase, frozen=True, kw_only=True, tag="since", tag_field="kind"):
    """A reading `name`: seconds since the reading `of` was last there (a blob, a range) or last yes (bumper).

    It is of a target where `of` is one; absent where that never was.
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
    """A sort of robot: a disc on two wheels with its sensors, and the behaviors it comes with.

    `speed` and `turning_deg` (per s) are what the commands drive = 1 and turn = 1 ask for; the accelerations, where
    given, limit how fast it gets there. Noise is a share of the motion of each tick. A robot carries up to
    `capacity` units of food, loads and unloads one in `load_s` and `unload_s` within `reach`, standing still.
    A behavior says for each channel how much of it, and for `signal` which one it raises while it runs.
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


class RobotGroup(Placement, frozen=True, kw_only=True):
    """Robots of one type; headings left out are drawn.

    `stored` is the food they carry at first.
    """

    type: str
    stored: int = 0


class TargetSpec(StrictStruct, frozen=True, kw_only=True):
    """What a target's name stands for: one of its fields.

    `nearest` of a class of objects (food: with food left), the first `object` of a class, the nearest robot of
    this `team`, or the nearest robot that is a "teammate", an "opponent" or "any". A `color` alone, for cameras.
    A `signal` alone, or beside `team` or `robot`, means robots that raise it. `nearest` may pass over objects that
    are `unclaimed` no more: another robot `within` that far of them raises this signal.
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
    """A feature under a name of its own: the `reading` behind it, whose usual feature it stands in for."""

    reading: str
    doc: str = ""


class Goal(StrictStruct, frozen=True, kw_only=True):
    """When a world is finished: all food `delivered`, so many boxes `gathered`, or a robot (or `all`) at a target.

    The target is a class of objects, any one of it, and `within` how near to it.
    """

    delivered: bool = False
    gathered: int = 0
    target: str | None = None
    within: float = 0.5
    all: bool = False


class Scenario(StrictStruct, frozen=True, kw_only=True):
    """Everything that makes a world, but for the seed."""

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
