"""The foraging world in characters, for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import RenderableType

    from understudy.worlds.forage_view import ForageView

ARROWS = "→↗↑↖←↙↓↘"
ROBOT, STATION, FOOD, GONE = "bold cyan", "bold magenta", "green", "dim"


def screen(view: ForageView, path: Sequence[str], *, wide: int, tall: int) -> RenderableType:
    """The world, what the robot is doing on every level, and what it has."""
    from rich import box
    from rich.console import Group
    from rich.panel import Panel
    from rich.text import Text

    columns, lines = _size(view, wide - 2, max(tall - 2, 6))
    doing = Text(" > ".join(path) or "idle", style="bold")
    bar = "■" * view.stored + "·" * (view.capacity - view.stored)
    facts = Text.assemble(
        (f"{view.time_s:6.1f} s", "bold"), "   carries ", (bar, FOOD), f"   home {view.delivered}"
    )
    return Group(
        Panel(
            _picture(view, columns, lines), box=box.ROUNDED, width=columns + 2, padding=0, border_style="dim"
        ),
        doing,
        facts,
        Text("Ctrl-C ends it", style="dim"),
    )


def _size(view: ForageView, wide: int, tall: int) -> tuple[int, int]:
    """Columns and lines that show the arena undistorted: a character is twice as high as wide."""
    lines = min(tall, max(int(wide * view.height / view.width / 2), 1))
    return max(int(lines * 2 * view.width / view.height), 1), lines


def _picture(view: ForageView, columns: int, lines: int) -> RenderableType:
    from rich.text import Text

    cells: dict[tuple[int, int], tuple[str, str]] = {}

    def put(x: float, y: float, text: str, style: str) -> None:
        column = min(int(x / view.width * columns), columns - len(text))
        line = min(int((view.height - y) / view.height * lines), lines - 1)
        for offset, character in enumerate(text):
            cells[line, max(column, 0) + offset] = (character, style)

    for source in view.sources:
        put(
            source.x, source.y, f"●{source.amount}" if source.amount else "○", FOOD if source.amount else GONE
        )
    put(*view.station, "⌂", STATION)
    put(view.x, view.y, ARROWS[round(view.heading / (pi / 4)) % 8], ROBOT)
    drawn = Text(no_wrap=True)
    for line in range(lines):
        for column in range(columns):
            drawn.append(*cells.get((line, column), (" ", "")))
        drawn.append("\n" if line < lines - 1 else "")
    return drawn
