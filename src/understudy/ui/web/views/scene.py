"""Describe the parts of world and kit that do not change from tick to tick, as data for the page."""

from __future__ import annotations

from math import isinf, isnan
from typing import Literal, Self, TypeAlias

from msgspec import UNSET, UnsetType, field

from understudy.addons.robots.twin import DigitalTwin, Ground
from understudy.model.library import Kit
from understudy.model.value_kinds import Kind
from understudy.sim.body_world import BodyWorld
from understudy.sim.scenario.files import MARKER
from understudy.sim.scenario.schema import MOUSE, Camera, RobotType
from understudy.sim.sensing.sensor_table import list_range_scans
from understudy.ui.web.messages.base import Data

Drawing: TypeAlias = Literal["map", "pictures", "none"]
"""How a world is shown: as a map, by the pictures that a body of the user's own draws, or by readings alone."""
KindName: TypeAlias = Literal["continuous", "toroidal", "categorical"]


class RobotTypeData(Data, frozen=True, kw_only=True):
    """A type of robots, for drawing."""

    name: str
    radius: float
    color: str | None
    team: str


class ObjectClassData(Data, frozen=True, kw_only=True):
    """A class of objects."""

    name: str
    color: str | None
    radius: float
    food: bool
    home: bool
    solid: bool
    pushable: bool
    """Whether robots can push or pull it."""
    marker: bool
    """Whether this is a marker that a person placed."""
    offered: bool
    """Whether the page offers to add one."""


class DiscData(Data, frozen=True, kw_only=True):
    """A round obstacle."""

    x: float
    y: float
    radius: float
    color: str | None


class RangeArcData(Data, frozen=True, kw_only=True):
    """The arc of a distance sensor relative to the robot's heading; both angles are equal for a beam."""

    reading: str = field(name="name")
    from_deg: float
    to_deg: float
    range: float


class CameraData(Data, frozen=True, kw_only=True):
    """The field of view of a robot's camera."""

    view_deg: float
    range: float | None
    """The range in m; null if it is unlimited."""


class FeatureData(Data, frozen=True, kw_only=True):
    """A feature with its unit and the kind of its values."""

    label: str
    unit: str
    kind: KindName
    labels: list[str] | UnsetType = UNSET
    """The names of the values of a categorical feature."""
    period: float | UnsetType = UNSET
    """The period of a toroidal feature."""

    @classmethod
    def of_kind(cls, kind: Kind, label: str, unit: str, **more: object) -> Self:
        """Describe a feature of this kind, with what else a subclass has."""
        return cls.of(kind, label=label, unit=unit, kind=type(kind).__name__.lower(), **more)


class KitFeatureData(FeatureData, frozen=True, kw_only=True):
    """A feature that a new automaton may use, as the page gets it."""

    parameters: list[str]


class BehaviorParametersData(Data, frozen=True, kw_only=True):
    """A behavior that the states of an automaton may run, or a property be about, with its parameters."""

    name: str
    parameters: list[str]


class SquadSortData(Data, frozen=True, kw_only=True):
    """A sort of squads."""

    name: str
    doc: str
    squads: list[list[int]]
    """The robots of each squad, including those of its subordinate squads."""


class SceneData(Data, frozen=True, kw_only=True):
    """The parts of world and kit that do not change from tick to tick."""

    scenario: str
    width: float
    height: float
    tick_s: float
    seed: int
    drawing: Drawing
    real_robots: list[str]
    """The names of the real robots; empty in simulation."""
    camera_robots: list[int]
    """The numbers of the real robots that have a camera."""
    needs_held_key: bool
    """Whether real robots move only while a key is held."""
    robots: int
    types: list[RobotTypeData]
    robot_type: list[int]
    classes: list[ObjectClassData]
    walls: list[tuple[float, float, float, float]]
    polygons: list[list[tuple[float, float]]]
    discs: list[DiscData]
    targets: list[str]
    sonars: list[list[RangeArcData]]
    """By type of robots."""
    cameras: list[list[CameraData]]
    """By type of robots."""
    features: list[KitFeatureData]
    behaviors: list[BehaviorParametersData]
    """The basic ones."""
    squads: list[SquadSortData]
    """The topmost sort first."""


def describe_scene(world: Ground, kit: Kit, squads: list[SquadSortData]) -> SceneData:
    """Return everything the page needs to draw a world and to choose from a kit."""
    view, scenario = world.view(), world.scenario
    kinds = [scenario.types[name] for name in world.names.types]
    discs = zip(view.discs.x, view.discs.y, view.discs.radius, view.discs.color, strict=True)
    return SceneData(
        scenario=scenario.name,
        width=view.width,
        height=view.height,
        tick_s=world.tick_s,
        seed=world.seeds[0],
        drawing=_choose_drawing(world),
        real_robots=[robot.file.name for robot in world.fleet] if isinstance(world, DigitalTwin) else [],
        camera_robots=_eyes(world),
        needs_held_key=isinstance(world, DigitalTwin) and world.fleet.needs_hold_to_run,
        robots=world.robots,
        types=[
            RobotTypeData.of(kind, name=name, team=kind.team or name)
            for name, kind in zip(world.names.types, kinds, strict=True)
        ],
        robot_type=view.robots.type.tolist(),
        classes=_classes(world),
        walls=view.walls.tolist(),
        polygons=[corners.tolist() for corners in view.polygons],
        discs=[
            DiscData(x=float(x), y=float(y), radius=float(radius), color=view.color(int(color)))
            for x, y, radius, color in discs
        ],
        targets=list(world.targets),
        sonars=[_sonars(kind) for kind in kinds],
        cameras=[_cameras(kind) for kind in kinds],
        features=[
            KitFeatureData.of_kind(feature.kind, name, feature.unit, parameters=feature.parameters)
            for name, feature in kit.features.items()
        ],
        behaviors=[
            BehaviorParametersData.of(behavior, name=name) for name, behavior in kit.behaviors.items()
        ],
        squads=squads,
    )


def _choose_drawing(world: Ground) -> Drawing:
    if not isinstance(world, BodyWorld):
        return "map"
    return "pictures" if world.has_picture else "none"


def _eyes(world: Ground) -> list[int]:
    """Return the numbers of the real robots that have a camera."""
    if not isinstance(world, DigitalTwin):
        return []
    return [number for number, robot in enumerate(world.fleet) if robot.senses.camera is not None]


def _classes(world: Ground) -> list[ObjectClassData]:
    view, rows = world.view(), world.rules.classes
    pointed = any(MOUSE in (target.object, target.nearest) for target in world.scenario.targets.values())
    return [
        ObjectClassData(
            name=name,
            color=view.color(int(row["color"])),
            radius=float(row["radius"]),
            food=bool(row["food"]),
            home=bool(row["home"]),
            solid=bool(row["solid"]),
            pushable=bool(row["pushable"] or row["pull"]),
            marker=name == MARKER,
            offered=pointed or name != MOUSE,
        )
        for name, row in zip(world.names.classes, rows, strict=True)
    ]


def _sonars(kind: RobotType) -> list[RangeArcData]:
    return [RangeArcData.of(arc, range=scan.range) for scan in list_range_scans(kind) for arc in scan.arcs]


def _cameras(kind: RobotType) -> list[CameraData]:
    return [
        CameraData(view_deg=sensor.view_deg, range=_finite(sensor.range))
        for sensor in kind.sensors
        if isinstance(sensor, Camera)
    ]


def _finite(number: float | None) -> float | None:
    """Return a number, or None if it is infinite, NaN or None, which JSON cannot represent."""
    return None if number is None or isnan(number) or isinf(number) else number
