"""Draw a run as an animated GIF: few robots with their trails, many robots as dots."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.runtime.thinning_buffer import ThinningBuffer
from understudy.sim.view import RunFrame, WorldView
from understudy.storage.atomic_write import write_atomically
from understudy.viz.appearance import (
    FEW,
    Points,
    choose_robot_colors,
    collect_robot_places,
    count_food_units,
    describe_delivered,
    format_thousands,
    index_activities,
    measure_mark_unit,
)
from understudy.viz.canvas import FINE, RasterCanvas
from understudy.viz.palette import (
    FAINT,
    FOOD,
    GROUND,
    HOME,
    INK,
    PAPER,
    SOLID,
    assign_name_colors,
    blend_color,
)
from understudy.viz.team_colors import TeamColors, assign_team_colors

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw


WIDE, TALL, LEAST, MARGIN = 440, 520, 300, 14
"""Sizes in pixels: the largest picture width and arena height, the least caption width, the margin of the arena."""
MOST_DRAWN_FRAMES = 300
TRAIL = 60
"""The length of a robot's trail in frames, divided by the number of robots, at least 15."""
DISCS, TAILS = 60, 2000
"""The largest numbers of robots that are drawn with headings (more are dots), and with short trails."""
TAIL, LEAST_DOT = 3, 1.4
CORE, LEAST_CORE = 0.5, 1.0
"""The radius of the inner disc, as a share of the robot's, and its least radius in pixels, else it is omitted.

In worlds with several teams a robot has its team's color outside, and that of its activity in the inner disc.
"""
CALLING = 1.6
"""The radius of the ring around a robot that raises a signal, in robot radii."""
COLORS, SAMPLES, SAME = 128, 8, 10
"""The number of palette colors and of pictures that it is derived from, and the difference (of 255) of equal colors."""
MOST_BUFFERED_FRAMES, LEAST_FRAMES, MOST_ROWS = 20_000, 600, 2_000_000
LARGE, SMALL, DOT = 17 * FINE, 13 * FINE, 4 * FINE  # fine pixels
FIRST, LINE, GAP = 6 * FINE, 25 * FINE, 11 * FINE


def draw_run_gif(
    frames: Sequence[RunFrame], path: Path | str, *, speed: float = 8.0, per_s: float = 16.0
) -> None:
    """Write an animated GIF of a run, `speed` times as fast as simulated time, with `per_s` pictures per second.

    A long run is sped up further, to at most MOST_DRAWN_FRAMES pictures. SettingError if there are no frames, or
    `speed` or `per_s` is not between 0 and 1000.
    """
    for setting, value in (("speed", speed), ("per_s", per_s)):
        if not 0 < value < 1000:
            raise SettingError(where="GIF", setting=setting, problem=f"is {value}", remedy="give 0 to 1000")
    if not frames:
        raise SettingError(where="GIF", setting="frames", problem="are none", remedy="record a run first")
    from PIL.Image import Dither

    film = _FrameRenderer(_chosen(frames, speed / per_s))
    palette = film.palette()
    flat = (film.render(at).quantize(palette=palette, dither=Dither.NONE) for at in range(len(film.frames)))
    times = [round(1000 / per_s / 10) * 10] * (len(film.frames) - 1) + [2500]  # the end stays a while
    drawn = BytesIO()
    next(flat).save(drawn, "GIF", save_all=True, append_images=flat, duration=times, loop=0)
    write_atomically(Path(path), drawn.getvalue())


def _chosen(frames: Sequence[RunFrame], every_s: float) -> list[RunFrame]:
    """Return frames about `every_s` of simulated time apart, with the first and last, at most MOST_DRAWN_FRAMES."""
    length = frames[-1].view.time_s - frames[0].view.time_s
    every_s = max(every_s, length / (MOST_DRAWN_FRAMES - 2))
    chosen, due = [], frames[0].view.time_s
    for frame in frames[:-1]:
        if frame.view.time_s >= due - 1e-9:
            chosen.append(frame)
            due += every_s
    return [*chosen, frames[-1]]


