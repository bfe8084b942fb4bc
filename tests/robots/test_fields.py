"""Numbers out of messages, by hand: REP 117 for ranges, sectors of scans, headings."""

from __future__ import annotations

from math import cos, inf, isnan, nan, pi, sin, tau
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ODOMETRY, RANGE, SCAN

from understudy.addons.robots.robot_file import ReadingSpec
from understudy.addons.robots.ros.message_readings import compute_heading, make_extractor
from understudy.model.value_kinds import BOOLEAN, Continuous, Toroidal
from understudy.records.messages import decode_message, encode_message, make_message
from understudy.sim.scenario.toml_decode import DecodeProblem

RANGES = [  # what a sonar from 0.1 to 3 m says, how far from the rim 0.2 m before it that is
    (1.5, 1.3),
    (0.15, 0.0),  # the rim is nearer than the sensor
    (3.0, 2.8),
    (inf, 2.8),  # nothing in reach
    (-inf, 0.0),  # too near to tell: its minimum
    (nan, nan),  # no answer
    (3.5, nan),  # invalid, says REP 117
    (0.05, nan),
]

BEAMS = (1.0, 2.0, inf, -inf, nan, 0.5)
"""A scan from 0.2 to 4 m, beams every 45 degrees from -90: at -90, -45, 0, 45, 90 and 135 degrees."""
SECTORS = [  # from, to, nearest
    ((-90, -45), 1.0),
    ((-45, -45), 2.0),
    ((-50, -40), 2.0),
    ((-1, 1), 4.0),
    ((0, 45), 0.2),
    ((80, 100), nan),  # it did not answer
    ((100, 260), 0.5),
    ((90, 270), 0.5),  # one did not answer, and others did
    ((135, -90), 0.5),  # across the rear: both edges
    ((200, 230), nan),  # no beam there
    ((180, 180), nan),
    ((30, 30), 0.2),  # the nearest beam
    ((-180, 180), 0.2),
]

WRONG: list[tuple[dict[str, Any], str]] = [
    ({"type": "sensor_msgs/msg/Rnage"}, "type"),
    ({"type": SCAN}, "sector_deg"),
    ({"type": SCAN, "sector_deg": (0, 1), "field": "ranges"}, "field"),
    ({"type": RANGE, "sector_deg": (0, 1)}, "sector_deg"),
    ({"type": ODOMETRY}, "field"),
    ({"type": ODOMETRY, "field": "pose.pose.position.q"}, "field"),
    ({"type": ODOMETRY, "field": "pose.pose.position"}, "field"),
    ({"type": ODOMETRY, "field": "pose.pose.position.x.y"}, "field"),
    ({"type": ODOMETRY, "field": "child_frame_id"}, "field"),
    ({"type": ODOMETRY, "field": "pose.pose.position.x", "offset_m": 0.1}, "offset_m"),
]


def value(message: Any, **of: Any) -> float:
    found = make_extractor(ReadingSpec(topic="t", **of))
    assert not isinstance(found, DecodeProblem), found
    return found[2](message)


def same(one: float, other: float) -> bool:
    return one == pytest.approx(other, abs=1e-6, nan_ok=True)


@pytest.mark.parametrize(("said", "is_"), RANGES)
def test_a_range(said: float, is_: float) -> None:
    message = make_message(RANGE, min_range=0.1, max_range=3.0, range=said)
    assert same(value(message, type=RANGE, offset_m=0.2), is_)


@pytest.mark.parametrize(("said", "is_"), [(-inf, 0.0), (inf, 0.4), (nan, nan)])
def test_a_sensor_that_only_tells_whether_something_is_there(said: float, is_: float) -> None:
    """REP 117: its limits are one, and -inf says that there is."""
    message = make_message(RANGE, min_range=0.5, max_range=0.5, range=said)
    assert same(value(message, type=RANGE, offset_m=0.1), is_)


