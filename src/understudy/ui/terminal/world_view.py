"""A world as a picture in characters: robots, objects, reach, obstacles, and a robot's trail."""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, hypot, pi, sin
from typing import TypeAlias

from rich.text import Text

from understudy.sim.view import WorldView
from understudy.ui.terminal.braille_canvas import BrailleCanvas
from understudy.viz.appearance import (
    FEW,
    ObjectMark,
    choose_obstacle_colors,
    count_food_units,
    format_thousands,
    list_object_marks,
    measure_loading_reach,
)
from understudy.viz.palette import FOOD, HOME, INK, PAINTS, SOLID, THING, choose_drawing_color

MapPoint: TypeAlias = tuple[float, float]

ARROWS = "→↗↑↖←↙↓↘"
ROBOT, OTHER, TRAIL, AIM, WALL, GONE = "bold reverse", "bold cyan", "", "dim", "bold", "dim"
CROWD = ("cyan", "bold cyan", "bold yellow")
"""A crowd where it is thin, denser, and densest."""
STYLES = {FOOD: "bold green", HOME: "bold magenta", THING: "bold", SOLID: "bright_black", INK: "bold"} | {
    PAINTS[name]: f"bold {name}" for name in ("red", "green", "yellow", "blue", "magenta", "cyan", "white")
}
"""Colors that terminals have their own shades of, which fit light and dark ones."""
AIM_DOTS_M, NOSE_M = 0.55, 0.9
MOST_ARROWS = 40
"""The largest number of robots that are drawn as arrows; more are dots."""


def fit_arena(view: WorldView, columns: int, lines: int) -> tuple[int, int]:
    """Return the most columns and lines that show the arena undistorted: a character is twice as high as wide."""
    lines = max(1, min(lines, int(columns * view.height / view.width / 2)))
    return max(1, min(columns, round(lines * 2 * view.width / view.height))), lines


def render_world(
    view: WorldView,
    trail: Iterable[MapPoint] = (),
    aims: Iterable[MapPoint] = (),
    *,
    columns: int,
    lines: int,
    robot: int | None = None,
) -> Text:
    """Render the world. `robot` is the one that is followed, with its trail and dotted lines to its targets."""
    canvas = BrailleCanvas(columns, lines, width=view.width, height=view.height)
    _obstacles(canvas, view)
    few = 0 < len(view.robots) <= MOST_ARROWS
    if few and robot is not None:
        for aim in aims:
            canvas.line(_place(view, robot), aim, AIM, every=AIM_DOTS_M)
    canvas.dots(trail, TRAIL)
    near, marks = measure_loading_reach(view), list_object_marks(view)
    for thing in marks:
        if thing.served and thing.full and near is not None:
            canvas.circle(thing.x, thing.y, near, _style(thing.color))
    if few:
        _noses(canvas, view, robot)
    else:
        canvas.scatter(view.robots.x, view.robots.y, CROWD)
    for thing in marks:
        canvas.text(*_beside_robots(view, thing, near or 0.0), *_sign(view, thing))
    if few:
        _arrows(canvas, view, robot)
    return canvas.render()


def describe_followed_robot(view: WorldView, columns: int, robot: int = 0) -> str:
    """Describe the cargo of one robot beside the picture, with a bar if there is room."""
    robots = view.robots
    feeds = bool(robots.capacity.any())
    if len(robots) != 1:
        home = (
            f"  home {int(robots.delivered.sum())} of {count_food_units(view)}"
            if feeds and count_food_units(view)
            else ""
        )
        boxes = f"  boxes home {view.gathered}" if view.gathered or view.objects.pull.any() else ""
        return f"{format_thousands(len(robots))} robots{home}{boxes}"
    if not feeds:
        return ""
    stored, capacity, delivered = (
        int(column[robot]) for column in (robots.stored, robots.capacity, robots.delivered)
    )
    bar = "■" * stored + "·" * (capacity - stored)
    long = f"carries {bar} {stored}  home {delivered}"
    return long if len(long) <= columns - 6 else f"carries {stored} of {capacity}  home {delivered}"


def _obstacles(canvas: BrailleCanvas, view: WorldView) -> None:
    discs = view.discs
    rows = zip(
        discs.x.tolist(), discs.y.tolist(), discs.radius.tolist(), choose_obstacle_colors(view), strict=True
    )
    for x, y, radius, color in rows:
        canvas.disc(x, y, radius, _style(color))
    for corners in view.polygons:
        canvas.polygon(corners, _style(SOLID))
    for x0, y0, x1, y1 in view.walls.tolist():
        canvas.line((x0, y0), (x1, y1), WALL, every=view.width / canvas.columns / 4)


def _noses(canvas: BrailleCanvas, view: WorldView, robot: int | None) -> None:
    """Draw a line ahead of each robot, or if there are many, only of the one that is followed."""
    chosen = range(len(view.robots)) if len(view.robots) <= FEW else [] if robot is None else [robot]
    for at in chosen:
        (x, y), heading = _place(view, at), float(view.robots.heading[at])
        nose = x + NOSE_M * cos(heading), y + NOSE_M * sin(heading)
        style = "bold" if at == robot else _robot_style(view, at)
        canvas.line((x, y), nose, style, every=view.width / canvas.columns / 2)


def _arrows(canvas: BrailleCanvas, view: WorldView, robot: int | None) -> None:
    """Draw every robot, the one that is followed on top."""
    for at in sorted(range(len(view.robots)), key=lambda at: at == robot):
        style = ROBOT if at == robot else _robot_style(view, at)
        x, y = _place(view, at)
        canvas.text(x, y, ARROWS[round(float(view.robots.heading[at]) / (pi / 4)) % 8], style)


def _robot_style(view: WorldView, robot: int) -> str:
    color = view.color(int(view.robots.color[robot]))
    return OTHER if color is None else _style(choose_drawing_color(color))


def _sign(view: WorldView, thing: ObjectMark) -> tuple[str, str]:
    """Return the characters that draw an object in the terminal, and their text style."""
    if thing.units is not None:
        return (str(thing.units), _style(thing.color)) if thing.units else ("×", GONE)
    if thing.square:
        return "⌂", _style(thing.color)
    return "■" if thing.rimmed else "◆", _style(thing.color)


def _style(color: str) -> str:
    return STYLES.get(color, f"bold {color}")


def _place(view: WorldView, robot: int) -> MapPoint:
    return float(view.robots.x[robot]), float(view.robots.y[robot])


def _beside_robots(view: WorldView, thing: ObjectMark, near: float) -> MapPoint:
    """Return where to write text about a place so that a robot there does not cover it."""
    if len(view.robots) > MOST_ARROWS or not near:
        return thing.x, thing.y
    if (
        min(hypot(*place) for place in zip(view.robots.x - thing.x, view.robots.y - thing.y, strict=True))
        > 2 * near
    ):
        return thing.x, thing.y
    above = thing.y + 2 * near
    return thing.x, above if above < view.height else thing.y - 2 * near
