"""Recordings of messages as people have them: cut, without definitions or metadata, in several files, compressed."""

from __future__ import annotations

import gzip
import json
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.segmentation.test_messages import BEGAN_NS, MAP, make_map

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.errors import FileError
from understudy.records.messages import encode_message, load_typestore, make_message
from understudy.records.record import Record

pytest.importorskip("mcap")
pytest.importorskip("rosbags")

RANGE, TWIST, FOO = "sensor_msgs/msg/Range", "geometry_msgs/msg/Twist", "our_msgs/msg/Foo"
POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"
LINE = "=" * 80
MORE = '[[readings]]\ncolumn = "/foo.value"\nname = "value"\n'
"""A reading of a topic of a type of one's own."""
Message = tuple[str, int, str, bytes]
"""Topic, time in ns, type and bytes of a message."""


def list_messages(count: int = 200) -> Iterator[Message]:
    """A drive of 0.1 s a tick, whose ranges count its ticks; each range comes 10 ms before its command."""
    for tick in range(count):
        at = BEGAN_NS + tick * 100_000_000
        yield "/ball", at, RANGE, encode_message(RANGE, make_message(RANGE, range=tick / 64, max_range=9.0))
        command = make_message(TWIST)
        command.linear.x = 0.5 * (tick // 20 % 2)
        yield "/cmd_vel", at + 10_000_000, TWIST, encode_message(TWIST, command)


def add_foo(data: bytes = b"\0\1\0\0\0\0\x80\x3f\1\0\0\0\1\0\0\0", type: str = FOO) -> Iterator[Message]:
    for message in list_messages():
        yield message
        yield "/foo", message[1] + 1, type, data


def write_mcap(
    path: Path,
    messages: Sequence[Message],
    *,
    definitions: dict[str, str] | None = None,
    encoding: str = "cdr",
    schema: str = "ros2msg",
    **more: Any,
) -> Path:
    """Write messages as MCAP; each type has the definition that is given, or the one of ROS, or none."""
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer: Any = Writer(file, chunk_size=3000, **more)
        writer.start()
        channels: dict[tuple[str, str], int] = {}
        for topic, at, type, data in messages:
            if (topic, type) not in channels:
                text = (definitions or {}).get(type)
                if text is None:
                    text = load_typestore().generate_msgdef(type, ros_version=2)[0]
                number = writer.register_schema(type, schema, text.encode())
                channels[topic, type] = writer.register_channel(topic, encoding, number)
            writer.add_message(channels[topic, type], at, data, at)
        writer.finish()
    return path


def write_folder(path: Path, *, compress: str = "", storage: str = "SQLITE3") -> Path:
    """Write the drive as ROS 2 does, as a folder, perhaps compressed by the file or by the message."""
    from rosbags import rosbag2

    writer = rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin[storage])
    if compress:
        writer.set_compression(rosbag2.CompressionMode[compress], rosbag2.CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, at, type, data in list_messages():
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, type, typestore=load_typestore())
            writer.write(connections[topic], at, data)
    return path


def read(path: Path, text: str = MAP) -> Record:
    return read_recorded_drive(path, make_map(path.parent, text))


def check_whole(drive: Record, count: int = 200) -> None:
    assert drive.values["range", "ball"].tolist() == [tick / 64 for tick in range(count)]
    np.testing.assert_allclose(np.diff(drive.times), 0.1, atol=1e-6)


OUR_TYPE = f"float32 value\nour_msgs/Part[] parts\n{LINE}\nMSG: our_msgs/Part\nint32 size\n"
WRONG = "float32 § value\n"
HALF = "float32 value\nour_msgs/Part[] parts\n"
DEFINED: list[tuple[dict[str, str], str]] = [  # definitions that are other ones, what is said of the topic
    ({}, ""),
    ({RANGE: "", TWIST: ""}, ""),
    ({RANGE: WRONG, TWIST: HALF}, ""),
    ({FOO: OUR_TYPE}, ""),
    ({FOO: WRONG}, f"topic '/foo': the definition of its type {FOO} cannot be read"),
    (
        {FOO: HALF},
        f"topic '/foo': the definition of its type {FOO} cannot be read (it does not define our_msgs/msg/Part)",
    ),
    (
        {FOO: ""},
        f"topic '/foo': its type {FOO} is not a common one, and the recording has no definition of it",
    ),
]


@pytest.mark.parametrize(("definitions", "said"), DEFINED, ids=range(len(DEFINED)))
@pytest.mark.parametrize("mapped", [True, False])
def test_definitions_of_types(tmp_path: Path, definitions: dict[str, str], said: str, mapped: bool) -> None:
    messages = list(add_foo()) if FOO in definitions else list(list_messages())
    path = write_mcap(tmp_path / "drive.mcap", messages, definitions=definitions)
    mapped = mapped and FOO in definitions
    drive = read(path, MAP + MORE if mapped else MAP)
    check_whole(drive)
    if mapped and not said:
        assert (drive.values["value", None][1:] == 1).all()
    else:
        assert ("value", None) not in drive.values
    assert any(said in each for each in drive.omissions) if mapped and said else drive.omissions == ()


