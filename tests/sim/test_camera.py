"""The camera: blobs by closed forms, and against a raster that casts a ray through each of many columns."""

from math import cos, hypot, inf, isnan, nan, radians, sin, sqrt, tan
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from understudy.jit.plain import make_plain
from understudy.sim.kernels.camera import measure_blob, project_objects, project_segments
from understudy.sim.kernels.dtypes import SEGMENT, THING, VIEW

Floats: TypeAlias = NDArray[np.float64]
Thing: TypeAlias = tuple[float, float, float, float, int, int]
Segment: TypeAlias = tuple[float, float, float, float]
Blob: TypeAlias = tuple[float, float]

RED, BLUE = 0, 1
HIDDEN = (nan, nan)


def find_blob(
    things: list[Thing],
    segments: list[Segment],
    *,
    color: int = RED,
    view_deg: float = 90.0,
    nearest: bool = False,
    least_px: float = 1.0,
    limit_m: float = inf,
) -> Blob:
    """The blob of a color in a frame of 100 x 100 pixels."""
    tan_half = tan(radians(view_deg / 2.0)) if view_deg != 90.0 else 1.0
    discs = make_plain(np.array([(*thing,) for thing in things], THING))
    walls = make_plain(np.array([(*segment, 1) for segment in segments], SEGMENT))
    views = make_plain(np.zeros(len(discs) + len(walls), VIEW))
    count = project_objects(discs, len(discs), tan_half, 100.0, 100.0, limit_m, views)
    end = project_segments(walls, len(walls), tan_half, views, count)
    return measure_blob(views, count, end, color, tan_half, 100.0, nearest, least_px)


