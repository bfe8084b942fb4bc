"""Comparisons of evaluations in the same worlds, and evaluations as data frames."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np
import pytest
from tests.analysis.own_bodies import KIT, LIBRARY, Carts, make_approach

from understudy.errors import SettingError
from understudy.judging.comparison import compare
from understudy.judging.evaluate import evaluate
from understudy.judging.evaluation import Evaluation
from understudy.judging.outcomes import Outcomes
from understudy.model.library import Library


def make_evaluation(seconds: list[float], food: list[float], **given: Any) -> Evaluation:
    n = len(seconds)
    taught = Outcomes(np.array(seconds), np.full(n, 9.0), np.zeros(n, np.int64), np.zeros(n, np.int64))
    return Evaluation(
        **{
            "behavior": "a",
            "world": "w",
            "seeds": tuple(range(n)),
            "taught": taught,
            "expert": None,
            **given,
        },
        metrics={"food": np.array(food)},
    )


FIRST = make_evaluation([1, 2, 3, nan, nan, 6], [1, 2, 3, 4, 5, nan])
SECOND = make_evaluation([1, 4, 6, 5, 7, nan], [2, 4, 6, 8, 5, 3])


def test_success_is_compared_pair_by_pair() -> None:
    found = compare(FIRST, SECOND).success
    assert (found.first, found.second) == (4 / 6, 5 / 6)
    assert (found.only_first, found.only_second, found.p) == (1, 2, 1.0)
    assert found.difference == pytest.approx(1 / 6)
    assert found.interval[0] < found.difference < found.interval[1]


def test_metrics_are_compared_where_both_have_them() -> None:
    """Food in five worlds, one of them equal, 1 to 4 more in the others: p = 2 / 16. Time where both finished."""
    metrics = compare(FIRST, SECOND).metrics
    assert list(metrics) == ["seconds", "food"]
    food, seconds = metrics["food"], metrics["seconds"]
    assert (food.first, food.second, food.difference.median) == (3.0, 5.0, 2.0)
    assert (food.test.pairs, food.test.equal, food.test.p, food.test.rank_biserial) == (5, 1, 0.125, 1.0)
    assert (seconds.test.pairs, seconds.difference.median, seconds.test.p) == (3, 2.0, 0.5)


def test_the_other_way_round_signs_change() -> None:
    one, other = compare(FIRST, SECOND), compare(SECOND, FIRST)
    assert other.success.difference == -one.success.difference
    assert other.metrics["food"].difference.median == -2.0
    assert other.metrics["food"].test.rank_biserial == -1.0
    assert other.metrics["food"].test.p == one.metrics["food"].test.p


MISTAKES = [
    ({"seeds": (0, 1, 2, 3, 4, 7)}, "seeds differ, such as 5; evaluate both with the same seeds"),
    ({"seeds": (1, 0, 2, 3, 4, 5)}, "seeds differ in their order"),
    ({"world": "moon"}, "second evaluation is of moon, and the first of w; evaluate both in the same worlds"),
]


@pytest.mark.parametrize(("given", "message"), MISTAKES)
def test_what_cannot_be_compared(given: dict[str, Any], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        compare(FIRST, make_evaluation([1.0] * 6, [1.0] * 6, **given))


def test_different_limits_cannot_be_compared() -> None:
    """One second less in the fifth world."""
    limits = np.array([9.0, 9.0, 9.0, 9.0, 8.0, 9.0])
    other = Outcomes(SECOND.taught.seconds, limits, SECOND.taught.delivered, SECOND.taught.gathered)
    with pytest.raises(SettingError, match="time limits differ: 9 and 8 s in the world of seed 4"):
        compare(FIRST, make_evaluation([1.0] * 6, [1.0] * 6, taught=other))


def test_two_libraries_in_the_same_worlds() -> None:
    """The second stops 1 m earlier, two ticks of half a meter, wherever it starts farther away than that."""
    eager = Library.from_automata(KIT, make_approach(1.5))
    first, second = (
        evaluate(each, "approach", Carts, range(3, 13), limit_s=20.0, metrics=["far"])
        for each in (LIBRARY, eager)
    )
    found = compare(first, second)
    assert found.success.p == 1.0
    assert found.metrics["seconds"].difference.median == -1.0
    assert found.metrics["seconds"].test.p == 2 / 2**10
    assert found.metrics["far"].test.rank_biserial == 1.0
    assert repr(found).startswith("<Comparison of 'approach' and 'approach' in 10 worlds: success +0% [")


def test_an_evaluation_is_one_line() -> None:
    assert repr(FIRST) == "<Evaluation of 'a' in w: success in 4 of 6 worlds, metrics food>"


@pytest.mark.parametrize("backend", ["polars", "pandas", "pyarrow"])
def test_an_evaluation_as_a_frame(backend: str) -> None:
    frame = FIRST.to_frame(backend=backend)
    assert type(frame).__module__.partition(".")[0] == backend
    columns = (
        frame.to_pydict() if backend == "pyarrow" else {name: list(frame[name]) for name in frame.columns}
    )
    assert list(columns) == ["seed", "success", "seconds", "limit_s", "delivered", "gathered", "food"]
    assert columns["seed"] == [0, 1, 2, 3, 4, 5]
    assert columns["success"] == [True, True, True, False, False, True]
    absent = [value is None or value != value for value in columns["seconds"]]
    assert absent == [False, False, False, True, True, False]
    assert columns["food"][:5] == [1.0, 2.0, 3.0, 4.0, 5.0]
