"""Lay out a graph: boxes on an ellipse, curved arrows between them, and a numbered badge on each arrow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, hypot, pi, sin

CanvasPoint = tuple[float, float]
GAP = 56.0  # least free space between two boxes
BADGE = 11.0  # radius of a badge
BOWS = (0.16, 0.26, 0.08, 0.36, 0.48)  # how far an arrow bows to its left, of its length


@dataclass(frozen=True)
class NodeBox:
    """A box with its center at (x, y)."""

    x: float
    y: float
    width: float
    height: float

    def contains(self, point: CanvasPoint, pad: float = 0.0) -> bool:
        """Return whether a point is inside the box, or less than `pad` outside it."""
        return (
            abs(point[0] - self.x) < self.width / 2 + pad and abs(point[1] - self.y) < self.height / 2 + pad
        )

    def move_by(self, across: float, down: float) -> NodeBox:
        """Return the same box at another place."""
        return replace(self, x=self.x + across, y=self.y + down)

    def is_near(self, other: NodeBox) -> bool:
        """Return whether the space between two boxes is less than GAP."""
        across = abs(self.x - other.x) < (self.width + other.width) / 2 + GAP
        return across and abs(self.y - other.y) < (self.height + other.height) / 2 + GAP


@dataclass(frozen=True)
class EdgeArrow:
    """An arrow as a quadratic Bézier curve from the edge of one box to just before another."""

    begin: CanvasPoint
    control: CanvasPoint
    end: CanvasPoint
    badge: CanvasPoint

    def move_by(self, across: float, down: float) -> EdgeArrow:
        """Return the same arrow at another place."""
        points = (self.begin, self.control, self.end, self.badge)
        return EdgeArrow(*((x + across, y + down) for x, y in points))

    def point_at(self, t: float) -> CanvasPoint:
        """Return the point of the curve at parameter t, from 0 to 1."""
        return _curve(self.begin, self.control, self.end, t)


def _curve(begin: CanvasPoint, control: CanvasPoint, end: CanvasPoint, t: float) -> CanvasPoint:
    one, two, three = (1 - t) ** 2, 2 * t * (1 - t), t * t
    return (
        one * begin[0] + two * control[0] + three * end[0],
        one * begin[1] + two * control[1] + three * end[1],
    )


def place_boxes(sizes: Sequence[tuple[float, float]]) -> list[NodeBox]:
    """Place boxes of these sizes on an ellipse, clockwise from the left, no two near each other."""
    count = len(sizes)
    if count == 1:
        return [NodeBox(0.0, 0.0, *sizes[0])]
    grow = 1.0
    while True:
        across, down = (165.0 + 14.0 * count) * grow, (96.0 + 9.0 * count) * grow
        angles = [pi + 2 * pi * at / count for at in range(count)]
        boxes = [
            NodeBox(across * cos(angle), down * sin(angle), *size)
            for angle, size in zip(angles, sizes, strict=True)
        ]
        if not any(boxes[i].is_near(boxes[j]) for i in range(count) for j in range(i)):
            return boxes
        grow *= 1.06


def place_arrows(boxes: Sequence[NodeBox], pairs: Sequence[tuple[int, int]]) -> list[EdgeArrow]:
    """Place an arrow for each pair of boxes, avoiding other boxes, with badges apart from everything else."""
    curves = [_bowed(boxes, pair) for pair in pairs]
    drawn = [[_curve(*curve, step / 24) for step in range(25)] for curve in curves]
    badges: list[CanvasPoint] = []
    for at, curve in enumerate(curves):
        others = [point for other, points in enumerate(drawn) if other != at for point in points]

        def room(
            t: float,
            curve: tuple[CanvasPoint, CanvasPoint, CanvasPoint] = curve,
            others: list[CanvasPoint] = others,
        ) -> float:
            spot = _curve(*curve, t)
            if any(box.contains(spot, BADGE + 3) for box in boxes):
                return -1.0
            to_badges = min((_apart(spot, badge) - BADGE for badge in badges), default=99.0)
            to_others = min((_apart(spot, point) for point in others), default=99.0)
            return min(to_badges, to_others, 2.2 * BADGE) - abs(t - 0.5)

        best = max((0.5, 0.42, 0.58, 0.34, 0.66, 0.27, 0.73, 0.2, 0.8), key=room)
        badges.append(_curve(*curve, best))
    return [EdgeArrow(*curve, badge) for curve, badge in zip(curves, badges, strict=True)]


def _apart(one: CanvasPoint, other: CanvasPoint) -> float:
    return hypot(one[0] - other[0], one[1] - other[1])


def _bowed(boxes: Sequence[NodeBox], pair: tuple[int, int]) -> tuple[CanvasPoint, CanvasPoint, CanvasPoint]:
    """Return the first curve, among several curvatures, that avoids all other boxes, else the one that meets fewest."""
    begin, end = boxes[pair[0]], boxes[pair[1]]
    across, down = end.x - begin.x, end.y - begin.y
    others = [box for at, box in enumerate(boxes) if at not in pair]
    tried = []
    for bow in BOWS:
        control = ((begin.x + end.x) / 2 + bow * down, (begin.y + end.y) / 2 - bow * across)
        curve = ((begin.x, begin.y), control, (end.x, end.y))
        points = [_curve(*curve, step / 40) for step in range(41)]
        hits = sum(any(box.contains(point, 12.0) for box in others) for point in points)
        tried.append((hits, curve))
    curve = min(tried, key=lambda each: each[0])[1]
    return _trimmed(curve, begin, end)


def _trimmed(
    curve: tuple[CanvasPoint, CanvasPoint, CanvasPoint], begin: NodeBox, end: NodeBox
) -> tuple[CanvasPoint, CanvasPoint, CanvasPoint]:
    """Return the part of a curve between two boxes, with space for the arrow's head."""
    steps = [step / 200 for step in range(201)]
    leaves = max((t for t in steps if begin.contains(_curve(*curve, t), 1.0)), default=0.0)
    arrives = min((t for t in steps if t > leaves and end.contains(_curve(*curve, t), 4.0)), default=1.0)
    start, stop = _curve(*curve, leaves), _curve(*curve, arrives)
    # the control point of a part of a quadratic curve: where the tangents at its ends meet
    one, two, three = curve
    blend = (1 - leaves) * (1 - arrives), leaves * (1 - arrives) + arrives * (1 - leaves), leaves * arrives
    control = tuple(blend[0] * one[k] + blend[1] * two[k] + blend[2] * three[k] for k in range(2))
    return start, (control[0], control[1]), stop
