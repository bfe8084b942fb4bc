"""A run in motion, as an animated GIF: robots with trails where there are few, dots where there are many."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.sim.view import RunFrame
from understudy.storage.atomic_write import write_atomically
from understudy.viz.appearance import (
    FEW,
    Points,
    choose_robot_colors,
    collect_robot_places,
    index_activities,
    measure_mark_unit,
)
from understudy.viz.canvas import FINE, RasterCanvas
from understudy.viz.caption import Caption
from understudy.viz.palette import FOOD, GROUND, HOME, INK, PAPER, SOLID, assign_name_colors, blend_color
from understudy.viz.team_colors import assign_team_colors

if TYPE_CHECKING:
    from PIL.Image import Image


WIDE, TALL, LEAST, MARGIN = 440, 520, 300, 14
"""Pixels: of the picture and its arena at most, of its caption at least, and around the arena."""
MOST_DRAWN_FRAMES = 300
TRAIL = 60
"""How many frames a robot's trail is long; of several robots they share it."""
DISCS, TAILS = 60, 2000
"""So many robots are drawn with their headings, more are dots; so many have tails that show where they came from."""
TAIL, LEAST_DOT = 3, 1.4
CORE, LEAST_CORE = 0.5, 1.0
"""Where there are sides, a robot has its side's color, and the core of it (a share of its radius, and at least so many
pixels; smaller is left out) that of what it does.
"""
CALLING = 1.6
"""The ring around a robot that raises a signal, in its radii."""
COLORS, SAMPLES, SAME = 128, 8, 10
"""Colors of the palette, pictures that it is made of, and how close colors (of 255) are taken for one."""


def draw_run_gif(
    frames: Sequence[RunFrame], path: Path | str, *, speed: float = 8.0, per_s: float = 16.0
) -> None:
    """Write the run, `speed` times as fast as it was, `per_s` pictures a second; long runs go faster."""
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
    """Frames about `every_s` of simulated time apart, first and last among them, MOST_FRAMES at most."""
    length = frames[-1].view.time_s - frames[0].view.time_s
    every_s = max(every_s, length / (MOST_DRAWN_FRAMES - 2))
    chosen, due = [], frames[0].view.time_s
    for frame in frames[:-1]:
        if frame.view.time_s >= due - 1e-9:
            chosen.append(frame)
            due += every_s
    return [*chosen, frames[-1]]


class _FrameRenderer:
    """The pictures of a run; what stays is drawn once."""

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
        """The picture of a frame."""
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
        """One palette for all pictures, from some of them side by side."""
        from PIL import Image

        last = {doing: at for at, row in enumerate(self._doing) for doing in set(row.tolist())}
        spread = np.linspace(0, len(self.frames) - 1, SAMPLES).round().astype(int).tolist()
        pictures = [self.render(at) for at in sorted({*list(last.values())[:SAMPLES], *spread})]
        wide, tall = pictures[0].size
        together = Image.new("RGB", (wide * len(pictures), tall))
        for at, picture in enumerate(pictures):
            together.paste(picture, (at * wide, 0))
        reduced = together.quantize(COLORS)
        known = np.array(reduced.getpalette()).reshape(-1, 3)
        sides = () if self._sides is None else self._sides.colors
        exact = self._rgb([FOOD, HOME, SOLID, *self._palette, *sides, INK, GROUND, PAPER])
        far = np.abs(known[:, None] - exact.astype(np.int64)).max(axis=2)
        close = far.min(axis=1) < SAME
        known[close] = exact[far.argmin(axis=1)[close]]
        known[far.argmin(axis=0)] = exact  # those that nothing is close to
        reduced.putpalette(known.reshape(-1).tolist())
        return reduced

    def _rgb(self, colors: Sequence[str]) -> NDArray[np.uint8]:
        return np.array([tuple(bytes.fromhex(color[1:])) for color in colors], np.uint8)

    def _pen(self, image: Image) -> RasterCanvas:
        tall = self.frames[-1].view.height
        return RasterCanvas(image, tall=tall, scale=self._scale, corner=self._corner)

    def _trails(self, pen: RasterCanvas, at: int, length: int, wide: int, palette: Sequence[str]) -> None:
        """Where the robots came from lately, a line for each stretch of one doing."""
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
        """The picture with a dot for each robot, all of one size at once."""
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
        """Discs at places [N, 2], of sizes [N] (fine pixels; none of size 0) and colors [N, 3]."""
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


MOST_BUFFERED_FRAMES, LEAST_FRAMES, MOST_ROWS = 20_000, 600, 2_000_000


class FrameBuffer:
    """Frames of a run: when they become too many, every other one goes, and from then on half as many come."""

    def __init__(self, most: int | None = None) -> None:
        """`most` frames are kept; if left out, as many as are good for so many robots."""
        self._most, self._frames, self._every, self._seen = most, list[RunFrame](), 1, 0
        self._last: RunFrame | None = None

    def append(self, frame: RunFrame) -> None:
        """The next moment of the run."""
        most = self._most or min(
            MOST_BUFFERED_FRAMES, max(LEAST_FRAMES, MOST_ROWS // max(1, len(frame.doing)))
        )
        if self._seen % self._every == 0:
            if len(self._frames) >= most:
                self._frames, self._every = self._frames[::2], 2 * self._every
            if self._seen % self._every == 0:
                self._frames.append(frame)
        self._seen += 1
        self._last = frame

    @property
    def frames(self) -> list[RunFrame]:
        """What was kept; the first moment and the last are always among it."""
        late = self._last is not None and self._frames[-1] is not self._last
        return [*self._frames, self._last] if late and self._last is not None else list(self._frames)
