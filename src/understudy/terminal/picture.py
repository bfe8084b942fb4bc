"""The foraging world as a picture in characters: robot, station, food, what is in reach, and the trail."""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, hypot, pi, sin

from rich.text import Text

from understudy.terminal.braille import Canvas
from understudy.worlds.forage_view import ForageView

ARROWS = "→↗↑↖←↙↓↘"
ROBOT, STATION, FOOD, TRAIL, AIM = "bold reverse", "bold magenta", "bold green", "", "dim"
GONE = "dim"
AIM_DOTS_M = 0.55
NOSE_M = 0.9


def size(view: ForageView, columns: int, lines: int) -> tuple[int, int]:
    """The most columns and lines that show the arena undistorted: a character is twice as high as wide."""
    lines = max(1, min(lines, int(columns * view.height / view.width / 2)))
    return max(1, min(columns, round(lines * 2 * view.width / view.height))), lines


def picture(
    view: ForageView, trail: Iterable[tuple[float, float]], aims: Iterable[str], *, columns: int, lines: int
) -> Text:
    """The world; `aims` are the targets that parameters stand for now, to which dotted lines lead."""
    canvas = Canvas(columns, lines, width=view.width, height=view.height)
    for target in aims:
        place = _place(view, target)
        if place is not None:
            canvas.line((view.x, view.y), place, AIM, every=AIM_DOTS_M)
    canvas.dots(trail, TRAIL)
    canvas.circle(*view.station, view.reach, STATION)
    for source in view.sources:
        if source.amount:
            canvas.circle(source.x, source.y, view.reach, FOOD)
    nose = view.x + NOSE_M * cos(view.heading), view.y + NOSE_M * sin(view.heading)
    canvas.line((view.x, view.y), nose, "bold", every=view.width / columns / 2)
    for source in view.sources:
        text, style = (f"{source.amount}", FOOD) if source.amount else ("×", GONE)
        canvas.text(*_beside_robot(view, source.x, source.y), text, style)
    canvas.text(*_beside_robot(view, *view.station), "⌂", STATION)
    canvas.text(view.x, view.y, ARROWS[round(view.heading / (pi / 4)) % 8], ROBOT)
    return canvas.rendered()


def facts(view: ForageView, columns: int) -> str:
    """What the robot carries and has brought home; with a bar where there is room: carries ■■■········· 3."""
    bar = "■" * view.stored + "·" * (view.capacity - view.stored)
    long = f"carries {bar} {view.stored}  home {view.delivered}"
    return (
        long
        if len(long) <= columns - 6
        else f"carries {view.stored} of {view.capacity}  home {view.delivered}"
    )


def _beside_robot(view: ForageView, x: float, y: float) -> tuple[float, float]:
    """Where to write what is at a place, so that a robot there does not cover it."""
    if hypot(view.x - x, view.y - y) > 2 * view.reach:
        return x, y
    above = y + 2 * view.reach
    return x, above if above < view.height else y - 2 * view.reach


def _place(view: ForageView, target: str) -> tuple[float, float] | None:
    if target == "station":
        return view.station
    if target != "nearest_food":
        return None
    food = [source for source in view.sources if source.amount]
    if not food:
        return None
    nearest = min(food, key=lambda source: (source.x - view.x) ** 2 + (source.y - view.y) ** 2)
    return nearest.x, nearest.y
