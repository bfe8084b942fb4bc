"""Coordinate frames (REP 105): where one frame is in another, from the transforms on /tf and /tf_static."""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

from understudy.addons.robots.ros.message_readings import LARGEST, compute_heading
from understudy.records.messages import make_message

TRANSFORMS = "tf2_msgs/msg/TFMessage"
"""The type of messages on /tf and /tf_static."""
MOST_FRAMES = 1024
"""The largest number of frames that are kept, so that made-up names cannot fill the memory."""
DEEPEST = 32
"""The largest number of transforms between two frames."""


class Turn(NamedTuple):
    """A rotation as a unit quaternion."""

    x: float
    y: float
    z: float
    w: float


class Link(NamedTuple):
    """A frame in its parent frame: place (m), rotation, and when this was heard (s; infinite if it never changes)."""

    parent: str
    place: tuple[float, float, float]
    turn: Turn
    at_s: float


class FramePose(NamedTuple):
    """A frame in another one: place in the plane (m), heading (rad), and when the oldest part was heard (s)."""

    x: float
    y: float
    heading: float
    at_s: float


class FrameTree:
    """The latest transforms, each from a frame to its parent."""

    def __init__(self) -> None:
        self._links: dict[str, Link] = {}

    def update(self, message: Any, at_s: float) -> frozenset[str]:
        """Take the transforms of a message that arrived at `at_s` (s; infinite if they never change).

        Transforms that are not finite numbers are ignored.

        Parameters
        ----------
        message
            A message of the type `TRANSFORMS`.
        at_s
            When it arrived.

        Returns
        -------
        frozenset
            The frames whose transforms were taken.
        """
        taken = set()
        for each in message.transforms:
            frame, parent = each.child_frame_id.lstrip("/"), each.header.frame_id.lstrip("/")
            moved, turned = each.transform.translation, each.transform.rotation
            turn = _normalize(turned.x, turned.y, turned.z, turned.w)
            place = (moved.x, moved.y, moved.z)
            if turn is None or not all(abs(value) <= LARGEST for value in place):
                continue
            if frame in self._links or len(self._links) < MOST_FRAMES:
                self._links[frame] = Link(parent, place, turn, at_s)
                taken.add(frame)
        return frozenset(taken)

    def list_links(self, fixed: str, frame: str) -> list[str]:
        """List the frames whose transforms join `frame` and `fixed`, in either direction; empty if none do."""
        return [name for side in self._find_chain(fixed, frame) for name in side]

    def locate(self, fixed: str, frame: str) -> FramePose | None:
        """Find where `frame` is in `fixed`; None if no chain of transforms joins them.

        Transforms are used in both directions: `fixed` may be above `frame`, below it, or both below another frame.
        """
        from_frame, from_fixed = self._find_chain(fixed, frame)
        used = [self._links[name] for name in (*from_frame, *from_fixed)]
        (x, y, z), turn = self._place_above(from_frame)
        origin, turned = self._place_above(from_fixed)
        back = _invert(turned)
        place = _rotate(back, (x - origin[0], y - origin[1], z - origin[2]))
        heading = compute_heading(_compose(back, turn))
        if not used or not isfinite(heading):
            return None
        return FramePose(place[0], place[1], heading, min(link.at_s for link in used))

    def _find_chain(self, fixed: str, frame: str) -> tuple[list[str], list[str]]:
        """Find the frames from `frame`, and those from `fixed`, up to below the first frame above both, if any."""
        above_frame, above_fixed = self._list_above(frame), self._list_above(fixed)
        for down, name in enumerate(above_fixed):  # in a circle, the way up from `frame` counts
            if name in above_frame:
                up = above_frame.index(name)
                return (above_frame[:up], above_fixed[:down]) if up + down <= DEEPEST else ([], [])
        return [], []

    def _list_above(self, frame: str) -> list[str]:
        """List a frame and those above it, as far as each is said to be in another one; a circle is ended."""
        names = [frame]
        while frame in self._links and len(names) <= DEEPEST:
            frame = self._links[frame].parent
            if frame in names:
                break
            names.append(frame)
        return names

    def _place_above(self, names: list[str]) -> tuple[tuple[float, float, float], Turn]:
        """Compute where the first of these frames, each in the next one, is in the parent of the last one."""
        place, turn = (0.0, 0.0, 0.0), Turn(0.0, 0.0, 0.0, 1.0)
        for name in names:
            link = self._links[name]
            x, y, z = _rotate(link.turn, place)
            place = (x + link.place[0], y + link.place[1], z + link.place[2])
            turn = _compose(link.turn, turn)
        return place, turn


def make_transform(header: Any, child: str, *, x: float, y: float, turned: Any) -> Any:
    """Make a message with one transform: of the frame `child` in that of the header."""
    moved = make_message("geometry_msgs/msg/Vector3", x=x, y=y)
    transform = make_message("geometry_msgs/msg/Transform", translation=moved, rotation=turned)
    stamped = make_message(
        "geometry_msgs/msg/TransformStamped", header=header, child_frame_id=child, transform=transform
    )
    return make_message(TRANSFORMS, transforms=[stamped])


def _normalize(x: float, y: float, z: float, w: float) -> Turn | None:
    """Return a unit quaternion, or None if it is far from one, such as all zeros or NaN."""
    norm = x * x + y * y + z * z + w * w
    if not 0.5 < norm < 2.0:
        return None
    root = norm**0.5
    return Turn(x / root, y / root, z / root, w / root)


def _compose(first: Turn, then: Turn) -> Turn:
    """Multiply two quaternions."""
    a, b = first, then
    return Turn(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )


def _rotate(turn: Turn, place: tuple[float, float, float]) -> tuple[float, float, float]:
    """Rotate a point about the origin."""
    turned = _compose(_compose(turn, Turn(*place, 0.0)), _invert(turn))
    return turned.x, turned.y, turned.z


def _invert(turn: Turn) -> Turn:
    """Return the rotation that undoes another one."""
    return Turn(-turn.x, -turn.y, -turn.z, turn.w)
