"""Recordings: what went over a transport and what was decided, in files that others open, whatever ends them."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from math import inf, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="needs the extra ros2")
pytest.importorskip("mcap", reason="needs the extra ros2")

from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from tests.bodies import Scripted
from tests.processes import end_with_tests
from tests.robots.rovers import ODOMETRY, RANGE, ROVER, TWIST, Wire, odometry, sonar
from tests.simulated_clock import SimulatedClock
from tests.waiting import wait_until

from understudy.addons.robots.recording_transport import RecordingTransport
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.transport import Publisher
from understudy.errors import FileError
from understudy.model.value_kinds import Column
from understudy.records import recorder as recorder_module
from understudy.records import writer
from understudy.records.header import BODY, FORMAT, RUN, RunInfo, decode_header
from understudy.records.message_types import (
    READINGS,
    ReadingsEncoder,
    StatesEncoder,
    decode_states,
)
from understudy.records.messages import decode_message
from understudy.records.reader import Recording, read_recording
from understudy.records.record import RecordedPress
from understudy.records.recorder import RecordingFailed, RunRecorder
from understudy.runtime.body import list_reading_keys

FORWARD = {"drive": np.array([1.0]), "turn": np.array([0.0])}
NAMES = st.lists(st.text("abü( )_1", min_size=0, max_size=9), max_size=6, unique=True)
NUMBERS = st.floats(width=64)


def count_ticks(path: Path) -> int:
    """Return the number of ticks that a recording has so far; 0 if it cannot be read yet."""
    with suppress(FileError):
        return read_recording(path).ticks
    return 0


@given(NAMES, st.data())
def test_readings_are_kept_to_the_last_bit(names: list[str], data: st.DataObject) -> None:
    """Other people's decoder finds the same as ours, tick after tick."""
    messages, made = ReadingsEncoder(names), b""
    for _ in range(2):
        time_s = data.draw(NUMBERS)
        values = np.array(data.draw(st.lists(NUMBERS, min_size=len(names), max_size=len(names))))
        made = messages.encode(time_s, values)
        theirs = decode_message(READINGS, made)
        assert [each.name for each in theirs.readings] == names
        found = messages.decode(made)
        assert found is not None
        for one in ([found[0], *found[1]], [theirs.time_s, *(each.value for each in theirs.readings)]):
            assert np.array(one, float).tobytes() == np.array([time_s, *values], float).tobytes()
    assert ReadingsEncoder([*names, "another"]).decode(made) is None


def test_names_of_one_length_are_told_apart() -> None:
    assert ReadingsEncoder(["x", "y"]).decode(ReadingsEncoder(["x", "z"]).encode(0.0, np.zeros(2))) is None


def test_states_are_said_each_tick() -> None:
    states = StatesEncoder()
    said = [decode_states(states.encode(*each)) for each in ((0.1, ("a", "b")), (0.2, ("a", "b")), (0.3, ()))]
    assert said == [(0.1, ("a", "b")), (0.2, ("a", "b")), (0.3, ())]


def rover(path: Path) -> tuple[RunRecorder, Robot, Wire, SimulatedClock]:
    clock = SimulatedClock()
    recorder, wire = RunRecorder(path, clock=clock), Wire([Publisher("/rover/sonar", RANGE)])
    robot = Robot(parse_robot(ROVER), RecordingTransport(wire, recorder), clock=clock)
    wire.deliver("/rover/sonar", sonar(2.0), clock())  # robots do not wait until somebody begins
    recorder.begin(robot, names=["rover"], ran=RunInfo(behavior="wander"), files={"rover.toml": ROVER})
    return recorder, robot, wire, clock


