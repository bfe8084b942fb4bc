"""Coordinate frames (REP 105): where one frame is in another, from the transforms on /tf and /tf_static."""

from __future__ import annotations

from math import inf, isfinite
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
        """List the frames from `frame` up to below `fixed`; empty if no chain of transforms joins them."""
        links: list[str] = []
        while frame != fixed:
            if frame not in self._links or len(links) == DEEPEST:
                return []
            links.append(frame)
            frame = self._links[frame].parent
        return links

    def locate(self, fixed: str, frame: str) -> FramePose | None:
        """Find where `frame` is in `fixed`; None if no chain of transforms joins them."""
        place, turn, at_s = (0.0, 0.0, 0.0), Turn(0.0, 0.0, 0.0, 1.0), inf
        names = self.list_links(fixed, frame)
        for name in names:
            link = self._links[name]
            x, y, z = _rotate(link.turn, place)
            place = (x + link.place[0], y + link.place[1], z + link.place[2])
            turn, at_s = _compose(link.turn, turn), min(at_s, link.at_s)
        heading = compute_heading(turn)
        return FramePose(place[0], place[1], heading, at_s) if names and isfinite(heading) else None


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
    turned = _compose(_compose(turn, Turn(*place, 0.0)), Turn(-turn.x, -turn.y, -turn.z, turn.w))
    return turned.x, turned.y, turned.z
