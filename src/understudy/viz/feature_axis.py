"""Axes of plots for features: values of any kind, absence included, on a line of cells between thresholds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import degrees, isnan, nan, radians
from typing import TYPE_CHECKING, Literal

from understudy.model.describe import is_angle
from understudy.model.features import BoundFeature
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.viz.axes import escape_math

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STRIP = 0.07
"""The width of the strip for absent values, and of the gap beside it, as a share of the axis."""
PAD = 0.06
"""The space beyond the outermost values, as a share of their range."""


@dataclass(frozen=True)
class AxisCell:
    """A stretch of an axis, from `low` to `high`, on which no threshold lies; `sample` is a value in it."""

    low: float
    high: float
    sample: float


class FeatureAxis:
    """One axis of a plot: the positions of a feature's values on it.

    Angles are in degrees from −180 to 180, labels at whole numbers, other values at themselves. Absent values have a
    strip of their own at the low end, if there are any.

    Parameters
    ----------
    bound
        The feature.
    values
        Its values in the examples that are drawn.
    cuts
        Its thresholds.
    """

    def __init__(self, bound: BoundFeature, values: Iterable[float], cuts: Iterable[float]) -> None:
        self._kind, self._angle = bound.kind, is_angle(bound)
        unit = "°" if self._angle else bound.feature.unit
        self.label = escape_math(f"{bound} ({unit})" if unit else str(bound))
        values = list(values)
        self.low, self.high = self._limits([self._place(value) for value in values if not isnan(value)])
        self._has_absent = any(isnan(value) for value in values)
        size = STRIP * (self.high - self.low)
        self._strip = (self.low - 2 * size, self.low - size)
        self.cells = self._list_cells(cuts)

    @property
    def start(self) -> float:
        """The lowest position on the axis."""
        return self._strip[0] if self._has_absent else self.low

    @property
    def is_categorical(self) -> bool:
        """Whether the values are labels."""
        return isinstance(self._kind, Categorical)

    def position(self, value: float) -> float:
        """Return the position of a value; absent values are in the middle of their strip."""
        return sum(self._strip) / 2 if isnan(value) else self._place(value)

    def write_ticks(self, axes: Axes, side: Literal["x", "y"]) -> None:
        """Set the limits, the label and the ticks of one side of the axes."""
        axis = axes.xaxis if side == "x" else axes.yaxis
        (axes.set_xlim if side == "x" else axes.set_ylim)(self.start, self.high)
        axis.set_label_text(self.label)
        if isinstance(self._kind, Categorical):
            ticks: list[float] = [float(index) for index in range(len(self._kind.labels))]
            names: list[str] = [escape_math(label) for label in self._kind.labels]
        elif self._angle and self.high - self.low > 180:
            ticks = [-180.0, -90.0, 0.0, 90.0, 180.0]
            names = [f"{tick:.0f}".replace("-", "−") for tick in ticks]
        else:
            from matplotlib.ticker import MaxNLocator

            positions = MaxNLocator(6).tick_values(self.low, self.high)
            ticks = [float(tick) for tick in positions if self.low <= tick <= self.high]
            names = [f"{tick:g}".replace("-", "−") for tick in ticks]
        if self._has_absent:
            ticks, names = [self.position(nan), *ticks], ["absent", *names]
        axis.set_ticks(ticks, names)

    def _place(self, value: float) -> float:
        if not self._angle:
            return value
        degree = degrees(value) % 360.0
        return degree - 360.0 if degree > 180.0 else degree

    def _value(self, position: float) -> float:
        return radians(position % 360.0) if self._angle else position

    def _limits(self, places: Sequence[float]) -> tuple[float, float]:
        if isinstance(self._kind, Categorical):
            return -0.5, len(self._kind.labels) - 0.5
        if self._angle:
            return -180.0, 180.0
        if isinstance(self._kind, Toroidal):
            return 0.0, self._kind.period
        low, high = min(places, default=0.0), max(places, default=1.0)
        pad = PAD * (high - low) or 0.5
        return low - pad, high + pad

    def _list_cells(self, cuts: Iterable[float]) -> list[AxisCell]:
        if isinstance(self._kind, Categorical):
            cells = [
                AxisCell(index - 0.5, index + 0.5, float(index)) for index in range(len(self._kind.labels))
            ]
        else:
            inner = sorted({self._place(cut) for cut in cuts})
            edges = [self.low, *(cut for cut in inner if self.low < cut < self.high), self.high]
            cells = [AxisCell(low, high, self._value((low + high) / 2)) for low, high in pairwise(edges)]
        return [AxisCell(*self._strip, nan), *cells] if self._has_absent else cells

    def divide(self, parts: int) -> list[AxisCell]:
        """Divide the cells of the line into about as many parts of one length, for functions without thresholds."""
        pieces = []
        for cell in self.cells:
            if self.is_categorical or isnan(cell.sample):
                pieces.append(cell)
                continue
            count = max(1, round(parts * (cell.high - cell.low) / (self.high - self.low)))
            step = (cell.high - cell.low) / count
            ends = [cell.low + step * at for at in range(count)] + [cell.high]
            pieces += [AxisCell(low, high, self._value((low + high) / 2)) for low, high in pairwise(ends)]
        return pieces
