"""Robots on Fast DDS, in C++, and on Cyclone DDS, in C: their bytes and ours, what we read, what they obey."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import atan2
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from rosbags.typesys import Stores, get_typestore
from tests.peers.building import cyclone, fast_dds, missing
from tests.processes import end_with_tests
from tests.robots.domains import new_namespace, own_domain
from tests.robots.rovers import ODOMETRY, RANGE, ROVER, TWIST
from tests.ui.cli.commands import run
from tests.waiting import wait_until

from understudy.addons.robots.camera.image_decoding import decode_image
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.transport import Received
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.records.messages import decode_message as message_of
from understudy.records.messages import encode_twist

DOMAIN = own_domain()
IMAGE = "sensor_msgs/msg/Image"
OPTIONS = {"cyclone": (), "cyclone-t": ("-t",)}
PEERS = [
    ("fast_dds",),
    ("fast_dds", "best_effort"),
    ("fast_dds", "humble"),
    ("cyclone",),
    ("cyclone", "best_effort"),
    ("cyclone-t",),
]
SIZES = [(160, 120), (640, 480)]
"""Of images, in pixels: one that fits a datagram of UDP, and one that has to be sent in fragments."""


@pytest.fixture(scope="module", autouse=True)
def compilers() -> None:
    """Skip where peers cannot be built; found out when the first test runs, since compilers take seconds to say so."""
    if reason := missing():
        pytest.skip(reason)


class Tap(DdsTransport):
    """DDS that keeps the first message of each topic as it came."""

    def __init__(self, domain: int) -> None:
        super().__init__(domain)
        self.came: dict[str, bytes] = {}

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        def first(data: bytes, at_s: float) -> None:
            self.came.setdefault(topic, data)
            received(data, at_s)

        super().subscribe(topic, type, first, kept=kept)


class Peer:
    """A running peer, and what it said: the bytes that it sent, of each topic; then those that it got."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        self.process, self.sent = process, dict[str, bytes]()
        for line in process.stdout:
            if line == "ready\n":
                break
            _, topic, text = line.split()
            self.sent[topic] = bytes.fromhex(text)

    def got(self) -> list[tuple[bytes, float, float]]:
        """The commands, as bytes and as speeds, once it has ended."""
        assert self.process.wait(60) == 0
        assert self.process.stdout is not None
        lines = [line.split() for line in self.process.stdout]
        return [(bytes.fromhex(text), float(x), float(z)) for _, _, text, x, z in lines]


Start = Callable[..., Peer]


@pytest.fixture
def namespace() -> str:
    return new_namespace("peer")


@pytest.fixture
def start(pytestconfig: pytest.Config, namespace: str) -> Iterator[Start]:
    """Starts a peer by its name and options."""
    folder, processes = pytestconfig.cache.mkdir("peers"), list[subprocess.Popen[str]]()

    def begin(name: str, *options: str) -> Peer:
        program = fast_dds(folder) if name == "fast_dds" else cyclone(folder, *OPTIONS[name])
        command = [str(program), str(DOMAIN), namespace, *options]
        processes.append(subprocess.Popen(end_with_tests(command), stdout=subprocess.PIPE, text=True))
        return Peer(processes[-1])

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


def file_of(namespace: str) -> str:
    return ROVER.replace("/rover", namespace).replace("domain = 43", f"domain = {DOMAIN}")


def written(release: Stores, namespace: str) -> dict[str, bytes]:
    """What rosbags writes for the messages that all peers publish."""
    store = get_typestore(release)

    def make(type: str, *values: Any) -> Any:
        return store.types[type](*values)

    def header(frame: str) -> Any:
        return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", 12, 34), frame)

    point, vector = "geometry_msgs/msg/Point", "geometry_msgs/msg/Vector3"
    pose = make(
        "geometry_msgs/msg/Pose",
        make(point, 1.0, -2.0, 0.0),
        make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.6, 0.8),
    )
    moving = make(TWIST, make(vector, 0.5, 0.0, 0.0), make(vector, 0.0, 0.0, -0.25))
    odometry = make(
        ODOMETRY,
        header("odom"),
        "base_link",
        make("geometry_msgs/msg/PoseWithCovariance", pose, np.array([0.125] + [0.0] * 35)),
        make("geometry_msgs/msg/TwistWithCovariance", moving, np.array([0.0, 0.25] + [0.0] * 34)),
    )
    variance = [0.5] if release == Stores.ROS2_JAZZY else []
    sonar = make(RANGE, header("sonar"), 0, 0.25, 0.125, 3.0, 2.0, *variance)
    return {
        f"{namespace}/sonar": bytes(store.serialize_cdr(sonar, RANGE)),
        f"{namespace}/odom": bytes(store.serialize_cdr(odometry, ODOMETRY)),
    }


