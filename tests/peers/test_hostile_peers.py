"""Hostile messages on the way that real ones take: from Fast DDS, which sends any bytes, and over Zenoh."""

from __future__ import annotations

import resource
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isfinite, isnan
from random import Random

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("zenoh", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("cv2", reason="needs the extra camera")

from tests.peers.building import fast_dds, missing
from tests.processes import end_with_tests
from tests.robots.domains import own_domain
from tests.robots.hostile import FILE, TOPICS, anything
from tests.robots.routers import Router
from tests.robots.rovers import TWIST, sonar
from tests.waiting import wait_until

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.dds import DdsTransport
from understudy.addons.robots.ros.transport import Transport
from understudy.addons.robots.ros.zenoh import ZenohTransport
from understudy.records.messages import convert_to_dds_name
from understudy.runtime.body import list_reading_keys

DOMAIN = own_domain()
SENT = 300
"""Hostile messages."""
MEMORY = 100 * 2**20
"""More than this, in bytes, they may not take: libraries keep buffers."""

Send = Callable[[str, bytes], None]


@contextmanager
def over_dds(folder: pytest.Config) -> Iterator[tuple[Transport, Transport, Send]]:
    """The robot's transport, another that sees what it sends, and what publishes any bytes."""
    program = fast_dds(folder.cache.mkdir("peers"), "raw")
    command = [str(program), str(DOMAIN)]
    with subprocess.Popen(
        end_with_tests(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None

        def tell(line: str) -> None:
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(line)
            process.stdin.flush()
            assert process.stdout.readline() == "ok\n"

        def send(topic: str, data: bytes) -> None:
            tell(f"rt{topic} {convert_to_dds_name(TOPICS[topic])} {data.hex()}\n")

        for topic in TOPICS:
            send(topic, b"")
        ours = DdsTransport(DOMAIN)
        yield ours, DdsTransport(DOMAIN), send
        process.stdin.close()
        process.wait(60)


@contextmanager
def over_zenoh() -> Iterator[tuple[Transport, Transport, Send]]:
    with Router() as router:
        theirs, ours, third = (ZenohTransport(DOMAIN, router.endpoint) for _ in range(3))
        publish = {topic: theirs.publisher(topic, type) for topic, type in TOPICS.items()}
        yield ours, third, lambda topic, data: publish[topic](data)
        theirs.close()


@pytest.fixture(params=["dds", "zenoh"])
def way(request: pytest.FixtureRequest) -> Iterator[tuple[Transport, Transport, Send]]:
    if request.param == "dds" and missing():
        pytest.skip(missing())
    with over_dds(request.config) if request.param == "dds" else over_zenoh() as made:
        yield made
        made[1].close()


@pytest.mark.timed
def test_hostile_messages_on_the_wire_end_nothing_and_move_nothing(
    way: tuple[Transport, Transport, Send],
) -> None:
    """Unarmed it sends nothing; armed it keeps its limits; what is not hostile is read all the while."""
    ours, third, send = way
    commands: list[np.ndarray] = []
    third.subscribe("/rover/cmd_vel", TWIST, lambda data, _: commands.append(np.frombuffer(data[4:])))
    random = Random(1)
    with Robot(parse_robot(FILE), ours) as robot:
        sonar_ahead = robot.senses.latest["sonar_ahead"]

        def hear(range_m: float) -> None:
            def came() -> bool:
                send("/rover/sonar", sonar(range_m))
                return robot.senses.value("sonar_ahead", robot.now_s) == pytest.approx(range_m)

            wait_until(came)

        def besiege() -> None:
            for number in range(SENT):
                topic, type = random.choice(list(TOPICS.items()))
                send(topic, anything(type, random))
                if number % 10 == 0:
                    robot.act({"drive": np.array([1e300]), "turn": np.array([-9.0])})
                    values = robot.sense(list_reading_keys(robot)).values()
                    assert all(isnan(value) or isfinite(value) for [value] in values)
            time.sleep(0.1)

        hear(2.0)
        besiege()
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        hear(1.5)
        assert commands == []
        robot.arm("a test")
        besiege()
        hear(1.25)
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MEMORY / 1024
        assert sonar_ahead.count > 3
    assert commands
    assert all(abs(each[0]) <= 0.5 and abs(each[5]) <= 1.0 and not any(each[1:5]) for each in commands)
