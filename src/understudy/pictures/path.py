"""The path of a foraging run as a PNG, colored by what the robot was doing."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from itertools import groupby, pairwise
from math import cos, dist, sin
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from understudy.errors import SettingError
from understudy.model.atomic import write
from understudy.pictures.style import FAINT, FOOD, FOOD_GONE, GROUND, INK, PAPER, STATION, colors_for
from understudy.worlds.forage_view import ForageView, Frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Point = tuple[float, float]
ARENA_IN, SIDE_IN, ABOVE_IN, BELOW_IN = 6.6, 0.3, 0.8, 0.75  # inches on paper
ARROW_EVERY_M = 2.0
LANE_M = 0.07
"""The path is drawn this far to the right of where the robot went, so that there and back stay apart."""


def path_png(frames: Sequence[Frame], path: Path | str, *, title: str = "A foraging run") -> None:
    """Draw the run: where the robot went, doing what; station, food as it was at first, start and end."""
    if not frames:
        raise SettingError(where="path picture", setting="frames", problem="are none", remedy="record a run")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    first, last = frames[0].view, frames[-1].view
    tall = ARENA_IN * last.height / last.width
    size = (ARENA_IN + 2 * SIDE_IN, tall + ABOVE_IN + BELOW_IN)
    figure = Figure(figsize=size, dpi=160, facecolor=PAPER)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((SIDE_IN / size[0], BELOW_IN / size[1], ARENA_IN / size[0], tall / size[1]))
    axes.set(xlim=(0, last.width), ylim=(0, last.height))
    axes.set_axis_off()
    colors = colors_for(frame.doing for frame in frames)
    ways = [_beside_way(frame.view) for frame in frames]
    robots = [
        (view.x + dx, view.y + dy) for view in (first, last) for dx in (-0.2, 0.2) for dy in (-0.2, 0.2)
    ]
    _things(axes, last, [*ways, *robots * len(ways)])
    _ways(axes, frames, ways, colors)
    _robot(axes, first, PAPER, INK)
    _robot(axes, last, INK, PAPER)
    brought = f"{last.delivered} of {_total(last)} units brought home in {last.time_s:.0f} s"
    left = SIDE_IN / size[0]
    figure.text(left, 1 - 0.32 / size[1], title, fontsize=14, fontweight="bold", color=INK, va="center")
    figure.text(left, 1 - 0.58 / size[1], brought, fontsize=10, color=FAINT, va="center")
    _legend(figure, axes, colors, last)
    drawn = BytesIO()
    figure.savefig(drawn, format="png")
    write(Path(path), drawn.getvalue())


def _total(view: ForageView) -> int:
    return view.delivered + view.stored + sum(source.amount for source in view.sources)


def _beside_way(view: ForageView) -> Point:
    return view.x + LANE_M * sin(view.heading), view.y - LANE_M * cos(view.heading)


def _things(axes: Axes, view: ForageView, ways: Sequence[Point]) -> None:
    from matplotlib.patches import Circle, Rectangle

    ground = Rectangle((0, 0), view.width, view.height, fc=GROUND, ec=INK, lw=2.0, zorder=0, clip_on=False)
    axes.add_patch(ground)
    spots = [(view.station, STATION, "station")]
    for x, y, amount, at_first in view.sources:
        left = f"{amount} of {at_first} units left" if amount else f"{at_first} units"
        spots.append(((x, y), FOOD, left))
        axes.add_patch(Circle((x, y), 0.1 * at_first**0.5, fc=FOOD_GONE, ec=FOOD, lw=1.2, zorder=2))
        axes.add_patch(Circle((x, y), 0.1 * amount**0.5, fc=FOOD, ec="none", zorder=2))
    x, y = view.station
    side = 0.24
    axes.add_patch(Rectangle((x - side, y - side), 2 * side, 2 * side, fc=STATION, ec="none", zorder=2))
    for at, color, name in spots:
        axes.add_patch(Circle(at, view.reach, fc="none", ec=color, lw=0.9, ls=(0, (3, 3)), zorder=1))
        _label(axes, view, at, name, color, ways)


def _label(
    axes: Axes, view: ForageView, at: Point, name: str, color: str, ways: Sequence[Point]
) -> None:  # fmt: skip
    """A label above, under or beside a thing, wherever the path passes least."""
    from matplotlib.patheffects import withStroke

    wide, off = 0.16 * len(name), view.reach + 0.25
    sides: list[tuple[Point, Literal["center", "left", "right"]]] = [
        ((at[0], at[1] - off), "center"),
        ((at[0], at[1] + off), "center"),
        ((at[0] + off - 0.1, at[1]), "left"),
        ((at[0] - off + 0.1, at[1]), "right"),
    ]
    path = np.array(ways)

    def crowded(side: tuple[Point, Literal["center", "left", "right"]]) -> tuple[bool, int]:
        (x, y), align = side
        middle = x + {"center": 0.0, "left": wide / 2, "right": -wide / 2}[align]
        outside = not (wide / 2 < middle < view.width - wide / 2 and 0.2 < y < view.height - 0.2)
        over = (np.abs(path[:, 0] - middle) < wide / 2 + 0.1) & (np.abs(path[:, 1] - y) < 0.25)
        return outside, int(over.sum())

    (x, y), align = min(sides, key=crowded)
    text = axes.text(
        x, y, name, color=color, fontsize=9.5, fontweight="bold", zorder=6, ha=align, va="center"
    )
    text.set_path_effects([withStroke(linewidth=3, foreground=GROUND)])


def _ways(axes: Axes, frames: Sequence[Frame], ways: Sequence[Point], colors: dict[str, str]) -> None:
    """The way, a stretch per doing, each beginning where the one before ended; arrows show the direction."""
    at = 0
    for doing, stretch in groupby(frames, key=lambda frame: frame.doing):
        until = at + len(list(stretch))
        xs, ys = np.array(ways[max(0, at - 1) : until]).T
        axes.plot(xs, ys, color=colors[doing], lw=1.7, zorder=4, solid_capstyle="round")
        at = until
    travelled = 0.5 * ARROW_EVERY_M
    for (one, other), way in zip(pairwise(frames), ways[1:], strict=True):
        travelled += dist(one.view[5:7], other.view[5:7])
        if travelled >= ARROW_EVERY_M:
            travelled = 0.0
            _arrow(axes, way, other.view.heading, colors[other.doing])


def _arrow(axes: Axes, at: Point, heading: float, color: str) -> None:
    from matplotlib.patches import Polygon

    corners = [(0.17, 0.0), (-0.11, 0.11), (-0.05, 0.0), (-0.11, -0.11)]
    turned = [(x * cos(heading) - y * sin(heading), x * sin(heading) + y * cos(heading)) for x, y in corners]
    axes.add_patch(Polygon([(at[0] + x, at[1] + y) for x, y in turned], fc=color, ec="none", zorder=5))


def _robot(axes: Axes, view: ForageView, fill: str, mark: str) -> None:
    from matplotlib.patches import Circle

    axes.add_patch(Circle((view.x, view.y), view.radius, fc=fill, ec=INK, lw=1.6, zorder=7))
    nose = (view.x + view.radius * cos(view.heading), view.y + view.radius * sin(view.heading))
    axes.plot([view.x, nose[0]], [view.y, nose[1]], color=mark, lw=1.6, zorder=8)


def _legend(figure: Figure, axes: Axes, colors: dict[str, str], view: ForageView) -> None:
    from matplotlib.lines import Line2D

    meter = 2.0 if view.width >= 6.0 else 1.0
    below = -0.33 * view.width / ARENA_IN  # m
    ends = [view.width - meter, view.width]
    axes.plot(ends, [below, below], color=INK, lw=2.2, solid_capstyle="butt", clip_on=False)
    axes.text(ends[0] - 0.12, below, f"{meter:g} m", ha="right", va="center", fontsize=9.5, color=INK)
    entries = [Line2D([], [], color=color, lw=2.6, label=doing) for doing, color in colors.items()]
    entries.append(Line2D([], [], marker="o", ls="", mfc=PAPER, mec=INK, mew=1.4, ms=8, label="start"))
    entries.append(Line2D([], [], marker="o", ls="", mfc=INK, mec=INK, ms=8, label="end"))
    entries.append(Line2D([], [], color=FAINT, lw=0.9, ls=(0, (3, 3)), label="within reach"))
    wide, tall = figure.get_size_inches()
    axes.legend(
        handles=entries,
        loc="center left",
        bbox_to_anchor=(SIDE_IN / wide, (BELOW_IN - 0.33) / tall),
        bbox_transform=figure.transFigure,
        ncols=4 if len(entries) > 5 else len(entries),
        frameon=False,
        fontsize=9.5,
        labelcolor=INK,
        borderpad=0.0,
        borderaxespad=0.0,
        columnspacing=1.4,
        handlelength=1.5,
    )
