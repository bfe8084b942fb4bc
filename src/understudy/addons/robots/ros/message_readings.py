"""Extraction of readings from messages: the number a robot file asks for, NaN if a message does not have it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from math import atan2, inf, isfinite, isinf, nan, radians, tau
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.robot_file import ReadingSpec, TargetPlaceSpec
from understudy.errors import suggest_known_name
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Kind, Toroidal
from understudy.records.messages import (
    ARRAY,
    BASE,
    NAMED,
    SEQUENCE,
    is_known_type,
    list_message_fields,
)
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.sensing.sectors import find_nearest_beam, measure_widest_opening

Extract: TypeAlias = Callable[[Any], float]
ListFields: TypeAlias = Callable[[str], Mapping[str, tuple[int, Any]]]
"""A function from the name of a message type to its fields by name: the node type and element type of each."""

RANGE, SCAN = "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan"
BEARING, WIDTH = "bearing", "width"
"""The fields that a reading may name for a scan, besides none for the nearest distance."""
BEAM = re.compile(r"ranges\.(\d+)")
"""A field of a scan that a recording may name: a beam by its number."""
TIMES = frozenset({"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"})
MAY_LACK = frozenset({(SCAN, BEARING)})
"""The types and fields of readings that a valid message may lack; other absent ones stop a robot that requires them."""
CLEAR_M = 1.0
"""The default distance from the rim, in m, beyond which the way is clear."""
QUATERNION = "geometry_msgs/msg/Quaternion"
POSE_2D = "geometry_msgs/msg/Pose2D", "theta"
"""The only number in common messages that is a direction."""
LARGEST = 1e30
"""The largest absolute value that counts as a measurement; the squares of larger ones may overflow."""
_SAME = 1e-4
"""The difference of two angles, in rad, below which they count as equal.

Angles of scans are sums of 32-bit floats.
"""
_SAME_M = 1e-6
"""The relative difference of two distances below which they count as equal.

