"""A run as it is watched in a terminal: its world in characters, and what its robots are doing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import RenderableType

    from understudy.sim.view import WorldView


def screen(view: WorldView, paths: Sequence[Sequence[str]], *, wide: int, tall: int) -> RenderableType:
    """The world, what its robot is doing on every level (of several: how many do what), and what there is."""
    from rich import box
    from rich.console import Group
    from rich.panel import Panel
    from rich.text import Text

    from understudy.ui.tui.world_view import facts, picture, size

    columns, lines = size(view, wide - 2, max(tall - 2, 6))
    drawn = picture(view, columns=columns, lines=lines, robot=0 if len(paths) == 1 else None)
    known = Text.assemble((f"{view.time_s:6.1f} s", "bold"), "   ", facts(view, wide))
    return Group(
        Panel(drawn, box=box.ROUNDED, width=columns + 2, padding=0, border_style="dim"),
        Text(_doing(paths), style="bold", no_wrap=True, overflow="ellipsis"),
        known,
        Text("Ctrl-C ends it", style="dim"),
    )


def _doing(paths: Sequence[Sequence[str]]) -> str:
    if len(paths) == 1:
        return " > ".join(paths[0]) or "idle"
    counts = Counter(path[0] if path else "idle" for path in paths)
    return "   ".join(f"{name} {count}" for name, count in sorted(counts.items()))
