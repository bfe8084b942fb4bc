"""Robot files: what they may say, and errors down to the key."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.robots.rovers import ROVER, Wire

from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import load_robot, parse_robot
from understudy.errors import FileError

TOPICS = [  # namespace, name in the file, the topic
    ("", "odom", "/odom"),
    ("rover", "odom", "/rover/odom"),
    ("/rover", "odom", "/rover/odom"),
    ("/fleet/rover", "sonar/front", "/fleet/rover/sonar/front"),
    ("/rover", "/odom", "/odom"),
]

WRONG = [  # this in the file, replaced by that, is an error at this key, which says this
    ('"understudy-robot/1"', '"understudy-robot/2"', "format", "not a known format of robots"),
    ('name = "rover"', "", "name", "is missing"),
    ("domain = 43", "domain = 233", "domain", "from 0 to 232"),
    ("domain = 43", "domian = 43", "domian", "did you mean 'domain'"),
    ("tick_s = 0.1", "tick_s = 100", "tick_s", "up to 1"),
    ("tick_s = 0.1", 'transport = "serial"', "transport", "known are"),
    ("tick_s = 0.1", "tick_s = nan", "tick_s", "is nan"),
    ("speed_m_s = 0.5", "speed_m_s = 50", "limits.speed_m_s", "up to 5"),
    ("speed_m_s = 0.5", "speed_m_s = 0.3", "commands.drive_m_s", "up to 0.3"),
    ("speed_m_s = 0.5", "speed_m_s = 0.5\nacceleration_m_s2 = 0", "limits.acceleration_m_s2", "is 0"),
    ("turn_rad_s = 1.0\n\n", "turn_rad_s = 1.0\ngeofence = [1, 0, 0, 1]\n\n", "limits.geofence", "x0 < x1"),
    ("turn_rad_s = 1.0\n\n", "turn_rad_s = 1.0\ngeofence = [0, 0, 1, 1]\n\n", "readings.y", "is missing"),
    ('topic = "sonar"', 'topic = "so nar"', "readings.sonar_ahead.topic", "not a valid topic name"),
    ('topic = "sonar"', f'topic = "{"s" * 70_000}"', "readings.sonar_ahead.topic", "70007 letters"),
    ('topic = "sonar"', f'topic = "/{"s" * 247}"', "readings.sonar_ahead.topic", "at most 247"),
    ('namespace = "/rover"', f'namespace = "/{"r" * 224}"', "namespace", "at most 223"),
    ("[commands]", f'[targets.ball]\ntopic = "{"b" * 248}"\n[commands]', "targets.ball.topic", "at most 247"),
    ("sensor_msgs/msg/Range", "sensor_msgs/Range", "readings.sonar_ahead.type", "not a message type"),
    ("stale_s = 0.5", "stale_s = 0.5\nrate_hz = 1", "readings.sonar_ahead.stale_s", "more than 1"),
    ("required = true", 'required = "yes"', "readings.sonar_ahead.required", "true or false"),
    ("drive_m_s = 0.4", "drive_m_s = -0.4", "commands.drive_m_s", "above 0"),
    ("drive_m_s = 0.4", 'drive_m_s = 0.4\ntype = "std_msgs/msg/Bool"', "commands.type", "TwistStamped"),
    ("[commands]", "[commands", "line 31, column 10", "not TOML"),
    ('"understudy-robot/1"', '"understudy-robots/1"', "format", "give it to understudy robots run"),
    ("[readings.x]", "[targets.ball]\nat = [1, 0]\n\n[readings.range]", "readings.range", "another name"),
    ("[readings.x]", "[camera]\n\n[readings.blob_x]", "readings.blob_x", "what the camera give"),
    ("[commands]", "[camera]\nrate_hz = nan\n[commands]", "camera.rate_hz", "is nan"),
    (
        "[commands]",
        '[targets.ball]\ntopic = "b"\nrate_hz = 0.5\n[commands]',
        "targets.ball.stale_s",
        "more than 2",
    ),
    ("[commands]", "[safety]\ndeadline_s = 0.01\n[commands]", "safety.deadline_s", "above 0.04"),
    ('namespace = "/rover"', 'namespace = "/röver"', "namespace", "letters, digits"),
]
SONAR = 'type = "sensor_msgs/msg/Range"'
WRONG_IN_ARENA = [  # the same of a file that names the world arena
    (SONAR, 'type = "std_msgs/msg/Bool"\nfield = "data"', "readings.sonar_ahead", "and continuous in arena"),
    (SONAR, f'{SONAR}\nunit = "cm"', "readings.sonar_ahead.unit", "is cm, and m in arena; read a field in m"),
]


def test_a_file_is_read() -> None:
    robot = parse_robot(ROVER)
    assert (robot.name, robot.domain, robot.tick_s) == ("rover", 43, 0.1)
    assert list(robot.readings) == ["sonar_ahead", "x", "heading"]
    assert robot.commands.type == "geometry_msgs/msg/Twist"


@pytest.mark.parametrize(("namespace", "name", "topic"), TOPICS)
def test_topics_are_within_the_namespace(namespace: str, name: str, topic: str) -> None:
    robot = parse_robot(ROVER.replace('namespace = "/rover"', f'namespace = "{namespace}"'))
    assert robot.topic(name) == topic


@pytest.mark.parametrize(("this", "that", "place", "said"), WRONG, ids=[row[1][:40] for row in WRONG])
def test_what_cannot_be_names_its_key(this: str, that: str, place: str, said: str) -> None:
    assert this in ROVER
    with pytest.raises(FileError) as error:
        parse_robot(ROVER.replace(this, that, 1))
    assert error.value.place == place
    assert said in str(error.value)


def test_the_file_of_the_documents_is_one() -> None:
    page = (Path(__file__).parents[2] / "docs" / "robots.md").read_text("utf-8")
    robot = parse_robot(page.split("```toml\n")[1].split("```")[0])
    assert list(robot.readings) == ["sonar_ahead", "x", "y", "heading"]


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(FileError, match="no such file"):
        load_robot("nowhere.toml")


@pytest.mark.parametrize(("this", "that", "place", "said"), WRONG_IN_ARENA)
def test_readings_are_of_the_sort_that_lessons_are_about(this: str, that: str, place: str, said: str) -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    file = ROVER.replace("[limits]", 'world = "arena"\n[limits]')
    Robot(parse_robot(file), Wire())
    with pytest.raises(FileError) as error:
        Robot(parse_robot(file.replace(this, that)), Wire())
    assert error.value.place == place
    assert said in str(error.value)