Distances in scans are 32-bit floats.
"""


def make_extractor(
    reading: ReadingSpec, list_fields: ListFields | None = None
) -> tuple[Kind, str, Extract] | DecodeProblem:
    """Make the kind, unit and extracting function of a reading, or return what in its description is invalid.

    `list_fields` returns the fields of a message type by name; a recording brings its own types with it.
    """
    if list_fields is None and not is_known_type(reading.type):
        problem = f"is {reading.type!r:.60}, which is unknown"
        return DecodeProblem(
            "type", problem, "give a type of ROS 2's common interfaces, as sensor_msgs/msg/Range"
        )
    if reading.clear_m is not None and (reading.type, reading.field) != (SCAN, WIDTH):
        return DecodeProblem("clear_m", f'is only used with field = "width" of a {SCAN}', "leave it out")
    if reading.type == SCAN and (beam := BEAM.fullmatch(reading.field or "")) and list_fields is not None:
        return Continuous(), reading.unit or "m", _of_beam(int(beam[1]), reading.offset_m)
    if reading.type == SCAN and (list_fields is None or reading.field in (None, BEARING, WIDTH)):
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
            "field",
            "is missing",
            f"give one of {', '.join((list_fields or list_message_fields)(reading.type))}",
        )
    return make_field_extractor(reading.type, reading.field, reading.unit, list_fields or list_message_fields)


def make_position_extractor(target: TargetPlaceSpec) -> Callable[[Any], tuple[float, float]] | DecodeProblem:
    """Make the function that takes x and y (m) of a target from a message; both are NaN unless both are finite.

    If the target's description is invalid, what is wrong is returned instead.
    """
    if not is_known_type(target.type):
        problem = f"is {target.type!r:.60}, which is unknown"
        return DecodeProblem("type", problem, "give a type of ROS 2's common interfaces")
    extractors = [make_field_extractor(target.type, f"{target.field}.{axis}", "m") for axis in ("x", "y")]
    for each in extractors:
        if isinstance(each, DecodeProblem):
            return DecodeProblem("field", f"is {target.field!r:.60}, which has no x and y", each.remedy)
    ahead, left = (each[2] for each in extractors if not isinstance(each, DecodeProblem))

    def extract(message: Any) -> tuple[float, float]:
        x, y = ahead(message), left(message)
        return (x, y) if isfinite(x) and isfinite(y) else (nan, nan)

    return extract


def make_field_extractor(
    type: str, path: str, unit: str, list_fields: ListFields = list_message_fields
) -> tuple[Kind, str, Extract] | DecodeProblem:
    """Make the kind, unit and extracting function of the field at the end of a path of names.

    The path may have numbers of elements of lists. `list_fields` returns the fields of a message type by name.
    """
    field = find_message_field(type, path, list_fields)
    if isinstance(field, DecodeProblem):
        return field
    node_type, of = field
    if node_type == NAMED and of in TIMES:
        return Continuous(), unit or "s", lambda message: _seconds(_walk(message, path))
    if (node_type, of) == (NAMED, QUATERNION):
        return Toroidal(), unit or "rad", lambda message: compute_heading(_walk(message, path))
    if node_type != BASE or of[0] == "string":
        inside = list_fields(of) if node_type == NAMED else {}
        fields = f", such as {path}.{next(iter(inside))}" if inside else ""
        remedy = f"give the path of a number, of a truth or of an orientation{fields}"
        return DecodeProblem("field", f"is {path!r:.60}, which is not a number", remedy)
    if (type, path) == POSE_2D:
        return Toroidal(), unit or "rad", lambda message: _turned(float(_walk(message, path)))
    kind = BOOLEAN if of[0] == "bool" else Continuous()
    return kind, unit, lambda message: _finite(float(_walk(message, path)))


def find_message_field(type: str, path: str, list_fields: ListFields) -> tuple[int, Any] | DecodeProblem:
    """Find the node type and element type of the field at the end of a path, or return what of the path is invalid."""
    node_type: int = NAMED
    of: Any = type
    for name in path.split("."):
        if node_type in (ARRAY, SEQUENCE) and name.isdecimal():
            (node_type, of), _length = of
            continue
        inside = list_fields(of) if node_type == NAMED else {}
        if name not in inside:
            has = f"{suggest_known_name(name, inside)}give one of {', '.join(inside)}"
            if node_type in (ARRAY, SEQUENCE):
                has = "give the number of an element, from 0"
            elif not inside:
                has = "end the path before it"
            return DecodeProblem("field", f"is {path!r:.60}, and there is no {name!r}", has)
        node_type, of = inside[name]
    return node_type, of


def _walk(message: Any, path: str) -> Any:
    for name in path.split("."):
        if name.isdecimal():
            if int(name) >= len(message):  # a list may be shorter in some messages
                return nan
            message = message[int(name)]
        else:
            message = getattr(message, name)
    return message


def _seconds(stamp: Any) -> float:
    """Return a time or duration of ROS in s; absent if it is a list that had no such element."""
    return float(stamp.sec + stamp.nanosec * 1e-9) if hasattr(stamp, "sec") else nan


def _finite(value: float) -> float:
    return value if abs(value) <= LARGEST else nan


def compute_heading(quaternion: Any) -> float:
    """Compute the heading of an orientation (REP 103), in [0, tau) rad; NaN if its norm is far from 1."""
    x, y, z, w = quaternion.x, quaternion.y, quaternion.z, quaternion.w
    norm = x * x + y * y + z * z + w * w
    if not 0.5 < norm < 2.0:  # many drivers leave it at zero; NaN is not between them either
        return nan
    return _turned(atan2(2 * (w * z + x * y) / norm, 1 - 2 * (y * y + z * z) / norm))


def _turned(angle: float) -> float:
    """Wrap an angle to [0, tau) rad; NaN if it is not finite."""
    return angle % tau % tau if isfinite(angle) else nan


def _of_range(offset_m: float) -> Extract:
    """Make the function that takes the distance from a Range message, read as REP 117 defines it.

    +inf means that nothing is in reach, and -inf that something is too near to measure; other values outside the
    limits are invalid. Sensors that only detect contact have equal limits; -inf is contact there, and reads 0.
    """

    def extract(message: Any) -> float:
        return _clear(message.range, message.min_range, message.max_range, offset_m)

    return extract


def _of_beam(number: int, offset_m: float) -> Extract:
    """Make the function that takes the distance of a beam by its number, read as a Range is."""

    def extract(scan: Any) -> float:
        if number >= len(scan.ranges):
            return nan
        return _clear(float(scan.ranges[number]), scan.range_min, scan.range_max, offset_m)

    return extract


def _clear(value: float, low: float, high: float, offset_m: float) -> float:
    """Compute a distance from the rim, in m.

    It is the maximum if nothing is in reach, and the minimum if something is too near.
    """
    if value == -inf and low == high:
        return 0.0 if isfinite(high) else nan
    if isinf(value):
        value = high if value > 0 else low
    return _finite(max(value - offset_m, 0.0)) if low <= value <= high else nan


def _make_scan_extractor(reading: ReadingSpec) -> tuple[Kind, str, Extract] | DecodeProblem:
    """Make the extractor for the nearest return in a sector of a scan, for its bearing, or for the widest opening."""
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
    """A sector of a LaserScan, counter-clockwise from angle `start` to angle `end` (rad), both included."""

    def __init__(self, start: float, end: float) -> None:
        self._start = start
        self._full = end - start >= tau - _SAME
        self._width = tau if self._full else (end - start) % tau
        self._beam = not self._full and (self._width < _SAME or self._width > tau - _SAME)

    def find_nearest(self, scan: Any, offset_m: float) -> float:
        """Return the nearest distance minus `offset_m`, in m; NaN if no beam in the sector is valid."""
        _, _, ranges = self._select(scan)
        ranges = ranges[~np.isnan(ranges)]
        return _finite(max(float(ranges.min()) - offset_m, 0.0)) if len(ranges) else nan

    def find_bearing(self, scan: Any) -> float:
        """Return the direction (rad, [0, tau)) of the nearest return; NaN if nothing is in range."""
        _, after, ranges = self._select(scan)
        nearest = find_nearest_beam(ranges, 0, len(ranges), len(ranges))
        if nearest < 0 or ranges[nearest] >= scan.range_max:
            return nan
        return float(_turned(self._start + after[nearest]))

    def measure_opening(self, scan: Any, offset_m: float, clear_m: float) -> float:
        """Return the width (m) of the widest opening; NaN if no beam in the sector is valid.

        An opening ends at the edge of the scan. If a scan goes around more than once, its first turn counts.
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
        """Return the numbers, angles and ranges of the beams in the sector, sorted by angle.

        Angles are in rad after the start of the sector. A range is the scan's maximum if nothing is in reach, its
        minimum if something is too near, and NaN if it is invalid.
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
