"""Diagnostics: what a robot's drivers say stops it or excludes it, and what is published of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, Wire, sonar

from understudy.errors import FileError
from understudy.robots.diagnostics import diagnose_connection
from understudy.robots.robot import Robot
from understudy.robots.robot_file import parse_robot
from understudy.robots.ros.diagnostic_messages import (
    DIAGNOSTICS,
    PERIOD_S,
    DiagnosticStatus,
    StatusLevel,
    encode_statuses,
)
from understudy.robots.ros.messages import decode_message
from understudy.robots.ros.transport import Transport

SAID = '[diagnostics]\npublish = true\nunfit = ["battery"]\nstop = ["motors: left"]\n[commands]'
FILE = parse_robot(ROVER.replace("[commands]", SAID))
OK, WARN, ERROR, STALE = StatusLevel


class Clock:
    """The time, set by hand."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def say(name: str, level: StatusLevel, message: str = "") -> bytes:
    return encode_statuses([DiagnosticStatus(name, level, message)], time_s=0.0)


def armed(wire: Wire, clock: Clock) -> Robot:
    robot = Robot(FILE, wire, clock=clock)
    wire.deliver("/rover/sonar", sonar(1.0), clock.now)
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
    wire, clock = Wire(), Clock()
    robot = armed(wire, clock)
    wire.deliver("/diagnostics", say(name, level, "overheated"), clock.now)
    robot.act({"drive": [1.0]})  # type: ignore[dict-item]
    assert (robot.stop_cause != "") == stops
    if stops:
        assert robot.stop_cause == f"diagnostics of {name!r}: overheated"
    assert (robot.unfitness == "") == fit
    wire.deliver("/diagnostics", say(name, OK), clock.now)
    robot.act({"drive": [1.0]})  # type: ignore[dict-item]
    assert robot.stop_cause == robot.unfitness == ""


def test_nonsense_changes_nothing() -> None:
    wire, clock = Wire(), Clock()
    robot = armed(wire, clock)
    wire.deliver("/diagnostics", b"\x00\x01\x00\x00 nonsense", clock.now)
    assert robot.unfitness == ""


def published(wire: Wire) -> list[Any]:
    return [
        decode_message(DIAGNOSTICS, data).status[0] for topic, data in wire.sent if topic == "/diagnostics"
    ]


def test_a_robot_says_how_it_is_once_a_second_and_when_that_changes() -> None:
    wire, clock = Wire(), Clock()
    robot = armed(wire, clock)
    first = published(wire)
    assert [(each.name, each.level, each.message) for each in first] == [("understudy: rover", OK, "armed")]
    assert {pair.key: pair.value for pair in first[0].values}["age of sonar_ahead (s)"] == "0.0"
    clock.now += 0.05
    robot.act({})
    assert len(published(wire)) == 1
    robot.disarm("Ada disarmed it")
    robot.act({})
    assert [(each.level, each.message) for each in published(wire)[1:]] == [(WARN, "Ada disarmed it")]
    clock.now += PERIOD_S
    robot.act({})
    assert len(published(wire)) == 3


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


def check_real_messages(driver: Transport, program: Transport) -> None:
    """A driver's error reaches the robot, and the driver hears what the robot says of itself."""
    robot = Robot(FILE, program)
    heard: list[Any] = []
    driver.subscribe(
        "/diagnostics", DIAGNOSTICS, lambda data, at_s: heard.append(decode_message(DIAGNOSTICS, data))
    )
    publish = driver.publisher("/diagnostics", DIAGNOSTICS)
    wait_until(lambda: _tell(robot, publish) == "diagnostics of 'motors: left': overheated")
    wait_until(lambda: _tell(robot, publish) != "" and bool(heard))
    assert any(status.name == "understudy: rover" for message in heard for status in message.status)


def _tell(robot: Robot, publish: Callable[[bytes], None]) -> str:
    publish(say("motors: left", ERROR, "overheated"))
    robot.act({})
    time.sleep(0.05)
    return robot.statuses.find_error(["motors: left"]) or ""


def wait_until(seen: Callable[[], bool]) -> None:
    until = time.monotonic() + 10.0
    while not seen():
        assert time.monotonic() < until, "it never came"


def test_over_dds() -> None:
    pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    from understudy.robots.ros.dds import DdsTransport

    driver, program = DdsTransport(FILE.domain), DdsTransport(FILE.domain)
    try:
        check_real_messages(driver, program)
    finally:
        program.close()
        driver.close()


def test_over_zenoh() -> None:
    pytest.importorskip("zenoh", reason="needs the extra ros2")
    from tests.robots.routers import Router

    from understudy.robots.ros.zenoh import ZenohTransport

    with Router() as router:
        driver, program = (ZenohTransport(FILE.domain, router.endpoint) for _ in range(2))
        try:
            check_real_messages(driver, program)
        finally:
            program.close()
            driver.close()
