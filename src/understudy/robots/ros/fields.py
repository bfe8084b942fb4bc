"""Numbers out of messages: the value that a robot's file asks for, absent (NaN) where a message holds none."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, inf, isfinite, isinf, nan, radians, tau
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import BOOLEAN, Column, Continuous, Kind, Toroidal
from understudy.robots.robot_file import ReadingSpec, TargetPlaceSpec
from understudy.robots.ros.messages import BASE, NAMED, is_known_type, list_message_fields
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.sensing.sectors import find_nearest_beam, measure_widest_opening

Extract: TypeAlias = Callable[[Any], float]

RANGE, SCAN = "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan"
BEARING, WIDTH = "bearing", "width"
"""What a reading may be of a scan, beside the nearest distance."""
CLEAR_M = 1.0
"""What lies farther from the rim than this leaves room to pass, where a robot's file says nothing else."""
QUATERNION = "geometry_msgs/msg/Quaternion"
POSE_2D = "geometry_msgs/msg/Pose2D", "theta"
"""The one number of common messages that is a direction."""
LARGEST = 1e30
"""Numbers beyond it measure nothing: their squares would be no numbers any more."""
_SAME = 1e-4
"""Angles (rad) nearer to each other than this are one: those of scans are sums of 32-bit floats."""
_SAME_M = 1e-6
"""Distances nearer to each other than this share of them are one: those in scans are 32-bit floats."""


def make_extractor(reading: ReadingSpec) -> tuple[Kind, str, Extract] | DecodeProblem:
    """The kind and unit of a reading and what takes it out of a message; or what in its description cannot be."""
    if not is_known_type(reading.type):
        problem = f"is {reading.type!r:.60}, which is unknown"
        return DecodeProblem(
            "type", problem, "give a type of ROS 2's common interfaces, as sensor_msgs/msg/Range"
        )
    if reading.clear_m is not None and (reading.type, reading.field) != (SCAN, WIDTH):
        return DecodeProblem("clear_m", f'is only used with field = "width" of a {SCAN}', "leave it out")
    if reading.type == SCAN:
        return _make_scan_extractor(reading)
    if reading.sector_deg is not None:
        return DecodeProblem(
            "sector_deg", f"is not used with a {reading.type}", f"leave it out, or read a {SCAN}"
        )
    if reading.type == RANGE and reading.field in (None, "range"):
        return Continuous(), reading.unit or "m", _of_range(reading.offset_m)
    if reading.offset_m:
        return DecodeProblem("offset_m", "is only used with ranges", "leave it out")
    if reading.field is None:
        return DecodeProblem(
            "field", "is missing", f"give one of {', '.join(list_message_fields(reading.type))}"
        )
    return _of_field(reading.type, reading.field, reading.unit)


def make_position_extractor(target: TargetPlaceSpec) -> Callable[[Any], tuple[float, float]] | DecodeProblem:
    """What takes a target's x and y, m, out of a message; absent where one of them is not finite."""
    if not is_known_type(target.type):
        problem = f"is {target.type!r:.60}, which is unknown"
        return DecodeProblem("type", problem, "give a type of ROS 2's common interfaces")
    found = [_of_field(target.type, f"{target.field}.{axis}", "m") for axis in ("x", "y")]
    for each in found:
        if isinstance(each, DecodeProblem):
            return DecodeProblem("field", f"is {target.field!r:.60}, which has no x and y", each.remedy)
    ahead, left = (each[2] for each in found if not isinstance(each, DecodeProblem))

    def extract(message: Any) -> tuple[float, float]:
        x, y = ahead(message), left(message)
        return (x, y) if isfinite(x) and isfinite(y) else (nan, nan)

    return extract


def _of_field(type: str, path: str, unit: str) -> tuple[Kind, str, Extract] | DecodeProblem:
    """What is at the end of a path of names."""
    sort, of = NAMED, type
    for name in path.split("."):
        inside = list_message_fields(of) if sort == NAMED else {}
        if name not in inside:
            has = f"give one of {', '.join(inside)}" if inside else "end the path before it"
            return DecodeProblem("field", f"is {path!r:.60}, and there is no {name!r}", has)
        sort, of = inside[name]
    if (sort, of) == (NAMED, QUATERNION):
        return Toroidal(), unit or "rad", lambda message: compute_heading(_walk(message, path))
    if sort != BASE or of[0] == "string":
        remedy = "give the path of a number, of a truth or of an orientation"
        return DecodeProblem("field", f"is {path!r:.60}, which is not a number", remedy)
    if (type, path) == POSE_2D:
        return Toroidal(), unit or "rad", lambda message: _turned(float(_walk(message, path)))
    kind = BOOLEAN if of[0] == "bool" else Continuous()
    return kind, unit, lambda message: _finite(float(_walk(message, path)))


def _walk(message: Any, path: str) -> Any:
    for name in path.split("."):
        message = getattr(message, name)
    return message


def _finite(value: float) -> float:
    return value if abs(value) <= LARGEST else nan


