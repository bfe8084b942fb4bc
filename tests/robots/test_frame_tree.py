"""Poses out of /tf and /tf_static: chains of frames by hand, their age, and real messages over both transports."""

from __future__ import annotations

from math import atan2, cos, inf, nan, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ROVER, Wire

from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.ros.frame_tree import TRANSFORMS, FrameTree
from understudy.errors import FileError
from understudy.records.messages import encode_message, make_message

FRAMES = '[frames]\nfixed = "map"\nrobot = "base_link"\nstale_s = 0.5\nrequired = true\n'
WITHOUT = ROVER.replace("[readings.x]", "[readings.odom_x]").replace(
    "[readings.heading]", "[readings.odom_heading]"
)
ROBOT = parse_robot(WITHOUT.replace("[commands]", f"{FRAMES}[commands]"))
LEFT = (0.0, 0.0, sqrt(0.5), sqrt(0.5))
"""A quarter of a turn to the left."""
AHEAD = (0.0, 0.0, 0.0, 1.0)


def transform(parent: str, child: str, x: float, y: float, turn: tuple[float, ...] = AHEAD) -> Any:
    """One transform, between frames of these names."""
    return make_message(
        "geometry_msgs/msg/TransformStamped",
        header=make_message("std_msgs/msg/Header", frame_id=parent),
        child_frame_id=child,
        transform=make_message(
            "geometry_msgs/msg/Transform",
            translation=make_message("geometry_msgs/msg/Vector3", x=x, y=y),
            rotation=make_message("geometry_msgs/msg/Quaternion", **dict(zip("xyzw", turn, strict=True))),
        ),
    )


def transforms(*each: Any) -> Any:
    return make_message(TRANSFORMS, transforms=list(each))


def encode(*each: Any) -> bytes:
    return encode_message(TRANSFORMS, transforms(*each))


CHAINS = [  # transforms, and the pose of base_link in map
    ([("map", "base_link", 1.0, 2.0, AHEAD)], (1.0, 2.0, 0.0)),
    ([("map", "odom", 1.0, 2.0, AHEAD), ("odom", "base_link", 3.0, 0.0, AHEAD)], (4.0, 2.0, 0.0)),
    ([("map", "odom", 1.0, 2.0, LEFT), ("odom", "base_link", 3.0, 0.0, AHEAD)], (1.0, 5.0, pi / 2)),
    ([("map", "odom", 0.0, 0.0, LEFT), ("odom", "base_link", 1.0, 0.0, LEFT)], (0.0, 1.0, pi)),
    ([("/map", "/base_link", 1.0, 2.0, AHEAD)], (1.0, 2.0, 0.0)),  # as ROS 1 wrote them
    ([("odom", "base_link", 1.0, 2.0, AHEAD)], None),  # nobody says where odom is in map
    ([("map", "odom", 1.0, 2.0, AHEAD), ("odom", "map", 1.0, 2.0, AHEAD)], None),
    ([("base_link", "base_link", 1.0, 2.0, AHEAD)], None),  # a circle
    ([("base_link", "map", -2.0, 0.0, AHEAD)], (2.0, 0.0, 0.0)),  # odometry with the robot as the parent
    ([("base_link", "map", -2.0, 0.0, LEFT)], (0.0, -2.0, 3 * pi / 2)),
    ([("base_link", "odom", 1.0, 0.0, AHEAD), ("odom", "map", 0.0, 2.0, AHEAD)], (-1.0, -2.0, 0.0)),
    ([("world", "map", 0.0, 0.0, AHEAD), ("world", "base_link", 3.0, 0.0, AHEAD)], (3.0, 0.0, 0.0)),
    ([("world", "map", 1.0, 0.0, LEFT), ("world", "base_link", 1.0, 2.0, AHEAD)], (2.0, 0.0, 3 * pi / 2)),
    ([("map", "base_link", 1.0, 2.0, AHEAD), ("base_link", "map", 5.0, 5.0, AHEAD)], (1.0, 2.0, 0.0)),  # both
    ([("earth", "map", 1.0, 2.0, AHEAD), ("base_link", "laser", 3.0, 0.0, AHEAD)], None),  # two trees
    ([("map", "base_link", nan, 2.0, AHEAD)], None),
    ([("map", "base_link", 1.0, 2.0, (0.0, 0.0, 0.0, 0.0))], None),
]


@pytest.mark.parametrize(("links", "pose"), CHAINS)
def test_a_pose_is_what_the_chain_of_frames_says(links: list[Any], pose: tuple[float, ...] | None) -> None:
    tree = FrameTree()
    tree.update(transforms(*(transform(*link) for link in links)), 7.0)
    found = tree.locate("map", "base_link")
    assert found == (None if pose is None else pytest.approx((*pose, 7.0)))


numbers = st.floats(-9.0, 9.0)
turns = st.tuples(numbers, numbers, numbers, numbers).filter(
    lambda turn: sum(part * part for part in turn) > 0.1
)


def compute_matrix(place: tuple[float, ...], turn: tuple[float, ...]) -> NDArray[np.float64]:
    """Compute the homogeneous matrix [4, 4] of a frame in its parent."""
    x, y, z, w = np.array(turn) / np.linalg.norm(turn)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += 2 * w * cross + 2 * cross @ cross  # Rodrigues' formula
    matrix[:3, 3] = place
    return matrix


