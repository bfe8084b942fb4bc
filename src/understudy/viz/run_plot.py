"""Plot the paths of a run into axes with scales in meters, and draw a world for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from io import StringIO
from typing import TYPE_CHECKING, Any

from understudy.sim.view import RunFrame, WorldView
from understudy.viz.axes import STYLE, make_axes, make_figure
from understudy.viz.palette import GROUND, INK, PAPER
from understudy.viz.path_png import LineStyle, draw_run, list_path_entries
from understudy.viz.sheet import draw_ground

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDE_IN, TALL_IN, LEGEND_IN = 4.6, 4.8, 1.7
"""The largest sizes of an arena on paper, and the width of the legend beside it."""
AROUND_IN = 0.7
"""The space for labels of the axes."""
WORLD_IN = 3.6
"""The longer side of a world in a notebook."""
STYLES: tuple[LineStyle, ...] = (
    "-",
    (0.0, (5.0, 1.5)),
    (0.0, (1.2, 1.2)),
    (0.0, (6.0, 1.5, 1.2, 1.5)),
    (0.0, (3.0, 1.0)),
    (0.0, (8.0, 2.0)),
    (0.0, (3.0, 1.2, 1.2, 1.2, 1.2, 1.2)),
    (0.0, (1.2, 2.4)),
)
"""The line styles of robots or activities, which tell paths apart without colors."""


def plot_run(moments: Sequence[tuple[Any, Sequence[str]]], ax: Axes | None = None) -> Axes:
    """Plot the paths of robots over moments of a run: views of a world, and what each robot was doing."""
    frames = [RunFrame(view, doing) for view, doing in moments]
    view = frames[-1].view
    wide, tall = _fit(view)
    axes = make_axes(wide + AROUND_IN + LEGEND_IN, tall + AROUND_IN) if ax is None else ax
    draw_ground(axes, view)
    _scale(axes, view)
    if ax is not None:  # in new axes of constrained layout the size is not known yet
        wide = axes.get_window_extent().width / axes.figure.dpi
    draw_run(axes, frames, inch=view.width / wide, styles=STYLES)
    axes.legend(
        handles=list_path_entries(frames, styles=STYLES),
        loc="upper left",
        bbox_to_anchor=(1.01, 1.0),
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=2.6,
        borderaxespad=0.0,
    )
    return axes


def draw_world_svg(view: WorldView) -> str:
    """Draw a world as it is now, as an SVG document without legend or scales."""
    import matplotlib as mpl

    wide, tall = _fit(view)
    shrink = WORLD_IN / max(wide, tall)
    with mpl.rc_context(STYLE):
        figure = make_figure(wide * shrink, tall * shrink)
        axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
        axes.set_axis_off()
        draw_ground(axes, view)
        axes.set(xlim=(0, view.width), ylim=(0, view.height))
        draw_run(axes, [RunFrame(view, [""] * len(view.robots))], inch=view.width / (wide * shrink))
        text = StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None}, facecolor=PAPER)
    return text.getvalue()


def _fit(view: WorldView) -> tuple[float, float]:
    """Return the size of the arena on paper, in inches."""
    inch = max(view.width / WIDE_IN, view.height / TALL_IN)
    return view.width / inch, view.height / inch


def _scale(axes: Axes, view: WorldView) -> None:
    axes.set(xlim=(0, view.width), ylim=(0, view.height), xlabel="x (m)", ylabel="y (m)", facecolor=GROUND)
    axes.set_aspect("equal")
