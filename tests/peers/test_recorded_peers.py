"""The recorded bytes of peers are those of rosbags, and read by us as they were meant, without a compiler."""

from __future__ import annotations

from math import atan2

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from rosbags.typesys import Stores
from tests.peers.recorded_peers import (
    PEERS,
    SPACE,
    SPEED_M_S,
    TURN_RAD_S,
    check_sources,
    hash_sources,
    read_record,
)
from tests.peers.test_peers import written
from tests.robots.rovers import ODOMETRY, RANGE, TWIST

from understudy.records.messages import decode_message, encode_twist


def test_sources_are_as_recorded_or_peers_are_compiled() -> None:
    check_sources()
    assert len(hash_sources()) == 20


@pytest.mark.parametrize("name", PEERS)
def test_recorded_bytes_are_equal_in_both_directions(name: str) -> None:
    peer = read_record()["peers"][name]
    release = Stores.ROS2_HUMBLE if "humble" in name else Stores.ROS2_JAZZY
    sent = {f"{SPACE}{topic}": bytes.fromhex(text) for topic, text in peer["sent"].items()}
    assert sent == written(release, SPACE)
    assert peer["got"] == {
        "bytes": encode_twist(TWIST, speed_m_s=SPEED_M_S, turn_rad_s=TURN_RAD_S).hex(),
        "speed_m_s": SPEED_M_S,
        "turn_rad_s": TURN_RAD_S,
    }


@pytest.mark.parametrize("name", PEERS)
def test_recorded_bytes_are_read_as_they_were_meant(name: str) -> None:
    sent = {topic: bytes.fromhex(text) for topic, text in read_record()["peers"][name]["sent"].items()}
    assert decode_message(RANGE, sent["/sonar"]).range == 2.0
    pose = decode_message(ODOMETRY, sent["/odom"]).pose.pose
    assert (pose.position.x, pose.position.y) == (1.0, -2.0)
    assert atan2(pose.orientation.z, pose.orientation.w) == pytest.approx(atan2(0.6, 0.8))
