"""What presses for a flag had in common: the table says where, and what was right beside it."""

from __future__ import annotations

from math import inf, nan, radians
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.learning.csv_table import read_lesson_table
from understudy.learning.shown_ranges import ShownRange, find_shown_range
from understudy.model.lesson import Lesson
from understudy.model.value_kinds import TAU

NEAR = """state,next,kind,distance:continuous,angle:toroidal(6.283185307179586)
forward,done,directive,0.4,0.1
forward,done,directive,0.2,3.0
left,done,confirmation,0.3,5.0
forward,forward,default,0.5,0.2
forward,left,directive,4.0,1.0
left,forward,watched,2.0,0.0
"""


def read(tmp_path: Path, text: str) -> Lesson:
    path = tmp_path / "lesson.csv"
    path.write_text(text)
    return read_lesson_table(path)


def find(tmp_path: Path, text: str) -> ShownRange:
    found = find_shown_range(read(tmp_path, text), "done")
    assert found is not None
    return found


def test_the_distance_is_what_presses_have_in_common(tmp_path: Path) -> None:
    found = find(tmp_path, NEAR)
    assert str(found.feature) == "distance"
    assert (found.low, found.high, found.below, found.above, found.presses) == (0.2, 0.4, -inf, 0.5, 3)
    assert found.describe() == "0.20 to 0.40"
    assert found.condition == "distance is below 0.5"


def test_what_agrees_is_nearer_than_anything_else_that_was_right(tmp_path: Path) -> None:
    found = find(tmp_path, NEAR)
    values = np.array([0.05, 0.2, 0.45, 0.5, 3.0, nan])
    assert found.contains(values).tolist() == [True, True, True, False, False, False]
    assert found.find_ends(values[:4]) == (0.05, 0.5)
    assert found.measure_gap(values).tolist() == [0.0, 0.0, 0.0, 0.0, 2.5, inf]


def test_what_lies_beyond_all_else_comes_before_what_agrees_by_chance(tmp_path: Path) -> None:
    """Two presses at nearly the same angle, amid other angles: they say something about the distance."""
    few = "forward,done,directive,0.4,5.3\nforward,done,directive,0.2,5.31\n"
    others = "forward,forward,default,0.5,0.2\nforward,left,directive,4.0,1.0\n"
    header = NEAR.splitlines()[0] + "\n"
    found = find(tmp_path, header + few + others)
    assert (str(found.feature), found.high) == ("distance", 0.4)
    nearer = (
        "forward,forward,default,0.1,0.3\n"  # now the distance is amid others, too: 3 of 10 times by chance
    )
    assert find_shown_range(read(tmp_path, header + few + others + nearer), "done") is None


CHANCES: dict[
    str, tuple[list[float], list[float], tuple[float, float] | None]
] = {  # presses for done and other presses, by distance -> the range that is found, or nothing
    "two of two, four others": ([0.2, 0.4], [1, 2, 3, 4], (0.2, 0.4)),  # 1 of 15 by chance
    "two of three are near": ([0.2, 0.4, 3.5], [1, 2, 3, 4], (0.2, 0.4)),  # a slip: 1 of 7
    "one of two is": ([0.2, 3.5], [1, 2, 3, 4], None),  # which one?
    "a slip nearer by": ([0.2, 0.3, 0.4], [0.1, 1, 2, 3, 4, 5], (0.2, 0.4)),
    "two of two, amid others": ([2.2, 2.4], [1, 2, 3, 4], None),  # 6 x 1 of 15
    "four of four, amid others": ([2.2, 2.4, 2.6, 2.8], [1, 2, 3, 4, 5, 6, 7, 8], (2.2, 2.8)),
}


@pytest.mark.parametrize("why", CHANCES)
def test_what_is_likely_by_chance_is_not_concluded(tmp_path: Path, why: str) -> None:
    presses, others, expected = CHANCES[why]
    rows = "".join(f"forward,done,directive,{each}\n" for each in presses)
    rows += "".join(f"forward,left,directive,{each}\n" for each in others)
    found = find_shown_range(read(tmp_path, "state,next,kind,distance:continuous\n" + rows), "done")
    assert (None if found is None else (found.low, found.high)) == expected


SILENCE = {  # watched examples at 0.6 and beyond -> the limit, between presses for done up to 0.4 and for left at 4
    3: 4.0,
    4: 0.9,
    6: 0.9,
}


@pytest.mark.parametrize("count", SILENCE)
def test_silence_limits_it_from_four_on_and_never_on_the_open_side(tmp_path: Path, count: int) -> None:
    watched = "".join(f"forward,forward,watched,{0.6 + 0.1 * each}\n" for each in range(count))
    nearer = "left,left,watched,0.1\n" * 5  # it had turned beside it, and nobody pressed done
    pressed = (("done", 0.2), ("done", 0.4), ("left", 4.0), ("left", 5.0))
    rows = "".join(f"forward,{following},directive,{value}\n" for following, value in pressed)
    found = find(tmp_path, "state,next,kind,distance:continuous\n" + rows + watched + nearer)
    assert found.below == -inf
    assert found.above == pytest.approx(SILENCE[count])


