"""Kernels of a pin-hole camera at a robot's center that looks along x: discs appear as blobs of color.

`project_objects` and `project_segments` project all things into the image, once per robot; `measure_blob` measures
the blob of one color. Inputs and results are records THING and VIEW, in memory of the caller.

Which of two things is in front is decided once for all rays that meet both. That is exact if they do not overlap:
their radical axis separates two discs, and the disc with the smaller power is on the camera's side. The point where
a ray meets a segment is in front of a disc if its squared distance is less than the power.
"""

import math
from typing import Any

from numpy.typing import NDArray

from understudy.jit.decorators import inner

Records = NDArray[Any]


@inner
def project_objects(
    things: Records,
    count: int,
    tan_half: float,
    width_px: float,
    height_px: float,
    limit_m: float,
    views: Records,
) -> int:
    """Write a VIEW for each of the first `count` THING that appears in the image, in order; return their number.

    `tan_half` is the tangent of half the angle of view. A thing whose center is `limit_m` or farther away is no blob.
    Things that could neither be a blob nor hide one, and things that contain the camera, are omitted.
    """
    focal_px = 0.5 * width_px / tan_half
    widening = math.sqrt(1.0 + tan_half * tan_half)
    views_written = 0
    for index in range(count):
        thing = things[index]
        x, y, radius = thing.x, thing.y, thing.radius
        margin = radius * widening
        if abs(y) - tan_half * x >= margin or x <= -radius:
            continue
        squared = x * x + y * y
        power = squared - radius * radius
        reach = limit_m + radius
        if not power > 0.0 or squared >= reach * reach:
            continue
        color = thing.color if squared < limit_m * limit_m else -1
        if color < 0 and thing.opaque <= 0:
            continue
        tangent = math.sqrt(power)
        ahead_left, ahead_right = x * tangent - y * radius, x * tangent + y * radius
        left, right = -tan_half, tan_half
        if ahead_left > 0.0:
            left = max(left, -(y * tangent + x * radius) / ahead_left)
        if ahead_right > 0.0:
            right = min(right, (x * radius - y * tangent) / ahead_right)
        # One of its tangents leads ahead, except by rounding.
        if not left < right or (ahead_left <= 0.0 and ahead_right <= 0.0):
            continue
        view = views[views_written]
        view.left, view.right, view.power, view.squared = left, right, power, squared
        tall = focal_px * thing.height
        view.height_px = tall / x if tall < height_px * x else height_px
        view.color, view.opaque = color, thing.opaque
        views_written += 1
    return views_written


@inner
def project_segments(segments: Records, count: int, tan_half: float, views: Records, end: int) -> int:
    """Write a VIEW for each of the first `count` segments in the image, from index `end` on; return the new end.

    Segments with an end at NaN do not exist, and a segment through the camera hides nothing.
    """
    for index in range(count):
        segment = segments[index]
        x0, y0, x1, y1 = segment.x0, segment.y0, segment.x1, segment.y1
        edge0, edge1 = tan_half * x0, tan_half * x1
        if (y0 >= edge0 and y1 >= edge1) or (y0 <= -edge0 and y1 <= -edge1):
            continue
        across_x, across_y = x1 - x0, y1 - y0
        aside = x0 * across_y - y0 * across_x
        if (x0 <= 0.0 and x1 <= 0.0) or not abs(aside) > 0.0:
            continue
        # Where an end is not ahead, it leaves the frame to the side on which it passes the camera.
        side = math.copysign(math.inf, aside)
        end0 = -y0 / x0 if x0 > 0.0 else side
        end1 = -y1 / x1 if x1 > 0.0 else -side
        left, right = max(-tan_half, min(end0, end1)), min(tan_half, max(end0, end1))
        if not left < right:
            continue
        view = views[end]
        view.left, view.right = left, right
        view.nearness, view.slope = across_y / aside, across_x / aside
        end += 1
    return end


@inner
def insert_cut(views: Records, count: int, left: float, right: float) -> None:
    """Insert the interval [left, right] into the first `count` cuts, which are sorted by their left ends."""
    at = count
    while at > 0 and views[at - 1].cut_left > left:
        views[at].cut_left, views[at].cut_right = views[at - 1].cut_left, views[at - 1].cut_right
        at -= 1
    views[at].cut_left, views[at].cut_right = left, right


@inner
def find_widest_piece(views: Records, discs: int, end: int, index: int) -> tuple[float, float]:
    """Return left and right end of the widest visible piece of a view, the leftmost of equals; 0, 0 if hidden."""
    view = views[index]
    left, right, power = view.left, view.right, view.power
    if view.opaque < 0:
        return left, right
    count = 0
    for other in range(end):
        hider = views[other]
        if hider.left >= right or hider.right <= left:
            continue
        if other < discs:
            hides = hider.opaque > 0 and hider.power < power
        else:
            middle = 0.5 * (max(left, hider.left) + min(right, hider.right))
            inverse = hider.nearness + middle * hider.slope
            hides = 1.0 + middle * middle < power * inverse * inverse
        if hides:
            if hider.left <= left and hider.right >= right:
                return 0.0, 0.0
            insert_cut(views, count, hider.left, hider.right)
            count += 1
    start, best_left, best_right = left, 0.0, 0.0
    for which in range(count):
        hider = views[which]
        if hider.cut_left - start > best_right - best_left:
            best_left, best_right = start, hider.cut_left
        start = max(start, hider.cut_right)
    if right - start > best_right - best_left:
        best_left, best_right = start, right
    return best_left, best_right


@inner
def measure_blob(
    views: Records,
    discs: int,
    end: int,
    color: int,
    tan_half: float,
    width_px: float,
    nearest: bool,
    least_px: float,
) -> tuple[float, float]:
    """Measure the blob of a color: its center (pixels from the image's left edge), its area (pixels); NaN if none.

    `views` are discs up to index `discs`, then segments up to `end`; only their cuts are overwritten. A blob is the
    widest visible piece of a disc, as high as the disc appears, and at least `least_px` large. Of several blobs the
    largest counts, or with `nearest` the one whose center is nearest; of equal ones the leftmost.
    """
    focal_px = 0.5 * width_px / tan_half
    best_x, best_size, best_squared = math.nan, 0.0, math.inf
    for index in range(discs):
        view = views[index]
        if view.color != color:
            continue
        scale = focal_px * view.height_px
        most = (view.right - view.left) * scale
        if most < least_px or (view.squared > best_squared if nearest else most < best_size):
            continue
        left, right = find_widest_piece(views, discs, end, index)
        size = (right - left) * scale
        if size <= 0.0 or size < least_px:
            continue
        x = 0.5 * width_px + focal_px * 0.5 * (left + right)
        if view.squared == best_squared if nearest else size == best_size:
            better = x < best_x
        else:
            better = nearest or size > best_size
        if better:
            best_x, best_size, best_squared = x, size, view.squared
    return best_x, best_size if best_size > 0.0 else math.nan
