"""DDS on this machine: a robot in a process of its own, bytes as rosbags writes them, `understudy robots check`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from rosbags.typesys import Stores, get_typestore
from tests.cli.commands import run
from tests.robots.rovers import ODOMETRY, RANGE, ROVER, STAMPED, TWIST, odometry, sonar

from understudy.robots.body import Robot, connect
from understudy.robots.dds import DDS, dds_name, ros_name, struct
from understudy.robots.file import parse_robot
from understudy.robots.messages import decode, encode, known, make, twist
from understudy.robots.transport import Peer

ROOT = Path(__file__).parents[2]
NUMBERS = count()
NAMES = [
    ("sensor_msgs/msg/Range", "sensor_msgs::msg::dds_::Range_"),
    ("builtin_interfaces/msg/Time", "builtin_interfaces::msg::dds_::Time_"),
]
TYPES = [
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/BatteryState",
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float64",
    "std_msgs/msg/String",
]


BYTES = [
    (RANGE, sonar(1.5)),
    (ODOMETRY, odometry(2.0, z=0.6, w=0.8)),
    (TWIST, twist(TWIST, speed_m_s=0.3, turn_rad_s=-0.2)),
    (STAMPED, twist(STAMPED, speed_m_s=0.3, turn_rad_s=-0.2, frame="base", time_s=1.5)),
]


def wait_for(what: Callable[[], object], seconds: float = 10.0) -> None:
    until = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.01)


@pytest.fixture
def namespace() -> str:
    """One that no other test uses, of those that run beside this one."""
    return f"/rover_{os.getpid()}_{next(NUMBERS)}"


@pytest.fixture
def rover(namespace: str) -> Iterator[subprocess.Popen[str]]:
    """A process that publishes sonar (2 m) and odometry (x = 1 m) at 50 Hz, and prints the first Twist that moves."""
    command = [sys.executable, "-m", "tests.robots.rover", "43", namespace]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.terminate()


@pytest.fixture
def text(namespace: str) -> str:
    """The file of that rover."""
    return ROVER.replace("/rover", namespace)


@pytest.mark.parametrize(("ros", "dds"), NAMES)
def test_types_are_named_as_ros_does(ros: str, dds: str) -> None:
    assert (dds_name(ros), ros_name(dds)) == (dds, ros)


@pytest.mark.parametrize("type", TYPES)
def test_every_type_can_be_described(type: str) -> None:
    assert known(type)
    assert struct(type).__idl_typename__.replace(".", "::") == dds_name(type)
    assert decode(type, encode(type, make(type))) is not None


@pytest.mark.parametrize(("type", "data"), BYTES, ids=[type for type, _ in BYTES])
def test_bytes_are_those_that_cyclone_writes(type: str, data: bytes) -> None:
    """What rosbags encodes, Cyclone DDS encodes alike from its own description of the type."""
    assert bytes(struct(type).__idl__.serialize(decode(type, data), use_version_2=False)) == data


def test_a_robot_reads_and_commands_another_process(rover: subprocess.Popen[str], text: str) -> None:
    """Ranges and odometry come in, and the Twist there is byte for byte what rosbags writes, of Humble too."""
    robot: Robot
    with connect(parse_robot(text)) as robot:
        wait_for(lambda: all(latest.count > 3 for latest in robot.senses.latest.values()))
        keys = [(reading.name, None) for reading in robot.readings]
        assert [float(column[0]) for column in robot.sense(keys).values()] == [2.0, 1.0, 0.0]
        robot.arm("a test")
        started = time.monotonic()
        while rover.poll() is None and time.monotonic() - started < 10:
            robot.act({"drive": np.array([1.0]), "turn": np.array([-0.5])})
            time.sleep(0.02)
    assert rover.stdout is not None
    got = bytes.fromhex(rover.stdout.read().strip())
    assert got == twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5)
    store = get_typestore(Stores.ROS2_HUMBLE)
    vector = store.types["geometry_msgs/msg/Vector3"]
    message = store.types[TWIST](linear=vector(0.4, 0.0, 0.0), angular=vector(0.0, 0.0, -0.5))
    assert got == bytes(store.serialize_cdr(message, TWIST))


def test_check_finds_all_there_and_sends_nothing(
    rover: subprocess.Popen[str], text: str, tmp_path: Path
) -> None:
    file = tmp_path / "rover.toml"
    file.write_text(text)
    result = run("robots", "check", file, "--seconds", 1.0, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said["problems"] == []
    assert [each["values"] for each in said["arrivals"]] == [
        {"sonar_ahead": 2.0},
        {"x": 1.0},
        {"heading": 0.0},
    ]
    assert all(35 < each["rate_hz"] < 65 and each["age_s"] < 0.5 for each in said["arrivals"])
    assert rover.poll() is None


def test_check_says_what_is_missing(text: str, tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text(text)
    result = run("robots", "check", file, "--seconds", 0.2)
    assert result.exit_code == 1
    assert "nobody publishes there" in result.stdout


def test_messages_arrive_as_they_were_sent_and_who_leaves_is_no_peer(namespace: str) -> None:
    ours, theirs, topic = DDS(43), DDS(43), f"{namespace}/odom"
    try:
        came: list[bytes] = []
        ours.subscribe(topic, ODOMETRY, lambda data, _: came.append(data))
        publish = theirs.publisher(topic, ODOMETRY)
        wait_for(lambda: Peer(topic, ODOMETRY) in ours.peers())
        assert Peer(topic, ODOMETRY) not in theirs.peers()
        sent = odometry(1.25)

        def arrived() -> bool:
            publish(sent)
            return bool(came)

        wait_for(arrived)
        assert came[0] == sent
        theirs.close()
        publish(sent)  # does nothing any more
        wait_for(lambda: Peer(topic, ODOMETRY) not in ours.peers())
    finally:
        ours.close()
        theirs.close()


def test_waiting_takes_no_time_of_the_processor(namespace: str) -> None:
    """Whether or not it subscribed to anything."""
    speaks, listens = DDS(43), DDS(43)
    try:
        speaks.publisher(f"{namespace}/odom", ODOMETRY)
        listens.subscribe(f"{namespace}/odom", ODOMETRY, lambda data, at_s: None)
        time.sleep(0.2)
        spent = time.process_time()
        time.sleep(0.4)
        assert time.process_time() - spent < 0.1
    finally:
        speaks.close()
        listens.close()


def test_a_plain_program_on_cyclone_reads_our_commands(namespace: str) -> None:
    """One that knows nothing of us: types written by hand, names as ROS 2 gives them."""
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import float64
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    vector = make_idl_struct(
        "Vector3_", "geometry_msgs::msg::dds_::Vector3_", {"x": float64, "y": float64, "z": float64}
    )
    plain = make_idl_struct(
        "Twist_", "geometry_msgs::msg::dds_::Twist_", {"linear": vector, "angular": vector}
    )
    participant, ours = DomainParticipant(43), DDS(43)
    try:
        reader = DataReader(participant, Topic(participant, f"rt{namespace}/cmd_vel", plain))
        publish, came = ours.publisher(f"{namespace}/cmd_vel", TWIST), list[Any]()

        def arrived() -> bool:
            publish(twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5))
            came.extend(reader.take(N=1))
            return bool(came)

        wait_for(arrived)
        assert (came[0].linear.x, came[0].linear.y, came[0].angular.z) == (0.4, 0.0, -0.5)
    finally:
        ours.close()
