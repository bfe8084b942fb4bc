"""What follows from the rows: each variant beside the one it is set against."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from understudy.experiments.experiment import Findings, Row


def conclude(rows: Sequence[Row]) -> Findings:
    """Stub."""
    return Findings("To come.")


def draw(rows: Sequence[Row]) -> Figure:
    """Stub."""
    return Figure()
