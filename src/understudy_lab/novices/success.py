"""When a novice has succeeded, and how many did."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from understudy.analysis.evaluation import interval_of_share
from understudy_lab.novices.traits import SUCCESS
from understudy_lab.study import Row
from understudy_lab.tasks.soccer import POSITIONS

TRIALS = 10
"""From each of the paper's three positions."""


def has_succeeded(row: Row) -> bool:
    """Whether the robot gets to the ball in half of its trials at least."""
    return bool(row["reached"] >= SUCCESS * TRIALS * len(POSITIONS))


def succeeds_everywhere(row: Row) -> bool:
    """Whether it does so in half of the trials from each position: a stricter reading, told beside."""
    return all(reaches(row, position) for position in POSITIONS)


def reaches(row: Row, position: str) -> bool:
    """Whether it does so in half of the trials from a position."""
    return len(times(row, position)) >= SUCCESS * TRIALS


def times(row: Row, position: str) -> list[float]:
    """The seconds of the trials from a position that reach the ball."""
    return [each for each in row["times"][position] if each is not None and each == each]


def select_unchanged(rows: Sequence[Row]) -> list[Row]:
    """Those of the novices as they are."""
    return [row for row in rows if "trait" not in row["task"]]


def share(rows: Sequence[Row], well: Callable[[Row], bool] = has_succeeded) -> dict[str, Any]:
    """How many of them succeed, with the 95 % interval of the share."""
    count, of = sum(map(well, rows)), len(rows)
    low, high = interval_of_share(count, of)
    return {"succeed": count, "of": of, "low": round(low, 4), "high": round(high, 4)}


def summarize_both_readings(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """`share` by either reading of success."""
    return {"half": share(rows), "everywhere": share(rows, succeeds_everywhere)}


def format_share(found: Mapping[str, Any]) -> str:
    """A share in words."""
    if not found["of"]:
        return "none"
    return f"{found['succeed']} of {found['of']} ({100 * found['low']:.0f}–{100 * found['high']:.0f} %)"