@pytest.mark.parametrize(("theta", "is_"), [(0.5, 0.5), (-0.5, tau - 0.5), (-1e-18, 0.0), (inf, nan)])
def test_the_direction_of_a_pose_in_the_plane(theta: float, is_: float) -> None:
    found = make_extractor(ReadingSpec(topic="t", type="geometry_msgs/msg/Pose2D", field="theta"))
    assert not isinstance(found, DecodeProblem)
    assert found[:2] == (Toroidal(), "rad")
    assert same(found[2](make_message("geometry_msgs/msg/Pose2D", theta=theta)), is_)


@pytest.mark.parametrize(("x", "is_"), [(1.5, 1.5), (-1e30, -1e30), (1e31, nan), (-1.7e308, nan), (inf, nan)])
def test_what_nothing_measures_is_absent(x: float, is_: float) -> None:
    message = make_message(ODOMETRY)
    message.pose.pose.position.x = x
    assert same(value(message, type=ODOMETRY, field="pose.pose.position.x"), is_)


def scan(*ranges: float) -> Any:
    """As it comes over the wire: angles are 32-bit floats."""
    message = make_message(
        SCAN,
        angle_min=-pi / 2,
        angle_max=3 * pi / 4,
        angle_increment=pi / 4,
        range_min=0.2,
        range_max=4.0,
        ranges=np.array(ranges, np.float32),
    )
    return decode_message(SCAN, encode_message(SCAN, message))


@pytest.mark.parametrize(("sector", "nearest"), SECTORS)
def test_a_sector_of_a_scan(sector: tuple[float, float], nearest: float) -> None:
    assert same(value(scan(*BEAMS), type=SCAN, sector_deg=sector), nearest)


def test_a_scan_of_nothing_is_absent() -> None:
    assert isnan(value(scan(), type=SCAN, sector_deg=(-180, 180)))


def test_a_not_a_number_that_signals_is_absent_like_any_other() -> None:
    """NumPy warns of those; warnings are errors here."""
    message = scan(*BEAMS)
    message.ranges = np.full(len(BEAMS), 0x7FA00000, np.uint32).view(np.float32)
    assert isnan(value(message, type=SCAN, sector_deg=(-180, 180)))


@given(
    st.lists(st.floats(width=32), max_size=8), st.floats(width=32), st.floats(width=32), st.floats(width=32)
)
def test_a_scan_of_anything_reads_within_its_limits_or_is_absent(
    ranges: list[float], step: float, low: float, high: float
) -> None:
    message = scan(*ranges)
    message.angle_increment, message.range_min, message.range_max = step, low, high
    with np.errstate(all="ignore"):
        read = value(message, type=SCAN, sector_deg=(-30, 30))
    assert isnan(read) or max(low, 0) <= read <= max(high, 0)


@given(st.floats(0, tau, exclude_max=True), st.floats(0.8, 1.2))
def test_a_heading(angle: float, scale: float) -> None:
    """Turned by `angle` about z; the quaternion need not be normal."""
    quaternion = make_message(
        "geometry_msgs/msg/Quaternion", z=scale * sin(angle / 2), w=scale * cos(angle / 2)
    )
    away = abs(compute_heading(quaternion) - angle)
    assert min(away, tau - away) < 1e-6
    assert 0 <= compute_heading(quaternion) < tau


def test_an_orientation_left_at_zero_is_no_heading() -> None:
    assert isnan(compute_heading(make_message("geometry_msgs/msg/Quaternion", w=0.0)))


def test_kinds_and_units_follow_from_the_field() -> None:
    rows = [
        (RANGE, None, Continuous(), "m"),
        (ODOMETRY, "pose.pose.orientation", Toroidal(), "rad"),
        ("std_msgs/msg/Bool", "data", BOOLEAN, ""),
        ("sensor_msgs/msg/BatteryState", "percentage", Continuous(), ""),
    ]
    for type, field, kind, unit in rows:
        found = make_extractor(ReadingSpec(topic="t", type=type, field=field))
        assert not isinstance(found, DecodeProblem)
        assert found[:2] == (kind, unit)


@pytest.mark.parametrize(("of", "key"), WRONG)
def test_what_no_message_has_is_said(of: dict[str, Any], key: str) -> None:
    found = make_extractor(ReadingSpec(topic="t", **of))
    assert isinstance(found, DecodeProblem)
    assert found.key == key
