"""A foraging run in motion, as an animated GIF."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from math import cos, sin
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.errors import SettingError
from understudy.model.atomic import write
from understudy.pictures.style import FAINT, FOOD, FOOD_GONE, GROUND, INK, PAPER, STATION, colors_for
from understudy.worlds.forage_view import ForageView, Frame

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

WIDE, MARGIN, BELOW = 440, 14, 58  # pixels
FINE = 2  # drawn so many times larger and then reduced, for smooth edges
MOST_FRAMES = 300
TRAIL = 60  # frames
COLORS = 64


def run_gif(frames: Sequence[Frame], path: Path | str, *, speed: float = 8.0, per_s: float = 16.0) -> None:
    """Write the run, `speed` times as fast as it was, `per_s` pictures a second; long runs go faster."""
    for setting, value in (("speed", speed), ("per_s", per_s)):
        if not 0 < value < 1000:
            raise SettingError(where="GIF", setting=setting, problem=f"is {value}", remedy="give 0 to 1000")
    if not frames:
        raise SettingError(where="GIF", setting="frames", problem="are none", remedy="record a run first")
    from PIL.Image import Dither

    shown = _chosen(frames, speed / per_s)
    colors = colors_for(frame.doing for frame in frames)
    pictures = [_picture(shown[max(0, at - TRAIL) : at + 1], colors) for at in range(len(shown))]
    palette = _palette(pictures, shown)
    flat = [picture.quantize(palette=palette, dither=Dither.NONE) for picture in pictures]
    times = [round(1000 / per_s / 10) * 10] * (len(flat) - 1) + [2500]  # the end stays a while
    drawn = BytesIO()
    flat[0].save(drawn, "GIF", save_all=True, append_images=flat[1:], duration=times, loop=0)
    write(Path(path), drawn.getvalue())


def _chosen(frames: Sequence[Frame], every_s: float) -> list[Frame]:
    """Frames about `every_s` of simulated time apart, first and last among them, MOST_FRAMES at most."""
    length = frames[-1].view.time_s - frames[0].view.time_s
    every_s = max(every_s, length / (MOST_FRAMES - 2))
    chosen, due = [], frames[0].view.time_s
    for frame in frames[:-1]:
        if frame.view.time_s >= due - 1e-9:
            chosen.append(frame)
            due += every_s
    return [*chosen, frames[-1]]


def _palette(pictures: Sequence[Image], frames: Sequence[Frame]) -> Image:
    """One palette for all pictures, from the last one of each doing side by side."""
    from PIL import Image

    last = {frame.doing: picture for frame, picture in zip(frames, pictures, strict=True)}
    wide, tall = pictures[0].size
    together = Image.new("RGB", (wide * len(last), tall))
    for at, picture in enumerate(last.values()):
        together.paste(picture, (at * wide, 0))
    return together.quantize(COLORS)


class _Pen:
    """Draws in meters: x to the right, y up."""

    def __init__(self, draw: ImageDraw, view: ForageView) -> None:
        self.draw, self.tall = draw, view.height
        self.scale = FINE * (WIDE - 2 * MARGIN) / view.width

    def at(self, x: float, y: float) -> tuple[float, float]:
        return FINE * MARGIN + x * self.scale, FINE * MARGIN + (self.tall - y) * self.scale

    def circle(self, x: float, y: float, radius: float, fill: str | None, line: str | None = None) -> None:
        (px, py), size = self.at(x, y), radius * self.scale
        self.draw.ellipse((px - size, py - size, px + size, py + size), fill=fill, outline=line, width=FINE)


def _picture(recent: Sequence[Frame], colors: dict[str, str]) -> Image:
    from PIL import Image, ImageDraw

    frame, view = recent[-1], recent[-1].view
    tall = round(WIDE * view.height / view.width) + BELOW
    image = Image.new("RGB", (FINE * WIDE, FINE * tall), PAPER)
    pen = _Pen(ImageDraw.Draw(image), view)
    pen.draw.rectangle(
        (*pen.at(0, view.height), *pen.at(view.width, 0)), fill=GROUND, outline=INK, width=2 * FINE
    )
    for x, y, amount, at_first in view.sources:
        pen.circle(x, y, view.reach, None, FOOD_GONE)
        pen.circle(x, y, 0.1 * at_first**0.5, FOOD_GONE, FOOD)
        pen.circle(x, y, 0.1 * amount**0.5, FOOD)
    x, y = view.station
    pen.circle(x, y, view.reach, None, FAINT)
    pen.draw.rectangle((*pen.at(x - 0.24, y + 0.24), *pen.at(x + 0.24, y - 0.24)), fill=STATION)
    for one, other in pairwise(recent):
        way = [pen.at(one.view.x, one.view.y), pen.at(other.view.x, other.view.y)]
        pen.draw.line(way, fill=colors[other.doing], width=2 * FINE)
    pen.circle(view.x, view.y, view.radius + 0.05, colors[frame.doing], INK)
    ahead = (view.x + view.radius * cos(view.heading), view.y + view.radius * sin(view.heading))
    pen.draw.line([pen.at(view.x, view.y), pen.at(*ahead)], fill=PAPER, width=2 * FINE)
    _caption(pen.draw, frame, FINE * tall, colors[frame.doing])
    return image.reduce(FINE)


def _caption(draw: ImageDraw, frame: Frame, tall: int, color: str) -> None:
    from PIL import ImageFont

    view, left = frame.view, FINE * MARGIN
    large, small = ImageFont.load_default(size=17 * FINE), ImageFont.load_default(size=13 * FINE)
    first, second = tall - FINE * (BELOW - 4), tall - FINE * (BELOW - 29)
    draw.text((left, first), frame.doing, font=large, fill=color)
    right = FINE * (WIDE - MARGIN)
    draw.text((right, first), f"{view.time_s:.0f} s", font=large, fill=INK, anchor="ra")
    carries = f"carries {view.stored} of {view.capacity}   ·   brought home {view.delivered}"
    draw.text((left, second), carries, font=small, fill=FAINT)
