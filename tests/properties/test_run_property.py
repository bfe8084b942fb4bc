"""Results of properties: verdicts, intervals, and how many worlds a sequential test runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.ui.cli.forage_parts import AUTOMATA

from understudy.judging.intervals import exact_interval_of_share
from understudy.judging.properties.monitor import PropertyOutcomes
from understudy.judging.properties.run_property import (
    PropertyResult,
    Verdict,
    compute_failure_bound,
    describe_result,
    run_property,
)
from understudy.model.library import Library
from understudy.model.property import Property, PropertyKind, SeededWorlds
from understudy.sim.catalog import find_scenario
from understudy.sim.forage import FORAGE_KIT

LIBRARY, FORAGE = Library.from_automata(FORAGE_KIT, *AUTOMATA), find_scenario("forage")
DELIVERS = Property(
    kind=PropertyKind.ALWAYS,
    what="goal is reached",
    seconds=600.0,
    start=SeededWorlds("forage", tuple(range(2_000))),
    behavior="forage",
    name="delivers",
)


def result(failures: int, worlds: int, at_least: float | None = None) -> PropertyResult:
    failed_s = np.full(worlds, np.nan)
    failed_s[:failures] = 12.0
    outcomes = PropertyOutcomes(failed_s, np.full(worlds, np.nan), np.where(np.isnan(failed_s), 0.5, -0.5))
    return PropertyResult(replace(DELIVERS, at_least=at_least), tuple(range(worlds)), outcomes)


VERDICTS = [  # failures, worlds, at_least, verdict
    (0, 100, None, Verdict.HOLDS),
    (1, 100, None, Verdict.FAILS),
    (0, 600, 0.99, Verdict.HOLDS),
    (0, 100, 0.99, Verdict.UNDECIDED),
    (50, 100, 0.99, Verdict.FAILS),
    (5, 600, 0.99, Verdict.UNDECIDED),
]


@pytest.mark.parametrize(("failures", "worlds", "at_least", "verdict"), VERDICTS)
def test_verdicts(failures: int, worlds: int, at_least: float | None, verdict: Verdict) -> None:
    assert result(failures, worlds, at_least).verdict is verdict


@pytest.mark.parametrize("worlds", [1, 10, 300])
def test_no_failure_in_so_many_worlds(worlds: int) -> None:
    """A larger rate would have shown a failure with more than 95 %; it is the exact limit of one side."""
    bound = compute_failure_bound(worlds)
    assert (1 - bound) ** worlds == pytest.approx(0.05)
    assert 1 - exact_interval_of_share(worlds, worlds, level=0.9)[0] == pytest.approx(bound)


def test_sentences() -> None:
    assert list(describe_result(result(0, 300))) == [
        "no failure in 300 worlds: it fails in at most 0.994 % of worlds, at 95 %"
    ]
    seen, seeds = describe_result(result(3, 200))
    assert seen == "3 of 200 worlds failed (1.5 %); exact 95 % interval of failures: 0.31 % to 4.32 %"
    assert seeds == "failed with seed 0 after 12.0 s, seed 1 after 12.0 s, seed 2 after 12.0 s"
    *_, decided = describe_result(result(0, 600, 0.99))
    assert decided == "it holds in at least 99 % of worlds, decided after 600 of 2000"
    short = replace(result(0, 100, 0.99).tested, start=SeededWorlds("forage", tuple(range(100))))
    *_, undecided = describe_result(replace(result(0, 100, 0.99), tested=short))
    assert undecided == "undecided whether it holds in at least 99 % of worlds: give at least 535 seeds"


@pytest.mark.parametrize(
    ("seconds", "at_least", "verdict", "worlds"),
    [(600.0, 0.9, Verdict.HOLDS, 51), (100.0, 0.9, Verdict.FAILS, 50)],
)
def test_it_stops_when_it_is_decided(seconds: float, at_least: float, verdict: Verdict, worlds: int) -> None:
    found = run_property(replace(DELIVERS, seconds=seconds, at_least=at_least), LIBRARY, FORAGE)
    assert (found.verdict, found.worlds) == (verdict, worlds)
    assert found.seeds == tuple(range(worlds))


def test_its_seeds_are_those_of_an_evaluation() -> None:
    some = replace(DELIVERS, seconds=150.0, start=SeededWorlds("forage", (7, 3, 11)))
    together = run_property(some, LIBRARY, FORAGE)
    for row, seed in enumerate((7, 3, 11)):
        alone = run_property(replace(some, start=SeededWorlds("forage", (seed,))), LIBRARY, FORAGE)
        assert alone.outcomes.robustness[0] == together.outcomes.robustness[row]
        assert (seed in together.failure_seeds) == bool(alone.failures)
