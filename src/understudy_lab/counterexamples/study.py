"""The experiment: novices correct their robots in failing worlds, or with as many presses at random places."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from understudy.judging.intervals import exact_interval_of_share
from understudy.model.library import Library
from understudy_lab.coaching_benefit.coached_teaching import ALONE, teach
from understudy_lab.coaching_benefit.tasks import EXERCISES
from understudy_lab.counterexamples.lessons import (
    LESSONS,
    SEARCHED,
    ArrivalMeasure,
    teach_at_random,
    teach_by_failures,
    teach_by_watching,
)
from understudy_lab.declaration import Units
from understudy_lab.figures import COLORS, Panels
from understudy_lab.novices.novice import draw_traits
from understudy_lab.statistics import compute_paired_p, format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEEDS = range(71_100, 71_130)
"""The seeds of the novices; the lessons were developed on seeds 70900 to 70959."""
UNSEEN = 2_000
"""The number of unseen worlds in which each robot is tested."""
WANTED = 10.0
BEFORE, FAILURES, RANDOM, WATCHED = "before", "counterexamples", "random", "watched"
NAMES = {
    BEFORE: "before",
    FAILURES: "after counterexamples",
    RANDOM: "after random places",
    WATCHED: "after random places, corrections only",
}
TITLES = {FAILURES: "Counterexamples", RANDOM: "Random places", WATCHED: "Random, corrections only"}
LESSONS_IN = (FAILURES, RANDOM, WATCHED)


def work(task: Task) -> Row:
    """Let a novice teach GoTo alone, then five lessons of each kind, and count failures in the same unseen worlds."""
    seed, exercise = task["seed"], EXERCISES["goto"]
    traits = draw_traits(seed)
    taught = teach(exercise.person(traits, seed), exercise, ALONE).session.make_trained_automaton()
    library = Library(exercise.kit).with_automaton(taught)
    by_failures = teach_by_failures(exercise.person(traits, seed), library, seed)
    at_random = teach_at_random(exercise.person(traits, seed), library, by_failures.presses)
    watched = teach_by_watching(exercise.person(traits, seed), library, by_failures.presses)
    unseen = range(UNSEEN * seed, UNSEEN * (seed + 1))
    lessons = {FAILURES: by_failures, RANDOM: at_random, WATCHED: watched}
    libraries = {BEFORE: library, **{name: each.library for name, each in lessons.items()}}
    return {
        "failures": {name: ArrivalMeasure(each).count_failures(unseen) for name, each in libraries.items()},
        "found": by_failures.found,
        "presses": {name: each.presses for name, each in lessons.items()},
    }


def compute_fall(row: Row, name: str) -> float:
    """Return by which factor failures fell; half a failure is added to both counts, so that it is finite."""
    failures = row["failures"]
    return float((failures[BEFORE] + 0.5) / (failures[name] + 0.5))


def select_failing(rows: Sequence[Row]) -> list[Row]:
    """Return the novices with something to correct: the first search found a world in which their robot fails."""
    return [row for row in rows if row["found"][0] > 0]


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize by which factor failures fell, and list all robots."""
    failing = select_failing(rows)
    falls = {name: [compute_fall(row, name) for row in failing] for name in LESSONS_IN}
    medians = {name: float(np.median(each)) for name, each in falls.items()}
    counts = {name: [row["failures"][name] for row in failing] for name in NAMES}
    presses = {name: [sum(row["presses"][name]) for row in failing] for name in LESSONS_IN}
    tenfold = {name: sum(each >= WANTED for each in found) for name, found in falls.items()}
    ps = {name: compute_paired_p(counts[FAILURES], counts[name]) for name in (RANDOM, WATCHED)}
    return StudyFindings(
        headline=f"Of {len(rows)} robots that novices taught GoTo, {len(failing)} fail in one of {SEARCHED} searched "
        f"worlds. {LESSONS} lessons in failing worlds, with {np.median(presses[FAILURES]):.0f} presses in the median, "
        f"divide their failures in unseen worlds by {medians[FAILURES]:.0f} in the median. As many presses at random "
        f"places divide them by {medians[RANDOM]:.1f}, and at most as many, all of them corrections of what looks "
        f"wrong there, by {medians[WATCHED]:.1f}.",
        tables=(
            ResultTable(
                f"The {len(failing)} robots that fail, by lessons: medians (smallest–largest)",
                (
                    "",
                    "#failures, % of unseen worlds",
                    "#failures divided by",
                    "#robots tenfold better",
                    "#robots without a failure",
                    "#robots worse",
                    "#presses",
                ),
                [_summarize(failing, name) for name in NAMES],
            ),
            ResultTable(
                f"Failures in {UNSEEN} unseen worlds by robot (exact 95 % interval of the share, %)",
                ("novice", *(f"#{name}" for name in NAMES.values()), "#presses in each lesson"),
                [_list_failures(row) for row in rows],
            ),
        ),
        goals=(
            StudyGoal(
                "failures before / after counterexamples, median",
                f"{WANTED:.0f}",
                f"{medians[FAILURES]:.1f} (after random places {medians[RANDOM]:.1f})",
                medians[FAILURES] >= WANTED,
            ),
        ),
        notes=(
            "Half a failure is added to both numbers before one is divided by the other. "
            f"{tenfold[FAILURES]} of {len(failing)} robots are at least ten times better after counterexamples, "
            f"{tenfold[RANDOM]} after random places, and {tenfold[WATCHED]} after random places with corrections only. "
            f"Failures after counterexamples differ from those after random places with p = {ps[RANDOM]:.2g}, and from "
            f"those with corrections only with p = {ps[WATCHED]:.2g} (signed-rank test).",
            "A lesson has no presses if no searched world fails, or if the novice sees nothing wrong in the one that "
            "does.",
        ),
        numbers={
            "falls": {name: round(each, 4) for name, each in medians.items()},
            "tenfold": tenfold,
            "presses": {name: float(np.median(each)) for name, each in presses.items()},
            "p": {name: round(p, 6) for name, p in ps.items()},
        },
    )


