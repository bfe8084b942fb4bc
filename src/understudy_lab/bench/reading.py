"""The speed of reading a bag: 40 topics at 20 Hz, six of them mapped, one a LaserScan of 360 beams."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import CommandColumn, ReadingColumn, RecordingMap
from understudy.records.messages import TWIST, encode_message, encode_twist, load_typestore, make_message
from understudy_lab.bench.harness import import_peer

TICKS, TICK_S, TOPICS = 6_000, 0.05, 40
GOAL_S = 10.0
"""The longest processor time for an hour, s."""
ROUNDS = 3
BEGAN_NS = 1_700_000_000_000_000_000
SCAN, NUMBER, ODOMETRY = "sensor_msgs/msg/LaserScan", "std_msgs/msg/Float64", "nav_msgs/msg/Odometry"
RANGE, IMU = "sensor_msgs/msg/Range", "sensor_msgs/msg/Imu"
MAPPED = {
    "/scan": SCAN,
    "/odom": ODOMETRY,
    "/range": RANGE,
    "/imu": IMU,
    "/number": NUMBER,
    "/cmd_vel": TWIST,
}
MAPPING = RecordingMap(
    format="understudy-recording-map/1",
    time="time_s",
    readings=(
        ReadingColumn(topic="/scan", sector_deg=(-15.0, 15.0), name="front"),
        ReadingColumn(column="/odom.pose.pose.orientation", name="heading"),
        ReadingColumn(topic="/range", name="near"),
        ReadingColumn(column="/imu.angular_velocity.z", name="turning"),
        ReadingColumn(column="/number.data", name="number"),
    ),
    commands=(CommandColumn(column="/cmd_vel.linear.x", channel="drive"),),
)


def make_scan() -> bytes:
    """Make a scan of 360 beams."""
    ranges = np.random.default_rng(0).uniform(0.5, 9.0, 360).astype(np.float32)
    step = 2 * np.pi / 360
    return encode_message(
        SCAN, make_message(SCAN, angle_increment=step, range_min=0.05, range_max=10.0, ranges=ranges)
    )


def write_bag(path: Path, ticks: int) -> None:
    """Write a bag as MCAP, in which the command alternates every three seconds."""
    writer_class = import_peer("mcap.writer", "mcap").Writer
    types = MAPPED | {f"/other_{number}": NUMBER for number in range(TOPICS - len(MAPPED))}
    messages = {type: encode_message(type, make_message(type)) for type in set(types.values())}
    messages[SCAN] = make_scan()
    twists = [encode_twist(TWIST, speed_m_s=speed, turn_rad_s=0.0) for speed in (0.8, -0.5)]
    with path.open("wb") as file:
        writer = writer_class(file)
        writer.start()
        channels = {}
        for topic, type in types.items():
            definition, _ = load_typestore().generate_msgdef(type, ros_version=2)
            schema = writer.register_schema(type, "ros2msg", definition.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for tick in range(ticks):
            at = BEGAN_NS + round(tick * TICK_S * 1e9)
            for topic, type in types.items():
                data = twists[tick // 60 % 2] if type == TWIST else messages[type]
                writer.add_message(channels[topic], at, data, at)
        writer.finish()


def run(*, rounds: int = ROUNDS, ticks: int = TICKS) -> dict[str, Any]:
    """Return the median processor time in s for an hour, measured with a few minutes, and the goal."""
    times, read = [], 0
    with TemporaryDirectory(prefix="understudy-bench-") as folder:
        path = Path(folder) / "drive.mcap"
        write_bag(path, ticks)
        for _ in range(rounds):
            began = process_time()
            read = read_recorded_drive(path, MAPPING).ticks
            times.append(process_time() - began)
    hours = ticks * TICK_S / 3600
    hour_s = median(times) / hours
    return {
        "ticks": read,
        "hours": hours,
        "topics": TOPICS,
        "mapped": len(MAPPED),
        "s": hour_s,
        "goal_s": GOAL_S,
        "passed": hour_s <= GOAL_S,
    }
