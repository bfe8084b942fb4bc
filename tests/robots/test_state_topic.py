"""Transitions: what is said of a switch, and to whom."""

from __future__ import annotations

import json

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import Wire

from understudy.addons.robots.ros.state_topic import StateChangePublisher
from understudy.records.message_types import detect_state_change
from understudy.records.messages import decode_message

SWITCHES = [  # states before and after, the outermost level that switched
    ((), (), None),
    (("a",), ("a",), None),
    ((), ("a", "x"), (0, "", "a")),
    (("a", "x"), ("b", "x"), (0, "a", "b")),
    (("a", "x"), ("a", "y"), (1, "x", "y")),
    (("a", "x"), ("a",), (1, "x", "")),
    (("a",), ("a", "x", "p"), (1, "", "x")),
    (("a", "x", "p"), ("a", "y", "q"), (1, "x", "y")),
]


@pytest.mark.parametrize(("before", "after", "expected"), SWITCHES)
def test_transition(
    before: tuple[str, ...], after: tuple[str, ...], expected: tuple[int, str, str] | None
) -> None:
    assert detect_state_change(before, after) == expected


def test_each_switch_is_published_once() -> None:
    wire = Wire()
    told = StateChangePublisher(wire, namespace="/rover", robot="rover")
    for tick, path in enumerate([("a",), ("a",), ("a", "ü"), ("b",)]):
        told.publish_changes(tick / 10, path)
    switched = [data for topic, data in wire.sent if topic == "/rover/understudy/transitions"]
    assert [json.loads(decode_message("std_msgs/msg/String", data).data) for data in switched] == [
        {"time_s": 0.0, "robot": "rover", "level": 0, "before": "", "after": "a", "path": ["a"]},
        {"time_s": 0.2, "robot": "rover", "level": 1, "before": "", "after": "ü", "path": ["a", "ü"]},
        {"time_s": 0.3, "robot": "rover", "level": 0, "before": "a", "after": "b", "path": ["b"]},
    ]


def test_each_stop_is_published_once() -> None:
    wire = Wire()
    told = StateChangePublisher(wire, namespace="/rover", robot="rover")
    for cause in ("not armed", "not armed", "", "", "x is absent"):
        told.publish_changes(0.0, (), stopped=cause)
    assert {topic for topic, _ in wire.sent} == {"/rover/understudy/stopped"}
    assert [decode_message("std_msgs/msg/String", data).data for _, data in wire.sent] == [
        "not armed",
        "",
        "x is absent",
    ]
