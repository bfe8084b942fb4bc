"""The order of failing worlds: the worst first, then always the one that is most unlike those before it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.falsification.kept import keep
from tests.falsification.planted import FORAGE
from tests.falsification.test_failing_world import find_failing_seed

from understudy.errors import FileError
from understudy.falsification.failing_world import (
    FACTS_FILE,
    FailingWorld,
    FailureFacts,
    compare_failures,
    list_failing_worlds,
    order_failing_worlds,
)
from understudy.falsification.joint_worlds import Trial


def make_failing_world(
    name: str, robustness: float, place: tuple[float, float] | None, state: str, **more: Any
) -> FailingWorld:
    facts = FailureFacts(
        behavior="forage", binding={}, seed=1, limit_s=600.0, robustness=robustness, wrong_s=1.0, end_hash="",
        found_by="random", steps=(), why=(), place=place, states=("harvest", "goto", state), **more,
    )  # fmt: skip
    return FailingWorld(Path(name), Trial(FORAGE, 1), facts)


ORDERS = [  # robustness, place (m), state, more; the names are a, b, c in this order; how they are listed
    ([(-0.1, (1, 1), "start"), (-0.5, (1, 1), "start"), (-0.3, (1, 1), "start")], "bca"),
    ([(-0.5, (1, 1), "start"), (-0.4, (2, 1), "start"), (-0.1, (8, 1), "start")], "acb"),  # far before near
    (
        [(-0.5, (1, 1), "start"), (-0.4, (8, 8), "start"), (-0.1, (1, 1), "left")],
        "acb",
    ),  # another state before far
    (
        [(-0.5, None, "start"), (-0.4, (8, 8), "start"), (-0.1, (2, 2), "start")],
        "abc",
    ),  # not kept: the worse first
    ([(-0.5, (1, 1), "start"), (-0.4, (1, 1), "start"), (-0.1, (1, 1), "start", "stays_near")], "acb"),
    (
        [(-0.5, (1, 1), "start"), (-0.4, (9, 9), "start"), (-0.3, (9, 8), "start"), (-0.1, (5, 5), "start")],
        "abdc",
    ),
    ([(-0.5, (1, 1), "start"), (-0.5, (1, 1), "start")], "ab"),  # by name
    ([], ""),
]


@pytest.mark.parametrize(("rows", "order"), ORDERS)
def test_the_worst_comes_first_and_then_the_most_different(rows: list[Any], order: str) -> None:
    worlds = [
        make_failing_world(name, robustness, place, state, property=of[0] if of else None)
        for name, (robustness, place, state, *of) in zip("abcd", rows, strict=False)
    ]
    assert "".join(each.folder.name for each in order_failing_worlds(worlds)) == order
    assert "".join(each.folder.name for each in order_failing_worlds(worlds[::-1])) == order


def test_the_difference_is_in_diagonals() -> None:
    width, height = FORAGE.size
    one, other = (make_failing_world("a", -1.0, place, "start") for place in ((0.0, 0.0), (width, height)))
    assert compare_failures(one, other) == compare_failures(other, one) == pytest.approx(1.0)
    assert compare_failures(one, one) == 0.0


def test_a_folder_is_listed_and_what_cannot_be_read_is_said(tmp_path: Path) -> None:
    kept = keep(Trial(FORAGE, find_failing_seed()), tmp_path / "forage-1")
    assert kept.facts.place is not None
    assert kept.facts.states[-1] == "start"
    (tmp_path / "forage-2").mkdir()
    (tmp_path / "forage-2" / FACTS_FILE).write_text("{")
    (tmp_path / "other").mkdir()  # no failing world
    (tmp_path / "note.txt").write_text("mine")
    worlds, problems = list_failing_worlds(tmp_path)
    assert worlds == (kept,)
    assert len(problems) == 1
    assert "forage-2" in problems[0]
    assert "is not valid" in problems[0]


def test_no_folder_is_an_empty_list_and_a_file_is_refused(tmp_path: Path) -> None:
    assert list_failing_worlds(tmp_path / "failures") == ((), ())
    (tmp_path / "failures").write_text("mine")
    with pytest.raises(FileError, match="reading the failing worlds failed"):
        list_failing_worlds(tmp_path / "failures")