# With 90 degrees in 100 pixels, what is 1 m to the side at 1 m ahead is 50 px from the middle. A disc at 5 m of
# radius 3 m has tangents 3/4 to both sides, and at 2 m high is 50 * 2 / 5 = 20 px high.
BALL: Thing = (5.0, 0.0, 3.0, 2.0, RED, 1)
ALOFT: Thing = (5.0, 0.0, 3.0, 2.0, RED, -1)
DIAGONAL = 5.0 / sqrt(2.0)
LOOKS = [
    ("ahead", [BALL], [], (50.0, 75 * 20)),
    ("of another color", [(5.0, 0.0, 3.0, 2.0, BLUE, 1)], [], HIDDEN),
    ("of no color", [(5.0, 0.0, 3.0, 2.0, -1, 1)], [], HIDDEN),
    ("behind", [(-5.0, 0.0, 3.0, 2.0, RED, 1)], [], HIDDEN),
    ("outside the frame", [(1.0, 5.0, 1.0, 2.0, RED, 1)], [], HIDDEN),
    ("around the camera", [(1.0, 0.0, 3.0, 2.0, RED, 1)], [], HIDDEN),
    (
        "left edge through its middle: from 1/7 to 1",
        [(DIAGONAL, DIAGONAL, 3.0, 2.0, RED, 1)],
        [],
        (150 / 7, 300 / 7 * 20 * sqrt(2)),
    ),
    (
        "right edge through its middle",
        [(DIAGONAL, -DIAGONAL, 3.0, 2.0, RED, 1)],
        [],
        (100 - 150 / 7, 300 / 7 * 20 * sqrt(2)),
    ),
    ("abreast, but so wide that it reaches in", [(0.0, 5.0, 4.0, 2.0, RED, 1)], [], (6.25, 12.5 * 100)),
    ("fills the height", [(5.0, 0.0, 3.0, 20.0, RED, 1)], [], (50.0, 75 * 100)),
    ("right half behind a wall", [BALL], [(1.0, 0.0, 1.0, -2.0)], (31.25, 37.5 * 20)),
    ("left half behind a wall", [BALL], [(1.0, 2.0, 1.0, 0.0)], (68.75, 37.5 * 20)),
    ("behind a wall", [BALL], [(1.0, -2.0, 1.0, 2.0)], HIDDEN),
    ("behind two walls that touch", [BALL], [(1.0, -2.0, 1.0, 0.0), (1.0, 0.0, 1.0, 2.0)], HIDDEN),
    ("before a wall", [BALL], [(9.0, -20.0, 9.0, 20.0)], (50.0, 75 * 20)),
    ("beside a wall that passes the camera", [BALL], [(-9.0, -4.0, 9.0, -4.0)], (50.0, 75 * 20)),
    (
        "a wall beside the camera ends at 1/2 on the right",
        [BALL],
        [(-9.0, -1.0, 2.0, -1.0)],
        (43.75, 62.5 * 20),
    ),
    ("right half behind a wall that passes the camera", [BALL], [(1.0, 0.0, -1.0, -1.0)], (31.25, 37.5 * 20)),
    ("the wall is behind", [BALL], [(-1.0, -2.0, -1.0, 2.0)], (50.0, 75 * 20)),
    ("no wall", [BALL], [(nan, 0.0, nan, 0.0)], (50.0, 75 * 20)),
    ("a robot hides it", [BALL, (2.5, 0.0, 1.5, 1.0, BLUE, 1)], [], HIDDEN),
    ("a robot does not hide what hangs aloft", [ALOFT, (2.5, 0.0, 1.5, 1.0, BLUE, 1)], [], (50.0, 75 * 20)),
    ("nor does a wall", [ALOFT], [(1.0, -2.0, 1.0, 2.0)], (50.0, 75 * 20)),
    ("what hangs aloft hides nothing", [BALL, (2.5, 0.0, 1.5, 1.0, BLUE, -1)], [], (50.0, 75 * 20)),
    ("food hides nothing", [BALL, (2.5, 0.0, 1.5, 1.0, BLUE, 0)], [], (50.0, 75 * 20)),
    (
        "a robot before its middle leaves two pieces of equal size",
        [(2.5, 0.0, 0.7, 1.0, BLUE, 1), BALL],
        [],
        (50 - (75 + 175 / 6) / 4, (37.5 - 87.5 / 6) * 20),
    ),
    (
        "and a wall makes one of them smaller",
        [(2.5, 0.0, 0.7, 1.0, BLUE, 1), BALL],
        [(1.0, 0.5, 1.0, 2.0)],
        (50 + (75 + 175 / 6) / 4, (37.5 - 87.5 / 6) * 20),
    ),
    (
        "a wall before a wall hides no more",
        [BALL],
        [(1.0, 0.5, 1.0, -2.0), (0.5, 0.2, 0.5, 0.15)],
        (18.75, 12.5 * 20),
    ),
    ("a robot behind it", [BALL, (12.0, 0.0, 2.0, 1.0, BLUE, 1)], [], (50.0, 75 * 20)),
    ("a robot on top of it", [(5.0, 0.0, 0.1, 2.0, RED, 0), (5.0, 0.0, 0.2, 1.0, BLUE, 1)], [], HIDDEN),
]


@pytest.mark.parametrize(
    ("things", "segments", "expected"), [look[1:] for look in LOOKS], ids=[o[0] for o in LOOKS]
)
def test_blob(things: list[Thing], segments: list[Segment], expected: Blob) -> None:
    assert find_blob(things, segments) == pytest.approx(expected, nan_ok=True)


SMALL: Thing = (2.5, 1.0, 0.2, 0.2, RED, 0)


def test_largest_or_nearest() -> None:
    small = find_blob([SMALL], [])
    assert find_blob([BALL, SMALL], []) == pytest.approx((50.0, 1500.0))
    assert find_blob([BALL, SMALL], [], nearest=True) == small
    assert find_blob([SMALL, BALL], [], nearest=True) == small


def test_of_equals_the_one_farthest_left() -> None:
    """In whatever order they come: robots are sorted now and then."""
    twins = [(4.0, side, 0.5, 1.0, RED, 1) for side in (-2.0, 2.0)]
    for order in (twins, twins[::-1]):
        assert find_blob(order, [])[0] < 50.0
        assert find_blob(order, [], nearest=True)[0] < 50.0


