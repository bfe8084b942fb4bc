"""What every transport does, DDS and Zenoh: another program as the robot, who is there, `robots check`."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from rosbags.typesys import Stores, get_typestore
from tests.processes import end_with_tests
from tests.robots.domains import new_namespace, own_domain
from tests.robots.kept_messages import keep_over_dds, keep_over_zenoh
from tests.robots.routers import Router
from tests.robots.rovers import ODOMETRY, RANGE, ROVER, TWIST, Wire, odometry
from tests.robots.test_diagnostics import FILE, say
from tests.robots.test_frame_tree import ROBOT, encode, transform
from tests.robots.test_simulation_clock import clock_at
from tests.ui.cli.commands import run
from tests.waiting import wait_until

from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot import Robot, connect_robot_body
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.diagnostic_messages import DIAGNOSTICS, StatusLevel
from understudy.addons.robots.ros.frame_tree import TRANSFORMS
from understudy.addons.robots.ros.simulation_clock import CLOCK, TIME, SimulationClock
from understudy.addons.robots.ros.transport import Publisher, Transport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.records.messages import decode_message, encode_twist

ROOT = Path(__file__).parents[2]
DOMAIN = own_domain()


@pytest.fixture(params=["dds", "zenoh"])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


Join = Callable[[], Transport]


@pytest.fixture
def join(kind: str, router: Router) -> Iterator[Join]:
    """Joins the domain once more."""
    with ExitStack() as ending:

        def begin() -> Transport:
            joined = ZenohTransport(DOMAIN, router.endpoint) if kind == "zenoh" else DdsTransport(DOMAIN)
            ending.callback(joined.close)
            return joined

        yield begin


@pytest.fixture
def namespace() -> str:
    return new_namespace()


@pytest.fixture
def rover(kind: str, router: Router, namespace: str) -> Iterator[subprocess.Popen[str]]:
    """A process that publishes sonar (2 m) and odometry (x = 1 m) at 50 Hz, and prints the first Twist that moves."""
    command = [sys.executable, "-m", "tests.robots.rover", str(DOMAIN), namespace]
    command += [router.endpoint] if kind == "zenoh" else []
    with subprocess.Popen(end_with_tests(command), cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.terminate()


@pytest.fixture
def text(kind: str, router: Router, namespace: str) -> str:
    """The file of that rover."""
    how = f'transport = "zenoh"\nrouter = "{router.endpoint}"' if kind == "zenoh" else 'transport = "dds"'
    text = ROVER.replace("/rover", namespace).replace("domain = 43", f"domain = {DOMAIN}")
    return text.replace("\ntick_s", f"\n{how}\ntick_s", 1)


def check(text: str, folder: Path, seconds: float = 0.2) -> dict[str, Any]:
    """What `robots check` finds."""
    (folder / "rover.toml").write_text(text)
    result = run("robots", "check", folder / "rover.toml", "--seconds", seconds, "--json")
    said: dict[str, Any] = json.loads(result.stdout)
    assert result.exit_code == int(bool(said["problems"]))
    return said


def check_until(text: str, folder: Path) -> Callable[[Callable[[dict[str, Any]], bool]], dict[str, Any]]:
    """What `robots check` finds in the end: until others are found, and heard, a busy machine takes a while."""

    def find(there: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        found: list[dict[str, Any]] = []

        def come() -> bool:
            found.append(check(text, folder, 0.5))
            return there(found[-1])

        wait_until(come)
        return found[-1]

    return find


@pytest.mark.timed
def test_a_robot_in_another_process_is_found_read_and_commanded(
    rover: subprocess.Popen[str], join: Join, text: str, namespace: str, tmp_path: Path
) -> None:
    """Ranges and odometry come in, and the Twist there is byte for byte what rosbags writes, of Humble too.

    Before, there are another robot with the same namespace, somebody who commands this one, and a type that nobody
    there publishes.
    """

    def has_rates(said: dict[str, Any]) -> bool:
        return all(each["messages"] > 1 and each["rate_hz"] > 0 for each in said["arrivals"])

    said = check_until(text, tmp_path)(lambda said: said["problems"] == [] and has_rates(said))
    assert [each["values"] for each in said["arrivals"]] == [
        {"sonar_ahead": 2.0},
        {"x": 1.0},
        {"heading": 0.0},
    ]
    other = join()
    other.publisher(f"{namespace}/sonar", RANGE)
    other.publisher(f"{namespace}/cmd_vel", TWIST)
    wrong = '[readings.wrong]\ntopic = "odom"\ntype = "std_msgs/msg/Float64"\nfield = "data"\n'
    problems = [
        f"wrong: {namespace}/odom carries nav_msgs/msg/Odometry, not std_msgs/msg/Float64; "
        "correct `type` in the robot's file",
        f"somebody else publishes on {namespace}/cmd_vel; stop them, or this robot obeys two masters",
        f"2 publish on {namespace}/sonar; give each robot a namespace of its own",
    ]
    said = check_until(f"{text}\n{wrong}", tmp_path)(lambda said: said["problems"] == problems)
    assert rover.poll() is None  # nothing was sent
    other.close()
    robot: Robot
    with connect_robot_body(parse_robot(text), path=tmp_path / "rover.toml") as robot:
        keys = [(reading.name, None) for reading in robot.readings]
        commands, readings = robot.file.topic("cmd_vel"), robot.senses.latest.values()
        wait_until(
            lambda: (
                all(latest.count > 3 for latest in readings)
                and commands not in {peer.topic for peer in robot.transport.peers()}
            )
        )
        wait_until(
            lambda: [float(column[0]) for column in robot.sense(keys).values()] == [2.0, 1.0, 0.0]
        )  # fresh, all of them

        def has_ended() -> bool:
            with suppress(
                ArmingRefused
            ):  # on a busy machine it was stopped before, or the rover has ended since
                robot.arm("a test")
            robot.act({"drive": np.array([1.0]), "turn": np.array([-0.5])})
            return rover.poll() is not None

        wait_until(has_ended)
    assert rover.stdout is not None
    got = bytes.fromhex(rover.stdout.read().strip())
    assert got == encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5)
    store = get_typestore(Stores.ROS2_HUMBLE)
    vector = store.types["geometry_msgs/msg/Vector3"]
    message = store.types[TWIST](linear=vector(0.4, 0.0, 0.0), angular=vector(0.0, 0.0, -0.5))
    assert got == bytes(store.serialize_cdr(message, TWIST))


def test_check_says_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.addons.robots.robot.open_transport", lambda file: Wire())
    remedy = "start the robot, or correct `topic`, `namespace` or `domain` in its file"
    assert check(ROVER, tmp_path, 0.1)["problems"] == [
        f"{name}: nothing comes on /rover/{topic}, and nobody publishes there; {remedy}"
        for name, topic in (("sonar_ahead", "sonar"), ("x", "odom"), ("heading", "odom"))
    ]


def check_messages(join: Join, _: Router) -> None:
    """Messages arrive as they were sent, and whoever leaves is no peer."""
    ours, theirs, topic = join(), join(), f"{new_namespace()}/odom"
    came: list[bytes] = []
    ours.subscribe(topic, ODOMETRY, lambda data, _: came.append(data))
    publish = theirs.publisher(topic, ODOMETRY)
    wait_until(lambda: Publisher(topic, ODOMETRY) in ours.peers())
    assert Publisher(topic, ODOMETRY) not in theirs.peers()
    sent = odometry(1.25)
    wait_until(lambda: came, meanwhile=lambda: publish(sent))
    assert came[0] == sent
    theirs.close()
    publish(sent)  # does nothing any more
    wait_until(lambda: Publisher(topic, ODOMETRY) not in ours.peers())


def check_answers(join: Join, _: Router) -> None:
    """Who listens may answer at once, over the same session, also what it said itself."""
    ours, came, namespace = join(), list[bytes](), new_namespace()
    answer = ours.publisher(f"{namespace}/answer", ODOMETRY)
    ours.subscribe(f"{namespace}/odom", ODOMETRY, lambda data, _: answer(data))
    ours.subscribe(f"{namespace}/answer", ODOMETRY, lambda data, _: came.append(data))
    ask = ours.publisher(f"{namespace}/odom", ODOMETRY)
    wait_until(lambda: came, meanwhile=lambda: ask(odometry(2.5)))
    assert came[0] == odometry(2.5)


def check_diagnostics(join: Join, _: Router) -> None:
    """A driver's error reaches the robot, and the driver hears what the robot says of itself."""
    driver, heard = join(), list[Any]()
    robot = Robot(FILE, join())
    driver.subscribe(
        "/diagnostics", DIAGNOSTICS, lambda data, _: heard.append(decode_message(DIAGNOSTICS, data))
    )
    publish = driver.publisher("/diagnostics", DIAGNOSTICS)

    def is_reported() -> bool:
        publish(say("motors: left", StatusLevel.ERROR, "overheated"))
        robot.act({})
        return robot.statuses.find_error(["motors: left"]) == "diagnostics of 'motors: left': overheated"

    def is_named() -> bool:
        return is_reported() and any(
            status.name == "understudy: rover" for message in heard for status in message.status
        )

    wait_until(is_named)


