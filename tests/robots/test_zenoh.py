"""Zenoh as ROS 2 speaks it: keys and tokens beside those of its documentation, a plain program as the robot."""

from __future__ import annotations

import struct
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from rosbags.typesys import Stores, get_typestore
from tests.processes import end_with_tests
from tests.robots.domains import new_namespace
from tests.robots.routers import Router, free_port
from tests.robots.rovers import RANGE, ROVER, TWIST, sonar
from tests.waiting import wait_until

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.transport import Publisher, Unreachable
from understudy.addons.robots.ros.zenoh import (
    Endpoint,
    ZenohSession,
    ZenohTransport,
    hash_type_definition,
    make_attachment,
    make_topic_keys,
    parse_liveliness_token,
)
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.errors import FileError
from understudy.records.messages import encode_twist

PLAIN = Path(__file__).with_name("plain_zenoh.py")
HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
STRING = "std_msgs/msg/String"
TALKER = (
    "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/"
    f"{HASH}/::,7:,:,:,,"
)
"""The publisher of the documentation of rmw_zenoh, as are the keys below."""

KEYS = [
    (0, "/chatter", f"0/chatter/std_msgs::msg::dds_::String_/{HASH}"),
    (0, "/robot1/chatter", f"0/robot1/chatter/std_msgs::msg::dds_::String_/{HASH}"),
]
NOBODY = [
    "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener",  # a node
    TALKER.replace("/MP/", "/SC/"),  # of a service's client
    TALKER.replace("@ros2_lv", "@ros3_lv"),
    TALKER + "/more",
    TALKER.rpartition("/")[0],
    "",
    "/" * 12,
]

