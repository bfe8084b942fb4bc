"""A comparison of live teaching with the paper's training: the same tasks, paired by seed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, StudyGoal
from understudy_lab.teachers.live_teacher import LIVE

LIVE_TEACHINGS = 5
"""The number of teachings of a team that are also taught live."""
MOST_EXAMPLES = 0.6
"""The largest share of the examples of the paper's training, median over teachings."""
CLOSE = 0.02
"""The largest loss in a measure between 0 and 1, median over teachings."""

Measure = Callable[[Row], float]
"""A function that returns one result of a teaching."""


def is_live(row: Row) -> bool:
    """Return whether a row is of a teaching that was taught live."""
    return bool(row["task"].get("method") == LIVE)


def pair_by_seed(live: Sequence[Row], others: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Return each live teaching with the other teaching of the same seed."""
    by_seed = {row["task"]["seed"]: row for row in others}
    return [(row, by_seed[row["task"]["seed"]]) for row in live if row["task"]["seed"] in by_seed]


def make_live_table(
    pairs: Sequence[tuple[Row, Row]], examples: Measure, results: Mapping[str, Measure]
) -> ResultTable:
    """Return the table of examples and of results in percent, taught live and by the paper's training."""
    live, others = zip(*pairs, strict=True)
    seeds = [row["task"]["seed"] for row in live]
    measures = [("examples", examples, False), *((name, of, True) for name, of in results.items())]
    cells = [
        (
            name,
            *(
                format_median([of(row) for row in rows], int(percent), percent=percent)
                for rows in (live, others)
            ),
        )
        for name, of, percent in measures
    ]
    share = format_median(share_examples(pairs, examples), 2)
    return ResultTable(
        f"Taught live, and by the paper's training with the same seeds, {seeds[0]} to {seeds[-1]}: median (smallest–"
        "largest)",
        ("", "#taught live", "#the paper's training"),
        [*cells[:1], ("examples, relative to the paper's training", share, "1"), *cells[1:]],
    )


def share_examples(pairs: Sequence[tuple[Row, Row]], examples: Measure) -> list[float]:
    """Return the examples of each live teaching relative to those of the paper's training."""
    return [examples(live) / examples(other) for live, other in pairs]


def make_live_goals(
    pairs: Sequence[tuple[Row, Row]], examples: Measure, results: Mapping[str, Measure]
) -> list[StudyGoal]:
    """Return the goals of live teaching: at most 60 % of the examples, and results that are hardly worse."""
    share = float(np.median(share_examples(pairs, examples)))
    goals = [
        StudyGoal(
            "taught live: examples, relative to the paper's training",
            f"at most {MOST_EXAMPLES}",
            f"{share:.2f}",
            share <= MOST_EXAMPLES,
        )
    ]
    for name, of in results.items():
        apart = float(np.median([of(live) - of(other) for live, other in pairs]))
        goals.append(
            StudyGoal(
                f"taught live: {name}, difference in points",
                f"at least -{100 * CLOSE:.0f}",
                f"{100 * apart:+.1f}",
                apart >= -CLOSE,
            )
        )
    return goals
