"""Figures of experiments in one style: a dot for every taught automaton, a line at the median."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.rows import Groups, Rows, Value
from understudy_lab.study import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLORS = ("#2563a8", "#c8651b", "#3b8a57", "#8a4fa3", "#a8323e", "#6b7280", "#9a7b16")
STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "svg.hashsalt": "understudy",
    "svg.fonttype": "none",
}


def dots(axes: Axes, groups: Mapping[str, Sequence[float]], label: str) -> None:
    """Draw a column of dots per group, one for each automaton, with a line at the median; a group may be empty."""
    for at, (values, color) in enumerate(zip(groups.values(), COLORS * len(groups), strict=False)):
        numbers = np.asarray(values, np.float64)
        if len(numbers) == 0:
            continue
        aside = at + 0.3 * _fanned(numbers)
        axes.plot(aside, numbers, "o", color=color, markersize=4, alpha=0.6, markeredgewidth=0)
        axes.hlines(np.median(numbers), at - 0.35, at + 0.35, color=color, linewidth=2)
    axes.set_xticks(range(len(groups)), list(groups))
    axes.set_xlim(-0.6, len(groups) - 0.4)
    axes.set_ylabel(label)


@dataclass(frozen=True)
class Dots:
    """A panel with a column of dots per group, its title, and what the dots show."""

    title: str
    said: str
    groups: Callable[[Any], Mapping[str, Sequence[float]]]
    limits: tuple[float | None, float | None] | None = None
    """The limits of the vertical axis; None: those of the dots."""
    dotted: float | None = None
    """The height of a dotted line."""

    def __call__(self, axes: Axes, summary: Any) -> None:
        """Draw the panel."""
        dots(axes, self.groups(summary), self.said)
        if self.dotted is not None:
            axes.axhline(self.dotted, color="#6b7280", linewidth=0.8, linestyle=":")
        axes.set_title(self.title)
        if self.limits is not None:
            axes.set_ylim(*self.limits)


def by_group(groups: Groups, of: Value, scale: float = 1.0) -> Callable[[Any], dict[str, list[float]]]:
    """Return a function that returns one value of all rows of each group."""
    return lambda summary: {
        name: [scale * value for value in rows.values(of)] for name, rows in groups(summary).items()
    }


def by_value(labels: Mapping[Any, str], scale: float = 1.0) -> Callable[[Any], dict[str, list[float]]]:
    """Return a function that returns several values of the same rows, by their labels."""
    return lambda rows: {label: [scale * value for value in rows.values(of)] for of, label in labels.items()}


@dataclass(frozen=True)
class Panels:
    """A figure of panels, each drawn by a function of what `prepare` makes of all rows; sizes are in inches."""

    panels: Sequence[Callable[[Axes, Any], None]]
    rows: int = 1
    wide: float = 3.4
    tall: float = 2.8
    prepare: Callable[[Rows], Any] = Rows

    def __call__(self, rows: Sequence[Row]) -> Figure:
        """Draw the figure."""
        import matplotlib as mpl
        from matplotlib.figure import Figure

        columns, summary = -(-len(self.panels) // self.rows), self.prepare(Rows(rows))
        with mpl.rc_context(STYLE):
            size = self.wide * columns, self.tall * self.rows
            figure = Figure(figsize=size, layout="constrained")
            axes = [figure.add_subplot(self.rows, columns, k + 1) for k in range(len(self.panels))]
        for each, draw in zip(axes, self.panels, strict=True):
            draw(each, summary)
        return figure


def _fanned(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Return a sideways offset for each dot, from -1 to 1, so that equal values do not overlap."""
    order = np.argsort(values, kind="stable")
    steps = np.array([0.0, 0.5, -0.5, 1.0, -1.0, 0.25, -0.25, 0.75, -0.75])
    aside = np.empty(len(values))
    aside[order] = steps[np.arange(len(values)) % len(steps)]
    return aside


def save(figure: Figure, path: Path) -> None:
    """Write a figure as SVG or PNG, by the file's ending; the same figure gives the same file."""
    import matplotlib as mpl

    path.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE):
        figure.savefig(path, dpi=150, metadata={"Date": None} if path.suffix == ".svg" else None)
