"""Plot evaluations: the share of worlds that had finished by each time, with exact intervals."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from understudy.model.value_kinds import Column
from understudy.viz.axes import escape_math, make_axes
from understudy.viz.palette import COLORS, FAINT, INK, PAPER, blend_color

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Interval: TypeAlias = Callable[[int, int], tuple[float, float]]
"""A function that computes the 95 % interval of a share from a count and the number of worlds."""
WIDE_IN, TALL_IN = 5.4, 3.4
TAUGHT, BASELINE = COLORS[0], COLORS[1]


class PlottedOutcomes(Protocol):
    """The results of N worlds: the time to finish of each [N], s, NaN where the limit came first, and the limits."""

    seconds: Column
    limit_s: Column


class PlottedEvaluation(Protocol):
    """The part of an evaluation that a plot needs: names, the results, and those of the baseline if there is one."""

    behavior: str
    world: str
    taught: PlottedOutcomes
    expert: PlottedOutcomes | None


def plot_evaluation(evaluation: PlottedEvaluation, interval: Interval, ax: Axes | None = None) -> Axes:
    """Plot the share of worlds finished by each time, of the behavior and of the baseline, with their intervals."""
    from matplotlib.ticker import PercentFormatter

    axes = make_axes(WIDE_IN, TALL_IN) if ax is None else ax
    both = [each for each in (evaluation.taught, evaluation.expert) if each is not None]
    ends = [np.nan_to_num(each.seconds, nan=0.0).max(initial=0.0) for each in both]
    unfinished = bool(np.isnan(evaluation.taught.seconds).any())
    end = float(max([*ends, evaluation.taught.limit_s.max() if unfinished else 0.0])) * 1.02 or 1.0
    _draw(axes, evaluation.taught, evaluation.behavior, TAUGHT, "-", end, interval)
    if evaluation.expert is not None:
        _draw(axes, evaluation.expert, "baseline", BASELINE, "--", end, interval)
    worlds = len(evaluation.taught.seconds)
    axes.set(
        xlim=(0.0, end), ylim=(0.0, 1.03), xlabel="time (s)", ylabel=f"share of {worlds} worlds finished"
    )
    axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    axes.set_title(
        escape_math(f"{evaluation.behavior} in {evaluation.world}"),
        loc="left",
        fontsize=10,
        fontweight="bold",
        color=INK,
    )
    axes.grid(axis="y", color=blend_color(FAINT, PAPER, 0.3), lw=0.6)
    axes.set_axisbelow(True)
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(0.0, -0.18),
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        borderaxespad=0.0,
        handlelength=2.6,
    )
    return axes


def _draw(
    axes: Axes,
    outcomes: PlottedOutcomes,
    name: str,
    color: str,
    style: str,
    end: float,
    interval: Interval,
) -> None:
    """Draw a curve in steps, the band of its intervals, and the final share with its interval in the legend."""
    times = np.sort(outcomes.seconds[~np.isnan(outcomes.seconds)])
    worlds = len(outcomes.seconds)
    steps, counts = np.unique(times, return_counts=True)
    total = np.concatenate([[0], np.cumsum(counts)])
    at = np.concatenate([[0.0], steps, [end]])
    shares = np.append(total, total[-1]) / worlds
    limits = np.array([interval(int(count), worlds) for count in total])
    limits = np.vstack([limits, limits[-1:]])
    low, high = (100 * limit for limit in limits[-1])
    label = f"{name}: {total[-1]} of {worlds} (95 % interval {low:.0f} to {high:.0f} %)"
    axes.fill_between(at, limits[:, 0], limits[:, 1], step="post", color=color, alpha=0.14, lw=0.0, zorder=2)
    for limit in limits.T:
        axes.step(at, limit, where="post", color=color, lw=0.6, ls=style, alpha=0.6, zorder=2)
    axes.step(at, shares, where="post", color=color, lw=1.8, ls=style, label=escape_math(label), zorder=3)