def test_nearest_that_is_hidden_does_not_count() -> None:
    hidden = (2.5, 0.0, 0.1, 0.2, RED, 0)
    wall = (1.0, -0.1, 1.0, 0.1)
    assert find_blob([hidden, SMALL], [wall], nearest=True) == find_blob([SMALL], [wall])


@pytest.mark.parametrize(("limit_m", "there"), [(5.001, True), (5.0, False), (1.0, False)])
def test_range_is_to_the_center(limit_m: float, there: bool) -> None:
    assert isnan(find_blob([BALL], [], limit_m=limit_m)[0]) is not there


def test_thing_out_of_range_still_hides() -> None:
    big = (5.0, 0.0, 3.0, 2.0, BLUE, 1)
    beside = (4.8 * cos(radians(36)), 4.8 * sin(radians(36)), 0.03, 1.0, RED, 0)  # just behind its flank
    assert isnan(find_blob([big, beside], [], limit_m=4.95)[0])
    assert not isnan(find_blob([beside], [], limit_m=4.95)[0])


@pytest.mark.parametrize(("least_px", "there"), [(1499.0, True), (1501.0, False)])
def test_least_size(least_px: float, there: bool) -> None:
    for nearest in (True, False):
        assert isnan(find_blob([BALL], [], least_px=least_px, nearest=nearest)[0]) is not there


# --- Against a raster ---

COLUMNS = 4000


def entries(thing: Thing, across: Floats) -> Floats:
    """Where the ray through each column enters a disc; infinite where it does not."""
    x, y, radius = thing[:3]
    norm = np.sqrt(1.0 + across**2)
    middle = (x - across * y) / norm
    under = middle**2 - (x * x + y * y - radius * radius)
    return np.where((under > 0.0) & (middle > 0.0), middle - np.sqrt(np.maximum(under, 0.0)), inf)


def crossings(segment: Segment, across: Floats) -> Floats:
    """Where the ray through each column meets a segment; infinite where it does not."""
    x0, y0, x1, y1 = segment
    norm = np.sqrt(1.0 + across**2)
    ray_x, ray_y = 1.0 / norm, -across / norm
    side0, side1 = ray_x * y0 - ray_y * x0, ray_x * y1 - ray_y * x1
    with np.errstate(divide="ignore", invalid="ignore"):
        share = side0 / (side0 - side1)
        distance = (x0 + share * (x1 - x0)) * ray_x + (y0 + share * (y1 - y0)) * ray_y
    return np.where((share >= 0.0) & (share <= 1.0) & (distance > 0.0), distance, inf)


