"""The findings: each variant compared with its reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.ablation.evaluate import WORLDS
from understudy_lab.ablation.variants import BASE, SILENT, VARIANTS
from understudy_lab.figures import COLORS, panels
from understudy_lab.statistics import compute_paired_p, format_median
from understudy_lab.study import ResultTable, Row, StudyFindings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SURE = 0.01
MEASURES = {
    "success": "success",
    "food per second": "relative_to_expert",
    "GoTo as shown": "arrives_as_shown",
    "presses": "presses",
    "teaching time": "teaching_seconds",
}
"""The measures by which variants are compared."""


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Compare each variant with its reference, and summarize."""
    found = {name: summarize_variant(rows, name) for name in VARIANTS}
    seeds = sorted({row["task"]["seed"] for row in rows})
    return StudyFindings(
        headline=_headline(found),
        tables=(
            ResultTable(
                f"{len(seeds)} teachings each (seeds {seeds[0]} to {seeds[-1]}), tested in {WORLDS} unseen worlds: "
                "medians (smallest–largest)",
                (
                    "variant",
                    "part varied",
                    "#teachings with 95 % success",
                    "#food per second / hand-written",
                    "#examples",
                    "#presses",
                    "#teaching time, s",
                    "#GoTo arrives before corrections (mean)",
                ),
                [_told(rows, name) for name in VARIANTS],
            ),
            ResultTable(
                f"Significant differences between medians (of success, means), in signed-rank tests over seeds at p < "
                f"{SURE}. About one of {len(MEASURES) * (len(VARIANTS) - 1)} comparisons is significant by chance",
                ("variant", "compared with", "differences"),
                [
                    (name, VARIANTS[name].against, ", ".join(found[name]["differs"]) or "none")
                    for name in VARIANTS
                    if name != BASE
                ],
            ),
        ),
        notes=NOTES,
        numbers={"variants": found},
    )


def values(rows: Sequence[Row], name: str, measure: str) -> list[float]:
    """Return one measure of all teachings of a variant, in order of seeds; missing values are 0."""
    mine = sorted(
        (row for row in rows if row["task"]["variant"] == name), key=lambda row: int(row["task"]["seed"])
    )
    return [float(row[measure] or 0.0) for row in mine]


def summarize_variant(rows: Sequence[Row], name: str) -> dict[str, Any]:
    """Return the medians of a variant (means for success shares), and its differences from its reference."""
    against = VARIANTS[name].against
    differs = []
    for said, measure in MEASURES.items():
        ours, theirs = values(rows, name, measure), values(rows, against, measure)
        if name != BASE and compute_paired_p(ours, theirs) < SURE:
            of = _mean if measure in MEANS else _median
            digits = 0 if measure in ("presses", "teaching_seconds") else 2
            differs.append(f"{said} {of(theirs):.{digits}f} → {of(ours):.{digits}f}")
    success = np.array(values(rows, name, "success"))
    return {
        "teachings_reaching_95": int((success >= 0.95).sum()),
        "of": len(success),
        **{
            measure: round((_mean if measure in MEANS else _median)(values(rows, name, measure)), 4)
            for measure in (*MEASURES.values(), "examples")
        },
        "differs": differs,
    }


MEANS = ("success", "arrives_as_shown")


def _mean(numbers: Sequence[float]) -> float:
    return float(np.mean(numbers))


def _median(numbers: Sequence[float]) -> float:
    return float(np.median(numbers))


def _told(rows: Sequence[Row], name: str) -> tuple[str, ...]:
    found = summarize_variant(rows, name)
    return (
        name,
        VARIANTS[name].about,
        f"{found['teachings_reaching_95']} of {found['of']}",
        format_median(values(rows, name, "relative_to_expert"), 2),
        *(
            format_median(values(rows, name, measure))
            for measure in ("examples", "presses", "teaching_seconds")
        ),
        f"{found['arrives_as_shown']:.0%}",
    )