@pytest.mark.timed
@pytest.mark.parametrize("peer", PEERS, ids="-".join)
def test_bytes_are_equal_in_both_directions(peer: tuple[str, ...], start: Start, namespace: str) -> None:
    """Theirs, as they wrote them and as they came, are those of rosbags; ours, as they got them, too."""
    expected = written(Stores.ROS2_HUMBLE if "humble" in peer else Stores.ROS2_JAZZY, namespace)
    started = start(*peer)
    assert started.sent == expected
    file, tap = parse_robot(file_of(namespace)), Tap(DOMAIN)
    with Robot(file, tap) as robot:
        wait_until(lambda: all(latest.count > 3 for latest in robot.senses.latest.values()))
        assert tap.came == expected
        assert all(latest.refused == 0 for latest in robot.senses.latest.values())
        expected_values = {"sonar_ahead": 2.0, "x": 1.0, "heading": 2 * atan2(0.6, 0.8)}

        def read() -> bool:
            values = {name: robot.senses.value(name, robot.now_s) for name in expected_values}
            return values == pytest.approx(expected_values)

        wait_until(read)  # fresh, all of them

        def obeyed() -> bool:
            with suppress(ArmingRefused):  # a busy computer may have been late before
                robot.arm("a test")
            robot.act({"drive": np.array([1.0]), "turn": np.array([-0.5])})
            return started.process.poll() is not None

        wait_until(obeyed)
        got = started.got()
        assert got[-1] == (encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5), 0.4, -0.5)
        assert all(data == encode_twist(TWIST, speed_m_s=x, turn_rad_s=z) for data, x, z in got)


@pytest.mark.timed
def test_each_message_comes_once(start: Start, namespace: str) -> None:
    """A Range fits the definitions of two releases, and is listened for with both."""
    start("fast_dds")
    came: list[bytes] = []
    tap = DdsTransport(DOMAIN)
    try:
        tap.subscribe(f"{namespace}/sonar", RANGE, lambda data, _: came.append(data))
        wait_until(lambda: came)
        before, started = len(came), time.monotonic()
        time.sleep(0.5)
        assert len(came) - before < 65 * (time.monotonic() - started)
    finally:
        tap.close()


@pytest.mark.timed
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_images_come_whole(width: int, height: int, start: Start, namespace: str) -> None:
    """Of Fast DDS, where byte i is i modulo 251."""
    start("fast_dds", "image", str(width), str(height))
    came: list[bytes] = []
    tap = DdsTransport(DOMAIN)
    try:
        tap.subscribe(f"{namespace}/image", IMAGE, lambda data, _: came.append(data))
        wait_until(lambda: came)
    finally:
        tap.close()
    message = message_of(IMAGE, came[0])
    size = {each: getattr(message, each) for each in ("encoding", "width", "height", "step")}
    image = decode_image(message.data, **size)
    assert image.shape == (height, width, 3)
    assert np.array_equal(image.reshape(-1), np.arange(3 * width * height) % 251)


Case = tuple[list[tuple[str, ...]], str, list[str]]
REMEDY = "start the robot, or correct `topic`, `namespace` or `domain` in its file"
CHECKS: dict[str, Case] = {  # peers, what more the file says, problems
    "all are there": ([("fast_dds",)], "", []),
    "two robots with one namespace": (  # one on Fast DDS, one on Cyclone DDS
        [("fast_dds",), ("cyclone",)],
        "",
        [f"2 publish on {{}}/{topic}; give each robot a namespace of its own" for topic in ("sonar", "odom")],
    ),
    "another master": (
        [("cyclone", "master")],
        "",
        ["somebody else publishes on {}/cmd_vel; stop them, or this robot obeys two masters"],
    ),
    "a wrong type, and a topic that never comes": (
        [("fast_dds",)],
        '[readings.wrong]\ntopic = "sonar"\ntype = "std_msgs/msg/Float64"\nfield = "data"\n'
        '[readings.never]\ntopic = "front"\ntype = "sensor_msgs/msg/Range"\n',
        [
            "wrong: {}/sonar carries sensor_msgs/msg/Range, not std_msgs/msg/Float64; "
            "correct `type` in the robot's file",
            f"never: nothing comes on {{}}/front, and nobody publishes there; {REMEDY}",
        ],
    ),
}


@pytest.mark.timed
@pytest.mark.parametrize("case", CHECKS)
def test_check_tells_of(case: str, start: Start, namespace: str, tmp_path: Path) -> None:
    """And says so in the end: until others are found, and heard, a busy machine takes a while."""
    peers, more, problems = CHECKS[case]
    for peer in peers:
        start(*peer)
    file, expected = tmp_path / "rover.toml", [problem.format(namespace) for problem in problems]
    file.write_text(f"{file_of(namespace)}\n{more}")

    def told() -> bool:
        result = run("robots", "check", file, "--seconds", 0.5, "--json")
        assert result.exit_code in (0, 1), result.output
        return (result.exit_code, json.loads(result.stdout)["problems"]) == (int(bool(expected)), expected)

    wait_until(told)
