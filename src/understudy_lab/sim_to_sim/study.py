"""The experiment: behaviors taught in the 2-D world, tested there and in physics on the same unseen seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, Units
from understudy_lab.figures import Dots, Panels
from understudy_lab.rows import Median, Rows, group_by
from understudy_lab.sim_to_sim.trials import FLAT, PATROL, PHYSICS, TRIED, measure_transfer
from understudy_lab.statistics import format_share
from understudy_lab.study import Row, Study, StudyGoal, Task

SEEDS = range(64_000, 64_010)
"""The teaching seeds of the published result; none was used during development."""
KEPT, CYCLES = 0.9, 0.8
"""The goals: success in physics relative to the 2-D world, and the share of completed patrol cycles."""
WORLDS: Mapping[str, str] = {FLAT: "2-D world", PHYSICS: "physics"}


def work(task: Task) -> Row:
    """Teach one behavior once and test it in both worlds."""
    return measure_transfer(task["behavior"], task["seed"])


def _count(rows: Rows, world: str) -> tuple[int, int]:
    """Return the number of successful trials of one behavior, and that of all."""
    results = [row[world] for row in rows]
    if rows[0]["task"]["behavior"] == PATROL:
        return sum(each["complete"] for each in results), sum(each["cycles"] for each in results)
    counts = [len(each["values"]) for each in results]
    good = sum(each["success"] * count for each, count in zip(results, counts, strict=True))
    return round(good), sum(counts)


def _share(rows: Rows, world: str = PHYSICS) -> float:
    good, of = _count(rows, world)
    return good / of if of else 0.0


def _keep(rows: Rows) -> float:
    """Return the success rate in physics relative to the 2-D world."""
    before = _share(rows, FLAT)
    return _share(rows) / before if before else 0.0


def _median(rows: Rows, world: str) -> float | None:
    values = [value for row in rows for value in row[world]["values"] if value is not None]
    return round(float(np.median(values)), 1) if values else None


def _format_median(rows: Rows, world: str) -> str:
    median = _median(rows, world)
    return "none" if median is None else f"{median:g}"


def _headline(groups: Mapping[str, Rows]) -> str:
    parts = [
        f"{name} {_share(of):.0%} ({_share(of, FLAT):.0%} in the 2-D world)" for name, of in groups.items()
    ]
    return (
        "Share of successful trials in simulated physics with rendered cameras, after teaching in the 2-D world and "
        f"without any added example: {', '.join(parts)}."
    )


NOTES = (
    "Medians: for GoTo and visual servoing, seconds until arrival; for Disperse, the distance in meters from its start "
    "of the robot that got least far in a world; for CollectivePatrol, seconds from a capture until all robots have "
    "left again.",
    "In the 2-D world, the robot of visual servoing walks, slips and sways; in physics it rolls, and is faster.",
)


def _judge(name: str) -> Callable[[Mapping[str, Rows]], StudyGoal | None]:
    if name == PATROL:
        goal = Goal("cycles of CollectivePatrol completed in physics", _share, least=CYCLES)
    else:
        goal = Goal(f"{name}: success in physics / in the 2-D world", _keep, ".2f", KEPT, wanted=f"{KEPT}")
    return lambda groups: goal(groups[name]) if name in groups else None


def _list_numbers(rows: Rows) -> dict[str, Any]:
    numbers: dict[str, Any] = {"examples": rows.values("examples")}
    for world in WORLDS:
        good, of = _count(rows, world)
        numbers[world] = {"good": good, "of": of, "median": _median(rows, world)}
    return numbers


def _panel(name: str) -> Dots:
    return Dots(
        name,
        "success, %",
        lambda rows: {
            title: [100 * (row[world]["success"] or 0.0) for row in rows.where(behavior=name)]
            for world, title in WORLDS.items()
        },
        limits=(-3, 103),
    )


EXPERIMENT = Study(
    name="transfer",
    seeds=SEEDS,
    quick=1,
    tasks=Units({"behavior": TRIED}),
    work=work,
    conclude=Conclusion(
        prepare=group_by("behavior"),
        headline=_headline,
        tables=(
            LinePerGroup(
                "Successful trials, over {teachings} teachings of each behavior (seeds {seeds})",
                ["behavior"],
                dict,
                {
                    **{
                        title: lambda rows, world=world: format_share(*_count(rows, world))
                        for world, title in WORLDS.items()
                    },
                    "physics / 2-D": lambda rows: f"{_keep(rows):.2f}",
                    "median, 2-D": partial(_format_median, world=FLAT),
                    "median, physics": partial(_format_median, world=PHYSICS),
                    "examples": Median("examples"),
                },
            ),
        ),
        goals=[_judge(name) for name in TRIED],
        notes=NOTES,
        numbers=lambda found: {name: _list_numbers(rows) for name, rows in found.items()},
    ),
    draw=Panels([_panel(name) for name in TRIED], wide=2.3),
    worlds=("forage", "soccer", "patrol"),
    varies=(PHYSICS,),
)
