"""The paired comparison of two evaluations in the same worlds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.judging.evaluation import Evaluation, name_measure
from understudy.judging.intervals import MedianEstimate, find_median
from understudy.judging.paired_tests import (
    SignedRankTest,
    compare_signed_ranks,
    compute_mcnemar_p,
    interval_of_paired_difference,
)
from understudy.judging.raised_range import describe_raised
from understudy.judging.result_table import MARKDOWN, Cell, Limits, Probability, Share, format_table
from understudy.model.value_kinds import Column

NO_DIFFERENCE = {"seed", "success", "limit_s", "expert_seconds"}
"""Results that are not compared as numbers."""


@dataclass(frozen=True, slots=True)
class SuccessComparison:
    """The success of two behaviors in the same worlds."""

    first: float
    """The share of worlds in which the first succeeded."""
    second: float
    """The share of worlds in which the second succeeded."""
    only_first: int
    """The number of worlds in which only the first succeeded."""
    only_second: int
    """The number of worlds in which only the second succeeded."""
    difference: float
    """The effect size: the second share minus the first."""
    interval: tuple[float, float]
    """The 95 % interval of the difference for pairs (Bonett and Price 2012)."""
    p: float
    """The two-sided p-value of McNemar's exact test."""


@dataclass(frozen=True, slots=True)
class MetricComparison:
    """A metric of two behaviors in the worlds in which both have it."""

    first: float
    """The median of the first; NaN if there is no such world."""
    second: float
    """The median of the second."""
    difference: MedianEstimate
    """The median of the differences, second minus first, with its 95 % interval."""
    test: SignedRankTest
    """The signed-rank test, with the matched-pairs rank-biserial correlation as effect size; positive where the second
    is larger."""


@dataclass(frozen=True, repr=False)
class Comparison:
    """Two behaviors, or two libraries, in the same worlds.

    Parameters
    ----------
    first
        The first evaluation.
    second
        The second one, in the same worlds.
    success
        The comparison of their success.
    metrics
        The comparison of each metric that both have, and of `seconds`, by name. Time is compared in worlds in which
        both finished.
    """

    first: Evaluation
    second: Evaluation
    success: SuccessComparison
    metrics: Mapping[str, MetricComparison]

    def __repr__(self) -> str:
        names = f"{self.first.behavior!r} and {self.second.behavior!r} in {len(self.first.seeds)} worlds"
        low, high = self.success.interval
        return (
            f"<Comparison of {names}: success {self.success.difference:+.0%} "
            f"[{low:+.0%}, {high:+.0%}], p = {self.success.p:.2g}>"
        )

    def describe(self) -> str:
        """Return what the table of the comparison shows, as a caption.

        Returns
        -------
        str
            A few sentences.
        """
        behaviors = [each.behavior for each in (self.first, self.second)]
        which = behaviors[0] if behaviors[0] == behaviors[1] else " and ".join(behaviors)
        raised = [describe_raised(each.flag, each.raised) for each in (self.first, self.second)]
        is_known = self.first.raised is not None or self.second.raised is not None
        where = (
            f" The first: {raised[0] or 'no flag'}; the second: {raised[1] or 'no flag'}." if is_known else ""
        )
        return (
            f"{which} in the same {len(self.first.seeds)} worlds of {self.first.world}.{where} Numbers are medians "
            "over the worlds in which both have one, and medians of differences. Success: McNemar's exact test; "
            "numbers: Wilcoxon's signed-rank test, with the matched-pairs rank-biserial correlation as effect."
        )

    def to_table(self, layout: str = MARKDOWN, *, names: tuple[str, str] = ("first", "second")) -> str:
        """Make a table of both results, their differences with 95 % intervals, p-values and effect sizes.

        Parameters
        ----------
        layout
            "markdown", "latex" (a tabular that needs no package) or "csv".
        names
            The titles of the two columns of results.

        Returns
        -------
        str
            The text of the table. The effect size of success is the difference itself; that of numbers is the
            matched-pairs rank-biserial correlation.

        Raises
        ------
        SettingError
            If there is no such layout.
        """
        titles, rows = self.list_rows(layout, names=names)
        return format_table(titles, rows, layout, caption=self.describe())

    def list_rows(
        self, layout: str = MARKDOWN, *, names: tuple[str, str] = ("first", "second")
    ) -> tuple[list[str], list[list[Cell]]]:
        """List the titles and the rows of the table, for a layout of one's own.

        Parameters
        ----------
        layout
            The layout whose names of measures are wanted.
        names
            The titles of the two columns of results.

        Returns
        -------
        tuple
            The titles, and the cells of each row, which `format_cell` formats.
        """
        success = self.success
        rows: list[list[Cell]] = [
            [
                "success",
                Share(success.first),
                Share(success.second),
                Share(success.difference),
                Limits(*success.interval, percent=True),
                Probability(success.p),
                nan,
                len(self.first.seeds),
            ]
        ]
        for name, each in self.metrics.items():
            difference, test = each.difference, each.test
            rows.append(
                [
                    name_measure(name, layout),
                    each.first,
                    each.second,
                    difference.median,
                    Limits(difference.low, difference.high),
                    Probability(test.p),
                    test.rank_biserial,
                    test.pairs,
                ]
            )
        titles = ["measure", *names, "difference", "95 % interval", "p", "effect", "pairs"]
        return titles, rows


