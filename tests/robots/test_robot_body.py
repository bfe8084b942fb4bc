"""A robot as a body, over a wire in memory and by a clock that tests set: what it senses, and when it moves."""

from __future__ import annotations

from math import inf, isnan, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rigs import CMD, FENCED, ODOM, SONAR, STOP, Rig
from tests.robots.rovers import ODOMETRY, ROVER, STAMPED, TWIST, Wire, odometry, sonar

from understudy.addons.robots.diagnostics import diagnose_connection
from understudy.addons.robots.ros.transport import Publisher
from understudy.errors import DefinitionError, FileError, UnknownName
from understudy.runtime.body import list_reading_keys
from understudy.testing import check_body

ACCELERATIONS = "turn_rad_s = 1.0\nacceleration_m_s2 = 1.0\nturn_acceleration_rad_s2 = 2.0\n\n[readings.sonar"

MOVES = [  # drive, turn, what is sent: 0.4 m/s and 1 rad/s at 1, never above 0.5 and 1
    (1.0, 0.0, (0.4, 0.0)),
    (-1.0, 0.5, (-0.4, 0.5)),
    (2.0, -3.0, (0.5, -1.0)),
]


def test_it_keeps_the_laws_of_bodies() -> None:
    check_body(Rig().robot)


def test_it_senses_the_last_values() -> None:
    rig = Rig()
    rig.hear(SONAR, sonar(2.5))
    rig.hear(SONAR, sonar(1.5))
    rig.hear(ODOM, odometry(3.0, z=sqrt(0.5), w=sqrt(0.5)))
    assert [rig.read(name) for name, _ in list_reading_keys(rig.robot)] == pytest.approx([1.5, 3.0, pi / 2])


def test_it_senses_the_same_until_it_acts() -> None:
    rig = Rig()
    rig.hear(SONAR, sonar(2.5))
    assert rig.read("sonar_ahead") == 2.5
    rig.hear(SONAR, sonar(1.5))
    assert rig.read("sonar_ahead") == 2.5
    rig.robot.act({})
    assert rig.read("sonar_ahead") == 1.5


def test_a_reading_is_absent_once_it_is_stale() -> None:
    rig = Rig()
    assert isnan(rig.read("sonar_ahead"))
    rig.now += 0.2
    rig.hear(SONAR, sonar(2.5))
    rig.now += 0.5
    assert rig.read("sonar_ahead") == 2.5
    rig.now += 0.2
    assert isnan(rig.read("sonar_ahead"))


@pytest.mark.parametrize("type", [TWIST, STAMPED])
@pytest.mark.parametrize(("drive", "turn", "sent"), MOVES)
def test_it_obeys_within_its_limits(type: str, drive: float, turn: float, sent: tuple[float, float]) -> None:
    rig = Rig(ROVER.replace("[commands]", f'[commands]\ntype = "{type}"')).ready()
    assert rig.move(drive, turn) == pytest.approx(sent)


def test_a_command_that_makes_no_sense_stops_it() -> None:
    rig = Rig().ready()
    for drive in (nan, inf):
        assert rig.move(1.0) != STOP
        with pytest.raises(DefinitionError, match="drive"):
            rig.move(drive)
        assert rig.sent == STOP


def test_nothing_is_sent_before_it_is_armed_and_nothing_moves_after_a_stop() -> None:
    rig = Rig()
    rig.hear(SONAR, sonar(2.0))
    rig.robot.act({"drive": np.ones(1)})
    assert rig.wire.sent == []
    assert rig.robot.stop_cause == "not armed"
    rig.robot.arm("Ada")
    assert rig.move(1.0) != STOP
    rig.robot.disarm("Ada said so")
    assert rig.sent == STOP
    assert rig.move(1.0) == STOP
    assert (rig.robot.armed, rig.robot.stop_cause) == (False, "Ada said so")


def test_without_a_required_reading_it_stops() -> None:
    """Where its sensor fell silent, until armed again; where it measured nothing, until it does."""
    rig = Rig().ready()
    rig.now += 0.2
    rig.hear(SONAR, sonar(nan))
    assert rig.move(1.0) == STOP
    assert rig.robot.stop_cause == "sonar_ahead is absent"
    rig.hear(SONAR, sonar(2.0))
    assert rig.move(1.0) != STOP
    rig.now += 0.5
    assert rig.move(1.0) != STOP
    rig.now += 0.1
    assert rig.move(1.0) == STOP
    rig.hear(SONAR, sonar(2.0))
    assert rig.move(1.0) == STOP
    assert [stop.cause for stop in rig.robot.stops] == ["sonar_ahead is absent"] * 2


def test_outside_its_geofence_it_stops() -> None:
    rig = Rig(FENCED)
    rig.hear(ODOM, odometry(0.9))
    rig.ready()
    assert rig.move(1.0) != STOP
    rig.hear(ODOM, odometry(1.1))
    rig.robot.guard.check()
    assert rig.sent == STOP
    assert rig.robot.stop_cause == "outside its geofence"
    rig.hear(ODOM, odometry(0.9))
    assert rig.move(1.0) == STOP