class _FrameRenderer:
    """A renderer of the pictures of a run; things that do not move are drawn once."""

    def __init__(self, frames: Sequence[RunFrame]) -> None:
        from PIL import Image

        view = frames[-1].view
        self.frames = frames
        self._colors = assign_name_colors(chain.from_iterable(frame.doing for frame in frames))
        self._palette = list(self._colors.values())
        self._faint = [blend_color(color, GROUND, 0.45) for color in self._palette]
        self._doing = index_activities(frames, self._colors)
        self._scale = FINE * min((WIDE - 2 * MARGIN) / view.width, TALL / view.height)
        arena = view.width * self._scale, view.height * self._scale
        wide = max(round(arena[0]) + 2 * FINE * MARGIN, FINE * LEAST)
        self._corner = (wide - arena[0]) / 2, float(FINE * MARGIN)
        under = round(self._corner[1] + arena[1])
        self._sides = assign_team_colors(view)
        self._caption = Caption(
            self._colors, frames, left=FINE * MARGIN, right=wide - FINE * MARGIN, top=under, sides=self._sides
        )
        size = -(-wide // FINE) * FINE, -(-(under + self._caption.tall) // FINE) * FINE
        self._blank = Image.new("RGB", size, PAPER)
        self._pen(self._blank).draw_arena(view)
        at, self._heading = collect_robot_places(frames)
        self._places = self._pen(self._blank).to_pixels(at)
        self._where = at
        self._radius = np.maximum(view.robots.radius, 0.02 * measure_mark_unit(view)).tolist()
        self._rims = [INK if color is None else color for color in choose_robot_colors(view)]

    def render(self, at: int) -> Image:
        """Return the picture of a frame."""
        image = self._blank.copy()
        pen = self._pen(image)
        pen.draw_objects(self.frames[at].view)
        robots = len(self._radius)
        if robots <= FEW:
            self._trails(pen, at, max(TRAIL // robots, 15), 2 * FINE, self._palette)
        elif robots <= TAILS:
            self._trails(pen, at, TAIL, FINE, self._faint)
        if robots <= DISCS:
            self._discs(pen, at)
        else:
            image = self._stamped(image, at)
        self._caption.draw(self._pen(image).draw, at)
        return image.reduce(FINE)

    def palette(self) -> Image:
        """Return one palette for all pictures, derived from some of them."""
        from PIL import Image

        last = {doing: at for at, row in enumerate(self._doing) for doing in set(row.tolist())}
        spread = np.linspace(0, len(self.frames) - 1, SAMPLES).round().astype(int).tolist()
        pictures = [self.render(at) for at in sorted({*list(last.values())[:SAMPLES], *spread})]
        wide, tall = pictures[0].size
        together = Image.new("RGB", (wide * len(pictures), tall))
        for at, picture in enumerate(pictures):
            together.paste(picture, (at * wide, 0))
        reduced = together.quantize(COLORS)
        colors = np.array(reduced.getpalette()).reshape(-1, 3)
        sides = () if self._sides is None else self._sides.colors
        exact = self._rgb([FOOD, HOME, SOLID, *self._palette, *sides, INK, GROUND, PAPER])
        far = np.abs(colors[:, None] - exact.astype(np.int64)).max(axis=2)
        close = far.min(axis=1) < SAME
        colors[close] = exact[far.argmin(axis=1)[close]]
        colors[far.argmin(axis=0)] = exact  # those that nothing is close to
        reduced.putpalette(colors.reshape(-1).tolist())
        return reduced

    def _rgb(self, colors: Sequence[str]) -> NDArray[np.uint8]:
        return np.array([tuple(bytes.fromhex(color[1:])) for color in colors], np.uint8)

    def _pen(self, image: Image) -> RasterCanvas:
        tall = self.frames[-1].view.height
        return RasterCanvas(image, tall=tall, scale=self._scale, corner=self._corner)

    def _trails(self, pen: RasterCanvas, at: int, length: int, wide: int, palette: Sequence[str]) -> None:
        """Draw each robot's recent path, with one line per stretch of the same activity."""
        begin = max(0, at - length)
        for robot in range(len(self._radius)):
            way = self._places[begin : at + 1, robot].tolist()
            does = self._doing[begin : at + 1, robot].tolist()
            start = 0
            for end in range(1, len(way)):
                if end == len(way) - 1 or does[end + 1] != does[end]:
                    points = [tuple(point) for point in way[start : end + 1]]
                    pen.draw.line(points, fill=palette[does[end]], width=wide, joint="curve")
                    start = end

    def _discs(self, pen: RasterCanvas, at: int) -> None:
        rows = zip(
            self._where[at].tolist(), self._heading[at].tolist(), self._doing[at].tolist(), strict=True
        )
        bodies = None if self._sides is None else self._sides.robots
        calls = self.frames[at].view.robots.signal.tolist()
        for robot, ((x, y), heading, doing) in enumerate(rows):
            radius = self._radius[robot] + 0.05 * measure_mark_unit(self.frames[at].view)
            does = self._palette[doing]
            if bodies is None:
                pen.draw_robot(x, y, heading, radius, (does, self._rims[robot], PAPER))
            else:
                pen.draw_robot(x, y, heading, radius, (bodies[robot], INK, PAPER))
                pen.circle(x, y, CORE * radius, does, PAPER)
            if calls[robot] >= 0:
                pen.circle(x, y, CALLING * radius, None, does)

    def _stamped(self, image: Image, at: int) -> Image:
        """Return the picture with a dot for each robot, drawn together by size."""
        from PIL import Image as images

        pixels = np.array(image)
        sizes = np.maximum(np.array(self._radius) * self._scale, LEAST_DOT * FINE)
        does = self._rgb(self._palette)[self._doing[at]]
        layers = [(sizes, does)]
        if self._sides is not None:
            cores = np.where(CORE * sizes >= LEAST_CORE * FINE, CORE * sizes, 0.0)
            layers = [(sizes, self._rgb(self._sides.robots)), (cores, does)]
        for radii, paints in layers:
            self._stamp(pixels, self._places[at], radii, paints)
        return images.fromarray(pixels)

    def _stamp(
        self, pixels: NDArray[np.uint8], places: Points, sizes: NDArray[np.float64], paints: NDArray[np.uint8]
    ) -> None:
        """Draw discs at places [N, 2], of radii [N] (fine pixels; 0 for none) and colors [N, 3]."""
        tall, wide, _ = pixels.shape
        for size in np.unique(sizes[sizes > 0]):
            rows = np.flatnonzero(sizes == size)
            reach = np.arange(-int(size), int(size) + 1)
            dx, dy = (
                grid[np.hypot(*np.meshgrid(reach, reach)) <= size] for grid in np.meshgrid(reach, reach)
            )
            center = places[rows].round().astype(np.int64)
            x = np.clip(center[:, :1] + dx, 0, wide - 1)
            y = np.clip(center[:, 1:] + dy, 0, tall - 1)
            pixels[y, x] = paints[rows][:, None]


class FrameBuffer:
    """A buffer of a run's frames; when it is full, it drops every second frame and then keeps half as many."""

    def __init__(self, most: int | None = None) -> None:
        """Keep at most `most` frames; by default a number that depends on the number of robots."""
        self._most = most
        self._kept: ThinningBuffer[RunFrame] | None = None

    def append(self, frame: RunFrame) -> None:
        """Add the next frame of the run."""
        if self._kept is None:
            fitting = max(LEAST_FRAMES, MOST_ROWS // max(1, len(frame.doing)))
            self._kept = ThinningBuffer(self._most or min(MOST_BUFFERED_FRAMES, fitting))
        self._kept.append(frame)

    @property
    def frames(self) -> list[RunFrame]:
        """The frames kept, with the first and the last frame always among them."""
        return [] if self._kept is None else self._kept.items


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
