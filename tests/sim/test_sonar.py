"""Sonar: distances in a sector, by closed forms and against many rays, each intersected on its own."""

from math import cos, hypot, inf, nan, radians, sin, sqrt, tau
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from understudy.sim.kernels.sector_distances import (
    measure_sector_to_bounds,
    measure_sector_to_disc,
    measure_sector_to_segment,
)
from understudy.sim.sensing.sectors import BEAM, FULL, NARROW, WIDE, make_sector

Floats: TypeAlias = NDArray[np.float64]
Disc: TypeAlias = tuple[float, float, float]
Segment: TypeAlias = tuple[float, float, float, float]
Degrees: TypeAlias = tuple[float, float]
Fields: TypeAlias = tuple[float, float, float, float, int]

FAR = 9.0


def prepare(degrees: Degrees) -> Fields:
    row = make_sector(radians(degrees[0]), radians(degrees[1]))
    return row["from_x"], row["from_y"], row["to_x"], row["to_y"], int(row["span"])


def to_disc(disc: Disc, degrees: Degrees, best: float = FAR) -> float:
    return float(measure_sector_to_disc(*(*disc, *prepare(degrees), best)))


def to_segment(segment: Segment, degrees: Degrees, best: float = FAR) -> float:
    return float(measure_sector_to_segment(*(*segment, *prepare(degrees), best)))


def to_bounds(pose: Disc, degrees: Degrees, best: float = FAR) -> float:
    """In an arena of 10 x 6; a pose is x, y and heading in degrees."""
    x, y, heading = pose[0], pose[1], radians(pose[2])
    placed = x, y, cos(heading), sin(heading), 10.0, 6.0
    return float(measure_sector_to_bounds(*(*placed, *prepare(degrees), best)))


SPANS = [
    ((0.0, 0.0), BEAM),
    ((180.0, -180.0), BEAM),
    ((-15.0, 15.0), NARROW),
    ((170.0, -170.0), NARROW),  # counter-clockwise through 180
    ((-90.0, 90.0), WIDE),
    ((10.0, -10.0), WIDE),  # all but 20 degrees
    ((-180.0, 180.0), FULL),
    ((10.0, 370.0), FULL),
    ((0.0, 400.0), FULL),
]


@pytest.mark.parametrize(("degrees", "span"), SPANS)
def test_sector(degrees: Degrees, span: int) -> None:
    row = make_sector(radians(degrees[0]), radians(degrees[1]))
    assert row["span"] == span
    edges = [row["from_x"], row["from_y"], row["to_x"], row["to_y"]]
    assert edges == pytest.approx([turn(radians(angle)) for angle in degrees for turn in (cos, sin)])


DISCS = [  # x, y, radius; from, to; distance
    ((3.0, 0.0, 1.0), (0, 0), 2.0),  # dead ahead
    ((3.0, 0.6, 1.0), (0, 0), 2.2),  # 3 - 0.8, as 0.6, 0.8, 1 is a right triangle
    ((3.0, 1.0, 1.0), (0, 0), 3.0),  # tangent
    ((3.0, 1.001, 1.0), (0, 0), FAR),  # just past it
    ((-3.0, 0.0, 1.0), (0, 0), FAR),  # behind
    ((0.0, 3.0, 1.0), (90, 90), 2.0),
    ((12.0, 0.0, 1.0), (0, 0), FAR),  # farther than the best so far
    ((0.5, 0.5, 1.0), (180, 180), 0.0),  # around the origin, whatever the direction
    ((0.5, 0.5, 1.0), (180, 190), 0.0),
    ((3.0, 0.0, 1.0), (-10, 10), 2.0),  # nearest point inside
    ((3.0, 0.6, 1.0), (-20, 0), 2.2),  # nearest point on the edges, from and to
    ((3.0, -0.6, 1.0), (0, 20), 2.2),
    ((3.0, 1.001, 1.0), (-20, 0), FAR),
    ((3.0, 0.0, 1.0), (-120, 120), 2.0),  # wide
    ((-3.0, 0.6, 1.0), (-180, 150), 2.2),  # wide, what is missing is between 150 and 180
    ((-3.0, 1.0, 0.3), (-170, 150), FAR),  # in the gap
    ((0.0, -3.0, 1.0), (0, 360), 2.0),
]


@pytest.mark.parametrize(("disc", "degrees", "distance"), DISCS)
def test_disc(disc: Disc, degrees: Degrees, distance: float) -> None:
    assert to_disc(disc, degrees) == pytest.approx(distance)