@given(
    parents=st.lists(st.integers(0, 9), min_size=1, max_size=9),
    data=st.data(),
)
def test_poses_in_random_trees_are_those_of_homogeneous_matrices(
    parents: list[int], data: st.DataObject
) -> None:
    """Frame n + 1 is in one of the frames 0 to n. The age is that of the oldest transform on the way between two."""
    tree, in_root, age, above = FrameTree(), {0: np.eye(4)}, {0: inf}, {0: [0]}
    for child, number in enumerate(parents, 1):
        parent = number % child
        place, turn = data.draw(st.tuples(numbers, numbers, numbers)), data.draw(turns)
        age[child] = data.draw(st.sampled_from([1.0, 2.0, 3.0, inf]))
        unit = np.array(turn) / np.linalg.norm(turn)
        message = transform(f"f{parent}", f"f{child}", *place[:2], tuple(unit.tolist()))
        message.transform.translation.z = place[2]
        tree.update(transforms(message), age[child])
        in_root[child] = in_root[parent] @ compute_matrix(place, turn)
        above[child] = [child, *above[parent]]
    fixed, frame = (data.draw(st.sampled_from(sorted(in_root))) for _ in range(2))
    found = tree.locate(f"f{fixed}", f"f{frame}")
    if fixed == frame:
        assert found is None
        return
    expected = np.linalg.inv(in_root[fixed]) @ in_root[frame]
    assert found is not None
    assert found[:2] == pytest.approx(expected[:2, 3], abs=1e-6)
    ahead = expected[:2, 0]
    assume(np.linalg.norm(ahead) > 1e-3)  # it looks straight up or down: no heading
    assert cos(found.heading - atan2(ahead[1], ahead[0])) == pytest.approx(1.0, abs=1e-6)
    assert found.at_s == min(age[name] for name in {*above[fixed]} ^ {*above[frame]})


def test_a_pose_from_inverted_and_static_transforms_is_as_old_as_the_odometry() -> None:
    wire = Wire()
    senses = SensorInputs(ROBOT, wire)
    wire.deliver("/tf_static", encode(transform("world", "map", 1.0, 0.0)), 0.0)
    wire.deliver("/tf", encode(transform("base_link", "odom", -2.0, 0.0)), 10.0)
    assert senses.value("x", 10.1) != senses.value("x", 10.1)  # absent: nobody says where odom is
    wire.deliver("/tf_static", encode(transform("odom", "world", -4.0, 0.0)), 10.4)
    wire.deliver("/tf", encode(transform("base_link", "odom", -2.5, 0.0)), 10.5)
    assert senses.value("x", 10.9) == 5.5
    assert senses.value("x", 11.1) != senses.value("x", 11.1)


def test_made_up_frames_do_not_fill_the_memory() -> None:
    tree = FrameTree()
    tree.update(transforms(*(transform("map", f"frame_{number}", 0.0, 0.0) for number in range(3000))), 0.0)
    assert len(tree.update(transforms(transform("map", "frame_1", 0.0, 0.0)), 0.0)) == 1
    assert tree.update(transforms(transform("map", "frame_2000", 0.0, 0.0)), 0.0) == frozenset()


def test_a_pose_is_as_old_as_its_oldest_transform() -> None:
    """Wheels and cameras are on /tf, too: their messages do not make the pose any newer."""
    wire = Wire()
    senses = SensorInputs(ROBOT, wire)
    wire.deliver("/tf_static", encode(transform("base_footprint", "base_link", 0.5, 0.0)), 0.0)
    wire.deliver("/tf", encode(transform("map", "odom", 1.0, 0.0)), 10.0)
    wire.deliver("/tf", encode(transform("odom", "base_footprint", 2.0, 0.0)), 10.2)
    assert senses.value("x", 10.4) == 3.5
    wire.deliver("/tf", encode(transform("odom", "base_footprint", 2.5, 0.0)), 10.6)
    wire.deliver("/tf", encode(transform("base_link", "wheel", 0.0, 1.0)), 10.6)
    assert senses.value("x", 10.6) != senses.value("x", 10.6)  # absent: the map's transform is 0.6 s old
    wire.deliver("/tf", encode(transform("map", "odom", 1.0, 0.0)), 10.7)
    assert senses.value("x", 10.8) == 4.0
    wire.deliver("/tf", b"\x00\x01\x00\x00 nonsense", 10.8)
    assert senses.latest["frames"].refused == 1


WRONG = [  # what the file says, what the error says
    ('[frames]\nrobot = ""\n', "at frames.robot: is empty"),
    ('[frames]\nfixed = "base_link"\n', "at frames.robot: is the same frame as fixed"),
    ("[frames]\nstale_s = 0\n", "at frames.stale_s: is 0"),
    ('[frames]\nstatic = "tf static"\n', "at frames.static: is 'tf static'"),
    ("[frames]\nchild = 1\n", "at frames.child"),
]


@pytest.mark.parametrize(("frames", "says"), WRONG)
def test_frames_that_are_refused(frames: str, says: str) -> None:
    with pytest.raises(FileError) as caught:
        parse_robot(WITHOUT.replace("[commands]", f"{frames}[commands]"))
    assert says in str(caught.value)


def test_a_pose_that_is_given_twice_is_refused() -> None:
    with pytest.raises(FileError, match=r"at readings.x: is what frames give, too"):
        parse_robot(ROVER.replace("[commands]", f"{FRAMES}[commands]"))