def runs(visible: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The first column of each run, and one after its last."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]])))
    return [(int(start), int(end)) for start, end in steps.reshape(-1, 2)]


def by_raster(
    things: list[Thing],
    segments: list[Segment],
    *,
    view_deg: float,
    nearest: bool,
    least_px: float,
    limit_m: float,
) -> list[tuple[float, float, float]]:
    """All answers that are right for red within the raster's resolution: x, size, and by how much that may be off.

    Both ends of a piece are between two columns, so its width may be off by two, its middle by one.
    """
    tan_half = tan(radians(view_deg / 2.0)) if view_deg != 90.0 else 1.0
    focal, column = 50.0 / tan_half, 100.0 / COLUMNS
    across = ((np.arange(COLUMNS) + 0.5) / COLUMNS * 2.0 - 1.0) * tan_half
    depths = [entries(thing, across) for thing in things]
    walls = [crossings(segment, across) for segment in segments]
    found = []  # distance, x, size, tolerance
    for index, (x, y, _, height, color, _) in enumerate(things):
        if color != RED or hypot(x, y) >= limit_m:
            continue
        others = [depths[other] for other, thing in enumerate(things) if other != index and thing[5] > 0]
        hiding = [*others, *walls] if things[index][5] >= 0 else []
        before = np.min(np.array([*hiding, np.full(COLUMNS, inf)]), axis=0)
        scale = focal * height / x if focal * height < 100.0 * x else 100.0
        for start, end in runs(depths[index] < before):
            size, off = (end - start) * column * scale, 2.0 * column * scale + 1e-6
            found.append((hypot(x, y), 0.5 * (start + end) * column, size, off))
    large = [answer for answer in found if answer[2] + answer[3] >= least_px]
    sure = [answer for answer in found if answer[2] - answer[3] >= least_px]
    if nearest:
        limit = min((answer[0] for answer in sure), default=inf)
        right = [answer for answer in large if answer[0] <= limit]
        return [answer[1:] for answer in right if widest(answer, found)] + ([] if sure else [(nan, nan, 0.0)])
    least = max((answer[2] - answer[3] for answer in sure), default=0.0)
    right = [answer for answer in large if answer[2] + answer[3] >= least]
    return [answer[1:] for answer in right] + ([] if sure else [(nan, nan, 0.0)])


def widest(answer: tuple[float, ...], found: list[tuple[float, float, float, float]]) -> bool:
    """Whether a piece may be the widest of its thing (told by its distance)."""
    return all(answer[2] + 2.0 * answer[3] >= other[2] for other in found if other[0] == answer[0])


@st.composite
def scenes(draw: st.DrawFn) -> tuple[list[Thing], list[Segment]]:
    """Discs in cells of their own, and walls that are clear of them and of the camera, and not seen end on."""
    things: list[Thing] = []
    cells = st.tuples(st.integers(-2, 6), st.integers(-5, 5)).filter(lambda cell: cell != (0, 0))
    for cell_x, cell_y in draw(st.lists(cells, unique=True, max_size=12)):
        radius = draw(st.floats(0.1, 0.45))
        place = st.floats(-0.49 + radius, 0.49 - radius)
        x, y = cell_x + draw(place), cell_y + draw(place)
        things.append(
            (x, y, radius, draw(st.floats(0.1, 3.0)), draw(st.integers(-1, 1)), draw(st.integers(-1, 1)))
        )
    ends = st.floats(-3.0, 6.0)
    segments = draw(st.lists(st.tuples(ends, ends, ends, ends), max_size=4))
    return things, [segment for segment in segments if is_clear(segment, things)]


def is_clear(segment: Segment, things: list[Thing]) -> bool:
    x0, y0, x1, y1 = segment
    turn = abs(np.arctan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1))
    shares = np.linspace(0.0, 1.0, 2000)
    x, y = x0 + shares * (x1 - x0), y0 + shares * (y1 - y0)
    near = min((np.min(np.hypot(x - thing[0], y - thing[1])) - thing[2] for thing in things), default=inf)
    return bool(near > 0.01 and turn > 0.01 and np.min(np.hypot(x, y)) > 0.01)


@given(
    scenes(),
    st.sampled_from([30.0, 60.0, 90.0, 150.0]),
    st.booleans(),
    st.sampled_from([1.0, 200.0]),
    st.sampled_from([inf, 4.37]),
)
@settings(max_examples=300)
def test_blob_as_by_raster(
    scene: tuple[list[Thing], list[Segment]], view_deg: float, nearest: bool, least_px: float, limit_m: float
) -> None:
    things, segments = scene
    x, size = find_blob(
        things, segments, view_deg=view_deg, nearest=nearest, least_px=least_px, limit_m=limit_m
    )
    answers = by_raster(
        things, segments, view_deg=view_deg, nearest=nearest, least_px=least_px, limit_m=limit_m
    )
    column = 100.0 / COLUMNS
    assert any(
        (isnan(x) and isnan(size) and isnan(right_x))
        or (abs(x - right_x) <= column + 1e-6 and abs(size - right_size) <= off)
        for right_x, right_size, off in answers
    ), (x, size, answers)