def test_a_command_whose_type_is_not_known_is_refused(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / "drive.mcap", list(add_foo()), definitions={FOO: ""})
    with pytest.raises(FileError, match=f"topic '/foo': its type {FOO} is not a common one"):
        read(path, MAP.replace("/cmd_vel.linear.x", "/foo.value"))


def test_messages_that_do_not_fit_their_type_are_left_out(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / "drive.mcap", list(add_foo(b"\0\1\0\0")), definitions={FOO: OUR_TYPE})
    drive = read(path, MAP + MORE)
    check_whole(drive)
    assert "topic '/foo': 400 messages cannot be decoded (SerdeError" in drive.omissions[0]


def test_messages_of_another_type_on_a_topic_are_left_out(tmp_path: Path) -> None:
    messages = [(topic.replace("/foo", "/ball"), at, type, data) for topic, at, type, data in add_foo()]
    drive = read(write_mcap(tmp_path / "drive.mcap", messages, definitions={FOO: OUR_TYPE}))
    check_whole(drive)
    assert f"topic '/ball': messages are {RANGE}; those of {FOO} are left out" in drive.omissions[0]
    assert len(drive.omissions) == 1


def write_ros_1(path: Path, messages: Sequence[Message]) -> Path:
    from rosbags.rosbag1 import Writer

    with Writer(path) as writer:
        store, connections = make_ros_1(), {}
        for topic, at, type, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, type, typestore=store)
            writer.write(connections[topic], at, data)
    return path


def make_ros_1() -> Any:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS1_NOETIC)


def list_ros_1() -> Iterator[Message]:
    """The same drive in messages of ROS 1, whose headers have a number."""
    store = make_ros_1()
    for topic, at, type, data in list_messages():
        message: Any = load_typestore().deserialize_cdr(data, type)
        if type == RANGE:
            stamp = store.types["builtin_interfaces/msg/Time"](0, 0)
            header = store.types["std_msgs/msg/Header"](7, stamp, "base")
            message = store.types[RANGE](header, 0, 0.0, 0.0, 9.0, message.range)
        yield topic, at, type, store.serialize_ros1(message, type)


@pytest.mark.parametrize("defined", [True, False])
def test_messages_of_ros_1(tmp_path: Path, defined: bool) -> None:
    store, messages = make_ros_1(), list(list_ros_1())
    texts = {
        type: store.generate_msgdef(type, ros_version=1)[0] if defined else "" for type in (RANGE, TWIST)
    }
    check_whole(
        read(
            write_mcap(
                tmp_path / "drive.mcap", messages, definitions=texts, encoding="ros1", schema="ros1msg"
            )
        )
    )


def test_bags_of_ros_1(tmp_path: Path) -> None:
    bag = write_ros_1(tmp_path / "drive.bag", list(list_ros_1()))
    check_whole(read(bag))
    (tmp_path / "packed.bag.gz").write_bytes(gzip.compress(bag.read_bytes()))
    check_whole(read(tmp_path / "packed.bag.gz"))
    bag.write_bytes(bag.read_bytes()[:5000])
    with pytest.raises(FileError, match="repair it with rosbag reindex"):
        read(bag)


def test_sqlite_without_definitions(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "drive")
    with sqlite3.connect(next(folder.glob("*.db3"))) as database:
        database.execute("DROP TABLE message_definitions")
    check_whole(read(folder))


@pytest.mark.parametrize(
    ("compress", "storage"), [("FILE", "SQLITE3"), ("MESSAGE", "SQLITE3"), ("FILE", "MCAP")]
)
def test_compressed_recordings(tmp_path: Path, compress: str, storage: str) -> None:
    check_whole(read(write_folder(tmp_path / "drive", compress=compress, storage=storage)))


def test_files_are_known_by_what_they_have(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / "drive.mcap", list(list_messages()))
    for name in ("drive.bag", "drive.db3"):
        shutil.copy(path, tmp_path / name)
        check_whole(read(tmp_path / name))
    (tmp_path / "drive.mcap.gz").write_bytes(gzip.compress(path.read_bytes()))
    check_whole(read(tmp_path / "drive.mcap.gz"))


NOT_THERE: list[tuple[bytes, str]] = [
    (POINTER, "it is a pointer of git-lfs, and not the file itself; fetch the file"),
    (b"", "it is empty"),
    (b"\0" * 500, "it is empty"),
    (b"\x89MCAP0\r\n\1\2", "it ends in the middle of a record"),
    (b"SQLite format 3\0" + b"\1" * 200, "it cannot be read"),
    (b"#ROSBAG V2.0\n", "it cannot be read"),
    (b"time_s,x\n0,1\n", "it is no recording"),
]


