"""Draw one moment of a world as an array of pixels, without a legend, for programs that show or film it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.sim.view import WorldView
from understudy.viz.appearance import choose_robot_colors, measure_mark_unit
from understudy.viz.canvas import FINE, RasterCanvas
from understudy.viz.palette import INK, PAPER
from understudy.viz.team_colors import assign_team_colors

MARGIN = 8
"""The width of the margin around the arena, pixels."""
ROBOT = "#4f6d8f"
"""The color of a robot that has neither a color nor a team."""


def draw_world_picture(view: WorldView, *, pixels: int = 480) -> NDArray[np.uint8]:
    """Draw a world.

    Parameters
    ----------
    view
        The world.
    pixels
        Length of the longer side of the picture.

    Returns
    -------
    NDArray[np.uint8]
        The picture [height, width, 3], red, green and blue.
    """
    from PIL import Image

    scale = FINE * (pixels - 2 * MARGIN) / max(view.width, view.height)
    size = [FINE * round((side * scale + 2 * FINE * MARGIN) / FINE) for side in (view.width, view.height)]
    image = Image.new("RGB", (size[0], size[1]), PAPER)
    pen = RasterCanvas(image, tall=view.height, scale=scale, corner=(FINE * MARGIN, FINE * MARGIN))
    pen.draw_arena(view)
    pen.draw_objects(view)
    robots, sides, rims = view.robots, assign_team_colors(view), choose_robot_colors(view)
    least = 0.02 * measure_mark_unit(view)
    for robot, (x, y, heading, radius) in enumerate(
        zip(robots.x, robots.y, robots.heading, robots.radius, strict=True)
    ):
        fill = ROBOT if sides is None else sides.robots[robot]
        pen.draw_robot(x, y, heading, max(radius, least), (fill, rims[robot] or INK, PAPER))
    return np.asarray(image.reduce(FINE))
