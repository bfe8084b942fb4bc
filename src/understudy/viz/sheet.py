"""Make the figure of a picture on paper: title above, the arena, a legend and a scale bar below."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10
from typing import TYPE_CHECKING

from understudy.sim.view import WorldView
from understudy.viz.palette import FAINT, GROUND, INK, PAPER

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDE_IN, TALL_IN, LEAST_IN = 6.6, 8.4, 4.6  # of the arena on paper: at most, and of what is written around it
SIDE_IN, ABOVE_IN, BELOW_IN, ROW_IN = 0.3, 0.8, 0.52, 0.21
DPI = 160


class FigureSheet:
    """A figure with axes for the arena of a world; `inch` is the length (m) that one inch on paper shows."""

    def __init__(self, view: WorldView, title: str, subtitle: str, entries: Sequence[Artist]) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.inch = max(view.width / WIDE_IN, view.height / TALL_IN)
        wide, tall = view.width / self.inch, view.height / self.inch
        written = max(wide, LEAST_IN)
        page = written + 2 * SIDE_IN
        self.figure = Figure(figsize=(page, 1.0), dpi=DPI, facecolor=PAPER)
        FigureCanvasAgg(self.figure)
        meter = choose_scale_length(view.width * min(1.0, written / wide))
        rows = _legend(self.figure, entries, written - meter / self.inch - 0.75)
        below = BELOW_IN + ROW_IN * max(rows - 1, 0)
        size = (page, tall + ABOVE_IN + below)
        self.figure.set_size_inches(size)
        left = (page - wide) / 2
        self.axes = self.figure.add_axes((left / page, below / size[1], wide / page, tall / size[1]))
        self.axes.set(xlim=(0, view.width), ylim=(0, view.height))
        self.axes.set_axis_off()
        draw_ground(self.axes, view)
        for text, down, points, color, weight in (
            (title, 0.32, 14, INK, "bold"),
            (subtitle, 0.58, 10, FAINT, "normal"),
        ):
            self.figure.text(
                SIDE_IN / page,
                1 - down / size[1],
                text,
                fontsize=points,
                fontweight=weight,
                color=color,
                va="center",
            )
        self._scale(meter, page - SIDE_IN, below - 0.33)

    def _scale(self, meter: float, right: float, up: float) -> None:
        from matplotlib.lines import Line2D

        wide, tall = self.figure.get_size_inches()
        ends = (right - meter / self.inch, right)
        bar = Line2D([end / wide for end in ends], [up / tall] * 2, color=INK, lw=2.2, solid_capstyle="butt")
        self.figure.add_artist(bar)
        self.figure.text(
            (ends[0] - 0.066) / wide,
            up / tall,
            f"{meter:g} m",
            ha="right",
            va="center",
            fontsize=9.5,
            color=INK,
        )


def choose_scale_length(width: float) -> float:
    """Return a round length (1, 2 or 5 times a power of 10) of about a sixth of a width."""
    power = 10.0 ** floor(log10(width / 6))
    return max(step * power for step in (1, 2, 5) if step * power <= width / 6 * 1.001)


def draw_ground(axes: Axes, view: WorldView) -> None:
    """Draw the arena's floor and its outer walls."""
    from matplotlib.patches import Rectangle

    axes.add_patch(
        Rectangle((0, 0), view.width, view.height, fc=GROUND, ec=INK, lw=2.0, zorder=0, clip_on=False)
    )


def _legend(figure: Figure, entries: Sequence[Artist], wide: float) -> int:
    """Add a legend with as many columns as fit into a width (inches); return its number of rows."""
    for columns in range(min(len(entries), 6), 0, -1):
        rows = -(-len(entries) // columns)
        legend = figure.legend(
            handles=entries,
            loc="upper left",
            bbox_to_anchor=(SIDE_IN, BELOW_IN - 0.33 + 0.11 + ROW_IN * (rows - 1)),
            bbox_transform=figure.dpi_scale_trans,
            ncols=columns,
            frameon=False,
            fontsize=9.5,
            labelcolor=INK,
            borderpad=0.0,
            borderaxespad=0.0,
            columnspacing=1.4,
            handlelength=1.5,
        )
        if columns == 1 or legend.get_window_extent().width / figure.dpi <= wide:
            return rows
        legend.remove()
    return 0