def test_it_gets_faster_no_faster_than_it_may_and_stops_at_once() -> None:
    """1 m/s² and 2 rad/s², a command each 0.1 s; after half a second of silence no further than in two ticks."""
    rig = Rig(ROVER.replace("turn_rad_s = 1.0\n\n[readings.sonar", ACCELERATIONS)).ready()
    rig.move(0.0)
    sent = []
    for _ in range(5):
        rig.now += 0.1
        rig.hear(SONAR, sonar(2.0))
        sent.append(rig.move(1.0, 0.5))
    assert sent == [
        pytest.approx(row) for row in [(0.1, 0.2), (0.2, 0.4), (0.3, 0.5), (0.4, 0.5), (0.4, 0.5)]
    ]
    rig.now += 0.5
    rig.hear(SONAR, sonar(2.0))
    assert rig.move(-1.0, 0.5) == pytest.approx((0.2, 0.5))
    rig.robot.disarm()
    assert rig.sent == STOP


@given(st.binary(max_size=120))
def test_made_up_messages_never_move_it_nor_end_it(data: bytes) -> None:
    rig = Rig().ready()
    rig.now += 0.6  # what it heard is stale
    rig.hear(SONAR, data)
    rig.hear(ODOM, data)
    if not rig.robot.senses.latest["sonar_ahead"].count > 1:
        assert rig.move(1.0) == STOP
    assert all(abs(speed) <= most for speed, most in zip(rig.move(1.0, 1.0), (0.5, 1.0), strict=True))


@given(st.integers(0, 30), st.integers(0, 255))
def test_a_message_with_one_byte_changed_is_a_range_or_absent(place: int, byte: int) -> None:
    data = bytearray(sonar(2.0))
    data[place % len(data)] = byte
    rig = Rig()
    rig.hear(SONAR, bytes(data))
    assert not np.isinf(rig.read("sonar_ahead"))


def test_closing_stops_what_was_commanded_and_only_that() -> None:
    looked, driven = Rig(), Rig().ready()
    driven.move(1.0)
    for rig in (looked, driven):
        with rig.robot:
            pass
        assert rig.wire.closed
    assert looked.wire.sent == []
    assert driven.sent == STOP


def test_unknown_readings_and_channels_are_errors() -> None:
    rig = Rig()
    with pytest.raises(UnknownName, match="no reading 'sonar'"):
        rig.robot.sense([("sonar", None)])
    with pytest.raises(UnknownName, match="no channel 'load'"):
        rig.robot.act({"load": np.ones(1)})


def test_what_no_message_has_names_its_key_in_the_file() -> None:
    with pytest.raises(FileError, match=r"readings\.x\.field: is 'pose\.pose\.position\.q'"):
        Rig(ROVER.replace("position.x", "position.q"))


SURVEYS = [  # who else publishes, what came in 2 s, what is said
    ([], {}, ["nobody publishes there"]),
    (
        [Publisher(SONAR, ODOMETRY)],
        {},
        ["/rover/sonar carries nav_msgs/msg/Odometry, not sensor_msgs/msg/Range"],
    ),
    ([Publisher(SONAR, "sensor_msgs/msg/Range")], {}, ["somebody publishes there"]),
    ([], {SONAR: b"\0\1\0\0"}, ["is no sensor_msgs/msg/Range"]),
    ([Publisher(CMD, TWIST)], {SONAR: sonar(1.0), ODOM: odometry(0.0)}, ["two masters"]),
    ([Publisher(ODOM, ODOMETRY)] * 2, {SONAR: sonar(1.0), ODOM: odometry(0.0)}, ["namespace of its own"]),
    ([], {SONAR: sonar(1.0), ODOM: odometry(0.0)}, []),
]


@pytest.mark.parametrize(("peers", "came", "said"), SURVEYS)
def test_a_survey_says_what_is_missing(
    peers: list[Publisher], came: dict[str, bytes], said: list[str]
) -> None:
    rig = Rig(wire=Wire(peers))

    for _ in range(20):
        rig.now += 0.1
        for topic, data in came.items():
            rig.hear(topic, data)
    found = diagnose_connection(rig.robot, seconds=2.0)
    assert len(found.problems) >= len(said)
    assert all(any(words in problem for problem in found.problems) for words in said)
    assert bool(found.problems) == bool(said)
    assert rig.wire.sent == []
    if not said:
        assert [each.rate_hz for each in found.arrivals] == pytest.approx([10.0] * 3)


def test_a_survey_tells_slow_and_silent_sensors() -> None:
    rig = Rig(ROVER.replace("stale_s = 0.5", "stale_s = 0.5\nrate_hz = 10", 1))

    for _ in range(5):
        rig.now += 0.4
        rig.hear(SONAR, sonar(1.0))
        if rig.now < 101.0:
            rig.hear(ODOM, odometry(0.0))
    problems = diagnose_connection(rig.robot, seconds=2.0).problems
    assert ["2.5 Hz, not 10" in problems[0], "fell silent 1.2 s ago" in problems[1]] == [True, True]