ROOT = sqrt(2.0)
SEGMENTS = [  # ends; from, to; distance
    ((2.0, -1.0, 2.0, 1.0), (0, 0), 2.0),  # across
    ((2.0, 1.0, 2.0, -1.0), (0, 0), 2.0),
    ((2.0, 0.0, 2.0, 1.0), (0, 0), 2.0),  # its end on the beam
    ((2.0, 0.001, 2.0, 1.0), (0, 0), FAR),
    ((-2.0, -1.0, -2.0, 1.0), (0, 0), FAR),  # behind
    ((1.0, 0.5, 3.0, 0.5), (0, 0), FAR),  # parallel
    ((3.0, 0.0, 2.0, 0.0), (0, 0), 2.0),  # along the beam
    ((-3.0, 0.0, 2.0, 0.0), (0, 0), 0.0),  # from behind through the origin
    ((-3.0, 0.0, -2.0, 0.0), (0, 0), FAR),
    ((2.0, -2.0, 2.0, 2.0), (45, 45), 2.0 * ROOT),
    ((2.0, -9.0, 2.0, 9.0), (-30, 30), 2.0),  # nearest point inside
    ((2.0, -9.0, 2.0, 9.0), (45, 60), 2.0 * ROOT),  # on an edge
    ((2.0, -9.0, 2.0, 9.0), (-60, -45), 2.0 * ROOT),
    ((3.0, 0.0, 5.0, 9.0), (-10, 10), 3.0),  # its end inside
    ((5.0, 9.0, 3.0, 0.0), (-10, 10), 3.0),
    ((3.0, 4.0, 3.0, 4.0), (0, 90), 5.0),  # a point
    ((2.0, -9.0, 2.0, 9.0), (100, -100), FAR),
    ((2.0, -9.0, 2.0, 9.0), (45, -45), 2.0 * ROOT),  # wide, and all that is ahead is missing
    ((2.0, -1.0, 2.0, 1.0), (45, -45), FAR),
    ((0.0, -3.0, 1.0, -3.0), (0, 360), 3.0),
    ((nan, 0.0, nan, 0.0), (0, 0), FAR),  # none
    ((nan, nan, nan, nan), (0, 360), FAR),
    ((nan, nan, nan, nan), (-10, 10), FAR),
]


@pytest.mark.parametrize(("segment", "degrees", "distance"), SEGMENTS)
def test_segment(segment: Segment, degrees: Degrees, distance: float) -> None:
    assert to_segment(segment, degrees) == pytest.approx(distance)


BOUNDS = [  # pose (heading in degrees) in an arena of 10 x 6; from, to; distance
    ((3.0, 2.0, 0.0), (0, 0), 7.0),
    ((3.0, 2.0, 90.0), (0, 0), 4.0),
    ((3.0, 2.0, 0.0), (-90, -90), 2.0),
    ((3.0, 2.0, 180.0), (0, 0), 3.0),
    ((3.0, 2.0, 180.0), (-45, -45), 3.0 * ROOT),  # to the left and up
    ((3.0, 2.0, 45.0), (-10, 10), 4.0 / sin(radians(55.0))),  # the wall above, seen from the far edge
    ((3.0, 2.0, 0.0), (-100, 10), 2.0),
    ((3.0, 2.0, 0.0), (-30, 200), 3.0),  # wide: of the wall below only what is 4 away
    ((3.0, 2.0, 77.0), (0, 360), 2.0),
    ((3.0, -0.1, 0.0), (-90, -90), 0.0),  # outside
    ((3.0, 2.0, 0.0), (0, 1), 7.0),
]


@pytest.mark.parametrize(("pose", "degrees", "distance"), BOUNDS)
def test_bounds(pose: Disc, degrees: Degrees, distance: float) -> None:
    assert to_bounds(pose, degrees) == pytest.approx(distance)


# --- Against many rays ---

STEP = tau / 3600
NUDGE = 1e-7  # by how much a thing is larger, or smaller, so that what is just touched does not matter
EXACT = 1e-6

coordinates = st.floats(-5.0, 5.0, allow_subnormal=False)
angles = st.floats(-180.0, 180.0, allow_subnormal=False)
widths = st.sampled_from([0.0, 30.0, 90.0, 180.0, 270.0, 360.0]) | st.floats(0.1, 359.9)
bests = st.sampled_from([inf, 3.0, 0.5])
sectors = st.builds(lambda start, width: (start, start + width), angles, widths)


def rays(degrees: Degrees) -> Floats:
    """Directions (rad) from edge to edge, at most a step apart."""
    start, end = radians(degrees[0]), radians(degrees[1])
    return np.linspace(start, end, 2 + int((end - start) / STEP))