INT64, BOOL, TEXT = ((1, (of, 0)) for of in ("int64", "bool", "string"))
Fields: TypeAlias = list[tuple[str, Any]]
SERVICES: list[tuple[str, Fields, Fields, str]] = [  # the first from the documentation of rmw_zenoh
    (
        "example_interfaces/srv/AddTwoInts",
        [("a", INT64), ("b", INT64)],
        [("sum", INT64)],
        "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
    ),
    (
        "std_srvs/srv/Trigger",
        [],
        [("success", BOOL), ("message", TEXT)],
        "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    ),
    (
        "std_srvs/srv/SetBool",
        [("data", BOOL)],
        [("success", BOOL), ("message", TEXT)],
        "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    ),
]


@pytest.fixture
def namespace() -> str:
    return new_namespace("plain")


@pytest.mark.parametrize(("domain", "topic", "key"), KEYS)
def test_keys_are_those_of_the_documentation(domain: int, topic: str, key: str) -> None:
    assert make_topic_keys(domain, topic, STRING) == (key, key.replace(HASH, "TypeHashNotSupported"))


@pytest.mark.parametrize(
    ("type", "request_", "response", "published"), SERVICES, ids=[row[0] for row in SERVICES]
)
def test_hashes_of_services_are_those_published(
    type: str, request_: Fields, response: Fields, published: str
) -> None:
    """A service has a request, a response, and an event, in which there are 16 char of who called."""
    typestore = get_typestore(Stores.ROS2_JAZZY)
    parts: Any = {part: (2, f"{type}_{part}") for part in ("Request", "Response", "Event")}
    defined: Any = {
        f"{type}_Request": ([], request_),
        f"{type}_Response": ([], response),
        f"{type}_Event": (
            [],
            [
                ("info", (2, "service_msgs/msg/ServiceEventInfo")),
                ("request", (4, (parts["Request"], 1))),
                ("response", (4, (parts["Response"], 1))),
            ],
        ),
        type: ([], [(f"{part.lower()}_message", of) for part, of in parts.items()]),
    }
    typestore.fielddefs |= defined
    assert hash_type_definition(type, typestore) == f"RIHS01_{published}"


def test_hashes_of_messages_with_char_are_those_published() -> None:
    published = "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45"
    assert hash_type_definition("service_msgs/msg/ServiceEventInfo") == f"RIHS01_{published}"
    assert hash_type_definition(STRING) == HASH


def test_tokens_are_those_of_the_documentation() -> None:
    session = ZenohSession(2, "8b20917502ee955ac4476e0266340d5c")
    ours = session.token(10, "MP", topic="/chatter", type=STRING, depth=7)
    assert ours == TALKER.replace("talker", "understudy")
    assert session.node() == "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/0/NN/%/%/understudy"
    assert parse_liveliness_token(TALKER) == Endpoint(
        "8b20917502ee955ac4476e0266340d5c", "MP", "/chatter", STRING, HASH
    )


@pytest.mark.parametrize("token", NOBODY)
def test_other_tokens_are_nobodies(token: str) -> None:
    assert parse_liveliness_token(token) is None


def test_an_attachment_is_33_bytes() -> None:
    """Two numbers of 8 bytes, the length of the id, and an id of its own for each publisher."""
    data = make_attachment(5, 1_000_000_007, TALKER)
    assert struct.unpack("<qqB", data[:17]) == (5, 1_000_000_007, 16)
    assert len(data) == 33
    assert data[17:] == make_attachment(6, 8, TALKER)[17:] != make_attachment(5, 1_000_000_007, "other")[17:]


@pytest.mark.timed
@pytest.mark.parametrize("release", ["jazzy", "humble"])
def test_a_plain_program_is_read_and_obeys(release: str, router: Router, namespace: str) -> None:
    """Also one of Humble, whose keys have no hash, and whose ranges have no variance."""
    command = [sys.executable, str(PLAIN), router.endpoint, namespace, release]
    text = ROVER.replace("/rover", namespace).replace("domain = 43", "domain = 3")
    joined = ZenohTransport(3, router.endpoint)
    with (
        subprocess.Popen(end_with_tests(command), stdout=subprocess.PIPE, text=True) as process,
        Robot(parse_robot(text), joined) as robot,
    ):
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        wait_until(lambda: robot.senses.latest["sonar_ahead"].count > 3)
        wait_until(lambda: robot.senses.value("sonar_ahead", robot.now_s) == 2.0)
        wait_until(lambda: joined.peers() == [Publisher(f"{namespace}/sonar", RANGE)])

        def has_stopped() -> bool:
            with suppress(ArmingRefused):  # a busy computer may have been late before
                robot.arm("a test")
            robot.act({"drive": np.array([1.0]), "turn": np.array([-0.5])})
            return process.poll() is not None

        wait_until(has_stopped)
        data, attached = (bytes.fromhex(each) for each in process.stdout.readline().split())
    assert data == encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5)
    number, time_ns, length = struct.unpack("<qqB", attached[:17])
    assert number >= 1
    assert abs(time_ns - time.time_ns()) < 60e9
    assert (length, len(attached)) == (16, 33)


ENDS = """
import select, sys, time
from contextlib import suppress
import numpy as np
from understudy.addons.robots.robot import connect_robot_body
from understudy.addons.robots.robot_file import load_robot
from understudy.addons.robots.safety.guard import ArmingRefused

robot = connect_robot_body(load_robot(sys.argv[1]), path=sys.argv[1])
while robot.senses.find_missing(robot.now_s) is not None:
    time.sleep(0.01)
while not select.select([sys.stdin], [], [], 0.02)[0]:
    with suppress(ArmingRefused):  # a busy computer was late, and its sensor has to be heard again
        robot.arm("a test")
    robot.act({"drive": np.array([1.0])})
"""
"""A program that ends while its robot drives, without a word."""


@pytest.mark.timed
def test_a_program_that_just_ends_stops_its_robot(router: Router, namespace: str, tmp_path: Path) -> None:
    """Its last words go out when hardly anything of the program is left; who only forgets to close ends as well."""
    forgets = (
        "from understudy.addons.robots.ros.zenoh import ZenohTransport\n"
        f"joined = ZenohTransport(3, {router.endpoint!r})\n"
        f"joined.subscribe('/odom', {RANGE!r}, print)\n"
    )
    assert subprocess.run(end_with_tests([sys.executable, "-c", forgets]), check=False).returncode == 0
    how = f'transport = "zenoh"\nrouter = "{router.endpoint}"\ntick_s'
    text = ROVER.replace("/rover", namespace).replace("domain = 43", "domain = 3").replace("tick_s", how, 1)
    (tmp_path / "rover.toml").write_text(text)
    speeds, ahead = list[float](), struct.Struct("<d")
    command = end_with_tests([sys.executable, "-c", ENDS, str(tmp_path / "rover.toml")])
    with (
        closing(ZenohTransport(3, router.endpoint)) as robot,
        subprocess.Popen(command, stdin=subprocess.PIPE) as process,
    ):
        robot.subscribe(
            f"{namespace}/cmd_vel", TWIST, lambda data, _: speeds.append(ahead.unpack_from(data, 4)[0])
        )
        publish = robot.publisher(f"{namespace}/sonar", RANGE)

        def drives() -> bool:
            publish(sonar(2.0))
            return bool(speeds) and speeds[-1] == 0.4

        def has_exited() -> bool:
            publish(sonar(2.0))
            return process.poll() is not None

        wait_until(drives)
        assert process.stdin is not None
        process.stdin.close()  # which it takes for the end
        wait_until(has_exited)
        assert process.returncode == 0
        assert max(speeds) == 0.4
        wait_until(lambda: speeds[-1] == 0.0)


def check_listening(_: Router, namespace: str) -> None:
    """Without a router, one listens and the other connects."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    listening, came = ZenohTransport(3, listen=endpoint), list[bytes]()
    connected = ZenohTransport(3, endpoint)
    with closing(listening), closing(connected):
        connected.subscribe(f"{namespace}/sonar", RANGE, lambda data, _: came.append(data))
        publish = listening.publisher(f"{namespace}/sonar", RANGE)
        wait_until(lambda: came, meanwhile=lambda: publish(sonar(1.5)))
        assert came[0] == sonar(1.5)
        wait_until(lambda: Publisher(f"{namespace}/sonar", RANGE) in connected.peers())


def check_domains(router: Router, namespace: str) -> None:
    """Domains hear nothing of each other."""
    here, there, same = (ZenohTransport(domain, router.endpoint) for domain in (3, 4, 3))
    with closing(here), closing(there), closing(same):
        came = list[str]()
        there.subscribe(f"{namespace}/sonar", RANGE, lambda data, _: came.append("there"))
        same.subscribe(f"{namespace}/sonar", RANGE, lambda data, _: came.append("same"))
        publish = here.publisher(f"{namespace}/sonar", RANGE)
        wait_until(lambda: "same" in came, meanwhile=lambda: publish(sonar(1.5)))
        wait_until(same.peers)
        assert "there" not in came
        assert there.peers() == []


def check_killed(router: Router, namespace: str) -> None:
    """Who is killed is no peer, although nobody is left to take back its tokens."""
    command = [sys.executable, str(PLAIN), router.endpoint, namespace]
    with (
        closing(ZenohTransport(3, router.endpoint)) as ours,
        subprocess.Popen(end_with_tests(command), stdout=subprocess.PIPE, text=True) as process,
    ):
        try:
            wait_until(ours.peers)
            process.kill()
            wait_until(lambda: not ours.peers())
        finally:
            process.kill()


@pytest.mark.timed
@pytest.mark.parametrize(
    "subject", [check_listening, check_domains, check_killed], ids=lambda each: each.__name__
)
def test_sessions(subject: Callable[[Router, str], None], router: Router, namespace: str) -> None:
    subject(router, namespace)


def test_a_router_that_is_not_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("understudy.addons.robots.ros.zenoh.WAIT_MS", 200)
    file = parse_robot(ROVER.replace("tick_s", 'transport = "zenoh"\nrouter = "tcp/127.0.0.1:1"\ntick_s'))
    with pytest.raises(Unreachable) as raised:
        open_transport(file)
    assert str(raised.value).startswith("Zenoh's router tcp/127.0.0.1:1 cannot be joined: Unable to connect")
    assert "rmw_zenohd" in str(raised.value)
    assert "\n" not in str(raised.value)
    assert "cargo" not in str(raised.value)


@pytest.mark.parametrize("router", ["nonsense", "192.168.0.5:7447", "tcp/192.168.0.5", ""])
def test_a_router_that_is_no_endpoint_is_refused(router: str) -> None:
    with pytest.raises(FileError, match="router"):
        parse_robot(ROVER.replace("tick_s", f'transport = "zenoh"\nrouter = "{router}"\ntick_s'))