def _headline(found: Any) -> str:
    bare, features = found["no automatic defaults, not watched"], found["all features, not watched"]
    late, knows = found["1 s late, reaction time unknown"], found["1 s late, reaction time known"]
    by_hand, drawn = found["defaults by hand, not watched"], found["leaves draw by corrected votes"]

    def reach(variant: Any) -> str:
        return f"{variant['teachings_reaching_95']} of {variant['of']}"

    return (
        f"Corrections make up for most changes. Three parts of the method are necessary. Default examples: without any,"
        f" {reach(bare)} teachings reach 95 % success, with {bare['presses']:.0f} presses instead of "
        f"{found[SILENT]['presses']:.0f}; with defaults pressed by hand, {reach(by_hand)} do. The choice of features: "
        f"with all features, {reach(features)}. Leaves that decide as shown: with leaves that draw by corrected votes, "
        f"{reach(drawn)}. With a demonstrator who presses a second late, robots collect "
        f"{late['relative_to_expert']:.2f} of the food per second of the hand-written controller ({reach(late)}), or "
        f"{knows['relative_to_expert']:.2f} if the lesson knows the delay ({reach(knows)}), instead of "
        f"{found[BASE]['relative_to_expert']:.2f}."
    )


NOTES = (
    "A teaching continues until the robot needs no more corrections or the teacher gives up (after five minutes, no "
    "new attempt with an automaton begins). So variants differ in the teaching effort and in the speed of the robot. "
    "The last column is measured after the four cases shown in the lesson of GoTo, before any correction. There the "
    "boundaries matter most, and results vary widely from teaching to teaching.",
    "With leaves that draw, robots are tested in 5 worlds only, because such runs are computed tick by tick.",
    "A tick lasts 0.1 s, so nobody can press sooner than that after seeing something. A person who pressed in the same "
    "tick would correct the robot before it had done anything.",
    "The variant *all features* with watched examples was left out: its trees are grown from thousands of examples "
    "with seven angles and distances, and a teaching takes minutes.",
    "Leaves that draw were taught like *as the demo teaches*; only the final runs draw. Drawing by votes does not "
    "matter, because nearly all leaves are unanimous. With Laplace's correction, a robot leaves its state at random "
    "every few ticks.",
    "A robot that sees no flags loads as soon as food is within reach, at half a meter; GoTo reports *done* at about "
    "0.4 m. That makes this robot faster. In this world, other readings tell the same as the flags. Where only a flag "
    "tells it, flags are necessary.",
    "Angles cut by plain thresholds do as well as arcs here. The important cuts are two close to straight ahead, and "
    "neither representation jumps at an angle where these robots have to decide precisely.",
)


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success, speed and presses of every teaching, a row for each variant."""
    figure, axes = panels(3, wide=3.6, tall=6.2)
    for panel, (measure, said, scale) in zip(axes, DRAWN, strict=True):
        _lines(panel, rows, measure, scale)
        panel.set_title(said)
    axes[0].set_yticks(range(len(VARIANTS)), list(VARIANTS), fontsize=8)
    for panel in axes[1:]:
        panel.set_yticks([])
    axes[2].set_xscale("log")
    axes[2].set_xticks([20, 50, 100, 200, 500], ["20", "50", "100", "200", "500"])
    axes[2].minorticks_off()
    return figure


DRAWN = (
    ("success", "worlds finished in time, %", 100.0),
    ("relative_to_expert", "food per second, % of hand-written", 100.0),
    ("presses", "presses", 1.0),
)


def _lines(axes: Axes, rows: Sequence[Row], measure: str, scale: float) -> None:
    abouts = list(dict.fromkeys(variant.about for variant in VARIANTS.values()))
    base = scale * _median(values(rows, BASE, measure))
    axes.axvline(base, color="0.8", linewidth=1, zorder=0)
    for line, (name, variant) in enumerate(VARIANTS.items()):
        color = COLORS[abouts.index(variant.about) % len(COLORS)]
        found = scale * np.array(values(rows, name, measure))
        axes.plot(
            found, np.full(len(found), line), "o", color=color, markersize=4, alpha=0.35, markeredgewidth=0
        )
        axes.plot([np.median(found)], [line], "|", color=color, markersize=11, markeredgewidth=2)
    axes.set_ylim(len(VARIANTS) - 0.4, -0.6)
