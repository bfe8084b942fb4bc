"""The sensitivity of the results: the same novices with each parameter of the model multiplied by 0.5 and 1.5."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from understudy_lab.figures import COLORS
from understudy_lab.novices.failure_causes import (
    format_succeeding,
    has_succeeded,
    select_unchanged,
    succeeds_everywhere,
    summarize_both_readings,
)
from understudy_lab.novices.novice import PARAMETERS
from understudy_lab.rows import Rows
from understudy_lab.statistics import apply_holm_correction, pairs_differ
from understudy_lab.study import ResultTable, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SENSITIVITY = 50
"""The number of novices, counted from the first, that are run again with each parameter changed."""
FACTORS = (0.5, 1.5)
READINGS = {"half": has_succeeded, "everywhere": succeeds_everywhere}

SAID: Mapping[str, str] = {
    "reaction_s": "mean reaction",
    "slips": "chance of a slip",
    "lapses": "share of time not looking",
    "misjudged": "error in judging the distance",
    "left_out": "situations that do not occur to them",
    "off_middle_px": "error in judging the middle of the frame",
    "misunderstood": "chance of a misunderstanding",
    "at_edge": "share who turn at the edge of the frame",
    "edge_px": "width of the edge of the frame",
    "carry_s": "time to move the robot elsewhere",
    "patience_s": "patience",
    "spread": "spread of reactions",
    "least_s": "fastest reaction",
    "stop_s": "time to cancel a press",
    "lapse_s": "length of a lapse",
    "emerged_px": "margin for a ball in the frame",
    "other_px": "margin for a ball beyond the middle",
    "distance_m": "distance from the ball at placement",
    "given_s": "teaching time",
}
"""The names of the parameters in tables."""


def select_changed(rows: Sequence[Row], name: str, factor: float) -> Rows:
    """Return the rows of novices with this parameter multiplied by this factor."""
    return Rows(rows).where(trait=name, factor=factor)


def numbers(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Count the novices who succeed, by parameter, factor and criterion of success."""
    return {
        name: {str(factor): summarize_both_readings(select_changed(rows, name, factor)) for factor in FACTORS}
        for name in PARAMETERS
    }


def chances(rows: Sequence[Row]) -> dict[tuple[str, float, str], float]:
    """Return the p-value of each change: each novice is compared with itself without the change."""
    before = {row["task"]["seed"]: row for row in select_unchanged(rows)}
    p_values = {}
    for name in PARAMETERS:
        for factor in FACTORS:
            now = select_changed(rows, name, factor)
            for reading, well in READINGS.items():
                was = [well(before[row["task"]["seed"]]) for row in now]
                p_values[name, factor, reading] = pairs_differ(was, [well(row) for row in now])
    return p_values


def list_significant_changes(rows: Sequence[Row]) -> set[tuple[str, float, str]]:
    """Return the changes that have a significant effect after Holm's correction."""
    p_values = chances(rows)
    return {
        key
        for key, remains in zip(p_values, apply_holm_correction(list(p_values.values())), strict=True)
        if remains
    }


def table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of success with each parameter changed, by both criteria."""
    same, remain = (
        summarize_both_readings(select_unchanged(rows)[:SENSITIVITY]),
        list_significant_changes(rows),
    )

    def cell(name: str, reading: str, factor: float) -> str:
        star = " *" if (name, factor, reading) in remain else ""
        return format_succeeding(select_changed(rows, name, factor), READINGS[reading]) + star

    return ResultTable(
        f"Success of the first {same['half']['of']} novices with one parameter changed (unchanged: "
        f"{same['half']['succeed']} succeed, {same['everywhere']['succeed']} from each position; *: differs from that "
        "significantly at 5 % after Holm's correction for all changes)",
        ("", *(f"#{what}, ×{factor}" for what in ("half", "each") for factor in FACTORS)),
        [
            (SAID[name], *(cell(name, reading, factor) for reading in READINGS for factor in FACTORS))
            for name in PARAMETERS
        ],
    )


def note(rows: Sequence[Row]) -> str:
    """Return a note on the range of success over all changes, and on the constants that were not varied."""
    within = {
        reading: [
            found["succeed"]
            for name in PARAMETERS
            for factor in FACTORS
            if (found := summarize_both_readings(select_changed(rows, name, factor))[reading])["of"]
        ]
        for reading in READINGS
    }
    ranges = {
        reading: f"{min(found)} to {max(found)}" if found else "none" for reading, found in within.items()
    }
    stay = list_significant_changes(rows)
    remain = [
        f"{SAID[name]} ×{factor}"
        for name in PARAMETERS
        for factor in FACTORS
        if any((name, factor, reading) in stay for reading in READINGS)
    ]
    return (
        f"Whichever parameter is changed, {ranges['half']} of the first {SENSITIVITY} novices succeed, and "
        f"{ranges['everywhere']} from each position. Changes with a significant effect: "
        f"{', '.join(remain) or 'none'}.{_minutes(rows)} Not varied: what the question fixes (the robot and its "
        "camera, 15 cm, the thirty trials), the bearings that define the situations, and draws with equal chances "
        "(which mistake, which other button a slip hits, to which side they turn first). Distances above 2.85 m were "
        "not possible, because the field ends there."
    )


def _minutes(rows: Sequence[Row]) -> str:
    """Return a sentence on the effect of the teaching time."""
    less, more = (select_changed(rows, "given_s", factor) for factor in FACTORS)
    if not less or len(less) != len(more):
        return ""
    p = pairs_differ([succeeds_everywhere(row) for row in less], [succeeds_everywhere(row) for row in more])
    counts = [sum(map(succeeds_everywhere, of)) for of in (less, select_unchanged(rows)[: len(less)], more)]
    return (
        f" More time does not help: {counts[0]}, {counts[1]} and {counts[2]} succeed from each position after 2.5, 5 "
        f"and 7.5 minutes (p = {p:.2g} between first and last, not corrected for this selection). With more time there "
        "are more occasions to press a turn back."
    )


def draw(axes: Axes, rows: Sequence[Row]) -> None:
    """Draw success with each parameter changed: filled for half of all trials, hollow for each position."""
    same = summarize_both_readings(select_unchanged(rows)[:SENSITIVITY])
    for now in same.values():
        axes.axvline(100 * now["succeed"] / now["of"], color="#6b7280", linewidth=1, linestyle=":")
    for factor, color, up in zip(FACTORS, COLORS, (0.17, -0.17), strict=False):
        for what, fill in (("half", color), ("everywhere", "white")):
            summaries = [
                summarize_both_readings(select_changed(rows, name, factor))[what] for name in PARAMETERS
            ]
            at = [(k + up, each) for k, each in enumerate(summaries) if each["of"]]
            low, high = ([100 * each[end] for _, each in at] for end in ("low", "high"))
            middle = [100 * each["succeed"] / each["of"] for _, each in at]
            heights = [height for height, _ in at]
            axes.hlines(heights, low, high, color=color, linewidth=1)
            label = f"×{factor}" if fill == color else None
            axes.plot(middle, heights, "o", color=color, markerfacecolor=fill, markersize=4, label=label)
    axes.set_yticks(range(len(PARAMETERS)), [SAID[name] for name in PARAMETERS], fontsize=7)
    axes.set_ylim(len(PARAMETERS) - 0.4, -0.6)
    axes.set_xlim(0, 103)
    axes.set_xlabel("novices who succeed, %\n(hollow: from each position)")
    axes.set_title("with one parameter changed")
    axes.legend(fontsize=7.5, loc="center left", frameon=False)
