"""The ways of robots on paper: lines with arrows for a few, faint trails for a crowd."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from understudy.sim.view import Frame
from understudy.viz.appearance import FEW, Grid, Points, doings, places, unit
from understudy.viz.palette import COLORS, INK, PAPER
from understudy.viz.team_colors import sides_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ARROW_EVERY, LANE = 2.0, 0.07
"""In units of the picture. Lane: how far to the right of it a way is drawn, so that there and back stay apart."""
ARROW = np.array([(0.17, 0.0), (-0.11, 0.11), (-0.05, 0.0), (-0.11, -0.11)])
MOST_PIECES = 240_000
THIN_PT, COVER = 0.7, 0.2
"""How wide the trails of a crowd are, and about how much of the arena their ink may cover."""
RIM_PT = 1.2
"""Where there are sides, a robot of a crowd has its side's color, and a rim in that of what it does."""
POINTS_PER_IN = 72.0


def draw(axes: Axes, frames: Sequence[Frame], colors: Mapping[str, str], *, inch: float) -> Points:
    """Draw where the robots went, `inch` m on an inch of paper; the points [P, 2] that this covers.

    Of a few robots each has a color of its own; where there are sides, a shade of its side's.
    """
    one = unit(frames[-1].view)
    if len(frames[-1].view.robots) > FEW:
        return _crowd(axes, frames, colors, one=one, inch=inch)
    at, heading = places(frames)
    beside = at + LANE * one * np.stack([np.sin(heading), -np.cos(heading)], axis=2)
    alone = at.shape[1] == 1
    sides = sides_of(frames[-1].view)
    own_color = list(COLORS) if sides is None else sides.shades
    palette, which = (list(colors.values()), doings(frames, colors)) if alone else (own_color, None)
    for robot in range(at.shape[1]):
        own = np.full(len(frames), robot) if which is None else which[:, robot]
        _stretches(axes, beside[:, robot], own, palette)
        _arrows(axes, beside[:, robot], heading[:, robot], own, palette, one=one)
    covered = [beside.reshape(-1, 2)]
    for robot in range(at.shape[1]):
        mark = INK if alone else own_color[robot]
        radius = max(float(frames[-1].view.robots.radius[robot]), 0.08 * one)
        for moment, fill, nose in ((0, PAPER, mark), (-1, mark, PAPER)):
            _robot(axes, at[moment, robot], float(heading[moment, robot]), radius, (fill, mark, nose))
            corners = at[moment, robot] + radius * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
            covered.append(np.repeat(corners, len(frames), axis=0))
    return np.concatenate(covered)


def _stretches(axes: Axes, way: Points, which: Grid, palette: Sequence[str]) -> None:
    """The way, a stretch per color, each beginning where the one before ended."""
    starts = np.flatnonzero(np.diff(which, prepend=-1))
    for begin, end in zip(starts, [*starts[1:], len(which)], strict=True):
        xs, ys = way[max(0, begin - 1) : end].T
        axes.plot(xs, ys, color=palette[which[begin]], lw=1.7, zorder=4, solid_capstyle="round")


def _arrows(
    axes: Axes, way: Points, heading: Points, which: Grid, palette: Sequence[str], *, one: float
) -> None:  # fmt: skip
    from matplotlib.patches import Polygon

    steps = np.hypot(*np.diff(way, axis=0).T)
    due = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) / (ARROW_EVERY * one) + 0.5)
    for at in np.flatnonzero(np.diff(due, prepend=0.0) > 0):
        ahead, beside = cos(heading[at]), sin(heading[at])
        corners = way[at] + one * ARROW @ np.array([(ahead, beside), (-beside, ahead)])
        axes.add_patch(Polygon(corners, fc=palette[which[at]], ec="none", zorder=5))


def _robot(axes: Axes, at: Points, heading: float, radius: float, colors: tuple[str, str, str]) -> None:
    from matplotlib.patches import Circle

    (x, y), (fill, edge, nose) = at.tolist(), colors
    axes.add_patch(Circle((x, y), radius, fc=fill, ec=edge, lw=1.6, zorder=7))
    axes.plot([x, x + radius * cos(heading)], [y, y + radius * sin(heading)], color=nose, lw=1.6, zorder=8)


def _crowd(
    axes: Axes, frames: Sequence[Frame], colors: Mapping[str, str], *, one: float, inch: float
) -> Points:  # fmt: skip
    """Trails by what was done, the fainter the more there are; robots where they are at the end."""
    from matplotlib.collections import EllipseCollection, LineCollection

    robots = frames[-1].view.robots
    every = max(1, -(-len(frames) * len(robots) // MOST_PIECES))
    shown = [*frames[:-1][::every], frames[-1]]
    at, _ = places(shown)
    which, palette = doings(shown, colors), np.array(list(colors.values()))
    pieces = np.stack([at[:-1], at[1:]], axis=2).reshape(-1, 2, 2)
    length = float(np.hypot(*(pieces[:, 1] - pieces[:, 0]).T).sum())
    view = frames[-1].view
    ink = length * THIN_PT / POINTS_PER_IN * inch
    faint = min(0.6, max(0.05, COVER * view.width * view.height / max(ink, 1e-9)))
    for doing in range(len(palette)):
        own = pieces[which[1:].reshape(-1) == doing]
        lines = LineCollection(
            list(own), colors=palette[doing], linewidths=THIN_PT, alpha=faint, capstyle="butt", zorder=3
        )
        axes.add_collection(lines)
    across = 2 * np.maximum(robots.radius, 0.035 * one)
    does, sides = palette[which[-1]], sides_of(view)
    fill, rim, wide = (does, PAPER, 0.4) if sides is None else (sides.robots, does, RIM_PT)
    dots = EllipseCollection(
        across, across, np.zeros(len(robots)), units="xy", offsets=at[-1], offset_transform=axes.transData,
        facecolors=fill, edgecolors=rim, linewidths=wide, zorder=7,
    )  # fmt: skip
    axes.add_collection(dots)
    return at.reshape(-1, 2)
