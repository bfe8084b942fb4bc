"""The experiment: twenty simulated hands drive GoTo with a stick, and the robot learns it from the recordings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy_lab.figures import dots, panels
from understudy_lab.recordings.driven_goto import (
    DRIVES,
    WORLDS,
    learn_from_drives,
    measure_success,
    teach_by_presses,
)
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(16_000, 16_020)
"""The seeds of the hands and of their worlds; tuning used seeds 0 to 5."""
TICKS, SWITCHES, APART = 0.95, 0.9, 0.05


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per hand."""
    return [{"seed": seed} for seed in plan.seeds]


def work(task: Task) -> Row:
    """Drive with one hand, learn from the recordings, teach the same by presses, and test both in the same worlds."""
    seed = task["seed"]
    driven = learn_from_drives(seed)
    return {
        "ticks": round(driven.ticks, 4),
        "answered": round(driven.answered, 4),
        "switches": round(driven.switches, 4),
        "driven": measure_success(driven.library, seed),
        "pressed": measure_success(teach_by_presses(seed), seed, parameter="A"),
    }


MEASURES = {
    "ticks as the driver meant": "ticks",
    "ticks as the hand answered": "answered",
    "switches within 0.3 s": "switches",
    "success, learned from recordings": "driven",
    "success, taught by presses": "pressed",
}


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize all hands."""
    columns = {key: [row[key] for row in rows] for key in MEASURES.values()}
    ticks, switches, driven, pressed = (
        float(np.median(columns[key])) for key in ("ticks", "switches", "driven", "pressed")
    )
    near = sum(row["pressed"] - row["driven"] <= APART + 1e-9 for row in rows)
    first, last = rows[0]["task"]["seed"], rows[-1]["task"]["seed"]
    return StudyFindings(
        headline=f"Of {DRIVES} drives with a stick, {ticks:.1%} of the ticks and {switches:.1%} of the switches are "
        f"recognized without a press; what is learned from them reaches {driven:.0%} of the posts, and what is "
        f"taught by presses {pressed:.0%} (medians of {len(rows)} hands). Of the hands, {near} come within "
        f"{100 * APART:.0f} points of presses.",
        tables=(
            ResultTable(
                f"GoTo from drives, % of ticks, switches and {WORLDS} unseen worlds (seeds {first} to {last})",
                ("", "#median [smallest, largest]"),
                [
                    (what, format_median([100 * each for each in columns[key]], 1))
                    for what, key in MEASURES.items()
                ],
            ),
        ),
        goals=(
            StudyGoal("ticks as the driver meant, median", f"{TICKS:.0%}", f"{ticks:.1%}", ticks >= TICKS),
            StudyGoal(
                "switches within 0.3 s, median", f"{SWITCHES:.0%}", f"{switches:.1%}", switches >= SWITCHES
            ),
            StudyGoal(
                f"hands whose success is within {100 * APART:.0f} points of that by presses",
                f"{len(rows)} of {len(rows)}",
                f"{near} of {len(rows)}",
                near == len(rows),
            ),
        ),
        notes=(
            "The hand answers to what the driver means 0 to 0.2 s later, so each switch costs as many ticks.",
        ),
        numbers={key: round(float(np.median(values)), 4) for key, values in columns.items()},
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the shares of ticks and switches, and the success, of each hand."""
    figure, (left, right) = panels(2)
    names = {
        "ticks": "ticks\nas meant",
        "answered": "ticks\nas answered",
        "switches": "switches\nwithin 0.3 s",
    }
    dots(left, {name: [100 * row[key] for row in rows] for key, name in names.items()}, "% right")
    left.set_title("Labels of the recordings")
    names = {"driven": "from\nrecordings", "pressed": "by presses"}
    dots(right, {name: [100 * row[key] for row in rows] for key, name in names.items()}, "% of unseen worlds")
    right.set_title("Success of GoTo")
    return figure


EXPERIMENT = Study(
    name="recordings", seeds=SEEDS, quick=2, tasks=tasks, work=work, conclude=conclude, draw=draw
)
