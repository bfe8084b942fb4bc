"""The experiment: independent teachings of scouts, carriers and their coordinator, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy_lab.figures import dots, panels
from understudy_lab.lesson_stats import examples_in, lessons_in, lessons_of
from understudy_lab.mixed_teams.evaluate import (
    FAILING,
    LED,
    MIXED,
    SINGLE,
    WORLDS,
    measure_mixed_teams,
    worlds_of,
)
from understudy_lab.mixed_teams.practice import teach
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHINGS = range(59_000, 59_010)
"""The teaching seeds of the published result; none was used during development."""
BETTER = 1.5
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
NAMES = {LED: "mixed, under their coordinator", MIXED: MIXED} | {name: name for name in SINGLE}


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per seed."""
    return [{"seed": seed} for seed in plan.seeds]


def work(task: Task) -> Row:
    """Teach a mixed team with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"])
    lessons = {kind: lessons_of(teaching) for kind, teaching in taught.robots.items()}
    lessons["coordinator"] = lessons_of(taught.coordinator)
    return {**measure_mixed_teams(taught, worlds_of(task["seed"])), "lessons": lessons}


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize all teachings as a headline, tables, goals and notes."""
    first, last = rows[0]["task"]["seed"], rows[-1]["task"]["seed"]
    better, alone = _against_single(rows), _against_alone(rows)
    return StudyFindings(
        headline="A mixed team of four scouts and eight carriers, each type taught its own behaviors, brings home "
        f"{np.median(better):.1f} times as much under its coordinator as the best team of twelve robots of one type, "
        f"in unseen worlds (median: {format_median(_rates(rows, LED))} units an hour). All automata together take "
        f"{np.median(examples_in(rows)):.0f} examples. Without the coordinator, the same robots bring home "
        f"{1 / np.median(alone):.2f} times as much as with it.",
        tables=(
            ResultTable(
                f"Salvage, teachings {first} to {last}, {WORLDS} unseen worlds of 20 minutes each: median (worst–best)",
                ("team of twelve", "#units an hour"),
                [(said, format_median(_rates(rows, name))) for name, said in NAMES.items()],
            ),
            ResultTable(
                "Yield after a third of the members was killed at random moments",
                ("team of twelve", "#units an hour", "#share of the yield without failures"),
                [
                    (
                        NAMES[name],
                        format_median(_of(rows, "after_failures", name)),
                        format_median(_of(rows, "kept", name), percent=True),
                    )
                    for name in (LED, MIXED)
                ],
            ),
            ResultTable(
                "Teaching effort per automaton: median (smallest–largest)",
                ("type", "automaton", "#examples", "#seconds", "#states", "#features"),
                lessons_in(rows),
            ),
        ),
        goals=_goals(rows),
        notes=_notes(rows),
        numbers={"teachings": len(rows), "better": better, "examples": examples_in(rows)},
    )


def _of(rows: Sequence[Row], what: str, name: str) -> list[float]:
    return [row[what][name] for row in rows]


def _rates(rows: Sequence[Row], name: str) -> list[float]:
    return _of(rows, "rate", name)


def _best_single(row: Row) -> float:
    return max(float(row["rate"][name]) for name in SINGLE)


def _against_single(rows: Sequence[Row]) -> list[float]:
    """Return the yield of each coordinated team relative to the best team of one type."""
    return [round(row["rate"][LED] / max(1.0, _best_single(row)), 3) for row in rows]


def _against_alone(rows: Sequence[Row]) -> list[float]:
    return [row["rate"][LED] / max(1.0, row["rate"][MIXED]) for row in rows]


def _goals(rows: Sequence[Row]) -> tuple[StudyGoal, ...]:
    better = _against_single(rows)
    kept = float(np.median(_of(rows, "kept", LED)))
    return (
        StudyGoal(
            "units brought home, relative to the best team of one type",
            f"×{BETTER}",
            f"×{np.median(better):.2f}, worst ×{min(better):.2f}",
            float(np.median(better)) >= BETTER,
        ),
        StudyGoal(
            "share of the yield kept after a third of the members was killed",
            f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            f"{kept:.0%}",
            kept >= KEPT,
        ),
    )


def _notes(rows: Sequence[Row]) -> tuple[str, ...]:
    alone, after = float(np.median(_against_alone(rows))), _of(rows, "after_failures", LED)
    failing = float(np.median(np.divide(after, np.maximum(1.0, _of(rows, "after_failures", MIXED)))))
    return (
        f"The mix makes the difference: under the coordinator, the team brings home ×{alone:.2f} of what the same "
        f"robots bring home on their own, and ×{failing:.2f} after a third was killed. A carrier that follows an "
        "exploring scout is close by when the scout finds something, so the coordinator can add little.",
        "A carrier cannot distinguish a dead scout at an empty wreck from a scout on guard. This is what failures cost "
        "beyond the loss of the members themselves.",
        f"Scouts cannot carry anything: a team of scouts brings home {max(_rates(rows, 'all scouts')):.0f} units.",
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw how much food each team brought home, with all its robots and after a third of them failed."""
    figure, (left, right) = panels(2, wide=4.2)
    short = ("mixed,\nled", "mixed,\nalone", "carriers,\nsearching", "carriers,\ngoing back", "scouts")
    dots(left, {said: _rates(rows, name) for said, name in zip(short, NAMES, strict=True)}, "units an hour")
    left.set_title("all twelve")
    killed = {
        said: _of(rows, "after_failures", name) for said, name in zip(short[:2], (LED, MIXED), strict=True)
    }
    dots(right, killed, "units an hour")
    right.set_title("after a third was killed")
    return figure


EXPERIMENT = Study(
    name="roles",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("salvage",),
)
