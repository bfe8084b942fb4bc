"""The experiment: behaviors taught in the 2-D world, tested there and in physics on the same unseen seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.analysis.intervals import interval_of_share
from understudy_lab.figures import dots, panels
from understudy_lab.sim_to_sim.trials import FLAT, PATROL, PHYSICS, TRIED, measure_transfer
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = range(64_000, 64_010)
"""The teaching seeds of the published result; none was used during development."""
KEPT, CYCLES = 0.9, 0.8
"""The goals: success in physics relative to the 2-D world, and the share of completed patrol cycles."""
WORLDS: Mapping[str, str] = {FLAT: "2-D world", PHYSICS: "physics"}


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per behavior and seed."""
    return [{"behavior": name, "seed": seed} for name in TRIED for seed in plan.seeds]


def work(task: Task) -> Row:
    """Teach one behavior once and test it in both worlds."""
    return measure_transfer(task["behavior"], task["seed"])


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize how much of each behavior's success remains in physics as a headline, a table, goals and notes."""
    found = {name: _numbers([row for row in rows if row["task"]["behavior"] == name]) for name in TRIED}
    found = {name: each for name, each in found.items() if each}
    seeds = sorted({row["task"]["seed"] for row in rows})
    return StudyFindings(
        headline=_headline(found),
        tables=(
            ResultTable(
                f"Successful trials, over {len(seeds)} teachings of each behavior (seeds {seeds[0]} to {seeds[-1]})",
                ("behavior", *(f"#{world}" for world in WORLDS.values()), "#physics / 2-D", "#median, 2-D",
                 "#median, physics", "#examples"),
                [_told(name, each) for name, each in found.items()],
            ),
        ),
        goals=tuple(_goal(name, each) for name, each in found.items()),
        notes=NOTES,
        numbers=found,
    )  # fmt: skip


NOTES = (
    "Medians: for GoTo and visual servoing, seconds until arrival; for Disperse, the distance in meters from its start "
    "of the robot that got least far in a world; for CollectivePatrol, seconds from a capture until all robots have "
    "left again.",
    "In the 2-D world, the robot of visual servoing walks, slips and sways; in physics it rolls, and is faster.",
)


def _numbers(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the successful trials, all trials and the median value of one behavior in each world."""
    if not rows:
        return {}
    made: dict[str, Any] = {"examples": [row["examples"] for row in rows]}
    for world in WORLDS:
        if rows[0]["task"]["behavior"] == PATROL:
            good, count = (sum(row[world][key] for row in rows) for key in ("complete", "cycles"))
        else:
            count = sum(len(row[world]["values"]) for row in rows)
            good = round(sum(row[world]["success"] * len(row[world]["values"]) for row in rows))
        values = [value for row in rows for value in row[world]["values"] if value is not None]
        made[world] = {
            "good": good,
            "of": count,
            "median": round(float(np.median(values)), 1) if values else None,
        }
    return made


def _share(of: Mapping[str, Any]) -> float:
    return of["good"] / of["of"] if of["of"] else 0.0


def _left(found: Mapping[str, Any]) -> float:
    """Return the success rate in physics relative to the 2-D world."""
    before = _share(found[FLAT])
    return _share(found[PHYSICS]) / before if before else 0.0


def _headline(found: Mapping[str, Any]) -> str:
    parts = [
        f"{name} {_share(of[PHYSICS]):.0%} ({_share(of[FLAT]):.0%} in the 2-D world)"
        for name, of in found.items()
    ]
    return (
        "Share of successful trials in simulated physics with rendered cameras, after teaching in the 2-D world and "
        f"without any added example: {', '.join(parts)}."
    )


def _told(name: str, found: Mapping[str, Any]) -> tuple[str, ...]:
    shares = (_said(found[world]) for world in WORLDS)
    medians = (
        "none" if found[world]["median"] is None else f"{found[world]['median']:g}" for world in WORLDS
    )
    return (name, *shares, f"{_left(found):.2f}", *medians, format_median(found["examples"]))


def _said(of: Mapping[str, Any]) -> str:
    low, high = interval_of_share(of["good"], of["of"])
    return f"{of['good']} of {of['of']} ({100 * low:.0f}–{100 * high:.0f} %)"


def _goal(name: str, found: Mapping[str, Any]) -> StudyGoal:
    if name == PATROL:
        share = _share(found[PHYSICS])
        return StudyGoal(
            "cycles of CollectivePatrol completed in physics",
            f"{CYCLES:.0%}",
            f"{share:.0%}",
            share >= CYCLES,
        )
    left = _left(found)
    return StudyGoal(f"{name}: success in physics / in the 2-D world", f"{KEPT}", f"{left:.2f}", left >= KEPT)


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the success of every teaching in both worlds."""
    names = list(dict.fromkeys(row["task"]["behavior"] for row in rows))
    figure, axes = panels(len(names), wide=2.3)
    for panel, name in zip(axes, names, strict=True):
        mine = [row for row in rows if row["task"]["behavior"] == name]
        groups = {
            said: [100 * (row[world]["success"] or 0.0) for row in mine] for world, said in WORLDS.items()
        }
        dots(panel, groups, "success, %")
        panel.set_ylim(-3, 103)
        panel.set_title(name)
    return figure


EXPERIMENT = Study(
    name="transfer",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage", "soccer", "patrol"),
    varies=(PHYSICS,),
)
