"""What every transport does, DDS and Zenoh: a robot in a process of its own, who is there, `robots check`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from rosbags.typesys import Stores, get_typestore
from tests.robots.routers import Router
from tests.robots.rovers import ODOMETRY, RANGE, ROVER, TWIST, odometry
from tests.ui.cli.commands import run

from understudy.robots.robot import Robot, connect_robot_body
from understudy.robots.robot_file import parse_robot
from understudy.robots.ros.dds import DdsTransport
from understudy.robots.ros.messages import encode_twist
from understudy.robots.ros.transport import Publisher, Transport
from understudy.robots.ros.zenoh import ZenohTransport

ROOT = Path(__file__).parents[2]
DOMAIN = 43
NUMBERS = count()


@pytest.fixture(scope="module")
def router() -> Iterator[Router]:
    with Router() as opened:
        yield opened


@pytest.fixture(params=["dds", "zenoh"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


Join = Callable[[], Transport]


@pytest.fixture
def join(kind: str, router: Router) -> Iterator[Join]:
    """Joins the domain once more."""
    joined: list[Transport] = []

    def begin() -> Transport:
        joined.append(ZenohTransport(DOMAIN, router.endpoint) if kind == "zenoh" else DdsTransport(DOMAIN))
        return joined[-1]

    yield begin
    for transport in joined:
        transport.close()


@pytest.fixture
def namespace() -> str:
    """One that no other test uses, of those that run beside this one."""
    return f"/rover_{os.getpid()}_{next(NUMBERS)}"


@pytest.fixture
def rover(kind: str, router: Router, namespace: str) -> Iterator[subprocess.Popen[str]]:
    """A process that publishes sonar (2 m) and odometry (x = 1 m) at 50 Hz, and prints the first Twist that moves."""
    command = [sys.executable, "-m", "tests.robots.rover", str(DOMAIN), namespace]
    command += [router.endpoint] if kind == "zenoh" else []
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.terminate()


@pytest.fixture
def text(kind: str, router: Router, namespace: str) -> str:
    """The file of that rover."""
    how = f'transport = "zenoh"\nrouter = "{router.endpoint}"' if kind == "zenoh" else 'transport = "dds"'
    return ROVER.replace("/rover", namespace).replace("\ntick_s", f"\n{how}\ntick_s", 1)


def wait_for(what: Callable[[], object], seconds: float = 10.0) -> None:
    until = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.01)


def check(text: str, folder: Path, seconds: float = 0.5) -> tuple[int, list[str]]:
    """The exit code and the problems that `robots check` finds."""
    (folder / "rover.toml").write_text(text)
    result = run("robots", "check", folder / "rover.toml", "--seconds", seconds, "--json")
    return result.exit_code, json.loads(result.stdout)["problems"]


def test_a_robot_reads_and_commands_another_process(
    rover: subprocess.Popen[str], text: str, tmp_path: Path
) -> None:
    """Ranges and odometry come in, and the Twist there is byte for byte what rosbags writes, of Humble too."""
    robot: Robot
    with connect_robot_body(parse_robot(text), path=tmp_path / "rover.toml") as robot:
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
    assert got == encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5)
    store = get_typestore(Stores.ROS2_HUMBLE)
    vector = store.types["geometry_msgs/msg/Vector3"]
    message = store.types[TWIST](linear=vector(0.4, 0.0, 0.0), angular=vector(0.0, 0.0, -0.5))
    assert got == bytes(store.serialize_cdr(message, TWIST))


def test_check_finds_all_there_and_sends_nothing(
    rover: subprocess.Popen[str], text: str, tmp_path: Path
) -> None:
    (tmp_path / "rover.toml").write_text(text)
    result = run("robots", "check", tmp_path / "rover.toml", "--seconds", 1.0, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said["problems"] == []
    assert [each["values"] for each in said["arrivals"]] == [
        {"sonar_ahead": 2.0},
        {"x": 1.0},
        {"heading": 0.0},
    ]
    assert all(20 < each["rate_hz"] < 80 and each["age_s"] < 1.0 for each in said["arrivals"])
    assert rover.poll() is None


def test_check_says_what_is_missing(text: str, namespace: str, tmp_path: Path) -> None:
    code, problems = check(text, tmp_path, 0.2)
    remedy = "start the robot, or correct `topic`, `namespace` or `domain` in its file"
    assert (code, problems) == (
        1,
        [
            f"{name}: nothing comes on {namespace}/{topic}, and nobody publishes there; {remedy}"
            for name, topic in (("sonar_ahead", "sonar"), ("x", "odom"), ("heading", "odom"))
        ],
    )


def test_check_tells_of_others_and_of_wrong_types(
    rover: subprocess.Popen[str], join: Join, text: str, namespace: str, tmp_path: Path
) -> None:
    """Another robot with the same namespace, somebody who commands this one, a type that nobody there publishes."""
    other = join()
    other.publisher(f"{namespace}/sonar", RANGE)
    other.publisher(f"{namespace}/cmd_vel", TWIST)
    wrong = '[readings.wrong]\ntopic = "odom"\ntype = "std_msgs/msg/Float64"\nfield = "data"\n'
    assert check(f"{text}\n{wrong}", tmp_path, 1.0) == (
        1,
        [
            f"wrong: {namespace}/odom carries nav_msgs/msg/Odometry, not std_msgs/msg/Float64; "
            "correct `type` in the robot's file",
            f"somebody else publishes on {namespace}/cmd_vel; stop them, or this robot obeys two masters",
            f"2 publish on {namespace}/sonar; give each robot a namespace of its own",
        ],
    )


def test_messages_arrive_as_they_were_sent_and_who_leaves_is_no_peer(join: Join, namespace: str) -> None:
    ours, theirs, topic = join(), join(), f"{namespace}/odom"
    came: list[bytes] = []
    ours.subscribe(topic, ODOMETRY, lambda data, _: came.append(data))
    publish = theirs.publisher(topic, ODOMETRY)
    wait_for(lambda: Publisher(topic, ODOMETRY) in ours.peers())
    assert Publisher(topic, ODOMETRY) not in theirs.peers()
    sent = odometry(1.25)

    def arrived() -> bool:
        publish(sent)
        return bool(came)

    wait_for(arrived)
    assert came[0] == sent
    theirs.close()
    publish(sent)  # does nothing any more
    wait_for(lambda: Publisher(topic, ODOMETRY) not in ours.peers())


def test_who_listens_may_answer_at_once(join: Join, namespace: str) -> None:
    """Over the same session, also what it said itself."""
    ours, came = join(), list[bytes]()
    answer = ours.publisher(f"{namespace}/answer", ODOMETRY)
    ours.subscribe(f"{namespace}/odom", ODOMETRY, lambda data, _: answer(data))
    ours.subscribe(f"{namespace}/answer", ODOMETRY, lambda data, _: came.append(data))
    ask = ours.publisher(f"{namespace}/odom", ODOMETRY)

    def arrived() -> bool:
        ask(odometry(2.5))
        return bool(came)

    wait_for(arrived)
    assert came[0] == odometry(2.5)


def test_waiting_takes_no_time_of_the_processor(join: Join, namespace: str) -> None:
    """Whether or not it subscribed to anything."""
    join().publisher(f"{namespace}/odom", ODOMETRY)
    join().subscribe(f"{namespace}/odom", ODOMETRY, lambda data, at_s: None)
    time.sleep(0.2)
    spent = time.process_time()
    time.sleep(0.4)
    assert time.process_time() - spent < 0.1