def check_frames(join: Join, router: Router) -> None:
    """A pose from /tf and /tf_static, the latter sent before anybody listened."""
    static = encode(transform("base_footprint", "base_link", 0.5, 0.0))
    ours, theirs = join(), join()
    keep = keep_over_dds if isinstance(ours, DdsTransport) else keep_over_zenoh
    with keep(DOMAIN, router.endpoint, "/tf_static", TRANSFORMS, static):
        senses, publish = SensorInputs(ROBOT, ours), theirs.publisher("/tf", TRANSFORMS)
        moves = transform("map", "odom", 1.0, 0.0), transform("odom", "base_footprint", 2.0, 0.0)
        found: list[float] = []

        def came() -> bool:
            publish(encode(*moves))
            found.append(senses.value("x", time.monotonic()))
            return found[-1] == found[-1]

        wait_until(came)
        assert found[-1] == 3.5


def check_clock(join: Join, _: Router) -> None:
    """The time of a simulation."""
    clock, publish = SimulationClock(join()), join().publisher(CLOCK, TIME)
    seconds = [7.0]

    def has_passed() -> bool:
        publish(clock_at(seconds[0]))
        seconds[0] += 0.25
        return clock() >= 1.0

    wait_until(has_passed)


SUBJECTS = [check_messages, check_answers, check_diagnostics, check_frames, check_clock]