def compare(first: Evaluation, second: Evaluation) -> Comparison:
    """Compare two evaluations in the same worlds, pair by pair.

    Success is compared by McNemar's exact test, numbers by the signed-rank test. There is no correction for the number
    of tests.

    Parameters
    ----------
    first
        The evaluation of one behavior or library.
    second
        That of another one, with the same seeds in the same scenario.

    Returns
    -------
    Comparison
        Differences (second minus first), their intervals, p-values and effect sizes.

    Raises
    ------
    SettingError
        If the seeds, the worlds or their time limits differ.
    """
    _check_pairs(first, second)
    before, after = first.taught.finished, second.taught.finished
    only_first, only_second = int((before & ~after).sum()), int((after & ~before).sum())
    success = SuccessComparison(
        first.success,
        second.success,
        only_first,
        only_second,
        (only_second - only_first) / len(before),
        interval_of_paired_difference(only_first, only_second, len(before)),
        compute_mcnemar_p(only_first, only_second),
    )
    ones, others = first.columns, second.columns
    both = [name for name in ones if name in others and name not in NO_DIFFERENCE]
    metrics = {name: _compare_metric(ones[name], others[name]) for name in both if _says(ones, others, name)}
    return Comparison(first, second, success, metrics)


def _says(ones: Mapping[str, NDArray[Any]], others: Mapping[str, NDArray[Any]], name: str) -> bool:
    """Return whether a result is worth comparing: counts of food and boxes only where there are any."""
    return name not in ("delivered", "gathered") or bool(ones[name].any() or others[name].any())


def _check_pairs(first: Evaluation, second: Evaluation) -> None:
    if first.world != second.world:
        problem = f"is of {second.world}, and the first of {first.world}"
        raise _wrong("second evaluation", problem, "evaluate both in the same worlds")
    if first.seeds != second.seeds:
        differing = sorted(set(first.seeds) ^ set(second.seeds))
        which = f", such as {differing[0]}" if differing else " in their order"
        raise _wrong("seeds", f"differ{which}", "evaluate both with the same seeds")
    apart = np.flatnonzero(first.taught.limit_s != second.taught.limit_s)
    if len(apart):
        row = apart[0]
        limits = [f"{each.taught.limit_s[row]:g}" for each in (first, second)]
        problem = f"differ: {limits[0]} and {limits[1]} s in the world of seed {first.seeds[row]}"
        raise _wrong("time limits", problem, "evaluate both with the same goal and limit_s")


def _compare_metric(first: Column, second: Column) -> MetricComparison:
    present = ~np.isnan(first) & ~np.isnan(second)
    one, other = first[present].astype(np.float64), second[present].astype(np.float64)
    differences = other - one
    return MetricComparison(
        find_median(one).median,
        find_median(other).median,
        find_median(differences),
        compare_signed_ranks(differences),
    )


def _wrong(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="comparison", setting=setting, problem=problem, remedy=remedy)
