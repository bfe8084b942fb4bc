"""Situations in people's words."""

from __future__ import annotations

from math import nan, radians

import numpy as np
import pytest
from hypothesis import given
from tests.make.goto_sessions import ANGLE, DISTANCE, DONE, FOOD
from tests.make.lessons import draw_tables

from understudy.coaching.situation_text import (
    NOT_THERE,
    Cells,
    describe_situation,
    find_cells,
    find_usual_cells,
    make_feature_phrases,
    match_cells,
)
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT as forage
from understudy.sim.kit import make_scenario_kit

soccer = make_scenario_kit(find_scenario("soccer"))
BALL = Binding(A="ball")
X, SIZE = BoundFeature(soccer.features["blob_x"], BALL), BoundFeature(soccer.features["blob_size"], BALL)
HEADING = BoundFeature(Feature("heading", Toroidal(), "heading", unit="rad"))
HOUR = BoundFeature(Feature("hour", Toroidal(24.0), "hour"))
STATION = BoundFeature(forage.features["at_station"])
WEIGHT = BoundFeature(Feature("weight", Continuous(), "weight", unit="kg"))

SAID = [
    # features, the least and most seen, cells, in words
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {0: {0}, 1: {2}}, "A is close (below 2 m) and behind you"),
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {0: {1, 2}}, "A is not close (above 2 m)"),
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {0: {0, 1}}, "A is not far (below 4 m)"),
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {0: {0, 2}}, "A is close or far"),
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {1: {1, 3}}, "A is to the left or to the right"),
    ([DISTANCE, ANGLE], [(0, 0), (6, 6)], {1: {0, 1, 3}}, "A is not behind you"),
    ([DISTANCE], [(0,), (6,)], {0: {0, 1, 2}}, "A is there"),
    ([DISTANCE], [(0,), (6,)], {0: {0, NOT_THERE}}, "A is close (below 2 m) or absent"),
    ([X, SIZE], [(0, 0), (150, 9000)], {0: {NOT_THERE}, 1: {NOT_THERE}}, "ball is not seen"),
    ([X, SIZE], [(0, 0), (150, 9000)], {0: {0}}, "ball is in the left of the picture (below 50 px)"),
    ([X, SIZE], [(0, 0), (150, 9000)], {1: {0, 1, 2}}, "ball is seen"),
    ([FOOD, DONE], [(0, 0), (1, 1)], {0: {0}, 1: {1}}, "food_left is no and done is raised"),
    ([HEADING, HOUR], [(0, 0), (6, 23)], {0: {1}, 1: {2}}, "heading is around 90° and hour is around 12"),
    ([WEIGHT], [(0,), (0.3,)], {0: {2}}, "weight is above 0.2 kg"),
    ([WEIGHT], [(0,), (0.3,)], {0: {1}}, "weight is 0.1 to 0.2 kg"),
    ([WEIGHT], [(0,), (0.3,)], {0: {0, 1}}, "weight is below 0.2 kg"),
    ([WEIGHT], [(0,), (0.3,)], {0: {1, 2}}, "weight is above 0.1 kg"),
    ([WEIGHT], [(0,), (0.3,)], {0: {0, 2}}, "weight is below 0.1 kg or above 0.2 kg"),
    ([FOOD, STATION], [(0, 0), (1, 1)], {0: {1}, 1: {1}}, "food_left and at_station are yes"),
    ([WEIGHT], [(0,), (0.3,)], {}, ""),
]  # fmt: skip


@pytest.mark.parametrize(("features", "seen", "cells", "said"), SAID)
def test_a_situation_is_said_in_words(
    features: list[BoundFeature], seen: list[tuple[float, ...]], cells: dict[int, set[int]], said: str
) -> None:
    words = make_feature_phrases(features, np.array(seen, np.float64))
    assert (
        describe_situation(words, {feature: frozenset(chosen) for feature, chosen in cells.items()}) == said
    )


def test_what_is_usual_goes_without_saying() -> None:
    """Of ten examples seven have food_left, three of four do not; a number is never usual."""
    words = make_feature_phrases([FOOD, DONE, WEIGHT], np.array([(0, 0, 0), (1, 1, 0.3)], np.float64))
    rows = np.array([(1, each % 4 == 0, 2) for each in range(10)], np.int64)
    rows[:3, 0] = 0
    usual = find_usual_cells(rows, words)
    assert usual == {0: {1}, 1: {0}}
    chosen: Cells = {0: frozenset({1}), 1: frozenset({0}), 2: frozenset({2})}
    assert describe_situation(words, chosen, usual) == "weight is above 0.2 kg"
    assert (
        describe_situation(words, {**chosen, 1: frozenset({1})}, usual)
        == "done is raised and weight is above 0.2 kg"
    )
    rows[3, 0] = 0
    assert 0 not in find_usual_cells(rows, words)


def test_where_all_is_usual_all_is_said() -> None:
    words = make_feature_phrases([FOOD, DONE], np.array([(0, 0), (1, 1)], np.float64))
    usual: Cells = {0: frozenset({1}), 1: frozenset({0})}
    assert describe_situation(words, usual, usual) == "food_left is yes and done is not raised"
    assert find_usual_cells(np.zeros((0, 2), np.int64), words) == {}


AROUND = [(0, 0), (44, 0), (46, 1), (134, 1), (136, 2), (224, 2), (226, 3), (314, 3), (316, 0), (359, 0)]


@pytest.mark.parametrize(("degrees", "quarter"), AROUND)
def test_quarters_of_a_turn_lie_around_ahead_left_behind_and_right(degrees: float, quarter: int) -> None:
    (word,) = make_feature_phrases([ANGLE], np.zeros((1, 1)))
    assert word.cells_of(np.array([radians(degrees), nan])).tolist() == [quarter, NOT_THERE]


@given(draw_tables())
def test_every_value_lies_in_the_region_of_its_cell_and_in_no_other(
    table: tuple[list[tuple[tuple[float, ...], int, int]], list[object]],
) -> None:
    drawn, kinds = table
    rows = np.array([row[0] for row in drawn], np.float64).reshape(len(drawn), len(kinds))
    features = [BoundFeature(Feature(f"f{i}", kind, reading="f")) for i, kind in enumerate(kinds)]  # type: ignore[arg-type]
    words = make_feature_phrases(features, rows)
    cells = find_cells(words, rows)
    for word, column, found in zip(words, rows.T, cells.T, strict=True):
        for value, cell in zip(column.tolist(), found.tolist(), strict=True):
            others = [other for other in (*word.cells, NOT_THERE) if other != cell]
            assert value in word.region([cell])
            assert value not in word.region(others)
    mine: Cells = {feature: frozenset({int(cell)}) for feature, cell in enumerate(cells[0])}
    assert match_cells(mine, cells)[0]