@pytest.mark.timed
@pytest.mark.parametrize("subject", SUBJECTS, ids=lambda each: each.__name__.removeprefix("check_"))
def test_over_a_network(subject: Callable[[Join, Router], None], join: Join, router: Router) -> None:
    subject(join, router)


@pytest.mark.timed
def test_waiting_takes_no_time_of_the_processor(join: Join, namespace: str) -> None:
    """Whether or not it subscribed to anything; the receiving thread alone could take all the time there is.

    Other threads of this process, and what was held up before, may take some at first.
    """
    join().publisher(f"{namespace}/odom", ODOMETRY)
    join().subscribe(f"{namespace}/odom", ODOMETRY, lambda data, at_s: None)

    def is_idle() -> bool:
        spent_s = time.process_time()
        time.sleep(0.4)
        return time.process_time() - spent_s < 0.2

    wait_until(is_idle)


@pytest.mark.timed
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
    participant, ours = DomainParticipant(DOMAIN), DdsTransport(DOMAIN)
    try:
        reader = DataReader(participant, Topic(participant, f"rt{namespace}/cmd_vel", plain))
        publish, came = ours.publisher(f"{namespace}/cmd_vel", TWIST), list[Any]()

        def has_arrived() -> bool:
            publish(encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5))
            came.extend(reader.take(N=1))
            return bool(came)

        wait_until(has_arrived)
        assert (came[0].linear.x, came[0].linear.y, came[0].angular.z) == (0.4, 0.0, -0.5)
    finally:
        ours.close()


@pytest.mark.timed
def test_others_are_gone_through_only_when_one_comes_or_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    """There may be hundreds, and they are asked for several times a second."""
    one, two, namespace = DdsTransport(DOMAIN), DdsTransport(DOMAIN), new_namespace()

    def topics() -> set[str]:
        return {
            peer.topic.removeprefix(namespace) for peer in one.peers() if peer.topic.startswith(namespace)
        }

    try:
        two.publisher(f"{namespace}/a", TWIST)
        wait_until(lambda: topics() == {"/a"})
        reads, read = list[int](), one._publications.read

        def count_reads(**asked: Any) -> Any:
            reads.append(1)
            return read(**asked)

        monkeypatch.setattr(one._publications, "read", count_reads)
        assert all(topics() == {"/a"} for _ in range(20))
        assert not reads
        two.publisher(f"{namespace}/b", TWIST)
        wait_until(lambda: topics() == {"/a", "/b"})
        two.close()
        wait_until(lambda: not topics())
    finally:
        one.close()
        two.close()
