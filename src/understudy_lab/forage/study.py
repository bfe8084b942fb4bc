"""The experiment: many teachings with three methods, each tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Any

import numpy as np

from understudy.judging.baseline import ControllerRun
from understudy.judging.outcomes import measure_success
from understudy.sim.forage import Forage, make_corner_cases
from understudy_lab.declaration import ColumnPerGroup, Conclusion, Goal, Units, goals_among
from understudy_lab.figures import Dots, Panels, by_group
from understudy_lab.forage.teach import METHODS, WORLDS, teach_and_judge, worlds_of
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.statistics import spread
from understudy_lab.study import Row, Study, Task
from understudy_lab.tasks.forage_expert import ExpertForager, lower_bound
from understudy_lab.teachers.live_teacher import LIVE

TEACHINGS = range(41_000, 41_020)
"""The teaching seeds of the published result; none was used during development."""
REACHED = 0.95
"""The success that a teaching is to reach, and the share of teachings that are to reach it."""


def work(task: Task) -> Row:
    """Teach one robot, test it in its own unseen worlds, and compare the baseline there with its lower bound."""
    return {
        **teach_and_judge(task["seed"], method=task["method"]),
        "yardstick": measure_expert_ratio(task["seed"]),
    }


def measure_expert_ratio(seed: int) -> float:
    """Return the median ratio of the baseline's time to the lower bound, over the worlds of a teaching."""
    body = Forage(worlds_of(seed))
    bound = lower_bound(body)
    hand = ExpertForager(body.agents, body.settings)
    seconds = measure_success(ControllerRun(body, hand.decide, hand.keys), 10.0 * bound + 60.0).seconds
    return round(float(np.median(seconds / bound)), 4)


SUCCEEDS = Count(lambda row: row["success"] >= REACHED)
GROUPS = group_by("method", METHODS)


def summarize_rows(rows: Rows) -> dict[str, Any]:
    """Return the medians and spread over teachings; the unit is the taught automaton, not the world."""
    return {
        "teachings_reaching_95": SUCCEEDS.number(rows),
        "of": len(rows),
        "success": spread(rows.values("success")),
        "relative_to_expert": spread(rows.values("relative_to_expert")),
        "examples": spread(rows.values("examples.total")),
        "presses": spread(rows.values("presses")),
        "teaching_seconds": spread(rows.values("teaching_seconds")),
        "corner_cases": {name: spread(rows.values(f"corner_cases.{name}")) for name in make_corner_cases()},
    }


def write_headline(groups: Mapping[str, Rows]) -> str:
    """Return what the watched method and live teaching reach."""
    watched, live = summarize_rows(groups["watched"]), summarize_rows(groups[LIVE])
    return (
        f"{watched['teachings_reaching_95']} of {watched['of']} taught robots succeed in at least 95 % of "
        f"unseen worlds. They collect {watched['relative_to_expert']['median']:.0%} of the food per second that a "
        f"hand-written controller collects, after {watched['examples']['median']:.0f} examples and "
        f"{watched['teaching_seconds']['median'] / 60:.0f} minutes of teaching (medians). Taught live, it takes "
        f"{live['presses']['median']:.0f} instead of {watched['presses']['median']:.0f} presses and "
        f"{live['teaching_seconds']['median'] / 60:.1f} minutes."
    )


def write_bound(groups: Mapping[str, Rows]) -> str:
    """Return a note on how far the hand-written controller is from the optimum."""
    bound = spread(groups["watched"].values("yardstick"))
    return (
        f"The hand-written controller takes {bound['median']:.3f} ({bound['min']:.3f} to {bound['max']:.3f}) times "
        "the lower bound of the time for robots that always go to the nearest food (medians over the worlds of a "
        "teaching)."
    )


TEACHINGS_REACH = Goal(
    "teachings that reach 95 % success",
    lambda each: each["teachings_reaching_95"] / each["of"],
    least=REACHED,
    wanted=lambda each: f"{ceil(REACHED * each['of'])} of {each['of']}",
    measured=lambda each: f"{each['teachings_reaching_95']} of {each['of']}",
)
FOOD, SECONDS = "food per second / hand-written, median", "seconds of a median teaching"
GOALS = (
    TEACHINGS_REACH,
    Goal("success of the worst teaching", "success.min", least=0.85, wanted="85 %"),
    Goal(FOOD, "relative_to_expert.median", ".3f", 0.92, wanted="0.92"),
    Goal("examples of a median teaching", "examples.median", ".0f", most=80),
    Goal(SECONDS, "teaching_seconds.median", ".0f", most=600),
)
"""The goals of the watched method, for a summary of its rows."""
LIVE_GOALS = (
    TEACHINGS_REACH,
    Goal(FOOD, "relative_to_expert.median", ".3f", 0.94, wanted="0.94"),
    Goal("presses of a median teaching", "presses.median", ".0f", most=24),
    Goal(SECONDS, "teaching_seconds.median", ".0f", most=240),
)

EXPERIMENT = Study(
    name="forage",
    seeds=TEACHINGS,
    quick=1,
    tasks=Units({"method": METHODS}),
    work=work,
    conclude=Conclusion(
        prepare=GROUPS,
        headline=write_headline,
        tables=(
            ColumnPerGroup(
                f"Teachings {{seeds}}, each tested in {WORLDS} unseen worlds of its own (live: live teaching; watched: "
                "the paper's training, with watched examples; plain: without them)",
                dict,
                {
                    "teachings with 95 % success": SUCCEEDS,
                    "success": Median("success", percent=True),
                    "food per second / hand-written": Median("relative_to_expert", 3),
                    "examples from presses": Median("examples.total"),
                    "presses": Median("presses"),
                    "teaching time, s": Median("teaching_seconds"),
                },
            ),
            ColumnPerGroup(
                "Success of the worst teaching in the paper's corner cases",
                dict,
                {
                    case: lambda rows, of=f"corner_cases.{case}": f"{spread(rows.values(of))['min']:.0%}"
                    for case in make_corner_cases()
                },
                head="corner case",
            ),
        ),
        goals=(
            *goals_among(lambda groups: summarize_rows(groups["watched"]), GOALS),
            *goals_among(lambda groups: summarize_rows(groups[LIVE]), LIVE_GOALS, "taught live: "),
        ),
        notes=(write_bound,),
        numbers=lambda groups: {
            "methods": {name: summarize_rows(rows) for name, rows in groups.items()},
            "yardstick": spread(groups["watched"].values("yardstick")),
        },
    ),
    draw=Panels(
        (
            Dots("success", "worlds finished in time, %", by_group(GROUPS, "success", 100)),
            Dots("speed", "food per second, % of hand-written", by_group(GROUPS, "relative_to_expert", 100)),
        )
    ),
    worlds=("forage",),
)
