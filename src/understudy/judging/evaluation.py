"""The results of a behavior in many worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.judging.intervals import MedianEstimate, exact_interval_of_share, find_median
from understudy.judging.outcomes import Outcomes
from understudy.judging.raised_range import RaisedRange, describe_raised
from understudy.judging.result_table import CSV, MARKDOWN, Cell, Limits, Share, format_table
from understudy.model.data_frames import make_frame
from understudy.model.drawing import Axes, call_markup, call_plot
from understudy.model.value_kinds import Column

MEASURES = {"seconds": "time to finish (s)", "relative": "relative food per second"}
"""The results whose names are written out in tables for people."""


RESULTS = ("seed", "success", "seconds", "limit_s", "delivered", "gathered", "expert_seconds", "relative")
"""The names of the results that each world has, which metrics cannot have."""


def name_measure(name: str, layout: str) -> str:
    """Return the name of a result in a table."""
    return name if layout == CSV else MEASURES.get(name, name)


@dataclass(frozen=True, repr=False)
class Evaluation:
    """The results of a behavior in N worlds, and those of the baseline in the same worlds.

    Parameters
    ----------
    behavior
        Name of the behavior.
    world
        Name of the scenario, or of the function that makes the bodies.
    seeds
        Seed of each world.
    taught
        Results of the behavior.
    expert
        Results of the baseline. None if the scenario has none, or success was judged by a flag or a goal of one's own.
    flag
        Name of the flag that counted as success. None: a goal did.
    goal
        Name of the reading or function that counted as success. None: the flag or the scenario's goal did.
    metrics
        Each metric's value in every world [N], by name; NaN where it is absent.
    problems
        One sentence for each value of a metric that is absent because it could not be computed.
    simulated
        Whether the worlds are those of a scenario. If not, bodies of one's own were run, which deliver and gather
        nothing.
    raised
        Where the flag was raised, beside where it was shown. None: success is no flag, or its presses have nothing in
        common.
    """

    behavior: str
    world: str
    seeds: tuple[int, ...]
    taught: Outcomes
    expert: Outcomes | None
    flag: str | None = None
    goal: str | None = None
    metrics: Mapping[str, Column] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    simulated: bool = True
    raised: RaisedRange | None = None

    def __repr__(self) -> str:
        count = f"{int(self.taught.finished.sum())} of {len(self.seeds)} worlds"
        names = f", metrics {', '.join(self.metrics)}" if self.metrics else ""
        raised = "" if self.raised is None else f"; {self.raised.describe()}"
        return f"<Evaluation of {self.behavior!r} in {self.world}: success in {count}{names}{raised}>"

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_evaluation_html", self, exact_interval_of_share)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the share of worlds that had finished by each time, with exact 95 % intervals.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes: time in s to the right, share of worlds upward.
        """
        return call_plot("evaluation_plot:plot_evaluation", self, exact_interval_of_share, ax)

    @property
    def success(self) -> float:
        """The share of worlds that finished in time, from 0 to 1."""
        return self.taught.success

    @property
    def success_interval(self) -> tuple[float, float]:
        """The exact 95 % interval of the success rate (Clopper and Pearson 1934)."""
        return exact_interval_of_share(int(self.taught.finished.sum()), len(self.seeds))

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """All results as columns [N], by name, with the metrics last.

        They are `seed`, `success`, `seconds` (s, NaN if the world did not finish) and `limit_s` (s); in scenarios also
        `delivered` and `gathered`; where there is a baseline also `expert_seconds` (s) and `relative`.
        """
        columns: dict[str, NDArray[Any]] = {
            "seed": np.array(self.seeds, np.int64),
            "success": self.taught.finished,
            "seconds": self.taught.seconds,
            "limit_s": self.taught.limit_s,
        }
        if self.simulated:
            columns |= {"delivered": self.taught.delivered, "gathered": self.taught.gathered}
        if self.expert is not None:
            columns |= {"expert_seconds": self.expert.seconds, "relative": self.relative}
        return columns | dict(self.metrics)

    @property
    def relative(self) -> Column:
        """The behavior's food per second divided by the baseline's [N].

        It is NaN without a baseline, and in worlds where the baseline delivers no food.
        """
        absent = np.full(len(self.seeds), np.nan)
        if self.expert is None:
            return absent
        expert = self.expert.food_per_s
        ratio: Column = np.divide(self.taught.food_per_s, expert, out=absent, where=expert > 0)
        return ratio

    @property
    def relative_to_expert(self) -> float:
        """The median of `relative` over the worlds in which it is not NaN; NaN if it is NaN in all."""
        present = self.relative[~np.isnan(self.relative)]
        return float(np.median(present)) if len(present) else float("nan")

    @property
    def medians(self) -> dict[str, MedianEstimate]:
        """The median of each number in the worlds that have it, with its 95 % interval (order statistics), by name.

        `seconds` counts the worlds that finished. `delivered` and `gathered` are there if they are not 0 everywhere.
        """
        medians = {"seconds": find_median(self.taught.seconds)}
        if self.expert is not None:
            medians |= {"relative": find_median(self.relative)}
        for name, counts in (("delivered", self.taught.delivered), ("gathered", self.taught.gathered)):
            if counts.any():
                medians[name] = find_median(counts.astype(np.float64))
        return medians | {name: find_median(column) for name, column in self.metrics.items()}

    def describe(self) -> str:
        """Return in words what was evaluated, when a world counted as a success, and where the flag was raised.

        Returns
        -------
        str
            The sentence.
        """
        judged = self.flag or self.goal
        wanted = f"{judged} in time" if judged is not None else "goal reached in time"
        wanted = f"that it {judged}" if judged is not None and " " in judged else wanted  # a chosen goal
        raised = describe_raised(self.flag, self.raised)
        where = f" ({raised})" if raised else ""
        return f"{self.behavior} in {len(self.seeds)} worlds of {self.world}; success is {wanted}{where}."

    def to_table(self, layout: str = MARKDOWN) -> str:
        """Make a table of the success rate and of all medians, with their exact 95 % intervals.

        Parameters
        ----------
        layout
            "markdown", "latex" (a tabular that needs no package) or "csv".

        Returns
        -------
        str
            The text of the table. In CSV, the success rate is from 0 to 1, and numbers have all their digits.

        Raises
        ------
        SettingError
            If there is no such layout.
        """
        rows: list[list[Cell]] = [
            ["success", Share(self.success), Limits(*self.success_interval, percent=True), len(self.seeds)]
        ]
        rows += [
            [name_measure(name, layout), each.median, Limits(each.low, each.high), each.count]
            for name, each in self.medians.items()
        ]
        titles = ["measure", "value", "95 % interval", "worlds"]
        caption = f"{self.describe()} Numbers are medians over the worlds that have one."
        return format_table(titles, rows, layout, caption=caption)

    def to_frame(self, *, backend: str | None = None) -> Any:
        """Make a data frame of the results, with a row for each world and the columns of `columns`.

        Parameters
        ----------
        backend
            The package that makes it: "polars", "pandas" or "pyarrow". None: the first of them that is installed.

        Returns
        -------
        DataFrame or Table
            A frame of that package. Times are in s. What is NaN here is absent there.

        Raises
        ------
        ExtraMissing
            If narwhals is not installed.
        SettingError
            If the package is not installed, or is another one.
        """
        cells = {name: column.tolist() for name, column in self.columns.items()}
        types = {name: type(column[0]) for name, column in cells.items()}
        absent = {name: [None if cell != cell else cell for cell in column] for name, column in cells.items()}
        return make_frame(absent, types, backend=backend)


def join_evaluations(parts: Sequence[Evaluation]) -> Evaluation:
    """Join evaluations of one behavior in different worlds, in order."""
    first = parts[0]
    experts = [part.expert for part in parts if part.expert is not None]
    return replace(
        first,
        seeds=tuple(seed for part in parts for seed in part.seeds),
        taught=Outcomes.concatenate([part.taught for part in parts]),
        expert=Outcomes.concatenate(experts) if experts else None,
        metrics={name: np.concatenate([part.metrics[name] for part in parts]) for name in first.metrics},
        problems=tuple(problem for part in parts for problem in part.problems),
        raised=_join_raised(parts),
    )


def _join_raised(parts: Sequence[Evaluation]) -> RaisedRange | None:
    ranges = [part.raised for part in parts if part.raised is not None]
    return RaisedRange.concatenate(ranges) if ranges else None
