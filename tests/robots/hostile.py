"""What somebody may send who means ill, or whose program is broken: messages of any numbers, bytes that are none."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from math import inf, nan
from random import Random
from typing import Any

import numpy as np

from understudy.records.messages import (
    ARRAY,
    BASE,
    NAMED,
    encode_message,
    list_message_fields,
    load_typestore,
)

TOPICS: Mapping[str, str] = {
    "/rover/sonar": "sensor_msgs/msg/Range",
    "/rover/scan": "sensor_msgs/msg/LaserScan",
    "/rover/odom": "nav_msgs/msg/Odometry",
    "/rover/battery": "sensor_msgs/msg/BatteryState",
    "/rover/image": "sensor_msgs/msg/Image",
    "/rover/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "/rover/joints": "sensor_msgs/msg/JointState",
    "/rover/bumper": "std_msgs/msg/Bool",
    "/rover/level": "std_msgs/msg/Float64",
    "/rover/ball": "geometry_msgs/msg/PoseStamped",
}
"""All topics of the robot below, and their types."""

FILE = """
format = "understudy-robot/1"
name = "rover"
namespace = "/rover"
domain = 48
tick_s = 0.1
limits = { speed_m_s = 0.5, turn_rad_s = 1.0, acceleration_m_s2 = 1.0 }
commands = { drive_m_s = 0.4, turn_rad_s = 1.0 }

[readings]
sonar_ahead = { topic = "sonar", type = "sensor_msgs/msg/Range", required = true }
sonar_left = { topic = "scan", type = "sensor_msgs/msg/LaserScan", sector_deg = [60, 120], offset_m = 0.1 }
sonar_right = { topic = "scan", type = "sensor_msgs/msg/LaserScan", sector_deg = [-90, -90] }
x = { topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.position.x" }
y = { topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.position.y" }
heading = { topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.orientation" }
charge = { topic = "battery", type = "sensor_msgs/msg/BatteryState", field = "percentage" }
turned = { topic = "pose", type = "geometry_msgs/msg/PoseWithCovarianceStamped", field = "pose.pose.orientation" }
moved_s = { topic = "joints", type = "sensor_msgs/msg/JointState", field = "header.stamp.sec" }
bumped = { topic = "bumper", type = "std_msgs/msg/Bool", field = "data" }
level = { topic = "level", type = "std_msgs/msg/Float64", field = "data" }

[camera]
topic = "image"
type = "sensor_msgs/msg/Image"

[camera.colors]
red = { hue_deg = [340, 20], saturation = [0.3, 1], value = [0.3, 1] }

[targets.ball]
topic = "ball"
relative = true
"""
"""A robot that reads all the sorts of messages there are."""

FLOATS = (0.0, -0.0, 1.5, -1.5, nan, inf, -inf, 1e308, -1e308, 5e-324, 3e38)
LENGTHS = (0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x01000000, 0x00010000)
"""What a sequence or a text may claim to be long."""


def message(type: str, random: Random) -> bytes:
    """A message of a type whose numbers are anything."""
    return encode_message(type, make_message(type, random))


def mutate(data: bytes, random: Random) -> bytes:
    """A message after one to three accidents."""
    for _ in range(random.randint(1, 3)):
        data = random.choice(
            (truncate, flip_bits, enlarge_length, change_encapsulation, pad, insert_nan, _noise)
        )(data, random)
    return data


def anything(type: str, random: Random) -> bytes:
    """A message, mostly broken."""
    data = message(type, random)
    return data if random.random() < 0.25 else mutate(data, random)


def make_message(type: str, random: Random) -> Any:
    if type == "sensor_msgs/msg/Image" and random.random() < 0.5:
        return _image(random)
    return load_typestore().types[type](
        **{name: _value(sort, of, random) for name, (sort, of) in list_message_fields(type).items()}
    )


def _image(random: Random) -> Any:
    """One that nearly fits."""
    made = load_typestore().types["sensor_msgs/msg/Image"]
    width, height = random.randint(1, 4), random.randint(1, 4)
    header = make_message("std_msgs/msg/Header", random)
    data = np.frombuffer(random.randbytes(width * height * 3), np.uint8)
    lies = random.choice(((height, width), (height, width), (2**31, 2**31), (2**32 - 1, 1), (0, 0)))
    encoding = random.choice(("rgb8", "rgb8", "bgr8", "yuv422", "mono8", "32FC1", ""))
    return made(header, *lies, encoding, 0, random.choice((3 * width, 3 * width, 0, 2**32 - 1)), data)


def _value(sort: int, of: Any, random: Random) -> Any:
    if sort == NAMED:
        return make_message(of, random)
    if sort == BASE:
        return _number(of[0], random)
    inner, length = of
    count = length if sort == ARRAY else random.choice((0, 1, 2, 7))
    values = [_value(inner[0], inner[1], random) for _ in range(count)]
    if inner[0] == BASE and inner[1][0] != "string":
        return np.array(values, inner[1][0].replace("byte", "uint8"))
    return values


def _number(name: str, random: Random) -> Any:
    if name == "string":
        return random.choice(("", "base", "ä" * 9, "\x00", "../.."))
    if name == "bool":
        return random.random() < 0.5
    if "float" in name:
        value = random.choice((*FLOATS, random.uniform(-10, 10)))
        with np.errstate(over="ignore"):
            return float(np.float32(value)) if name == "float32" else value
    kind = np.iinfo(name.replace("byte", "uint8"))
    return random.choice((int(kind.min), int(kind.max), 0, 1))


def truncate(data: bytes, random: Random) -> bytes:
    return data[: random.randint(0, len(data))]


def flip_bits(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(random.randint(1, 8)):
        if changed:
            changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def enlarge_length(data: bytes, random: Random) -> bytes:
    """Some number that may be a length is huge."""
    if len(data) < 8:
        return data
    at = 4 * random.randrange(1, len(data) // 4)
    return data[:at] + struct.pack("<I", random.choice(LENGTHS)) + data[at + 4 :]


def change_encapsulation(data: bytes, random: Random) -> bytes:
    """In another encapsulation: big-endian, parameter lists, those of XCDR 2, and none that there is."""
    return bytes((0, random.choice((0, 2, 3, 6, 7, 9, 255)), 0, random.choice((0, 3)))) + data[4:]


def pad(data: bytes, random: Random) -> bytes:
    return data + random.randbytes(random.choice((1, 3, 4, 64, 5000)))


def insert_nan(data: bytes, random: Random) -> bytes:
    """Some number in it is none."""
    if len(data) < 12:
        return data
    at = 4 * random.randrange(1, len(data) // 4 - 1)
    lie = struct.pack("<d", random.choice(FLOATS))
    return data[:at] + lie + data[at + 8 :]


def _noise(data: bytes, random: Random) -> bytes:
    return random.randbytes(len(data))
