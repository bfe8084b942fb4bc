"""A comparison of live teaching with the paper's training: the same tasks, paired by seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from understudy_lab.declaration import Goal
from understudy_lab.rows import Median, Rows, Value, read_value
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, StudyGoal
from understudy_lab.teachers.live_teacher import LIVE

LIVE_TEACHINGS = 5
"""The number of teachings of a team that are also taught live."""
MOST_EXAMPLES = 0.6
"""The largest share of the examples of the paper's training, median over teachings."""
CLOSE = 0.02
"""The largest loss in a measure between 0 and 1, median over teachings."""

Pairs: TypeAlias = tuple[Rows, Rows]
"""The live teachings, and those by the paper's training with the same seeds."""


@dataclass(frozen=True)
class LiveComparison:
    """What live teaching takes and gives, compared with the paper's training.

    Parameters
    ----------
    examples
        The number of examples of a teaching.
    results
        Its results, from 0 to 1, by their names.
    """

    examples: Value
    results: Mapping[str, Value]

    def pair(self, rows: Rows) -> Pairs:
        """Find the live teachings, and the other one of each."""
        by_task = {tuple(row["task"].items()): row for row in rows.where(method=None)}
        pairs = [
            (row, other)
            for row in rows.where(method=LIVE)
            if (other := by_task.get(tuple(_list_others(row)))) is not None
        ]
        return Rows(live for live, _ in pairs), Rows(other for _, other in pairs)

    def make_table(self, pairs: Pairs) -> ResultTable:
        """Return the table of examples and of results in percent, by both ways."""
        share = format_median(self._compare(pairs, self.examples, np.divide), 2)
        cells = {"examples": Median(self.examples)}
        cells |= {name: Median(of, 1, percent=True) for name, of in self.results.items()}
        lines = [(name, *map(cell, pairs)) for name, cell in cells.items()]
        return ResultTable(
            f"Taught live, and by the paper's training with the same seeds, {pairs[0].seed_range}: median (smallest–"
            "largest)",
            ("", "#taught live", "#the paper's training"),
            [lines[0], ("examples, relative to the paper's training", share, "1"), *lines[1:]],
        )

    def list_goals(self, pairs: Pairs) -> list[StudyGoal]:
        """Return the goals: at most 60 % of the examples, and results that are hardly worse."""
        fewer = Goal(
            "taught live: examples, relative to the paper's training",
            lambda pairs: float(np.median(self._compare(pairs, self.examples, np.divide))),
            most=MOST_EXAMPLES,
            form=".2f",
            wanted=f"at most {MOST_EXAMPLES}",
        )
        return [fewer(pairs), *(self._judge(name, of, pairs) for name, of in self.results.items())]

    def _judge(self, name: str, of: Value, pairs: Pairs) -> StudyGoal:
        apart = float(np.median(self._compare(pairs, of, np.subtract)))
        what, wanted = f"taught live: {name}, difference in points", f"at least -{100 * CLOSE:.0f}"
        return StudyGoal(what, wanted, f"{100 * apart:+.1f}", apart >= -CLOSE)

    def _compare(self, pairs: Pairs, of: Value, how: np.ufunc) -> list[float]:
        return [
            float(how(read_value(live, of), read_value(other, of)))
            for live, other in zip(*pairs, strict=True)
        ]


def _list_others(row: Row) -> Iterable[tuple[str, object]]:
    return ((key, value) for key, value in row["task"].items() if key != "method")
