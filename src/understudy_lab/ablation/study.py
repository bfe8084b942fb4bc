"""The experiment: many teachings of each variant and of its reference, with the same seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.ablation.evaluate import WORLDS, measure_variant
from understudy_lab.ablation.variants import BASE, SILENT, VARIANTS
from understudy_lab.declaration import Conclusion, LinePerGroup, Units
from understudy_lab.figures import COLORS, Panels
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.statistics import compute_paired_p
from understudy_lab.study import ResultTable, Row, Study, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(56_000, 56_020)
SURE = 0.01


def work(task: Task) -> Row:
    """Run and test one teaching of a variant; only the base keeps its lessons."""
    row = measure_variant(task["variant"], task["seed"])
    return row if task["variant"] == BASE else {key: row[key] for key in row if key != "lessons"}


def _present(key: str) -> Callable[[Row], float]:
    """Return a function that returns a value of a row, 0 where it is missing."""
    return lambda row: float(row[key] or 0.0)


@dataclass(frozen=True)
class _Measure:
    """A measure by which variants are compared: its key, its average, and the digits of that."""

    key: str
    average: Callable[[Sequence[float]], Any] = np.median
    digits: int = 2

    def compute(self, rows: Rows) -> float:
        return float(self.average(rows.values(_present(self.key))))


MEASURES = {
    "success": _Measure("success", np.mean),
    "food per second": _Measure("relative_to_expert"),
    "GoTo as shown": _Measure("arrives_as_shown", np.mean),
    "presses": _Measure("presses", digits=0),
    "teaching time": _Measure("teaching_seconds", digits=0),
}
"""The measures by which variants are compared."""


def _group(rows: Rows) -> Mapping[str, Rows]:
    by_seed = Rows(sorted(rows, key=lambda row: int(row["task"]["seed"])))
    return group_by("variant", VARIANTS)(by_seed)


def _list_differences(groups: Mapping[str, Rows], name: str) -> list[str]:
    """Return the significant differences of a variant from its reference."""
    rows, reference = groups[name], groups[VARIANTS[name].against]
    differs = []
    for name_of_measure, measure in MEASURES.items():
        pair = (each.values(_present(measure.key)) for each in (rows, reference))
        if name != BASE and compute_paired_p(*pair) < SURE:
            before, now = (f"{measure.compute(each):.{measure.digits}f}" for each in (reference, rows))
            differs.append(f"{name_of_measure} {before} → {now}")
    return differs


def _summarize(groups: Mapping[str, Rows], name: str) -> dict[str, Any]:
    """Return the averages of a variant, and its differences from its reference."""
    rows = groups[name]
    return {
        "teachings_reaching_95": SUCCEEDS.number(rows),
        "of": len(rows),
        **{each.key: round(each.compute(rows), 4) for each in (*MEASURES.values(), _Measure("examples"))},
        "differs": _list_differences(groups, name),
    }


SUCCEEDS = Count(lambda row: _present("success")(row) >= 0.95)


def _headline(groups: Mapping[str, Rows]) -> str:
    reach = {name: SUCCEEDS(rows) for name, rows in groups.items()}
    food = {name: rows.median(_present("relative_to_expert")) for name, rows in groups.items()}
    bare, late, knows = (
        "no automatic defaults, not watched",
        "1 s late, reaction time unknown",
        "1 s late, reaction time known",
    )
    return (
        f"Corrections make up for most changes. Three parts of the method are necessary. Default examples: without any,"
        f" {reach[bare]} teachings reach 95 % success, with {groups[bare].median('presses'):.0f} presses instead of "
        f"{groups[SILENT].median('presses'):.0f}; with defaults pressed by hand, "
        f"{reach['defaults by hand, not watched']} do. The choice of features: with all features, "
        f"{reach['all features, not watched']}. Leaves that decide as shown: with leaves that draw by corrected votes, "
        f"{reach['leaves draw by corrected votes']}. With a demonstrator who presses a second late, robots collect "
        f"{food[late]:.2f} of the food per second of the hand-written controller ({reach[late]}), or "
        f"{food[knows]:.2f} if the lesson knows the delay ({reach[knows]}), instead of {food[BASE]:.2f}."
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


def _draw(axes: Axes, groups: Mapping[str, Rows], key: str, title: str, scale: float = 1.0) -> None:
    """Draw one measure of every teaching, a row for each variant."""
    abouts = list(dict.fromkeys(variant.about for variant in VARIANTS.values()))
    axes.axvline(scale * groups[BASE].median(_present(key)), color="0.8", linewidth=1, zorder=0)
    for line, (name, variant) in enumerate(VARIANTS.items()):
        color = COLORS[abouts.index(variant.about) % len(COLORS)]
        values = scale * np.array(groups[name].values(_present(key)))
        axes.plot(
            values, np.full(len(values), line), "o", color=color, markersize=4, alpha=0.35, markeredgewidth=0
        )
        axes.plot([np.median(values)], [line], "|", color=color, markersize=11, markeredgewidth=2)
    axes.set_ylim(len(VARIANTS) - 0.4, -0.6)
    axes.set_title(title)
    axes.set_yticks([])
    if key == "success":
        axes.set_yticks(range(len(VARIANTS)), list(VARIANTS), fontsize=8)
    if key == "presses":
        axes.set_xscale("log")
        axes.set_xticks([20, 50, 100, 200, 500], ["20", "50", "100", "200", "500"])
        axes.minorticks_off()


EXPERIMENT = Study(
    name="ablation",
    seeds=SEEDS,
    quick=1,
    tasks=Units({"variant": VARIANTS}, by_seed=True),  # the variants of one seed share their test worlds
    work=work,
    conclude=Conclusion(
        prepare=_group,
        headline=_headline,
        tables=(
            LinePerGroup(
                f"{{teachings}} teachings each (seeds {{seeds}}), tested in {WORLDS} unseen worlds: medians "
                "(smallest–largest)",
                ["variant", "part varied"],
                dict,
                {
                    "teachings with 95 % success": SUCCEEDS,
                    "food per second / hand-written": Median(_present("relative_to_expert"), 2),
                    "examples": Median(_present("examples")),
                    "presses": Median(_present("presses")),
                    "teaching time, s": Median(_present("teaching_seconds")),
                    "GoTo arrives before corrections (mean)": lambda rows: format(
                        MEASURES["GoTo as shown"].compute(rows), ".0%"
                    ),
                },
                lambda name: [name, VARIANTS[name].about],
            ),
            lambda groups: ResultTable(
                f"Significant differences between medians (of success, means), in signed-rank tests over seeds at p < "
                f"{SURE}. About one of {len(MEASURES) * (len(VARIANTS) - 1)} comparisons is significant by chance",
                ("variant", "compared with", "differences"),
                [
                    (name, VARIANTS[name].against, ", ".join(_list_differences(groups, name)) or "none")
                    for name in VARIANTS
                    if name != BASE
                ],
            ),
        ),
        notes=NOTES,
        numbers=lambda groups: {"variants": {name: _summarize(groups, name) for name in VARIANTS}},
    ),
    draw=Panels(
        (
            partial(_draw, key="success", title="worlds finished in time, %", scale=100.0),
            partial(_draw, key="relative_to_expert", title="food per second, % of hand-written", scale=100.0),
            partial(_draw, key="presses", title="presses"),
        ),
        wide=3.6,
        tall=6.2,
        prepare=_group,
    ),
    worlds=("forage",),
)
