"""Cuts in single precision keep every recorded example on its side, or the report says that they cannot."""

from __future__ import annotations

from math import inf, nextafter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.export.recorded_answers import Ask

from understudy.addons.export.body_interface import BodyInterface
from understudy.addons.export.condition_text import round_up_to_ms
from understudy.addons.export.export_automaton import export_automaton
from understudy.addons.export.single_precision import (
    round_cut,
    round_to_single,
    round_up_to_single,
    step_single,
)
from understudy.errors import DefinitionError
from understudy.model.automaton import START, Automaton, State
from understudy.model.behaviors import Behavior, Command, increment
from understudy.model.library import Kit, Library
from understudy.model.tree import Tree, make_leaf
from understudy.runtime.body import Channel
from understudy.runtime.interpreter import measure_elapsed

NUMBERS = st.floats(-1e6, 1e6)
SINGLES = st.floats(-1e6, 1e6, width=32)


@given(NUMBERS, SINGLES)
def test_rounding_up_changes_no_decision_on_32_bit_values(cut: float, value: float) -> None:
    assert (value < cut) == (value < round_up_to_single(cut))


@given(NUMBERS, st.lists(NUMBERS))
def test_recorded_values_stay_on_their_side(cut: float, values: list[float]) -> None:
    rounded, separates = round_cut(cut, np.array(values, np.float64))
    kept = all((value < cut) == (round_to_single(value) < rounded) for value in values)
    assert kept if separates else not kept


CUTS = [  # cut, recorded values, the exported cut, whether it separates
    (0.5, [0.1, 0.9], 0.5, True),
    (0.1, [], round_to_single(0.1), True),
    (nextafter(0.3, inf), [0.3], step_single(round_to_single(0.3), inf), True),  # 0.3 must stay below
    (0.3, [0.3, nextafter(0.3, -inf)], round_to_single(0.3), False),  # both are one 32-bit float
    (0.5, [float("nan")], 0.5, True),
]


@pytest.mark.parametrize(("cut", "values", "exported", "separates"), CUTS)
def test_cuts_by_hand(cut: float, values: list[float], exported: float, separates: bool) -> None:
    assert round_cut(cut, np.array(values, np.float64)) == (exported, separates)


@given(st.floats(0.0, 1e4), st.integers(0, 10**7), st.integers(0, 2**29))
def test_milliseconds_are_compared_as_the_interpreter_compares_seconds(
    cut: float, ms: int, begin_ms: int
) -> None:
    elapsed = measure_elapsed((begin_ms + ms) / 1000, begin_ms / 1000)
    assert (elapsed < cut) == (ms < round_up_to_ms(cut))


REFUSED = [
    (
        Behavior("go", Command(drive=1e300)),
        "it commands 1e\\+300 to 'drive', which single precision does not have",
    ),
    (Behavior("go", Command(), (increment("laps", 3e9),)), "it changes counter 'laps' by or to 3e\\+09"),
]


@pytest.mark.parametrize(("behavior", "problem"), REFUSED)
def test_numbers_too_large_for_32_bits_are_refused(behavior: Behavior, problem: str, tmp_path: Path) -> None:
    automaton = Automaton("a", (START, State("go", "go")), transitions={"start": Tree((make_leaf(1),))})
    library = Library.from_automata(Kit.from_parts(behavior), automaton)
    body = BodyInterface((), (Channel("drive"),))
    with pytest.raises(DefinitionError, match=problem):
        export_automaton(library, "a", tmp_path / "out", to="c99", body=body, single_precision=True)


def test_a_cut_beyond_all_32_bit_floats_is_infinite() -> None:
    with np.errstate(over="raise"):
        assert round_up_to_single(1e300) == inf
        assert round_up_to_single(-1e300) == -3.4028234663852886e38


def test_a_tiny_command_compiles_without_a_warning(ask: Ask, tmp_path: Path) -> None:
    kit = Kit.from_parts(Behavior("go", Command(drive=1e-50)))
    automaton = Automaton("a", (START, State("go", "go")), transitions={"start": Tree((make_leaf(1),))})
    library, body = Library.from_automata(kit, automaton), BodyInterface((), (Channel("drive"),))
    export_automaton(library, "a", tmp_path, to="c99", body=body, single_precision=True)
    assert ask("gcc", tmp_path).counts[1] == 0
