"""Messages that are hostile or broken: nothing they hold ends a program, takes its memory, or moves a robot."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import isfinite, isnan
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("cv2", reason="needs the extra camera")

from tests.robots.hostile import FILE, LENGTHS, TOPICS, anything, message
from tests.robots.rigs import Timed
from tests.robots.rovers import Wire, sonar

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.records.messages import (
    LONGEST,
    MessageRefused,
    decode_message,
    encode_message,
    make_message,
)
from understudy.runtime.body import list_reading_keys

SEEDS = st.integers(0, 2**32)
LITTLE = 2**20
"""More memory than this, in bytes, no message of some hundred bytes may take."""


@dataclass
class Rig(Timed):
    """A robot with everything that can be read, without its guard's thread, by a clock that tests set."""

    wire: Wire = field(default_factory=Wire)

    def __post_init__(self) -> None:
        self.robot = Robot(parse_robot(FILE), self.wire, clock=self.clock)

    def hear(self, topic: str, data: bytes) -> None:
        self.wire.deliver(topic, data, self.now)

    def read(self) -> list[float]:
        """All readings now."""
        self.robot.act({"drive": np.array([1.0]), "turn": np.array([1.0])})  # the next are new
        return [float(column[0]) for column in self.robot.sense(list_reading_keys(self.robot)).values()]

    def commands(self) -> list[tuple[float, ...]]:
        """All that it was sent, six speeds each."""
        return [struct.unpack("<6d", data[4:]) for _, data in self.wire.sent]


@contextmanager
def little_memory() -> Iterator[None]:
    """Whatever happens inside takes no memory to speak of."""
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        tracemalloc.reset_peak()
        yield
        assert tracemalloc.get_traced_memory()[1] - before < LITTLE
    finally:
        tracemalloc.stop()


@given(SEEDS)
def test_whatever_comes_readings_are_numbers_or_absent_and_nothing_moves(seed: int) -> None:
    random, rig = Random(seed), Rig()
    for _ in range(10):
        topic, type = random.choice(list(TOPICS.items()))
        rig.hear(topic, anything(type, random))
        rig.now += 0.1
        assert all(isnan(value) or isfinite(value) for value in rig.read())
    assert rig.commands() == []


@given(SEEDS)
def test_armed_it_keeps_its_limits(seed: int) -> None:
    """And what is not hostile still counts."""
    random, rig = Random(seed), Rig()
    rig.hear("/rover/sonar", sonar(2.0))
    rig.robot.arm("a test")
    for _ in range(10):
        rig.now += 0.1
        topic, type = random.choice(list(TOPICS.items()))
        rig.hear(topic, anything(type, random))
        drive, turn = (random.choice((1.0, -1.0, 1e300, -5.0)) for _ in range(2))
        rig.robot.act({"drive": np.array([drive]), "turn": np.array([turn])})
        rig.robot.guard.check()
    for x, *rest, z in rig.commands():
        assert abs(x) <= 0.5
        assert abs(z) <= 1.0
        assert rest == [0.0] * 4
    rig.hear("/rover/sonar", sonar(1.25))
    assert 1.25 in rig.read()


@pytest.mark.parametrize("topic", TOPICS)
def test_lengths_that_are_claimed_take_no_memory(topic: str) -> None:
    """Each four bytes of a message, one after the other, are taken for a huge length."""
    rig, data = Rig(), message(TOPICS[topic], Random(7))
    rig.hear(topic, data)  # what a first message takes is kept
    with little_memory():
        for at in range(4, len(data) - 3, 4):
            for length in LENGTHS:
                rig.hear(topic, data[:at] + struct.pack("<I", length) + data[at + 4 :])


@pytest.mark.parametrize("size", [(2**16, 2**16), (2**32 - 1, 2**32 - 1), (2**31, 1), (1, 2**31)])
def test_images_that_claim_to_be_giants_take_no_memory(size: tuple[int, int]) -> None:
    rig, image = Rig(), "sensor_msgs/msg/Image"
    width, height = size
    step = min(3 * width, 2**32 - 1)
    data = encode_message(image, make_message(image, encoding="rgb8", width=width, height=height, step=step))
    rig.hear("/rover/image", data)
    with little_memory():
        rig.hear("/rover/image", data)
    assert rig.robot.senses.latest["camera"].refused == 2


def test_messages_that_are_giants_are_not_looked_at() -> None:
    """Longer than any that a robot has use for: what is made of their numbers takes more than they do."""
    scan = "sensor_msgs/msg/LaserScan"
    ranges = np.ones(LONGEST // 4, np.float32)
    data = encode_message(scan, make_message(scan, angle_increment=1e-6, range_max=10.0, ranges=ranges))
    with little_memory(), pytest.raises(MessageRefused, match="bytes long"):
        decode_message(scan, data)
    image = "sensor_msgs/msg/Image"
    assert (
        decode_message(image, encode_message(image, make_message(image, data=np.zeros(LONGEST, np.uint8))))
        is not None
    )
