"""The experiment: two tasks taught in layers and as one automaton, with tests throughout each teaching."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.figures import COLORS, panels
from understudy_lab.forage.teach import WORLDS as JUDGED
from understudy_lab.hierarchy.learning_curves import WELL, find_first_success, success_at
from understudy_lab.hierarchy.teach import FORAGING, SERVOING, WORLDS, measure_teaching
from understudy_lab.statistics import compute_paired_p, format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per variant and seed."""
    return [{"way": way, "seed": seed} for way in (*SERVOING, *FORAGING) for seed in plan.seeds]


def work(task: Task) -> Row:
    """Run one teaching with measurements throughout."""
    return measure_teaching(task["way"], task["seed"])


def select_rows(rows: Sequence[Row], way: str) -> list[Row]:
    """Return the rows of one variant."""
    return [row for row in rows if row["task"]["way"] == way]


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
        [[count_needed(row, what) for row in select_rows(rows, way)] for way in (less, more)]
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


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize what each variant needs, and compare them."""
    compared = {
        f"{less} / {more}": {
            "examples": ratio(rows, less, more, EXAMPLES),
            "seconds": ratio(rows, less, more, SECONDS),
        }
        for _, less, more, _ in COMPARED
    }
    return StudyFindings(
        headline=_headline(rows, compared),
        tables=(
            *(_table(rows, task, ways) for task, ways in TASKS.items()),
            ResultTable(
                "Ratio of what the first needs to what the second needs (medians, 95 % interval; signed ranks by seed)",
                ("", "#examples", "#teaching time"),
                [
                    (name, *(_told(found[what]) for what in ("examples", "seconds")))
                    for name, found in compared.items()
                ],
            ),
        ),
        goals=tuple(_goal(rows, compared, *each) for each in COMPARED if each[3] is not None),
        notes=NOTES,
        numbers={
            "compared": compared,
            "reached": {
                way: sum(map(has_reached_goal, select_rows(rows, way))) for way in (*SERVOING, *FORAGING)
            },
        },
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


def _headline(rows: Sequence[Row], compared: Mapping[str, Any]) -> str:
    stop, whole = compared["two automata / one automaton"], compared["three layers / one layer"]
    untold = compared["three layers / one layer, told nothing"]
    return (
        f"Foraging in three layers needs ×{whole['examples']['ratio']:.2f} of the examples that one layer needs: "
        f"{_reached(rows, 'three layers')} teachings in three layers reach 90 % success in four tests in a row, and "
        f"{_reached(rows, 'one layer')} in one layer. If the states of the one layer are not chosen for "
        f"the task, three layers need only ×{untold['examples']['ratio']:.2f} of its examples. Approaching and "
        f"stopping needs ×{stop['examples']['ratio']:.2f} as many examples in two automata as in one: layers do not "
        "help in a task this small."
    )


def _reached(rows: Sequence[Row], way: str) -> str:
    return _count(select_rows(rows, way), has_reached_goal)


def _count(rows: Sequence[Row], which: Callable[[Row], bool]) -> str:
    return f"{sum(map(which, rows))} of {len(rows)}"


def _table(rows: Sequence[Row], task: str, ways: Sequence[str]) -> ResultTable:
    seeds = sorted({row["task"]["seed"] for row in rows})
    return ResultTable(
        f"{task}: {len(seeds)} teachings each (seeds {seeds[0]} to {seeds[-1]}), {WORLDS} unseen worlds in every test",
        ("", *(f"#{way}" for way in ways)),
        [(what, *(tell(select_rows(rows, way)) for way in ways)) for what, tell in TOLD.items()],
    )


TOLD: Mapping[str, Callable[[Sequence[Row]], str]] = {
    "teachings that reach 90 % in four tests in a row": lambda rows: _count(rows, has_reached_goal),
    f"of these, also 90 % at the end, in {JUDGED} other worlds": lambda rows: _count(
        list(filter(has_reached_goal, rows)), has_kept_success
    ),
    "examples needed to reach it": lambda rows: format_median(
        [count_needed(row, EXAMPLES) for row in rows if has_reached_goal(row)]
    ),
    "teaching time needed to reach it, s": lambda rows: format_median(
        [count_needed(row, SECONDS) for row in rows if has_reached_goal(row)]
    ),
    "examples at the end": lambda rows: format_median([row["examples"] for row in rows]),
    f"success at the end, in {JUDGED} other worlds": lambda rows: format_median(
        [row["success"] for row in rows], percent=True
    ),
}


def _told(found: Mapping[str, float]) -> str:
    return f"×{found['ratio']:.2f} ({found['low']:.2f}–{found['high']:.2f}), p = {found['p']:.2g}"


def _goal(
    rows: Sequence[Row], compared: Mapping[str, Any], task: str, less: str, more: str, most: float | None
) -> StudyGoal:
    found = compared[f"{less} / {more}"]["examples"]
    return StudyGoal(
        f"examples for 90 % success, {task}: {less} / {more}",
        f"at most ×{most or 0:.2f}",
        _told(found),
        found["ratio"] <= (most or 0),
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success over examples and over teaching time, with medians and quartiles over teachings."""
    figure, axes = panels(4, rows=2, wide=3.6)
    for row, (task, ways) in enumerate(TASKS.items()):
        for what, said in ((EXAMPLES, "press-made examples"), (SECONDS, "teaching time, s")):
            panel = axes[2 * row + what]
            _curves(panel, rows, ways, what)
            panel.set_xlabel(said)
            panel.set_title(task)
        axes[2 * row].set_ylabel("success, %")
        axes[2 * row].legend(fontsize=7.5, loc="lower right")
    return figure


def _curves(axes: Axes, rows: Sequence[Row], ways: Sequence[str], what: int) -> None:
    most = max(point[what] for way in ways for row in select_rows(rows, way) for point in row["points"])
    grid = np.linspace(0, most, 200)
    for way, color in zip(ways, COLORS, strict=False):
        found = np.array(
            [[100 * success_at(row["points"], upto, what) for upto in grid] for row in select_rows(rows, way)]
        )
        low, middle, high = np.percentile(found, [25, 50, 75], axis=0)
        axes.fill_between(grid, low, high, color=color, alpha=0.18, linewidth=0)
        axes.plot(grid, middle, color=color, linewidth=1.6, label=way)
    axes.axhline(90, color="0.7", linewidth=0.8, linestyle=":")
    axes.set_ylim(0, 103)


EXPERIMENT = Study(
    name="hierarchy",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("soccer", "forage"),
)
