"""Diagnostics: what a robot's drivers say stops it or excludes it, and what is published of it."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, Wire, sonar
from tests.simulated_clock import SimulatedClock

from understudy.addons.robots.diagnostics import diagnose_connection
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.diagnostic_messages import (
    DIAGNOSTICS,
    PERIOD_S,
    DiagnosticStatus,
    StatusLevel,
    encode_statuses,
)
from understudy.errors import FileError
from understudy.records.messages import decode_message

SAID = '[diagnostics]\npublish = true\nunfit = ["battery"]\nstop = ["motors: left"]\n[commands]'
FILE = parse_robot(ROVER.replace("[commands]", SAID))
OK, WARN, ERROR, STALE = StatusLevel


def say(name: str, level: StatusLevel, message: str = "") -> bytes:
    return encode_statuses([DiagnosticStatus(name, level, message)], time_s=0.0)


def make_armed_robot(wire: Wire, clock: SimulatedClock) -> Robot:
    robot = Robot(FILE, wire, clock=clock)
    wire.deliver("/rover/sonar", sonar(1.0), clock())
    robot.arm("Ada")
    robot.act({})
    return robot


STATUSES = [  # name, level, whether it stops the robot, whether it is fit
    ("motors: left", OK, False, True),
    ("motors: left", WARN, False, True),
    ("motors: left", ERROR, True, False),
    ("motors: left", STALE, True, False),
    ("battery", ERROR, False, False),
    ("motors: right", ERROR, False, True),  # the file does not name it
]


@pytest.mark.parametrize(("name", "level", "stops", "fit"), STATUSES)
def test_what_a_status_does(name: str, level: StatusLevel, stops: bool, fit: bool) -> None:
    wire, clock = Wire(), SimulatedClock()
    robot = make_armed_robot(wire, clock)
    wire.deliver("/diagnostics", say(name, level, "overheated"), clock())
    robot.act({"drive": [1.0]})  # type: ignore[dict-item]
    assert (robot.stop_cause != "") == stops
    if stops:
        assert robot.stop_cause == f"diagnostics of {name!r}: overheated"
    assert (robot.unfitness == "") == fit
    wire.deliver("/diagnostics", say(name, OK), clock())
    robot.act({"drive": [1.0]})  # type: ignore[dict-item]
    assert robot.stop_cause == robot.unfitness == ""


def test_nonsense_changes_nothing() -> None:
    wire, clock = Wire(), SimulatedClock()
    robot = make_armed_robot(wire, clock)
    wire.deliver("/diagnostics", b"\x00\x01\x00\x00 nonsense", clock())
    assert robot.unfitness == ""


def list_published(wire: Wire) -> list[Any]:
    return [
        decode_message(DIAGNOSTICS, data).status[0] for topic, data in wire.sent if topic == "/diagnostics"
    ]


def test_a_robot_says_how_it_is_once_a_second_and_when_that_changes() -> None:
    wire, clock = Wire(), SimulatedClock()
    robot = make_armed_robot(wire, clock)
    first = list_published(wire)
    assert [(each.name, each.level, each.message) for each in first] == [("understudy: rover", OK, "armed")]
    assert {pair.key: pair.value for pair in first[0].values}["age of sonar_ahead (s)"] == "0.0"
    clock.advance(0.05)
    robot.act({})
    assert len(list_published(wire)) == 1
    robot.disarm("Ada disarmed it")
    robot.act({})
    assert [(each.level, each.message) for each in list_published(wire)[1:]] == [(WARN, "Ada disarmed it")]
    clock.advance(PERIOD_S)
    robot.act({})
    assert len(list_published(wire)) == 3


def test_a_status_that_never_comes_is_reported_by_the_check() -> None:
    robot = Robot(FILE, Wire())
    robot.statuses.receive(say("battery", OK), 0.0)
    found = diagnose_connection(robot, seconds=0.0).problems
    said = [problem for problem in found if problem.startswith("diagnostics")]
    assert said == [
        "diagnostics: nothing named 'motors: left' comes on /diagnostics; start its driver, or correct the name in "
        "the robot's file"
    ]


WRONG = [('topic = "a b"', "at diagnostics.topic"), ("stop = [1]", "at diagnostics.stop")]


@pytest.mark.parametrize(("key", "says"), WRONG)
def test_diagnostics_that_are_refused(key: str, says: str) -> None:
    with pytest.raises(FileError) as caught:
        parse_robot(ROVER.replace("[commands]", f"[diagnostics]\n{key}\n[commands]"))
    assert says in str(caught.value)
