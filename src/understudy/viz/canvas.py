"""Draw worlds into raster images with coordinates in meters, at a higher resolution than shown, for smooth edges."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import TYPE_CHECKING

from understudy.sim.view import WorldView
from understudy.viz.appearance import (
    ObjectMark,
    Points,
    choose_obstacle_colors,
    list_object_marks,
    measure_loading_reach,
)
from understudy.viz.palette import EDGE, GROUND, INK, PAPER, SOLID, blend_color

if TYPE_CHECKING:
    from PIL.Image import Image

FINE = 2
"""The factor by which images are drawn larger before they are reduced."""


class RasterCanvas:
    """A canvas that draws a world into an image: x to the right, y up, `scale` fine pixels per m.

    `corner` is the arena's upper left corner (fine pixels), `tall` its height (m).
    """

    def __init__(self, image: Image, *, tall: float, scale: float, corner: tuple[float, float]) -> None:
        from PIL import ImageDraw

        self.draw, self.scale, self._size = ImageDraw.Draw(image), scale, image.size
        self._left, self._bottom = corner[0], corner[1] + tall * scale

    def to_pixel(self, x: float, y: float) -> tuple[float, float]:
        """Convert a place (m) to fine pixels."""
        return self._left + x * self.scale, self._bottom - y * self.scale

    def to_pixels(self, places: Points) -> Points:
        """Convert places [..., 2] (m) to fine pixels [..., 2]."""
        flipped: Points = places * (self.scale, -self.scale) + (self._left, self._bottom)
        return flipped

    def circle(
        self, x: float, y: float, radius: float, fill: str | None, line: str | None = None, wide: int = FINE
    ) -> None:
        """Draw a circle, filled, in outline, or both; `wide` is the width of the line (fine pixels)."""
        (px, py), size = self.to_pixel(x, y), radius * self.scale
        self.draw.ellipse((px - size, py - size, px + size, py + size), fill=fill, outline=line, width=wide)

    def square(self, x: float, y: float, half: float, fill: str | None, line: str | None = None) -> None:
        """Draw a square around a place, filled, in outline, or both."""
        self.draw.rectangle(
            (*self.to_pixel(x - half, y + half), *self.to_pixel(x + half, y - half)),
            fill=fill,
            outline=line,
            width=FINE,
        )

    def draw_robot(self, x: float, y: float, heading: float, radius: float, colors: Sequence[str]) -> None:
        """Draw a robot as a disc with a line towards its front; `colors` are those of disc, rim and line."""
        fill, rim, nose = colors
        self.circle(x, y, radius, fill, rim, 2 * FINE if rim != INK else FINE)
        ahead = x + radius * cos(heading), y + radius * sin(heading)
        self.draw.line([self.to_pixel(x, y), self.to_pixel(*ahead)], fill=nose, width=2 * FINE)

    def draw_arena(self, view: WorldView) -> None:
        """Draw the arena with its obstacles and walls."""
        bounds = (*self.to_pixel(0, view.height), *self.to_pixel(view.width, 0))
        self.draw.rectangle(bounds, fill=GROUND, outline=INK, width=2 * FINE)
        for corners in view.polygons:
            points = [tuple(point) for point in self.to_pixels(corners).tolist()]
            self.draw.polygon(points, fill=SOLID, outline=EDGE, width=FINE)
        discs = view.discs
        rows = zip(
            discs.x.tolist(),
            discs.y.tolist(),
            discs.radius.tolist(),
            choose_obstacle_colors(view),
            strict=True,
        )
        for x, y, radius, color in rows:
            self.circle(x, y, radius, color, blend_color(color, INK, 0.7))
        for x0, y0, x1, y1 in view.walls.tolist():
            self.draw.line([self.to_pixel(x0, y0), self.to_pixel(x1, y1)], fill=INK, width=2 * FINE)
        self._trim(bounds)

    def draw_objects(self, view: WorldView) -> None:
        """Draw the objects, with the share of food left in sources, and the reach for loading and unloading."""
        near = measure_loading_reach(view)
        for thing in list_object_marks(view):
            if thing.served and near is not None:
                self.circle(thing.x, thing.y, near, None, blend_color(thing.color, GROUND, 0.4))
            if thing.full < 1.0:
                self._shape(thing, thing.size, blend_color(thing.color, GROUND, 0.28), thing.color)
                self._shape(thing, thing.size * thing.full, thing.color, None)
            else:
                self._shape(
                    thing,
                    thing.size,
                    thing.color,
                    blend_color(thing.color, INK, 0.7) if thing.rimmed else None,
                )

    def _trim(self, bounds: tuple[float, float, float, float]) -> None:
        """Erase everything outside the arena."""
        left, top, right, bottom = bounds
        wide, tall = self._size
        outside = ((0, 0, wide, top), (0, bottom, wide, tall), (0, 0, left, tall), (right, 0, wide, tall))
        for box in outside:
            self.draw.rectangle(box, fill=PAPER)
        self.draw.rectangle(bounds, outline=INK, width=2 * FINE)

    def _shape(self, thing: ObjectMark, half: float, fill: str, line: str | None) -> None:
        (self.square if thing.square else self.circle)(thing.x, thing.y, half, fill, line)
