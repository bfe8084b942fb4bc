"""Write the caption of an animated picture: the time, and the robots' activities in words or counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from understudy.sim.view import RunFrame, WorldView
from understudy.viz.appearance import count_food_units, describe_delivered, format_thousands
from understudy.viz.canvas import FINE
from understudy.viz.palette import FAINT, INK
from understudy.viz.team_colors import TeamColors

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

LARGE, SMALL, DOT = 17 * FINE, 13 * FINE, 4 * FINE  # fine pixels
FIRST, LINE, GAP = 6 * FINE, 25 * FINE, 11 * FINE


class Caption:
    """The caption of a run, between two edges and below `top` (fine pixels), with a fixed place for each activity."""

    def __init__(
        self,
        colors: Mapping[str, str],
        frames: Sequence[RunFrame],
        *,
        left: int,
        right: int,
        top: int,
        sides: TeamColors | None = None,
    ) -> None:
        from PIL import ImageFont

        self._colors, self._frames = colors, frames
        self._left, self._right, self._top, self._sides = left, right, top, sides
        self._large, self._small = ImageFont.load_default(size=LARGE), ImageFont.load_default(size=SMALL)
        self._alone = len(frames[-1].doing) == 1
        self._feeds = bool(frames[-1].view.robots.capacity.any()) and count_food_units(frames[-1].view) > 0
        self._places = {} if self._alone else self._laid_out()
        lines = int(self._feeds) if self._alone else max(line for _, line in self._places.values())
        self.tall = FIRST + LINE * (lines + 1) + 4 * FINE

    def draw(self, draw: ImageDraw, at: int) -> None:
        """Write the caption of a frame."""
        view, doing = self._frames[at].view, self._frames[at].doing
        draw.text(
            (self._right, self._top + FIRST), f"{view.time_s:.0f} s", font=self._large, fill=INK, anchor="ra"
        )
        if self._alone:
            first = (self._left, self._top + FIRST)
            draw.text(first, doing[0], font=self._large, fill=self._colors[doing[0]])
            if self._feeds:
                draw.text(
                    (self._left, self._top + FIRST + LINE), _carries(view), font=self._small, fill=FAINT
                )
            return
        home = "".join(f"   ·   {words}" for words in describe_delivered(view))
        x = self._left + self._crew(draw, room=self._room(home, view.time_s), robots=len(doing))
        draw.text((x, self._top + FIRST + 2 * FINE), home, font=self._small, fill=INK)
        counts = Counter(doing)
        for name, (x, line) in self._places.items():
            y = self._top + FIRST + LINE * line + SMALL / 2 + 2 * FINE
            color = self._colors[name]
            draw.ellipse((x, y - DOT, x + 2 * DOT, y + DOT), fill=color)
            text = f"{name or 'idle'} {format_thousands(counts[name])}"
            draw.text(
                (x + 3 * DOT, y), text, font=self._small, fill=color if counts[name] else FAINT, anchor="lm"
            )

    def _room(self, home: str, time_s: float) -> float:
        """Return the width left in the first line beside the delivered amounts and the time (fine pixels)."""
        taken = self._small.getlength(home) + self._large.getlength(f"{time_s:.0f} s")
        return self._right - self._left - taken - GAP

    def _crew(self, draw: ImageDraw, *, room: float, robots: int) -> float:
        """Write the number of robots, by side in its color if there is space; return its width (fine pixels)."""
        words = [(f"{format_thousands(robots)} robots", INK)]
        if self._sides is not None:
            sides = list(zip(self._sides.counts, self._sides.colors, strict=True))
            if sum(self._small.getlength(word) + 3 * DOT + GAP for word, _ in sides) - GAP <= room:
                words = sides
        x, y = float(self._left), self._top + FIRST + 2 * FINE
        for word, color in words:
            if color != INK:
                middle = y + SMALL / 2 + FINE
                draw.ellipse(
                    (x, middle - DOT, x + 2 * DOT, middle + DOT), fill=color, outline=INK, width=FINE
                )
                x += 3 * DOT
            draw.text((x, y), word, font=self._small, fill=INK)
            x += self._small.getlength(word) + GAP
        return x - GAP - self._left

    def _laid_out(self) -> dict[str, tuple[float, int]]:
        """Return the place of each activity: its left edge and its line, with space for the largest count."""
        placed, x, line = {}, float(self._left), 1
        most = format_thousands(len(self._frames[-1].doing))
        for name in self._colors:
            wide = 3 * DOT + self._small.getlength(f"{name or 'idle'} {most}")
            if x > self._left and x + wide > self._right:
                x, line = float(self._left), line + 1
            placed[name] = (x, line)
            x += wide + GAP
        return placed


def _carries(view: WorldView) -> str:
    stored, capacity, delivered = (
        int(column[0]) for column in (view.robots.stored, view.robots.capacity, view.robots.delivered)
    )
    return f"carries {stored} of {capacity}   ·   brought home {delivered}"