def rays_to_disc(disc: Disc, angles: Floats) -> float:
    """By the quadratic equation of each ray."""
    x, y, radius = disc
    if hypot(x, y) <= radius:
        return 0.0
    middle = np.cos(angles) * x + np.sin(angles) * y
    under = middle**2 - (x**2 + y**2 - radius**2)
    hits = (under >= 0.0) & (middle > 0.0)
    return float(np.min(middle[hits] - np.sqrt(under[hits]), initial=inf))


def rays_to_segment(segment: Segment, angles: Floats, slack: float) -> float:
    """By two linear equations for each ray; ends are `slack` farther out, as a share of the length."""
    x0, y0, x1, y1 = segment
    result = inf
    for angle in angles:
        matrix = np.array([[cos(angle), x0 - x1], [sin(angle), y0 - y1]])
        if abs(matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]) < 1e-12:
            continue
        distance, share = np.linalg.solve(matrix, np.array([x0, y0]))
        if distance >= -slack and -slack <= share <= 1.0 + slack:
            result = min(result, distance)
    return result


def rays_to_bounds(pose: Disc, angles: Floats) -> float:
    x, y, heading = pose
    along_x, along_y = np.cos(angles + radians(heading)), np.sin(angles + radians(heading))
    with np.errstate(divide="ignore", over="ignore"):
        across = np.where(along_x > 0.0, 10.0 - x, -x) / along_x
        upward = np.where(along_y > 0.0, 6.0 - y, -y) / along_y
    return float(min(np.min(np.abs(across)), np.min(np.abs(upward))))


@given(coordinates, coordinates, st.floats(0.1, 2.0), sectors, bests)
@settings(max_examples=300)
def test_disc_as_by_rays(x: float, y: float, radius: float, degrees: Degrees, best: float) -> None:
    """The nearest ray is within a step of the nearest point, and d² step² / r farther at most (from cos and sqrt)."""
    found = to_disc((x, y, radius), degrees, best)
    between = (x * x + y * y) * STEP**2 / radius
    assert found <= min(best, rays_to_disc((x, y, radius - NUDGE), rays(degrees))) + EXACT
    assert found >= min(best, rays_to_disc((x, y, radius + NUDGE), rays(degrees))) - EXACT - between


def crosses_squarely(segment: Segment, angle: float) -> bool:
    x, y = segment[2] - segment[0], segment[3] - segment[1]
    return abs(cos(angle) * y - sin(angle) * x) > 0.01 * hypot(x, y)


@given(st.tuples(coordinates, coordinates, coordinates, coordinates), sectors, bests)
@settings(max_examples=60)
def test_segment_as_by_rays(segment: Segment, degrees: Degrees, best: float) -> None:
    """Rays towards the ends, too; in between the distance grows by d step² at most."""
    x0, y0, x1, y1 = segment
    edges = [radians(angle) for angle in degrees]
    ends = edges[0] + (np.arctan2([y0, y1], [x0, x1]) - edges[0]) % tau
    if hypot(x1 - x0, y1 - y0) < 0.01 or not all(
        crosses_squarely(segment, angle) for angle in (*edges, *ends)
    ):
        return  # exact cases are in the table
    coarse = rays(degrees)
    directions = np.concatenate([coarse[:: max(1, len(coarse) // 200)], coarse[-1:], ends[ends <= edges[1]]])
    step = max(STEP, (edges[1] - edges[0]) / 199)
    found = to_segment(segment, degrees, best)
    assert found <= min(best, rays_to_segment(segment, directions, -NUDGE)) + EXACT
    assert found >= min(best, rays_to_segment(segment, directions, NUDGE)) - EXACT - 8.0 * step**2


@given(st.floats(0.1, 9.9), st.floats(0.1, 5.9), angles, sectors, bests)
@settings(max_examples=300)
def test_bounds_as_by_rays(x: float, y: float, heading: float, degrees: Degrees, best: float) -> None:
    found = to_bounds((x, y, heading), degrees, best)
    expected = min(best, rays_to_bounds((x, y, heading), rays(degrees)))
    assert expected - 10.0 * STEP**2 - EXACT <= found <= expected + EXACT


@given(coordinates, coordinates, coordinates, coordinates)
def test_full_circle_is_two_halves(x0: float, y0: float, x1: float, y1: float) -> None:
    """Sectors side by side share an edge, so nothing is between them."""
    halves = to_segment((x0, y0, x1, y1), (0.0, 180.0), to_segment((x0, y0, x1, y1), (180.0, 360.0)))
    assert to_segment((x0, y0, x1, y1), (0.0, 360.0)) == pytest.approx(halves, abs=EXACT)
