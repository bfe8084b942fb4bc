"""The criteria of a novice's success, and the share of novices who meet them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from understudy.judging.intervals import interval_of_share
from understudy_lab.novices.traits import SUCCESS
from understudy_lab.rows import Count, Rows
from understudy_lab.study import Row
from understudy_lab.tasks.soccer import POSITIONS
from understudy_lab.teachers.live_teacher import LIVE

TRIALS = 10
"""The number of trials from each of the paper's three positions."""


def has_succeeded(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least half of all its trials."""
    return bool(row["reached"] >= SUCCESS * TRIALS * len(POSITIONS))


def succeeds_everywhere(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least half of the trials from each position."""
    return all(reaches(row, position) for position in POSITIONS)


def reaches(row: Row, position: str) -> bool:
    """Return whether the robot reaches the ball in at least half of the trials from one position."""
    return len(times(row, position)) >= SUCCESS * TRIALS


def times(row: Row, position: str) -> list[float]:
    """Return the seconds of the successful trials from one position."""
    return [each for each in row["times"][position] if each is not None and each == each]


def succeeds_nearly_always(row: Row) -> bool:
    """Return whether the robot reaches the ball in at least 90 % of all its trials."""
    return bool(row["reached"] >= 0.9 * TRIALS * len(POSITIONS))


def select_unchanged(rows: Sequence[Row]) -> Rows:
    """Return the rows of the paper's training without a changed parameter."""
    return Rows(rows).where(trait=None, method=None)


def select_live(rows: Sequence[Row]) -> Rows:
    """Return the rows of live teaching."""
    return Rows(rows).where(method=LIVE)


def share(rows: Sequence[Row], well: Callable[[Row], bool] = has_succeeded) -> dict[str, Any]:
    """Return how many novices succeed, with the 95 % interval of the share."""
    count, of = sum(map(well, rows)), len(rows)
    low, high = interval_of_share(count, of)
    return {"succeed": count, "of": of, "low": round(low, 4), "high": round(high, 4)}


def summarize_both_readings(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return `share` by both criteria of success."""
    return {"half": share(rows), "everywhere": share(rows, succeeds_everywhere)}


def format_succeeding(rows: Rows, well: Callable[[Row], bool] = has_succeeded) -> str:
    """Format how many novices succeed, with the 95 % interval of the share."""
    return Count(well, interval=True)(rows) if rows else "none"