def _summarize(rows: Sequence[Row], name: str) -> tuple[str, ...]:
    counts = [row["failures"][name] for row in rows]
    falls = [compute_fall(row, name) for row in rows]
    is_before = name == BEFORE
    return (
        NAMES[name],
        format_median([100 * each / UNSEEN for each in counts], 2),
        "" if is_before else format_median(falls, 1),
        "" if is_before else str(sum(each >= WANTED for each in falls)),
        str(counts.count(0)),
        "" if is_before else str(sum(each < 1.0 for each in falls)),
        "" if is_before else format_median([sum(row["presses"][name]) for row in rows]),
    )


def _list_failures(row: Row) -> tuple[str, ...]:
    return (
        str(row["task"]["seed"]),
        *(_format_count(row["failures"][name]) for name in NAMES),
        " ".join(map(str, row["presses"][FAILURES])),
    )


def _format_count(failed: int) -> str:
    low, high = exact_interval_of_share(failed, UNSEEN)
    return f"{failed} ({100 * low:.2f}–{100 * high:.2f})"


def _draw(panel: Axes, rows: Sequence[Row], name: str) -> None:
    """Draw the failures of each robot before and after the lessons of one kind."""
    counts = np.array([[row["failures"][each] for each in (BEFORE, name)] for row in rows], np.float64)
    panel.plot(
        [0, 1],
        counts.T,
        "-o",
        color=COLORS[LESSONS_IN.index(name)],
        linewidth=0.8,
        markersize=3.5,
        alpha=0.55,
    )
    panel.plot([0, 1], np.median(counts, axis=0), "-", color="#1f2937", linewidth=2.5, label="median")
    panel.set_yscale("symlog", linthresh=1.0)
    panel.set_ylim(-0.15, UNSEEN * 1.2)
    panel.set_yticks([0, 1, 10, 100, 1000], ["0", "1", "10", "100", "1000"])
    panel.set_xticks([0, 1], ["before", f"after {LESSONS} lessons"])
    panel.set_xlim(-0.25, 1.25)
    fall = float(np.median([compute_fall(row, name) for row in rows]))
    panel.set_title(f"{TITLES[name]}:\ndivided by {fall:.{0 if fall >= WANTED else 1}f} (median)")
    if name == FAILURES:
        panel.set_ylabel(f"failures in {UNSEEN} unseen worlds")
        panel.legend(loc="lower left")


EXPERIMENT = Study(
    name="counterexamples",
    seeds=SEEDS,
    quick=2,
    tasks=Units({}),
    work=work,
    conclude=conclude,
    draw=Panels(
        [partial(_draw, name=name) for name in LESSONS_IN], wide=3.2, tall=3.4, prepare=select_failing
    ),
)
