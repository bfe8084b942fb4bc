"""Conditions as text hold exactly where their definition says."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from tests.export.test_equality import holds

from understudy.addons.export.condition_text import C_WORDS, PYTHON_WORDS, Operand, Spelling, write_condition
from understudy.addons.export.decisions import Comparison, ValueCondition


def spell_real(value: float) -> str:
    return repr(value) if abs(value) < inf else f"({value!r})"


LANGUAGES: dict[str, tuple[Spelling, Callable[[str], str]]] = {
    "python": (Spelling(*PYTHON_WORDS, spell_real, str, str), lambda text: text),
    "c": (
        Spelling(*C_WORDS, spell_real, str, str),
        lambda text: text.replace("&&", "and").replace("||", "or").replace("!(", "not ("),
    ),
}
NUMBERS = st.sampled_from([-2.0, -0.5, 0.0, 0.0005, 0.001, 0.25, 0.3, 1.0, 2.0, 2.5, 5e6])
CUTS = st.one_of(NUMBERS, st.just(inf))


def draw_comparison(low: float, high: float) -> st.SearchStrategy[Comparison]:
    """Comparisons that these numbers may have."""
    ordered: tuple[Comparison, ...] = ("inside", "outside") if low <= high else ("across", "between")
    return st.sampled_from(["below", "from", *ordered])


def evaluate(language: str, condition: ValueCondition, operand: Operand, x: float) -> bool:
    spelling, translate = LANGUAGES[language]
    space: dict[str, Any] = {"x": x, "inf": inf, "x_set": x == x}
    return bool(eval(translate(write_condition(condition, operand, spelling)), space))


@given(st.data(), st.sampled_from(list(LANGUAGES)), CUTS, CUTS, st.one_of(NUMBERS, st.just(nan)))
def test_numbers(data: st.DataObject, language: str, low: float, high: float, x: float) -> None:
    condition = ValueCondition(0, data.draw(draw_comparison(low, high)), low, high)
    assert evaluate(language, condition, Operand("real", "x", "x != x"), x) == holds(condition, x)


@given(st.data(), st.sampled_from(list(LANGUAGES)), CUTS, CUTS, st.integers(0, 5000), st.booleans())
def test_milliseconds(
    data: st.DataObject, language: str, low: float, high: float, ms: int, is_set: bool
) -> None:
    """Whole milliseconds are compared as the same time in seconds; a timer that is not set is absent."""
    condition = ValueCondition(0, data.draw(draw_comparison(low, high)), low, high)
    spelling, translate = LANGUAGES[language]
    text = translate(write_condition(condition, Operand("ms", "x", "not x_set", "x_set"), spelling))
    assert bool(eval(text, {"x": ms, "x_set": is_set})) == holds(condition, ms / 1000 if is_set else nan)


@given(st.data(), st.sampled_from(list(LANGUAGES)), CUTS, CUTS, st.integers(-5, 5))
def test_counts(data: st.DataObject, language: str, low: float, high: float, count: int) -> None:
    condition = ValueCondition(0, data.draw(draw_comparison(low, high)), low, high)
    assert evaluate(language, condition, Operand("count", "x"), count) == holds(condition, count)


@given(st.sampled_from(list(LANGUAGES)), st.integers(0, 3), st.integers(0, 3))
def test_labels(language: str, label: int, x: int) -> None:
    condition = ValueCondition(0, "label", float(label))
    assert evaluate(language, condition, Operand("label", "x", "x < 0"), x) == (x == label)


@given(st.sampled_from(list(LANGUAGES)), st.integers(0, 1), st.booleans())
def test_flags(language: str, label: int, raised: bool) -> None:
    condition = ValueCondition(0, "label", float(label))
    assert evaluate(language, condition, Operand("flag", "x"), raised) == (raised == label)
