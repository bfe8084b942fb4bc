"""Drives in recordings of messages, written by mcap and by rosbags, and what is said about those that do not fit."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.segmentation.test_drive import make_drive
from typer.testing import CliRunner

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import RecordingMap, load_recording_map
from understudy.errors import FileError
from understudy.ui.cli.main import make_command_line

pytest.importorskip("mcap")
pytest.importorskip("rosbags")

MAP = """format = "understudy-recording-map/1"
time = "time_s"
[[readings]]
column = "/ball.range"
name = "range"
target = "ball"
unit = "m"
[[commands]]
column = "/cmd_vel.linear.x"
channel = "drive"
[behaviors.forward]
drive = 0.8
[behaviors.back]
drive = -0.5
"""
BEGAN_NS = 1_700_000_000_000_000_000


def list_messages() -> Iterator[tuple[str, int, float]]:
    """Topic, time and value of each message of the drive in a table; each range comes 10 ms before its command."""
    for row in make_drive()[1:]:
        time_s, distance, drive = map(float, row.split(","))
        at = BEGAN_NS + round(time_s * 1e9)
        yield "/ball", at, distance
        yield "/cmd_vel", at + 10_000_000, drive


def make_map(folder: Path, text: str = MAP) -> RecordingMap:
    (folder / "map.toml").write_text(text)
    return load_recording_map(folder / "map.toml")


def write_json(path: Path, encoding: str = "json") -> Path:
    """Write the drive as MCAP with JSON, without chunks, so that a cut costs the last message only."""
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer: Any = Writer(file, use_chunking=False)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels = {name: writer.register_channel(name, encoding, schema) for name in ("/ball", "/cmd_vel")}
        for topic, at, value in list_messages():
            content = {"range": value} if topic == "/ball" else {"linear": {"x": value}, "frame": "base"}
            writer.add_message(channels[topic], at, json.dumps(content).encode(), at)
        writer.finish()
    return path


def write_ros(path: Path, storage: str) -> Path:
    """Write the drive as ROS 2 does, as a folder."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store: Any = get_typestore(Stores.ROS2_JAZZY)
    types = {"/ball": "sensor_msgs/msg/Range", "/cmd_vel": "geometry_msgs/msg/Twist"}
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        connections = {
            topic: writer.add_connection(topic, type, typestore=store) for topic, type in types.items()
        }
        zero = store.types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
        stamp = store.types["builtin_interfaces/msg/Time"](0, 0)
        for topic, at, value in list_messages():
            if topic == "/ball":
                header = store.types["std_msgs/msg/Header"](stamp, "base")
                message = store.types[types[topic]](header, 0, 0.0, 0.0, 9.0, value, 0.0)
            else:
                forward = store.types["geometry_msgs/msg/Vector3"](value, 0.0, 0.0)
                message = store.types[types[topic]](forward, zero)
            writer.write(connections[topic], at, store.serialize_cdr(message, types[topic]))
    return path


def write_recordings(folder: Path) -> dict[str, Path]:
    """Write the drive as each kind of recording."""
    packed = write_ros(folder / "packed", "MCAP")
    return {
        "MCAP with JSON": write_json(folder / "drive.mcap"),
        "a folder with MCAP": packed,
        "MCAP with CDR": next(packed.glob("*.mcap")),
        "a folder with SQLite": write_ros(folder / "plain", "SQLITE3"),
    }


def test_all_recordings_of_messages_give_the_drive_of_the_table(tmp_path: Path) -> None:
    table = np.array([row.split(",") for row in make_drive()[1:]], np.float64)
    for kind, path in write_recordings(tmp_path).items():
        drive = read_recorded_drive(path, make_map(tmp_path))
        assert drive.tick_s == pytest.approx(0.1), kind
        np.testing.assert_allclose(drive.times, table[:, 0] + 0.01, atol=1e-6)
        np.testing.assert_allclose(drive.values["range", "ball"], table[:, 1], rtol=1e-6)
        np.testing.assert_allclose(drive.commands[:, 0], table[:, 2])
        assert drive.omissions == ()


def test_the_command_learns_from_messages(tmp_path: Path) -> None:
    make_map(tmp_path)
    path = write_json(tmp_path / "drive.mcap")
    arguments = ["learn", "--recording", str(path), "--map", str(tmp_path / "map.toml"), "--json"]
    done = CliRunner().invoke(make_command_line(), arguments)
    assert done.exit_code == 0, done.output
    assert {each["label"] for each in json.loads(done.stdout)["drive"]["spans"]} == {"forward", "back"}


def test_what_comes_before_damage_is_used(tmp_path: Path) -> None:
    path = write_json(tmp_path / "drive.mcap")
    path.write_bytes(path.read_bytes()[:20_000])
    drive = read_recorded_drive(path, make_map(tmp_path))
    assert 50 < drive.ticks < 299
    assert "what comes before is used" in drive.omissions[0]


REFUSED = [  # what is replaced in the mapping file, by what, the problem that is named
    ("/ball.range", "/bal.range", "topic '/bal': there is no message of it"),
    ("/ball.range", "/ball.rang", "there is no 'rang'; did you mean 'range'"),
    ("/ball.range", "ball", "it is no field of a message"),
    ("/ball.range", "/cmd_vel.linear", "is not a number; give the path of a number.* such as linear.x"),
    ("/ball.range", "/cmd_vel.linear.x.y", "there is no 'y'; end the path before it"),
]


@pytest.mark.parametrize(("former", "new", "problem"), REFUSED)
def test_fields_that_are_not_there_are_refused(tmp_path: Path, former: str, new: str, problem: str) -> None:
    path = write_ros(tmp_path / "drive", "MCAP")
    with pytest.raises(FileError, match="(?i)" + problem):
        read_recorded_drive(path, make_map(tmp_path, MAP.replace(former, new)))


def test_other_encodings_are_refused(tmp_path: Path) -> None:
    path = write_json(tmp_path / "drive.mcap", "protobuf")
    with pytest.raises(FileError, match="its messages are encoded as protobuf"):
        read_recorded_drive(path, make_map(tmp_path))


@pytest.mark.parametrize("name", ["none.mcap", "none.bag", "broken.mcap", "broken.db3", "folder"])
def test_what_is_no_recording_is_refused(tmp_path: Path, name: str) -> None:
    if name == "folder":
        (tmp_path / name).mkdir()
    elif name.startswith("broken"):
        (tmp_path / name).write_text("no recording")
    with pytest.raises(FileError, match=r"no such file|it cannot be read|no .mcap"):
        read_recorded_drive(tmp_path / name, make_map(tmp_path))


def test_messages_need_a_mapping_file(tmp_path: Path) -> None:
    path = write_json(tmp_path / "drive.mcap")
    with pytest.raises(FileError, match=r"give --map MAP.toml"):
        read_recorded_drive(path)