@pytest.mark.parametrize("name", ["drive.mcap", "drive.db3", "drive.bag"])
@pytest.mark.parametrize(("content", "problem"), NOT_THERE, ids=[each[1] for each in NOT_THERE])
def test_what_is_no_recording_is_refused(tmp_path: Path, content: bytes, problem: str, name: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError) as caught:
        read(tmp_path / name)
    assert problem in str(caught.value)
    assert name in str(caught.value)


def write_parts(folder: Path, names: Sequence[str], *, metadata: bool = True) -> Path:
    """Write the drive as a folder of several files, one after the other."""
    folder.mkdir()
    messages = list(list_messages())
    for name, part in zip(names, np.array_split(np.arange(len(messages)), len(names)), strict=True):
        write_mcap(folder / name, [messages[at] for at in part])
    if metadata:
        named = "".join(f"    - {name}\n" for name in names)
        (folder / "metadata.yaml").write_text(f"info:\n  relative_file_paths:\n{named}")
    return folder


TEN = [f"drive_{part}.mcap" for part in range(11)]
PARTS: list[tuple[Sequence[str], bytes | None, int, str]] = [
    # names of the files, what is in the place of the second one (None: nothing), ticks, what is said
    (TEN, b"", 182, "drive_1.mcap: it is empty; left out"),
    (TEN, POINTER, 182, "drive_1.mcap: it is a pointer of git-lfs, and not the file itself; left out"),
    (TEN, b"\x89MCAP0\r\n\1", 182, "drive_1.mcap: it cannot be read"),
    (TEN, None, 182, "metadata.yaml names drive_1.mcap, which is not there"),
]


@pytest.mark.parametrize(("names", "content", "ticks", "said"), PARTS, ids=[each[3] for each in PARTS])
def test_parts_that_are_missing(
    tmp_path: Path, names: Sequence[str], content: bytes | None, ticks: int, said: str
) -> None:
    folder = write_parts(tmp_path / "drive", names)
    check_whole(read(folder))
    (folder / names[1]).unlink()
    if content is not None:
        (folder / names[1]).write_bytes(content)
    drive = read(folder)
    assert abs(drive.ticks - ticks) <= 1
    assert len(drive.episodes) == 2
    assert said in drive.omissions[0]


def test_parts_follow_each_other_in_time(tmp_path: Path) -> None:
    drive = read(write_parts(tmp_path / "drive", ["zebra.mcap", "ant.mcap"], metadata=False))
    check_whole(drive)
    assert "it has no metadata.yaml" in drive.omissions[0]


def test_two_recordings_in_one_folder_are_refused(tmp_path: Path) -> None:
    folder = write_parts(tmp_path / "drive", ["one.mcap"])
    shutil.copy(folder / "one.mcap", folder / "two.mcap")
    with pytest.raises(FileError, match=r"two.mcap: it begins before one.mcap ends"):
        read(folder)


def test_parts_with_other_types_are_refused(tmp_path: Path) -> None:
    folder = write_parts(tmp_path / "drive", ["one.mcap"])
    later = [(topic, at + 10**11, TWIST, data) for topic, at, _, data in list_messages(5)]
    write_mcap(folder / "two.mcap", later)
    with pytest.raises(FileError, match=rf"two.mcap at topic '/ball': its messages are {TWIST}, and {RANGE}"):
        read(folder)


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "drive").mkdir()
    with pytest.raises(FileError, match=r"it has no .mcap or .db3 file, but nothing"):
        read(tmp_path / "drive")
    (tmp_path / "drive" / "notes.txt").write_text("none")
    with pytest.raises(FileError, match=r"it has no .mcap or .db3 file, but notes.txt"):
        read(tmp_path / "drive")


def test_other_encodings_of_a_reading_are_left_out(tmp_path: Path) -> None:
    from mcap.writer import Writer

    with (tmp_path / "drive.mcap").open("wb") as file:
        writer: Any = Writer(file)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels = {
            topic: writer.register_channel(topic, encoding, schema)
            for topic, encoding in (("/ball", "json"), ("/cmd_vel", "json"), ("/foo", "protobuf"))
        }
        for tick in range(50):
            content = {"range": tick / 64, "linear": {"x": tick % 3}}
            for topic in ("/ball", "/cmd_vel", "/foo"):
                writer.add_message(channels[topic], BEGAN_NS + tick * 10**8, json.dumps(content).encode(), 0)
        writer.finish()
    drive = read(tmp_path / "drive.mcap", MAP + MORE)
    check_whole(drive, 50)
    assert (
        "topic '/foo': its messages are encoded as protobuf with jsonschema; left out" in drive.omissions[0]
    )