LIMITS = [  # distances of presses for left, beside one for done at 0.2 and one for left at 4, and where the version
    # before raised it -> the limits of both versions; the table of docs/evaluation.md comes first
    ([3.0], [0.3, 0.4], 1.15, 0.78),
    ([3.0], [], 1.15, 1.15),  # the version before raised it nowhere
    ([3.0], [0.1], 1.15, 0.58),  # nearer than it was shown
    ([3.0], [1.1], 1.15, 1.15),  # never farther than before
    ([0.5], [0.3, 0.45], 0.5, 0.5),  # something else was right nearer by
    ([0.25], [0.2], 0.39, 0.39),  # so near that it is the same place
]


@pytest.mark.parametrize(("others", "raised", "before", "after"), LIMITS)
def test_where_a_flag_counts_before_and_after_a_press(
    tmp_path: Path, others: list[float], raised: list[float], before: float, after: float
) -> None:
    rows = "".join(f"forward,left,directive,{each}\n" for each in (*others, 4.0))
    lesson = read(tmp_path, "state,next,kind,distance:continuous\nforward,done,directive,0.2\n" + rows)
    found = find_shown_range(lesson, "done", fewest=1, chance=0.7)
    assert found is not None
    first = found.restrict_limits()
    second = first.limit_near(np.array(raised))
    assert (first.below, second.below) == (-inf, -inf)
    assert [first.above, second.above] == pytest.approx([before, after])


def test_angles_count_as_they_were_shown(tmp_path: Path) -> None:
    rows = "".join(f"a,done,directive,{angle}\n" for angle in (0, 5, 355)) + "".join(
        f"a,b,directive,{angle}\n" for angle in range(40, 320, 10)
    )
    found = find(tmp_path, "state,next,kind,angle:toroidal(360)\n" + rows)
    assert found.restrict_limits().limit_near(np.array([2.0])) == found


NOTHING = {  # why -> next state, kind and value of each example
    "one press": ["done,directive,0.4", "left,directive,9"],
    "none pressed": ["done,default,0.4", "done,default,0.2", "done,default,0.1", "left,directive,9"],
    "everywhere": ["done,directive,0", "done,directive,5", "done,directive,9", "left,directive,6"],
    "once absent": ["done,directive,0.4", "done,directive,0.2", "done,directive,", "left,directive,9"],
    "always the same": ["done,directive,1", "done,directive,1", "done,directive,1"],
}


@pytest.mark.parametrize("why", NOTHING)
def test_nothing_in_common(tmp_path: Path, why: str) -> None:
    rows = "".join(f"forward,{row}\n" for row in NOTHING[why])
    assert find_shown_range(read(tmp_path, "state,next,kind,x:continuous\n" + rows), "done") is None


def test_a_label(tmp_path: Path) -> None:
    rows = "a,done,directive,yes\na,done,directive,yes\na,done,directive,yes\na,b,directive,no\n"
    found = find(tmp_path, "state,next,kind,full:boolean\n" + rows)
    assert found.describe() == "yes"
    assert found.condition == "full is yes"
    assert found.contains(np.array([0.0, 1.0, nan])).tolist() == [False, True, False]


def test_on_a_circle_it_may_cross_the_seam(tmp_path: Path) -> None:
    rows = "".join(f"a,done,directive,{angle}\n" for angle in (350, 5, 10)) + "".join(
        f"a,b,directive,{angle}\n" for angle in (40, 300, *range(100, 280, 10))
    )
    found = find(tmp_path, "state,next,kind,angle:toroidal(360)\n" + rows)
    assert (found.low, found.high, found.below, found.above) == (350.0, 370.0, 300.0, 400.0)
    inside = found.contains(np.array([305.0, 355.0, 0.0, 39.0, 45.0, 180.0, 299.0]))
    assert inside.tolist() == [True, True, True, True, False, False, False]
    assert found.find_ends(np.array([340.0, 2.0, 20.0])) == (340.0, 380.0)
    assert found.measure_gap(np.array([305.0, 0.0, 39.0, 45.0, 290.0])).tolist() == [0, 0, 0, 5, 10]
    assert found.condition == "angle is at least 300 or below 40"


@given(st.lists(st.floats(0.0, TAU, exclude_max=True), min_size=3, max_size=6), st.floats(0.0, TAU))
def test_presses_lie_in_their_own_range(presses: list[float], turn: float) -> None:
    """Also after all angles were turned, and with something else right outside of them."""
    turned = np.mod(np.array(presses) * 0.2 + turn, TAU)
    away = (turn + 0.1 * TAU + radians(170)) % TAU
    rows = "".join(f"a,done,directive,{value!r}\n" for value in turned.tolist())
    with TemporaryDirectory() as folder:
        rows += "".join(f"a,b,directive,{away + 1e-9 * each!r}\n" for each in range(20))
        found = find(Path(folder), "state,next,kind,angle:toroidal(6.283185307179586)\n" + rows)
    assert found.contains(turned).all()
    assert not found.contains(np.array([away])).any()