def drive(path: Path) -> tuple[Wire, list[bytes]]:
    """A rover that hears twice from its sonar and once from its wheels, and is told to drive."""
    recorder, robot, wire, clock = rover(path)
    heard = [sonar(1.0), sonar(0.25), odometry(2.0)]
    with recorder, robot:
        for topic, data in zip(("/rover/sonar", "/rover/sonar", "/rover/odom"), heard, strict=True):
            percept = robot.sense(list_reading_keys(robot))
            robot.act(FORWARD)
            recorder.write_tick(robot.time_s, percept, [("wander", "forward")])
            clock.jump(0.1)
            wire.deliver(topic, data, clock())
            robot.arm("a test")  # its sonar was heard
        recorder.write_press("backward")
        recorder.write_press(None)
        recorder.write_tick(robot.time_s, robot.sense(list_reading_keys(robot)), [("wander", "backward")])
        assert robot.transport.peers() == wire.peers()
    assert wire.closed
    return wire, heard


def test_messages_are_kept_as_they_went(tmp_path: Path) -> None:
    """Bytes in and out, on their topics and with their types, for the readers of MCAP and of rosbags alike."""
    path = tmp_path / "drive.mcap"
    wire, (near, nearer, wheels) = drive(path)
    sent = [data for _, data in wire.sent]
    expected = {
        ("/rover/sonar", RANGE): [sonar(2.0), near, nearer],
        ("/rover/odom", ODOMETRY): [wheels],
        ("/rover/cmd_vel", TWIST): sent,
    }
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        found: dict[tuple[str, str], list[bytes]] = {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            found.setdefault((channel.topic, schema.name), []).append(message.data)
    assert {key: found[key] for key in expected} == expected
    with AnyReader([path]) as bag:
        messages: list[tuple[str, Any]] = [
            (connection.topic, bag.deserialize(data, connection.msgtype))
            for connection, _, data in bag.messages()
        ]
    by_topic: dict[str, list[Any]] = {}
    for topic, each in messages:
        by_topic.setdefault(topic, []).append(each)
    assert [each.range for each in by_topic["/rover/sonar"]] == [2.0, 1.0, 0.25]
    assert [each.name for each in by_topic["/rover/understudy/readings"][0].readings] == [
        "sonar_ahead", "x", "heading",
    ]  # fmt: skip
    assert [list(each.path) for each in by_topic["/rover/understudy/states"]][-1] == ["wander", "backward"]
    switched = [(each.level, each.before, each.after) for each in by_topic["/rover/understudy/switched"]]
    assert switched == [(0, "", "wander"), (1, "forward", "backward")]
    assert [each.data for each in by_topic["/rover/understudy/presses"]] == ["backward", ""]


def first_reading(found: Recording) -> Column:
    return next(iter(found.records[0].values.values()))


def test_what_is_read_back_is_what_was_said(tmp_path: Path) -> None:
    drive(tmp_path / "drive.mcap")
    found = read_recording(tmp_path / "drive.mcap")
    assert (found.ticks, found.whole) == (4, True)
    sonar_ahead = found.records[0].values[("sonar_ahead", None)]
    np.testing.assert_array_equal(sonar_ahead[[0, 3]], [2.0, 0.25])
    first = [column[0] for column in found.records[0].values.values()]
    np.testing.assert_array_equal(first[1:], [nan, nan])
    assert [*found.records[0].presses] == [RecordedPress(3, "backward"), RecordedPress(3, None)]
    assert found.records[0].states == (*[("wander", "forward")] * 3, ("wander", "backward"))
    assert (found.head.ran.behavior, found.head.files) == ("wander", {"rover.toml": ROVER})


def test_a_topic_that_two_listen_to_is_kept_once(tmp_path: Path) -> None:
    recorder, wire = RunRecorder(tmp_path / "two.mcap"), Wire()
    taped, heard = RecordingTransport(wire, recorder), list[bytes]()
    with recorder:
        for _ in range(2):
            taped.subscribe("/sonar", RANGE, lambda data, at_s: heard.append(data))
        wire.deliver("/sonar", sonar(1.0), 0.0)
    assert len(heard) == 2
    with (tmp_path / "two.mcap").open("rb") as file:
        assert len(list(make_reader(file).iter_messages())) == 1


@pytest.fixture
def wait_until_written(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """A function that returns once everything is written, or nothing more is."""
    writers: list[writer.RecordingWriter] = []

    def open_writer(path: Path, **options: Any) -> writer.RecordingWriter:
        writers.append(writer.RecordingWriter(path, **options))
        return writers[-1]

    monkeypatch.setattr(recorder_module, "RecordingWriter", open_writer)
    return lambda: wait_until(
        lambda: all(each.problem or (not each._waiting and each._queue.empty()) for each in writers)
    )


def slid(path: Path, ticks: int, each: Callable[[int], object] = lambda tick: None) -> None:
    body = Scripted(2)
    with RunRecorder(path) as recorder:
        recorder.begin(body)
        for tick in range(ticks):
            keys = list_reading_keys(body)
            recorder.write_tick(tick / 10, {key: np.array([tick, -inf]) for key in keys}, [("a",), ()])
            each(tick)


def test_what_was_cut_off_is_read_up_to_its_last_chunk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever a file ends, its ticks are the first of those that were recorded; no chunk that is there is lost."""
    monkeypatch.setattr(writer, "CHUNK_S", 0.0)
    slid(tmp_path / "all.mcap", 20)
    data = (tmp_path / "all.mcap").read_bytes()
    most, cut = 0, tmp_path / "cut.mcap"
    for length in range(0, len(data), 97):
        cut.write_bytes(data[:length])
        if not most:
            with suppress(FileError):
                most = read_recording(cut).ticks
            continue
        found = read_recording(cut)
        assert not found.whole
        assert found.ticks >= most
        most = found.ticks
        assert found.times.tolist() == [tick / 10 for tick in range(most)]
        np.testing.assert_array_equal(first_reading(found), np.arange(most))
    assert most == 20


@pytest.mark.timed
def test_a_killed_run_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from tests.robots import test_recording as t\n"
        "t.writer.CHUNK_S = 0.05\n"
        f"t.slid(Path({str(path)!r}), 31, lambda tick: sys.stdin.read() if tick == 29 else None)\n"
    )

    command = end_with_tests([sys.executable, "-c", program])
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, stdin=subprocess.PIPE, env=env) as running:
        wait_until(lambda: count_ticks(path) == 30)  # all that it recorded, although it does not end
        running.kill()
    found = read_recording(path)
    assert not found.whole
    assert found.ticks == 30


def test_a_tick_is_on_disk_a_second_later(tmp_path: Path) -> None:
    """What a killed run loses is a second at most, by the clock of its chunks."""
    clock, path, body = SimulatedClock(), tmp_path / "run.mcap", Scripted(1)

    with RunRecorder(path, chunks=clock) as recorder:
        recorder.begin(body)
        clock.expect(1)
        for tick in range(25):
            recorder.write_tick(tick, {("load", None): np.array([1.0])}, [("a",)])
            clock.advance(0.1)
            assert count_ticks(path) == (tick + 1) // 10 * 10


def test_a_full_disk_ends_a_run_with_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wait_until_written: Callable[[], None]
) -> None:
    """Not in the thread of some message, but at a tick, where whoever runs the robot stops it."""
    if not Path("/dev/full").exists():
        pytest.skip("needs /dev/full")
    monkeypatch.setattr(writer, "CHUNK_S", 0.0)
    monkeypatch.setattr(writer, "_opened", lambda path: Path("/dev/full").open("wb"))  # noqa: SIM115
    with pytest.raises(
        RecordingFailed, match=r"full\.mcap: recording ended: No space left on device; free space"
    ):
        slid(tmp_path / "full.mcap", 200, lambda tick: wait_until_written())


def test_what_a_full_disk_holds_can_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wait_until_written: Callable[[], None]
) -> None:
    class Small(io.FileIO):
        """A disk with room for 4000 bytes."""

        def write(self, data: Any, /) -> int:
            room = 4000 - self.tell()
            if room <= 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(memoryview(data)[:room])

    monkeypatch.setattr(writer, "CHUNK_S", 0.0)
    monkeypatch.setattr(writer, "_opened", lambda path: io.BufferedWriter(Small(path, "xb"), 64))
    path, ticks = tmp_path / "full.mcap", list[int]()

    def note_tick(tick: int) -> None:
        ticks.append(tick)
        wait_until_written()

    with pytest.raises(RecordingFailed):
        slid(path, 200, note_tick)
    found = read_recording(path)
    assert not found.whole
    assert 2 < found.ticks <= len(ticks)


def test_a_robot_whose_recording_ends_stops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "MOST_WAITING", -1)
    recorder, robot, wire, clock = rover(tmp_path / "drive.mcap")

    def drives() -> None:
        with recorder, robot:
            wire.deliver("/rover/sonar", sonar(1.0), clock())
            robot.arm("a test")
            for _ in range(3):
                percept = robot.sense(list_reading_keys(robot))
                robot.act(FORWARD)
                recorder.write_tick(robot.time_s, percept, [("forward",)])

    with pytest.raises(RecordingFailed):
        drives()
    assert wire.closed
    last = decode_message(TWIST, wire.sent[-1][1])
    assert (last.linear.x, last.angular.z) == (0.0, 0.0)


def test_a_run_that_begins_anew_is_what_counts(tmp_path: Path) -> None:
    body, keys = Scripted(1), [("load", None)]
    with RunRecorder(tmp_path / "two.mcap") as recorder:
        for begun in range(2):
            recorder.begin(body)
            for tick in range(3):
                recorder.write_tick(tick, {key: np.array([10.0 * begun + tick]) for key in keys}, [("a",)])
    found = read_recording(tmp_path / "two.mcap")
    assert first_reading(found).tolist() == [10.0, 11.0, 12.0]


@given(st.data())
def test_damage_is_refused_or_ends_the_recording(data: st.DataObject) -> None:
    """Whatever bytes are damaged, what is read is the beginning of what was recorded, or nothing."""
    damaged = bytearray(_slid())
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.mcap"
        path.write_bytes(damaged)
        try:
            found = read_recording(path)
        except FileError:
            return
    assert found.times.tolist() == [tick / 10 for tick in range(found.ticks)]
    assert (first_reading(found) == np.arange(found.ticks)).all()


@cache
def _slid() -> bytes:
    with TemporaryDirectory() as folder:
        slid(Path(folder) / "all.mcap", 10)
        return (Path(folder) / "all.mcap").read_bytes()


def test_messages_do_not_fail_where_their_recording_did(tmp_path: Path) -> None:
    recorder, robot, wire, clock = rover(tmp_path / "drive.mcap")
    recorder.close()
    wire.deliver("/rover/sonar", sonar(1.0), clock())
    robot.arm("a test")
    robot.act(FORWARD)
    assert wire.sent


def test_a_slow_disk_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "MOST_WAITING", -1)
    with pytest.raises(RecordingFailed, match="the disk is too slow"):
        slid(tmp_path / "slow.mcap", 2)


def test_what_is_there_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    path.write_bytes(b"mine")
    with pytest.raises(FileError, match="is there already; name another file"):
        RunRecorder(path)
    assert path.read_bytes() == b"mine"
    with pytest.raises(FileError, match="cannot be written"):
        RunRecorder(tmp_path / "nowhere" / "drive.mcap")


NONE = [
    (b"", "it is not an MCAP file"),
    (b"not an mcap file at all", "it is not an MCAP file"),
    (None, "there is no such file"),
]


@pytest.mark.parametrize(("content", "problem"), NONE)
def test_what_is_no_recording_is_refused(content: bytes | None, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "none.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match=problem):
        read_recording(path)


def test_a_head_that_is_nested_too_deeply_is_told() -> None:
    head = {"format": FORMAT, BODY: '{"more":' + "[" * 3000 + "]" * 3000 + "}", RUN: "{}"}
    assert "its header cannot be read (it is nested too deeply" in str(decode_header(head))


def test_a_recording_without_decisions_is_refused(tmp_path: Path) -> None:
    with RunRecorder(tmp_path / "bare.mcap") as recorder:
        recorder.open_topic("/sonar", RANGE)(sonar(1.0), 0.0)
    with pytest.raises(FileError, match="it does not say which behavior ran"):
        read_recording(tmp_path / "bare.mcap")
    with RunRecorder(tmp_path / "begun.mcap") as recorder:
        recorder.begin(Scripted(1))
    with pytest.raises(FileError, match="it holds no tick"):
        read_recording(tmp_path / "begun.mcap")
