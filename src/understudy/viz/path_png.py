"""Draw the robots' paths in a run, and the things in their world, as a PNG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from itertools import chain
from math import cos, sin
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from understudy.errors import SettingError
from understudy.sim.view import RunFrame, WorldView
from understudy.storage.atomic_write import write_atomically
from understudy.viz.appearance import (
    FEW,
    Grid,
    ObjectMark,
    Points,
    choose_obstacle_colors,
    collect_robot_places,
    describe_delivered,
    find_removed_objects,
    format_thousands,
    index_activities,
    list_object_marks,
    measure_loading_reach,
    measure_mark_unit,
)
from understudy.viz.labels import Labels
from understudy.viz.palette import (
    COLORS,
    EDGE,
    FAINT,
    GROUND,
    INK,
    PAPER,
    SOLID,
    assign_name_colors,
    blend_color,
)
from understudy.viz.sheet import FigureSheet
from understudy.viz.team_colors import assign_team_colors

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


ARROW_EVERY, LANE = 2.0, 0.07
"""The distance between arrows on a path, and that of the path to the right of the robot, in units of marks.

It separates the paths of opposite directions.
"""
ARROW = np.array([(0.17, 0.0), (-0.11, 0.11), (-0.05, 0.0), (-0.11, -0.11)])
MOST_PIECES = 240_000
THIN_PT, COVER = 0.7, 0.2
"""The width of a crowd's trails (points), and the share of the arena that their ink covers at most, roughly."""
RIM_PT = 1.2
"""The width of a robot's rim in a crowd with several teams, whose color is that of its activity (points)."""
POINTS_PER_IN = 72.0


LineStyle: TypeAlias = str | tuple[float, tuple[float, ...]]
"""A line style of matplotlib: "-", or an offset and the lengths of dashes and gaps."""
SOLID_LINES: tuple[LineStyle, ...] = ("-",)


def draw_paths(
    axes: Axes,
    frames: Sequence[RunFrame],
    colors: Mapping[str, str],
    *,
    inch: float,
    styles: Sequence[LineStyle] = SOLID_LINES,
) -> Points:
    """Draw the robots' paths; return the points [P, 2] (m) that the drawing covers.

    `inch` is the length (m) that one inch on paper shows. Few robots have a color each, shades of one color within a
    team; a single robot's path is colored by its activity. Colors have one of the `styles` each, in turn.
    """
    one = measure_mark_unit(frames[-1].view)
    if len(frames[-1].view.robots) > FEW:
        return _crowd(axes, frames, colors, one=one, inch=inch)
    at, heading = collect_robot_places(frames)
    beside = at + LANE * one * np.stack([np.sin(heading), -np.cos(heading)], axis=2)
    alone = at.shape[1] == 1
    sides = assign_team_colors(frames[-1].view)
    own_color = list(COLORS) if sides is None else sides.shades
    palette, which = (list(colors.values()), index_activities(frames, colors)) if alone else (own_color, None)
    for robot in range(at.shape[1]):
        own = np.full(len(frames), robot) if which is None else which[:, robot]
        _stretches(axes, beside[:, robot], own, palette, styles)
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