def compute_heading(quaternion: Any) -> float:
    """The direction in the plane of an orientation (REP 103), in [0, tau), rad; NaN where it is none."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    norm = x * x + y * y + z * z + w * w
    if not 0.5 < norm < 2.0:  # many drivers leave it at zero; NaN is not between them either
        return nan
    return _turned(atan2(2 * (w * z + x * y) / norm, 1 - 2 * (y * y + z * z) / norm))


def _turned(angle: float) -> float:
    """An angle in [0, tau), rad; NaN where it is not finite."""
    return angle % tau % tau if isfinite(angle) else nan


def _of_range(offset_m: float) -> Extract:
    """REP 117: +inf is nothing in reach, -inf too near to tell how near; all else outside its limits is invalid.

    Of a sensor that only tells whether something is there, both limits are one: -inf is contact, 0.
    """

    def extract(message: Any) -> float:
        return _clear(message.range, message.min_range, message.max_range, offset_m)

    return extract


def _clear(value: float, low: float, high: float, offset_m: float) -> float:
    """A distance from the rim, m: what hears nothing reads its maximum, what is too near its minimum."""
    if value == -inf and low == high:
        return 0.0 if isfinite(high) else nan
    if isinf(value):
        value = high if value > 0 else low
    return _finite(max(value - offset_m, 0.0)) if low <= value <= high else nan


def _make_scan_extractor(reading: ReadingSpec) -> tuple[Kind, str, Extract] | DecodeProblem:
    """The nearest return in a sector of a scan, its bearing, or the widest opening there."""
    if reading.sector_deg is None:
        return DecodeProblem("sector_deg", "is missing", "give sector_deg = [from, to] and no field")
    sector, offset_m = ScanSector(*map(radians, reading.sector_deg)), reading.offset_m
    if reading.field is None:
        return Continuous(), reading.unit or "m", lambda scan: sector.find_nearest(scan, offset_m)
    if reading.field == BEARING:
        return Toroidal(), reading.unit or "rad", sector.find_bearing
    if reading.field == WIDTH:
        clear_m = CLEAR_M if reading.clear_m is None else reading.clear_m
        return Continuous(), reading.unit or "m", lambda scan: sector.measure_opening(scan, offset_m, clear_m)
    remedy = 'give sector_deg = [from, to] and no field, or field = "bearing" or "width"'
    return DecodeProblem("field", "is not used with a scan", remedy)


class ScanSector:
    """A sector of a LaserScan, counter-clockwise from one angle (rad) to another, both edges part of it."""

    def __init__(self, start: float, end: float) -> None:
        self._start = start
        self._full = end - start >= tau - _SAME
        self._width = tau if self._full else (end - start) % tau
        self._beam = not self._full and (self._width < _SAME or self._width > tau - _SAME)

    def find_nearest(self, scan: Any, offset_m: float) -> float:
        """Return the nearest distance, `offset_m` taken off; NaN where no beam in the sector answered."""
        _, _, ranges = self._select(scan)
        ranges = ranges[~np.isnan(ranges)]
        return _finite(max(float(ranges.min()) - offset_m, 0.0)) if len(ranges) else nan

    def find_bearing(self, scan: Any) -> float:
        """Return the direction (rad, [0, tau)) of the nearest return; NaN where nothing is in range."""
        _, after, ranges = self._select(scan)
        nearest = find_nearest_beam(ranges, 0, len(ranges), len(ranges))
        if nearest < 0 or ranges[nearest] >= scan.range_max:
            return nan
        return float(_turned(self._start + after[nearest]))

    def measure_opening(self, scan: Any, offset_m: float, clear_m: float) -> float:
        """Return how wide (m) the widest opening is; NaN where no beam in the sector answered.

        An opening ends where the scan does. Of a scan that goes around more than once the first turn counts.
        """
        numbers, after, ranges = self._select(scan)
        spacing = abs(scan.angle_increment)
        first_turn = numbers * spacing < tau - _SAME
        numbers, after, ranges = numbers[first_turn], after[first_turn], ranges[first_turn]
        if np.isnan(ranges).all():
            return nan
        if self._full:
            ranges = ranges[np.argsort(numbers)]
        else:
            ranges = np.insert(ranges, np.flatnonzero(np.diff(after) > 1.5 * spacing) + 1, nan)
        far, count = np.maximum(ranges - offset_m, 0.0), len(ranges)
        far[np.abs(far - clear_m) < _SAME_M * (clear_m + offset_m)] = clear_m
        return measure_widest_opening(far.tolist(), 0, count, count, spacing, offset_m, clear_m)

    def _select(self, scan: Any) -> tuple[NDArray[np.intp], Column, Column]:
        """Return beams in the sector, how far (rad) they are after its start, in this order, and what they measured.

        Where nothing is in range that is the scan's largest distance, what is too near its least; NaN if invalid.
        """
        with np.errstate(invalid="ignore"):  # some NaN are said to be signals, which anybody may send
            ranges = np.asarray(scan.ranges, np.float64)
        low, high, step = scan.range_min, scan.range_max, scan.angle_increment
        if not (len(ranges) and all(map(isfinite, (scan.angle_min, step, low, high)))):
            return np.zeros(0, np.intp), np.zeros(0), np.zeros(0)
        after = (scan.angle_min + step * np.arange(len(ranges)) - self._start) % tau
        if self._beam:
            away = np.minimum(after, tau - after)
            nearest = int(np.argmin(away))
            chosen = np.array([nearest] if away[nearest] <= abs(step) / 2 + _SAME else [], np.intp)
        else:
            after = np.where(after >= tau - _SAME, after - tau, after)
            chosen = np.argsort(after, kind="stable")
            chosen = chosen[after[chosen] <= self._width + _SAME]
        after, ranges = after[chosen], ranges[chosen]
        ranges = np.where(ranges == inf, high, np.where(ranges == -inf, low, ranges))
        return chosen, after, np.where((ranges >= low) & (ranges <= high), ranges, nan)
