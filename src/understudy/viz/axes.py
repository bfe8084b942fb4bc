"""Axes of plots: make them in one style, and draw geometry in units of a picture, whose text scales with it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from understudy.viz.palette import FAINT, INK, LINE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # which matplotlib ships, so that a plot is the same everywhere
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "grid.color": LINE,
    "hatch.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "pdf.fonttype": 42,  # text stays text
    "svg.fonttype": "none",
    "svg.hashsalt": "understudy",  # the same plot gives the same file
}
"""The settings of matplotlib for figures of this package."""
PIXELS_PER_IN = 96.0
"""The number of picture units per inch of a figure that is made for a picture."""


def make_axes(width_in: float, height_in: float) -> Axes:
    """Make axes in a new figure of pyplot, which notebooks show and `matplotlib.pyplot.show` opens."""
    import matplotlib as mpl
    from matplotlib import pyplot

    with mpl.rc_context(STYLE):
        return pyplot.figure(figsize=(width_in, height_in), layout="constrained").add_subplot()


def make_figure(width_in: float, height_in: float) -> Figure:
    """Make a figure that pyplot does not know, to write to a file."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_in, height_in))


def make_picture_axes(width: float, height: float) -> Axes:
    """Make axes that fill a new figure of pyplot, for a picture of a size in picture units."""
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(width / PIXELS_PER_IN, height / PIXELS_PER_IN))
    return figure.add_axes((0.0, 0.0, 1.0, 1.0))


def open_picture(axes: Axes, width: float, height: float) -> None:
    """Prepare axes for a picture: x to the right, y down, one unit as long in both directions, no ticks."""
    axes.set(xlim=(0.0, width), ylim=(height, 0.0))
    axes.set_aspect("equal")
    axes.set_axis_off()


def write_scaled_text(
    axes: Axes,
    x: float,
    y: float,
    text: str,
    size: float,
    *,
    bold: bool = False,
    align: str = "left",
    color: str = INK,
) -> None:
    """Write a text on its base line, of a font size in picture units, which scales with the axes."""
    artist = _scaled_text_class()(
        x, y, text, units=size, color=color, ha=align, va="baseline", fontweight="bold" if bold else "normal",
        fontfamily="DejaVu Sans", clip_on=False, zorder=6, parse_math=False,
    )  # fmt: skip
    axes.add_artist(artist)


@lru_cache(1)
def _scaled_text_class() -> Any:
    """Make the class of texts on the first call, since matplotlib is imported late."""
    from matplotlib.text import Text

    class ScaledText(Text):
        """A text whose font size is in units of the axes."""

        def __init__(self, *args: Any, units: float, **settings: Any) -> None:
            self._units = units
            super().__init__(*args, **settings)

        def draw(self, renderer: Any) -> None:
            self._rescale()
            super().draw(renderer)

        def get_window_extent(self, *args: Any, **settings: Any) -> Any:
            self._rescale()
            return super().get_window_extent(*args, **settings)

        def _rescale(self) -> None:
            self.set_fontsize(max(self._units * measure_points_per_unit(self.axes), 0.1))

    return ScaledText


def escape_math(text: str) -> str:
    """Return a text in which matplotlib finds no formula, such as "$" in the name of a state."""
    return text.replace("$", r"\$")


def measure_points_per_unit(axes: Any) -> float:
    """Return the length in points of one picture unit in axes as they are now."""
    axes.apply_aspect()
    low, high = axes.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    return float(high[0] - low[0]) * 72.0 / float(axes.figure.dpi)


@lru_cache(4096)
def measure_text(text: str, size: float, bold: bool) -> float:
    """Return the exact width of a text in the font of plots."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal", size=size)
    width: float = text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]
    return float(width)
