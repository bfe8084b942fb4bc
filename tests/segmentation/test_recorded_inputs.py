"""The same messages give the same readings, recorded or from a robot that is connected, whatever its file says."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.mapping_file import load_recording_map
from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot_file import parse_robot
from understudy.records.messages import encode_message, make_message
from understudy.records.record import Record
from understudy.ui.cli.main import make_command_line

pytest.importorskip("mcap")
pytest.importorskip("rosbags")

HEAD = """format = "understudy-robot/1"
name = "rover"
namespace = "rover"
tick_s = 0.1
[limits]
speed_m_s = 1.0
turn_rad_s = 2.0
[commands]
type = "geometry_msgs/msg/{twist}"
drive_m_s = 0.5
turn_rad_s = 2.0
"""
READINGS = {  # name: what a robot file says of it
    "near": 'topic = "range"\ntype = "sensor_msgs/msg/Range"\noffset_m = 0.1',
    "raw": 'topic = "range"\ntype = "sensor_msgs/msg/Range"\nfield = "radiation_type"',
    "front": 'topic = "scan"\ntype = "sensor_msgs/msg/LaserScan"\nsector_deg = [-30, 30]\noffset_m = 0.2',
    "beam": 'topic = "scan"\ntype = "sensor_msgs/msg/LaserScan"\nsector_deg = [90, 90]',
    "toward": 'topic = "scan"\ntype = "sensor_msgs/msg/LaserScan"\nsector_deg = [-90, 90]\nfield = "bearing"',
    "opening": 'topic = "scan"\ntype = "sensor_msgs/msg/LaserScan"\nsector_deg = [0, 360]\nfield = "width"',
    "turned": 'topic = "/odom"\ntype = "nav_msgs/msg/Odometry"\nfield = "pose.pose.orientation"',
    "ahead": 'topic = "/odom"\ntype = "nav_msgs/msg/Odometry"\nfield = "pose.pose.position.x"\nunit = "m"',
    "stamped": 'topic = "/odom"\ntype = "nav_msgs/msg/Odometry"\nfield = "header.stamp"',
    "variance": 'topic = "/odom"\ntype = "nav_msgs/msg/Odometry"\nfield = "pose.covariance.7"',
    "charged": 'topic = "battery"\ntype = "sensor_msgs/msg/BatteryState"\nfield = "percentage"\nunit = "of full"',
    "cell": 'topic = "battery"\ntype = "sensor_msgs/msg/BatteryState"\nfield = "cell_voltage.2"\nunit = "V"',
    "pressed": 'topic = "button"\ntype = "std_msgs/msg/Bool"\nfield = "data"',
}
PLACES = """[targets.home]
at = [1.5, -2.0]
[targets.ball]
topic = "ball"
stale_s = 0.4505
[targets.hand]
topic = "hand"
type = "geometry_msgs/msg/PointStamped"
field = "point"
relative = true
[frames]
stale_s = 0.3505
"""
AHEAD, LEFT = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.7071067811865476, 0.7071067811865476)

values = st.sampled_from([0.0, -0.0, inf, -inf, nan, 1e31, 0.3, 2.0]) | st.floats(0.0625, 9.0, width=32)
turns = st.sampled_from([AHEAD, LEFT, (0.0, 0.0, 0.0, 0.0), (nan, 0.0, 0.0, 1.0)])


def make_point(x: float, y: float) -> Any:
    return make_message("geometry_msgs/msg/Point", x=x, y=y)


def make_range(x: float, y: float, _turn: Any) -> Any:
    return make_message("sensor_msgs/msg/Range", range=x, min_range=0.1, max_range=4.0, radiation_type=1)


def make_scan(x: float, y: float, _turn: Any) -> Any:
    ranges = np.array([y, 1.0, x, 3.0, inf, y, -inf, x], np.float32)
    return make_message(
        "sensor_msgs/msg/LaserScan", angle_increment=np.pi / 4, range_min=0.1, range_max=8.0, ranges=ranges
    )


def make_odometry(x: float, y: float, turn: Sequence[float]) -> Any:
    message = make_message("nav_msgs/msg/Odometry")
    message.pose.pose.position.x, message.pose.covariance[7] = x, y
    message.header.stamp.sec = 5
    for name, value in zip("xyzw", turn, strict=True):
        setattr(message.pose.pose.orientation, name, value)
    return message


def make_battery(x: float, y: float, _turn: Any) -> Any:
    volts = np.array([1.0, 2.0, y][: 2 + int(x > 1.0)], np.float32)  # the cell is not in all messages
    return make_message("sensor_msgs/msg/BatteryState", percentage=x, cell_voltage=volts)


def make_button(x: float, y: float, _turn: Any) -> Any:
    return make_message("std_msgs/msg/Bool", data=bool(x > 1.0))


def make_ball(x: float, y: float, _turn: Any) -> Any:
    message = make_message("geometry_msgs/msg/PoseStamped")
    message.pose.position = make_point(x, y)
    return message


def make_hand(x: float, y: float, _turn: Any) -> Any:
    return make_message("geometry_msgs/msg/PointStamped", point=make_point(x, y))


def make_transforms(x: float, y: float, turn: Sequence[float]) -> Any:
    """One of the two links between map and base_link, so that the pose is as old as the older one."""
    parent, child = ("map", "odom") if y > 1.0 else ("odom", "base_link")
    link = make_message("geometry_msgs/msg/TransformStamped", child_frame_id=child)
    link.header.frame_id = parent
    link.transform.translation.x, link.transform.translation.y = x, y
    for name, value in zip("xyzw", turn, strict=True):
        setattr(link.transform.rotation, name, value)
    return make_message("tf2_msgs/msg/TFMessage", transforms=[link])


Make = Callable[[float, float, Sequence[float]], Any]
TOPICS: Mapping[str, tuple[str, Make]] = {
    "/rover/range": ("sensor_msgs/msg/Range", make_range),
    "/rover/scan": ("sensor_msgs/msg/LaserScan", make_scan),
    "/odom": ("nav_msgs/msg/Odometry", make_odometry),
    "/rover/battery": ("sensor_msgs/msg/BatteryState", make_battery),
    "/rover/button": ("std_msgs/msg/Bool", make_button),
    "/rover/ball": ("geometry_msgs/msg/PoseStamped", make_ball),
    "/rover/hand": ("geometry_msgs/msg/PointStamped", make_hand),
    "/tf": ("tf2_msgs/msg/TFMessage", make_transforms),
}
Message = tuple[int, str, bytes]
"""The time of a message, ms, its topic and its bytes."""


def make_messages(said: Sequence[tuple[int, str, float, float, Any]], twist: str) -> Iterator[Message]:
    """Messages in order of time, among them a command every 100 ms."""
    made = [
        (at, topic, encode_message(TOPICS[topic][0], TOPICS[topic][1](*more))) for at, topic, *more in said
    ]
    for tick in range(20):
        message = make_message(f"geometry_msgs/msg/{twist}")
        moved = message if twist == "Twist" else message.twist
        moved.linear.x, moved.angular.z = 0.25 * (tick % 3), 1.0
        made.append((100 * tick, "/rover/cmd_vel", encode_message(f"geometry_msgs/msg/{twist}", message)))
    yield from sorted(made, key=lambda each: (each[0], each[1] == "/rover/cmd_vel"))


def write_bag(path: Path, messages: Sequence[Message], twist: str) -> Path:
    from mcap.writer import Writer

    types = {topic: type for topic, (type, _) in TOPICS.items()} | {
        "/rover/cmd_vel": f"geometry_msgs/msg/{twist}"
    }
    if any(topic == "/rover/image" for _, topic, _ in messages):
        types["/rover/image"] = "sensor_msgs/msg/Image"
    with path.open("wb") as file:
        writer: Any = Writer(file)
        writer.start()
        channels = {}
        for topic, type in types.items():
            channels[topic] = writer.register_channel(topic, "cdr", writer.register_schema(type, "", b""))
        for at, topic, data in messages:
            writer.add_message(channels[topic], 10**18 + at * 1_000_000, data, 0)
        writer.finish()
    return path


class Wire:
    """A transport that passes on what it is given."""

    def __init__(self) -> None:
        self.received: dict[str, list[Callable[[Any, float], None]]] = {}

    def subscribe(
        self, topic: str, type: str, received: Callable[[Any, float], None], *, kept: bool = False
    ) -> None:
        self.received.setdefault(topic, []).append(received)

    def deliver(self, topic: str, data: bytes, at_s: float) -> None:
        for each in self.received.get(topic, ()):
            each(data, at_s)


def measure(message: Message, messages: Sequence[Message]) -> float:
    """The time of a message, s after the first one."""
    return (message[0] - messages[0][0]) * 1_000_000 * 1e-9


def read_live(
    text: str, messages: Sequence[Message], times: Sequence[float]
) -> tuple[SensorInputs, list[Any]]:
    """What a robot reads at some times, s after the first message."""
    wire, found, next_one = Wire(), [], 0
    inputs = SensorInputs(parse_robot(text), wire)
    for now in times:
        while next_one < len(messages) and measure(messages[next_one], messages) <= now + 1e-9:
            at, topic, data = messages[next_one]
            wire.deliver(topic, data, measure((at, topic, data), messages))
            next_one += 1
        found.append(inputs.values(now))
    return inputs, found


def describe(readings: Sequence[Any]) -> dict[str, tuple[str, str, str]]:
    return {each.name: (str(each.kind), each.unit, each.doc) for each in readings}


said = st.lists(
    st.tuples(st.integers(0, 1900), st.sampled_from(sorted(TOPICS)), values, values, turns), max_size=60
)


@given(
    said=said,
    names=st.lists(st.sampled_from(sorted(READINGS)), unique=True),
    places=st.booleans(),
    stale_s=st.sampled_from([0.0505, 0.2505, 1.0505, 60.0]),
    twist=st.sampled_from(["Twist", "TwistStamped"]),
)
@example(
    said=[(0, "/rover/scan", inf, 0.0, AHEAD)], names=["front"], places=True, stale_s=1.0505, twist="Twist"
)
@example(
    said=[(at, "/tf", 1.0, 2.0 * (at == 200), AHEAD) for at in range(100, 700, 100)],
    names=["near"],
    places=True,
    stale_s=1.0505,
    twist="TwistStamped",
)
@settings(deadline=None, max_examples=60)
def test_recorded_messages_give_the_readings_of_a_robot(
    tmp_path_factory: pytest.TempPathFactory,
    said: list[Any],
    names: list[str],
    places: bool,
    stale_s: float,
    twist: str,
) -> None:
    folder = tmp_path_factory.mktemp("bag")
    text = HEAD.format(twist=twist) + "".join(
        f'[readings.{name}]\n{READINGS[name]}\nstale_s = {stale_s}\ndoc = "What {name} says."\n'
        for name in names
    )
    text += PLACES if places else ""
    (folder / "rover.toml").write_text(text)
    messages = list(make_messages(said, twist))
    drive = read_recorded_drive(
        write_bag(folder / "drive.mcap", messages, twist), load_recording_map(folder / "rover.toml")
    )
    live, expected = read_live(text, messages, drive.times.tolist())
    check_same(drive, live, expected)
    assert drive.commands[:3].tolist() == [[0.0, 0.5], [0.5, 0.5], [1.0, 0.5]]
    assert len(drive.times) == 20


def check_same(drive: Record, live: SensorInputs, expected: Sequence[Mapping[Any, float]]) -> None:
    assert set(drive.values) == set(expected[0])
    for key, column in drive.values.items():
        np.testing.assert_array_equal(column, [each[key] for each in expected], str(key))
    assert describe(drive.readings) == describe(live.readings)
    assert set(drive.targets) == set(live.targets)


CAMERA = """[camera]
topic = "image"
type = "sensor_msgs/msg/Image"
[camera.colors]
ball = { hue_deg = [350, 10], saturation = [0.5, 1], value = [0.5, 1] }
"""


def make_image(left: int) -> bytes:
    """A black image with a red square; none where `left` is negative."""
    pixels = np.zeros((48, 64, 3), np.uint8)
    if left >= 0:
        pixels[20:30, left : left + 10, 0] = 255
    return encode_message(
        "sensor_msgs/msg/Image",
        make_message(
            "sensor_msgs/msg/Image", height=48, width=64, step=192, encoding="rgb8", data=pixels.ravel()
        ),
    )


def test_recorded_images_give_the_colors_that_a_robot_sees(tmp_path: Path) -> None:
    pytest.importorskip("cv2")
    text = HEAD.format(twist="Twist") + CAMERA
    (tmp_path / "rover.toml").write_text(text)
    images = [(150 * at, "/rover/image", make_image(left)) for at, left in enumerate([0, 27, 54, -1, 10])]
    messages = sorted([*make_messages([], "Twist"), *images])
    bag = write_bag(tmp_path / "drive.mcap", messages, "Twist")
    drive = read_recorded_drive(bag, load_recording_map(tmp_path / "rover.toml"))
    check_same(drive, *read_live(text, messages, drive.times.tolist()))
    assert np.isfinite(drive.values["blob_x", "ball"]).sum() == 11


def test_what_was_not_recorded_is_left_out(tmp_path: Path) -> None:
    reading = f"[readings.near]\n{READINGS['near'].replace('range', 'sonar', 1)}\n"
    (tmp_path / "rover.toml").write_text(HEAD.format(twist="Twist") + reading + PLACES + CAMERA)
    messages = list(make_messages([], "Twist"))
    bag = write_bag(tmp_path / "drive.mcap", messages, "Twist")
    drive = read_recorded_drive(bag, load_recording_map(tmp_path / "rover.toml"))
    for name, of in (("/rover/sonar", "reading 'near'"), ("/rover/image", "the camera")):
        assert any(f"topic {name!r}: there is no message of it for {of}" in each for each in drive.omissions)
    assert ("near", None) not in drive.values
    assert np.isnan(drive.values["range", "home"]).all()


WRONG_KEYS: list[tuple[str, str]] = [  # a mapping's table, what is said
    ('[targets.home]\ntopic = "/scan"\nfield = "nope"\n', "map.toml at targets.home.field: is 'nope', which"),
    (
        '[targets.home]\ntopic = "/scan"\ntype = "our_msgs/msg/Foo"\n',
        "map.toml at targets.home.type: is 'our_msgs",
    ),
    (
        '[targets.home]\ntopic = "/scan"\ntype = "std_msgs/msg/Bool"\n',
        "map.toml at targets.home.field: is 'pose",
    ),
]


@pytest.mark.parametrize(("table", "said"), WRONG_KEYS)
@pytest.mark.parametrize("command", [("learn", "drive"), ("replay",)])
def test_what_is_wrong_in_the_mapping_file_names_it(
    tmp_path: Path, table: str, said: str, command: tuple[str, ...]
) -> None:
    bag = write_bag(tmp_path / "drive.mcap", list(make_messages([], "Twist")), "Twist")
    mapping = tmp_path / "map.toml"
    mapping.write_text(
        'format = "understudy-recording-map/1"\ntime = "time_s"\n'
        '[[commands]]\ncolumn = "/rover/cmd_vel.linear.x"\nchannel = "drive"\n' + table
    )
    done = CliRunner().invoke(make_command_line(), [*command, str(bag), "--map", str(mapping)])
    assert done.exit_code == 2
    assert said in " ".join(done.output.split()), done.output
    assert "drive.mcap" not in done.output
