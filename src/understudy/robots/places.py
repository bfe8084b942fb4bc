"""Places of targets: how far they are from a robot and in which direction, as a simulated locator reads them."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, hypot, isfinite, isnan, nan, tau

from understudy.model.features import ReadingKey
from understudy.robots.robot_file import PlaceOf
from understudy.robots.sources import PLACE

POSE = ("x", "y", "heading")


def located(targets: Mapping[str, PlaceOf], values: Mapping[ReadingKey, float]) -> dict[ReadingKey, float]:
    """`range` (m) and `bearing` (rad, in [0, tau)) of each target, from `values`: the robot's pose, places told."""
    found: dict[ReadingKey, float] = {}
    pose = tuple(values.get((name, None), nan) for name in POSE)
    for name, target in targets.items():
        x, y = target.at or (values.get((axis, name), nan) for axis in PLACE)
        found["range", name], found["bearing", name] = _polar(
            x, y, (0.0, 0.0, 0.0) if target.relative else pose
        )
    return found


def _polar(x: float, y: float, pose: tuple[float, ...]) -> tuple[float, float]:
    ahead, left, heading = x - pose[0], y - pose[1], pose[2]
    distance = hypot(ahead, left)
    if not isfinite(distance) or isnan(heading):  # what is far beyond all places is none, either
        return nan, nan
    return distance, (atan2(left, ahead) - heading) % tau % tau