def _stretches(
    axes: Axes, way: Points, which: Grid, palette: Sequence[str], styles: Sequence[LineStyle]
) -> None:
    """Draw a path with one line per stretch of the same color, each starting where the previous one ended."""
    starts = np.flatnonzero(np.diff(which, prepend=-1))
    for begin, end in zip(starts, [*starts[1:], len(which)], strict=True):
        xs, ys = way[max(0, begin - 1) : end].T
        look = styles[which[begin] % len(styles)]
        axes.plot(xs, ys, color=palette[which[begin]], lw=1.7, ls=look, zorder=4, solid_capstyle="round")


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
    axes: Axes, frames: Sequence[RunFrame], colors: Mapping[str, str], *, one: float, inch: float
) -> Points:  # fmt: skip
    """Draw trails colored by activity, the fainter the more there are, and the robots at their last places."""
    from matplotlib.collections import EllipseCollection, LineCollection

    robots = frames[-1].view.robots
    every = max(1, -(-len(frames) * len(robots) // MOST_PIECES))
    sampled = [*frames[:-1][::every], frames[-1]]
    at, _ = collect_robot_places(sampled)
    which, palette = index_activities(sampled, colors), np.array(list(colors.values()))
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
    does, sides = palette[which[-1]], assign_team_colors(view)
    fill, rim, wide = (does, PAPER, 0.4) if sides is None else (sides.robots, does, RIM_PT)
    dots = EllipseCollection(
        across, across, np.zeros(len(robots)), units="xy", offsets=at[-1], offset_transform=axes.transData,
        facecolors=fill, edgecolors=rim, linewidths=wide, zorder=7,
    )  # fmt: skip
    axes.add_collection(dots)
    return at.reshape(-1, 2)


MOST_DOINGS = 8
REACH_STYLE = (0, (3, 3))


def draw_path_png(frames: Sequence[RunFrame], path: Path | str, *, title: str = "A run") -> None:
    """Write a PNG of a run: a robot's path by its activity, a color each for a few robots, faint trails for many.

    SettingError if there are no frames.
    """
    if not frames:
        raise SettingError(where="path picture", setting="frames", problem="are none", remedy="record a run")
    last = frames[-1].view
    sheet = FigureSheet(last, title, _summary(last), list_path_entries(frames))
    draw_run(sheet.axes, frames, inch=sheet.inch)
    buffer = BytesIO()
    sheet.figure.savefig(buffer, format="png")
    write_atomically(Path(path), buffer.getvalue())


def list_path_entries(
    frames: Sequence[RunFrame], *, styles: Sequence[LineStyle] = SOLID_LINES
) -> list[Artist]:
    """Return the entries of the legend of a run: activities or robots, teams, and the objects without a label."""
    first, last = frames[0].view, frames[-1].view
    now = list_object_marks(last)
    before = find_removed_objects(list_object_marks(first), now, last)
    robots = len(last.robots)
    doing, sides = _color_activities(frames), assign_team_colors(last)
    if robots == 1 or robots > FEW:
        lines = list(doing.items())
    else:
        lines = [(f"robot {at + 1}", COLORS[at]) for at in range(robots if sides is None else 0)]
    looks = styles if robots <= FEW else SOLID_LINES
    entries = [_line(color, name, looks[at % len(looks)]) for at, (name, color) in enumerate(lines) if name]
    if sides is not None:
        entries += [_marker(color, INK, name) for name, color in zip(sides.names, sides.colors, strict=True)]
    return entries[:MOST_DOINGS] + _markers(last, [*before, *now], crowd=robots > FEW)


def _color_activities(frames: Sequence[RunFrame]) -> dict[str, str]:
    return assign_name_colors(chain.from_iterable(frame.doing for frame in frames))


def draw_run(
    axes: Axes, frames: Sequence[RunFrame], *, inch: float, styles: Sequence[LineStyle] = SOLID_LINES
) -> None:
    """Draw the paths of a run, and the things in their world, into axes of an arena in m."""
    first, last = frames[0].view, frames[-1].view
    now = list_object_marks(last)
    _fixed(axes, last)
    for thing in find_removed_objects(list_object_marks(first), now, last):
        _thing(axes, thing, before=True)
    for thing in now:
        _thing(axes, thing)
    drawn = draw_paths(axes, frames, _color_activities(frames), inch=inch, styles=styles)
    _label(axes, last, now, drawn, inch=inch)


def _summary(view: WorldView) -> str:
    robots = len(view.robots)
    facts = [] if robots == 1 else [format_thousands(robots) + " robots"]
    home = describe_delivered(view)
    if home:
        words = " and ".join(home).replace(" home", " brought home")
        return ", ".join([*facts, f"{words} in {view.time_s:.0f} s"])
    return ", ".join([*facts, f"{view.time_s:.0f} s"])


def _line(color: str, label: str, style: LineStyle) -> Artist:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, lw=2.6 if style == "-" else 1.7, ls=style, label=label)


def _marker(fill: str, edge: str, label: str, *, size: float = 8.0, sign: str = "o") -> Artist:
    from matplotlib.lines import Line2D

    return Line2D([], [], marker=sign, ls="", mfc=fill, mec=edge, mew=1.4, ms=size, label=label)


def _markers(view: WorldView, things: Sequence[ObjectMark], *, crowd: bool) -> list[Artist]:
    """Return the legend's marks: start and end, and the classes of objects that have no label in the picture."""
    from matplotlib.lines import Line2D

    size = 5.0 if crowd else 8.0
    end = _marker(INK, INK, "end of path", size=size)
    artists = [end] if crowd else [_marker(PAPER, INK, "start of path", size=size), end]
    named: dict[tuple[str, str], ObjectMark] = {}
    for thing in things:
        if not thing.label:
            named.setdefault((thing.name, thing.color), thing)
    for (name, color), thing in named.items():
        artists.append(_marker(color, color, name, size=size, sign="s" if thing.square else "o"))
    if any(thing.served for thing in things):
        artists.append(Line2D([], [], color=FAINT, lw=0.9, ls=REACH_STYLE, label="within reach"))
    return artists


def _fixed(axes: Axes, view: WorldView) -> None:
    """Draw obstacles and walls."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle, Polygon

    for corners in view.polygons:
        axes.add_patch(Polygon(corners, fc=SOLID, ec=EDGE, lw=1.2, zorder=1.5, joinstyle="round"))
    discs = view.discs
    rows = zip(
        discs.x.tolist(), discs.y.tolist(), discs.radius.tolist(), choose_obstacle_colors(view), strict=True
    )
    for x, y, radius, color in rows:
        axes.add_patch(Circle((x, y), radius, fc=color, ec=blend_color(color, INK, 0.7), lw=1.2, zorder=1.5))
    walls = view.walls.reshape(-1, 2, 2)
    axes.add_collection(LineCollection(list(walls), colors=INK, linewidths=2.0, capstyle="round", zorder=2))


def _thing(axes: Axes, thing: ObjectMark, *, before: bool = False) -> None:
    """Draw an object, sources with the share of food left; in outline if it is missing or elsewhere at the end."""
    from matplotlib.patches import Circle, Rectangle

    def shape(half: float, **look: object) -> None:
        corner = (thing.x - half, thing.y - half)
        patch = Rectangle(corner, 2 * half, 2 * half) if thing.square else Circle((thing.x, thing.y), half)
        patch.set(zorder=2.2, **look)
        axes.add_patch(patch)

    if before:
        shape(thing.size, fc="none", ec=blend_color(thing.color, GROUND, 0.55), lw=1.2, ls=(0, (1.5, 1.5)))
    elif thing.full < 1.0:
        shape(thing.size, fc=blend_color(thing.color, GROUND, 0.28), ec=thing.color, lw=1.2)
        shape(thing.size * thing.full, fc=thing.color, ec="none")
    else:
        shape(
            thing.size,
            fc=thing.color,
            ec=blend_color(thing.color, INK, 0.7) if thing.rimmed else "none",
            lw=1.2,
        )


def _label(
    axes: Axes, view: WorldView, things: Sequence[ObjectMark], drawn: Points, *, inch: float
) -> None:  # fmt: skip
    from matplotlib.patches import Circle

    near = measure_loading_reach(view)
    labels = Labels(axes, (view.width, view.height), drawn, inch=inch)
    labels.keep_free(things)
    for thing in things:
        served = near if thing.served else None
        if served is not None:
            axes.add_patch(
                Circle(
                    (thing.x, thing.y), served, fc="none", ec=thing.color, lw=0.9, ls=REACH_STYLE, zorder=1
                )
            )
        if thing.label:
            around = max(thing.size, served or 0.0, thing.size + 0.02 * measure_mark_unit(view))
            labels.place_label(thing, around)
