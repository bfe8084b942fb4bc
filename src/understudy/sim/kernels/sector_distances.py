"""Kernels of sonar: the distance in a sector to a disc, a segment, or the outer walls of the arena.

All places are in the robot frame (m; x forward, y left, origin at the robot's center). A sector is given by the
fields of a SECTOR. Each kernel takes the least distance found so far, `best`, and returns the smaller one.

Within a cone of rays the distance to a convex thing is least towards its nearest point and grows to both sides. If
that point is outside the sector, the nearest visible point is on one of the sector's edges.
"""

import math

from understudy.jit.decorators import inner
from understudy.sim.sensing.sectors import BEAM, FULL, NARROW


@inner
def contains_point(
    x: float, y: float, from_x: float, from_y: float, to_x: float, to_y: float, span: int
) -> bool:
    """Return whether a point lies in a sector, edges included; the sector must not be a beam.

    The vectors along the sector's edges may have any length.
    """
    if span == FULL:
        return True
    after = from_x * y - from_y * x >= 0.0
    before = x * to_y - y * to_x >= 0.0
    return (after and before) if span == NARROW else (after or before)


@inner
def cast_ray_to_disc(ray_x: float, ray_y: float, x: float, y: float, radius: float, best: float) -> float:
    """Return the smaller of `best` and the distance (m) along a ray, a unit vector, to a disc around another point."""
    along = ray_x * x + ray_y * y
    aside = ray_x * y - ray_y * x
    half_squared = radius * radius - aside * aside
    if along > 0.0 and half_squared >= 0.0:
        return min(best, along - math.sqrt(half_squared))
    return best


@inner
def cast_ray_to_segment(
    ray_x: float, ray_y: float, x0: float, y0: float, x1: float, y1: float, best: float
) -> float:
    """Return the smaller of `best` and the distance (m) along a ray, a unit vector, to a segment, ends included."""
    side0 = ray_x * y0 - ray_y * x0
    side1 = ray_x * y1 - ray_y * x1
    if (side0 > 0.0 and side1 > 0.0) or (side0 < 0.0 and side1 < 0.0):
        return best
    if side0 == side1:  # it lies along the ray's line
        along0, along1 = ray_x * x0 + ray_y * y0, ray_x * x1 + ray_y * y1
        return min(best, max(0.0, min(along0, along1))) if max(along0, along1) >= 0.0 else best
    distance = (x0 * y1 - y0 * x1) / (side1 - side0)
    return distance if 0.0 <= distance < best else best


@inner
def measure_sector_to_disc(
    x: float,
    y: float,
    radius: float,
    from_x: float,
    from_y: float,
    to_x: float,
    to_y: float,
    span: int,
    best: float,
) -> float:
    """Return the smaller of `best` and the distance (m) to the part of a disc in a sector.

    0 if the disc contains the origin.
    """
    squared = x * x + y * y
    reach = best + radius
    if not squared < reach * reach:  # too far, or NaN
        return best
    if squared <= radius * radius:
        return 0.0
    if span == BEAM:
        return cast_ray_to_disc(from_x, from_y, x, y, radius, best)
    if contains_point(x, y, from_x, from_y, to_x, to_y, span):
        return min(best, math.sqrt(squared) - radius)
    best = cast_ray_to_disc(from_x, from_y, x, y, radius, best)
    return cast_ray_to_disc(to_x, to_y, x, y, radius, best)


@inner
def measure_sector_to_segment(
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    from_x: float,
    from_y: float,
    to_x: float,
    to_y: float,
    span: int,
    best: float,
) -> float:
    """Return the smaller of `best` and the distance (m) to the part of a segment in a sector.

    `best` if an end of the segment is NaN.
    """
    across_x, across_y = x1 - x0, y1 - y0
    length_squared = across_x * across_x + across_y * across_y
    aside = x0 * across_y - y0 * across_x
    # Its line is too far off: most are, and this is cheap to foresee.
    if not aside * aside < best * best * length_squared and length_squared > 0.0:
        return best
    if span == BEAM:
        return cast_ray_to_segment(from_x, from_y, x0, y0, x1, y1, best)
    along = -(x0 * across_x + y0 * across_y)
    # The direction of its nearest point, and that point's distance squared times `scale`.
    if along <= 0.0:
        x, y, scale = x0, y0, 1.0
        squared = x0 * x0 + y0 * y0
    elif along >= length_squared:
        x, y, scale = x1, y1, 1.0
        squared = x1 * x1 + y1 * y1
    else:
        x, y, scale = aside * across_y, -aside * across_x, length_squared
        squared = aside * aside
    if not squared < best * best * scale:
        return best
    if contains_point(x, y, from_x, from_y, to_x, to_y, span):
        return min(best, math.sqrt(squared / scale))
    best = cast_ray_to_segment(from_x, from_y, x0, y0, x1, y1, best)
    return cast_ray_to_segment(to_x, to_y, x0, y0, x1, y1, best)


@inner
def cast_ray_to_bounds(
    ray_x: float, ray_y: float, left: float, right: float, below: float, above: float, best: float
) -> float:
    """Return the smaller of `best` and the distance (m) along a ray to one of four walls around its origin.

    `left`, `right`, `below` and `above` are the distances to the walls; the ray is a unit vector in the world frame.
    """
    gap, slope = (right, ray_x) if ray_x > 0.0 else (left, -ray_x)
    if gap < best * slope:
        best = gap / slope
    gap, slope = (above, ray_y) if ray_y > 0.0 else (below, -ray_y)
    if gap < best * slope:
        best = gap / slope
    return best


@inner
def measure_sector_to_bounds(
    x: float,
    y: float,
    cosine: float,
    sine: float,
    width: float,
    height: float,
    from_x: float,
    from_y: float,
    to_x: float,
    to_y: float,
    span: int,
    best: float,
) -> float:
    """Return the smaller of `best` and the distance (m) in a sector to the walls around [0, width] x [0, height].

    (`x`, `y`), and `cosine` and `sine` of the heading, are the robot's pose in the world. For a robot outside, the
    walls that it has passed are at distance 0 in the directions that lead farther out.
    """
    left, right, below, above = max(0.0, x), max(0.0, width - x), max(0.0, y), max(0.0, height - y)
    if min(min(left, right), min(below, above)) >= best:
        return best
    if span != BEAM:
        if right < best and contains_point(cosine, -sine, from_x, from_y, to_x, to_y, span):
            best = right
        if left < best and contains_point(-cosine, sine, from_x, from_y, to_x, to_y, span):
            best = left
        if above < best and contains_point(sine, cosine, from_x, from_y, to_x, to_y, span):
            best = above
        if below < best and contains_point(-sine, -cosine, from_x, from_y, to_x, to_y, span):
            best = below
        if span == FULL:
            return best
        ray_x, ray_y = cosine * to_x - sine * to_y, sine * to_x + cosine * to_y
        best = cast_ray_to_bounds(ray_x, ray_y, left, right, below, above, best)
    ray_x, ray_y = cosine * from_x - sine * from_y, sine * from_x + cosine * from_y
    return cast_ray_to_bounds(ray_x, ray_y, left, right, below, above, best)
