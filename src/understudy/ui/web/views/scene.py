"""The scene: what of a world does not change from tick to tick, and what its kit has, as plain data for a page."""

from __future__ import annotations

from math import isinf, isnan
from typing import Any, TypeAlias

from understudy.model.kinds import Categorical, Kind, Toroidal
from understudy.model.library import Kit
from understudy.robots.twin import Ground, Twin
from understudy.sim.scenario.files import MARKER
from understudy.sim.scenario.schema import MOUSE, Camera, RobotType, Sonar

Plain: TypeAlias = dict[str, Any]


def scene(world: Ground, kit: Kit) -> Plain:
    """Everything a page needs in order to draw a world and to choose from a kit."""
    view, scenario = world.view(), world.scenario
    kinds = [scenario.types[name] for name in world.names.types]
    discs = zip(view.discs.x, view.discs.y, view.discs.radius, view.discs.color, strict=True)
    return {
        "scenario": scenario.name,
        "width": view.width,
        "height": view.height,
        "tick_s": world.tick_s,
        "seed": world.seeds[0],
        "real": [robot.file.name for robot in world.fleet] if isinstance(world, Twin) else [],
        "eyes": _eyes(world),
        "holds": isinstance(world, Twin) and world.fleet.holds_to_run,
        "robots": world.robots,
        "types": [
            {"name": name, "radius": kind.radius, "color": kind.color, "team": kind.team or name}
            for name, kind in zip(world.names.types, kinds, strict=True)
        ],
        "robot_type": view.robots.type.tolist(),
        "classes": _classes(world),
        "walls": view.walls.tolist(),
        "polygons": [corners.tolist() for corners in view.polygons],
        "discs": [
            {"x": float(x), "y": float(y), "radius": float(radius), "color": view.color(int(color))}
            for x, y, radius, color in discs
        ],
        "targets": list(world.targets),
        "sonars": [_sonars(kind) for kind in kinds],
        "cameras": [_cameras(kind) for kind in kinds],
        "features": [
            {
                "label": name,
                "parameters": list(feature.parameters),
                "unit": feature.unit,
                **described(feature.kind),
            }
            for name, feature in kit.features.items()
        ],
        "behaviors": [
            {"name": name, "parameters": list(behavior.parameters)}
            for name, behavior in kit.behaviors.items()
        ],
    }


def _eyes(world: Ground) -> list[int]:
    """The real robots that have a camera."""
    if not isinstance(world, Twin):
        return []
    return [number for number, robot in enumerate(world.fleet) if robot.senses.eye is not None]


def described(kind: Kind) -> Plain:
    """A kind as a page names it, with its labels or its period."""
    if isinstance(kind, Categorical):
        return {"kind": "categorical", "labels": list(kind.labels)}
    if isinstance(kind, Toroidal):
        return {"kind": "toroidal", "period": kind.period}
    return {"kind": "continuous"}


def _classes(world: Ground) -> list[Plain]:
    view, rows = world.view(), world.rules.classes
    pointed = any(MOUSE in (target.object, target.nearest) for target in world.scenario.targets.values())
    return [
        {
            "name": name,
            "color": view.color(int(row["color"])),
            "radius": float(row["radius"]),
            **{each: bool(row[each]) for each in ("food", "home", "solid")},
            "pushable": bool(row["pushable"] or row["pull"]),  # robots move it
            "marker": name == MARKER,
            "offered": pointed or name != MOUSE,
        }
        for name, row in zip(world.names.classes, rows, strict=True)
    ]


def _sonars(kind: RobotType) -> list[Plain]:
    return [
        {"name": name, "from_deg": start, "to_deg": stop, "range": sensor.range}
        for sensor in kind.sensors
        if isinstance(sensor, Sonar)
        for name, (start, stop) in sensor.sectors.items()
    ]


def _cameras(kind: RobotType) -> list[Plain]:
    return [
        {"view_deg": sensor.view_deg, "range": _finite(sensor.range)}
        for sensor in kind.sensors
        if isinstance(sensor, Camera)
    ]


def _finite(number: float | None) -> float | None:
    """A number as JSON has it: none that is infinite or absent."""
    return None if number is None or isnan(number) or isinf(number) else number
