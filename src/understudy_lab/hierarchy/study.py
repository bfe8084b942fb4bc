"""The experiment: two tasks taught in layers and as one automaton, with tests throughout each teaching."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from understudy_lab.declaration import ColumnPerGroup, Conclusion, Goal, Units
from understudy_lab.figures import COLORS, Panels
from understudy_lab.forage.teach import WORLDS as JUDGED
from understudy_lab.hierarchy.teach import (
    FORAGING,
    SERVOING,
    WELL,
    WORLDS,
    find_first_success,
    measure_teaching,
    success_at,
)
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.statistics import compute_paired_p
from understudy_lab.study import ResultTable, Row, Study, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(54_200, 54_220)
TASKS: Mapping[str, tuple[str, ...]] = {"approach and stop": SERVOING, "forage": FORAGING}
COMPARED = (
    ("approach and stop", "two automata", "one automaton", 0.6),
    ("forage", "three layers", "one layer", 1 / 3),
    ("forage", "three layers", "two layers", None),
    ("forage", "two layers", "one layer", None),
    ("forage", "three layers", "one layer, told nothing", None),
)
"""The compared variants of each task, and the goal for the ratio of their examples."""
EXAMPLES, SECONDS = 0, 1
AXES = {EXAMPLES: "press-made examples", SECONDS: "teaching time, s"}


def work(task: Task) -> Row:
    """Run one teaching with measurements throughout."""
    return measure_teaching(task["way"], task["seed"])


def has_reached_goal(row: Row) -> bool:
    """Return whether a teaching reached 90 % success in four tests in a row."""
    return find_first_success([point[2] for point in row["points"]]) is not None


def has_kept_success(row: Row) -> bool:
    """Return whether a teaching ends with at least 90 % success; corrections can make a robot worse again."""
    return bool(row["success"] >= WELL)


def count_needed(row: Row, what: int) -> float:
    """Return the examples or seconds until 90 % success, or those at the end if it was never reached."""
    first = find_first_success([point[2] for point in row["points"]])
    return float(row["points"][-1 if first is None else first][what])


def ratio(rows: Sequence[Row], less: str, more: str, what: int) -> dict[str, float]:
    """Return the ratio of the medians that `less` and `more` need, with a 95 % bootstrap interval and a p-value.

    Teachings with the same seed form a pair: they begin with the same draws of worlds and reaction times.
    """
    both = np.array(
        [[count_needed(row, what) for row in Rows(rows).where(way=way)] for way in (less, more)]
    )  # [2, seeds]
    seeds = both.shape[1]
    drawn = np.median(both[:, np.random.default_rng(0).integers(seeds, size=(4_000, seeds))], axis=2)
    low, high = np.percentile(drawn[0] / drawn[1], [2.5, 97.5])
    ours, theirs = np.median(both, axis=1)
    return {
        "ratio": round(float(ours / theirs), 3),
        "low": round(float(low), 3),
        "high": round(float(high), 3),
        "p": float(f"{compute_paired_p(*np.log(both)):.2g}"),
    }


REACHED = Count(has_reached_goal)


def _format(comparison: Mapping[str, float]) -> str:
    return f"×{comparison['ratio']:.2f} ({comparison['low']:.2f}–{comparison['high']:.2f}), p = {comparison['p']:.2g}"


def _headline(rows: Rows) -> str:
    whole, untold, stop = (
        ratio(rows, pair[0], pair[1], EXAMPLES)["ratio"]
        for pair in (
            ("three layers", "one layer"),
            ("three layers", "one layer, told nothing"),
            ("two automata", "one automaton"),
        )
    )
    three, one = (REACHED(rows.where(way=way)) for way in ("three layers", "one layer"))
    return (
        f"Foraging in three layers needs ×{whole:.2f} of the examples that one layer needs: {three} teachings in three "
        f"layers reach 90 % success in four tests in a row, and {one} in one layer. If the states of the one layer "
        f"are not chosen for the task, three layers need only ×{untold:.2f} of its examples. Approaching and stopping "
        f"needs ×{stop:.2f} as many examples in two automata as in one: layers do not help in a task this small."
    )


NOTES = (
    f"Every test uses {WORLDS} worlds of its own. When the teacher is satisfied, tests continue until four in a row "
    "succeed; if one fails, teaching continues, too. A robot that succeeds in 85 % of worlds passes four tests in a "
    "row one time in a hundred; a robot that succeeds in 95 % passes them four times in five. A long teaching has more "
    "tests, and so more chances to pass.",
    "A teaching that never reached 90 % counts with the examples (or seconds) that it had at the end, which is less "
    "than it would need. If anything, ratios to such teachings are too large.",
    "*One layer* is taught by a person who knows how the task has to be done. It has a state for each step on the way "
    "to food and on the way home, and no unnecessary feature. *Told nothing* means one state for each basic behavior, "
    "and all features.",
    "Presses come a quarter of a second late. The teacher of one layer knows this, and presses early when turning. The "
    "teacher of layers does not, but the lesson of GoTo compensates for 0.2 s. Letting that teacher press early as "
    "well made little difference (see *What else was tried* in the experiment's README).",
    "Why the goal for foraging was missed: four lessons of two to four states take about forty examples even without "
    "repetition, because a switch makes two examples, a directive and its default. A third of what one layer needs is "
    "less than that.",
    "In approaching and stopping, the two ways differ by one press per trip. With two automata, the ways to the ball "
    "are shown first, and then again with the stop; the teacher of one automaton shows both at once. Whatever saves "
    "examples in one way saves them in the other, too (see *What else was tried* in the experiment's README).",
)


def _needed(what: int) -> Callable[[Rows], str]:
    needed = Median(lambda row: count_needed(row, what))
    return lambda rows: needed(rows.filter(has_reached_goal))


def _curves(axes: Axes, rows: Rows, task: str, what: int) -> None:
    """Draw success over examples or teaching time, with medians and quartiles over teachings."""
    groups = group_by("way", TASKS[task])(rows)
    grid = np.linspace(
        0, max(point[what] for of in groups.values() for row in of for point in row["points"]), 200
    )
    for (way, of), color in zip(groups.items(), COLORS, strict=False):
        curves = np.array([[100 * success_at(row["points"], upto, what) for upto in grid] for row in of])
        low, middle, high = np.percentile(curves, [25, 50, 75], axis=0)
        axes.fill_between(grid, low, high, color=color, alpha=0.18, linewidth=0)
        axes.plot(grid, middle, color=color, linewidth=1.6, label=way)
    axes.axhline(90, color="0.7", linewidth=0.8, linestyle=":")
    axes.set_ylim(0, 103)
    axes.set_xlabel(AXES[what])
    axes.set_title(task)
    if what == EXAMPLES:
        axes.set_ylabel("success, %")
        axes.legend(fontsize=7.5, loc="lower right")


def _table(task: str) -> ColumnPerGroup:
    return ColumnPerGroup(
        f"{task}: {{teachings}} teachings each (seeds {{seeds}}), {WORLDS} unseen worlds in every test",
        group_by("way", TASKS[task]),
        {
            "teachings that reach 90 % in four tests in a row": REACHED,
            f"of these, also 90 % at the end, in {JUDGED} other worlds": lambda rows: Count(has_kept_success)(
                rows.filter(has_reached_goal)
            ),
            "examples needed to reach it": _needed(EXAMPLES),
            "teaching time needed to reach it, s": _needed(SECONDS),
            "examples at the end": Median("examples"),
            f"success at the end, in {JUDGED} other worlds": Median("success", percent=True),
        },
    )


EXPERIMENT = Study(
    name="hierarchy",
    seeds=SEEDS,
    quick=1,
    tasks=Units({"way": (*SERVOING, *FORAGING)}),
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            *map(_table, TASKS),
            lambda rows: ResultTable(
                "Ratio of what the first needs to what the second needs (medians, 95 % interval; signed ranks by seed)",
                ("", "#examples", "#teaching time"),
                [
                    (f"{less} / {more}", *(_format(ratio(rows, less, more, what)) for what in AXES))
                    for _, less, more, _ in COMPARED
                ],
            ),
        ),
        goals=[
            Goal(
                f"examples for 90 % success, {task}: {less} / {more}",
                lambda rows, pair=(less, more): ratio(rows, pair[0], pair[1], EXAMPLES)["ratio"],
                "×{:.2f}",
                most=most,
                measured=lambda rows, pair=(less, more): _format(ratio(rows, pair[0], pair[1], EXAMPLES)),
            )
            for task, less, more, most in COMPARED
            if most is not None
        ],
        notes=NOTES,
        numbers=lambda rows: {
            "compared": {
                f"{less} / {more}": {
                    "examples": ratio(rows, less, more, EXAMPLES),
                    "seconds": ratio(rows, less, more, SECONDS),
                }
                for _, less, more, _ in COMPARED
            },
            "reached": {way: REACHED.number(rows.where(way=way)) for way in (*SERVOING, *FORAGING)},
        },
    ),
    draw=Panels(
        [partial(_curves, task=task, what=what) for task, what in product(TASKS, AXES)], rows=2, wide=3.6
    ),
    worlds=("soccer", "forage"),
)
