"""The experiment: every behavior of the suite taught many times, each teaching tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from understudy_lab.behavior_suite import (
    chase,
    figure_eight,
    scavenge,
    triangle,
    wall_following,
    waypoints,
)
from understudy_lab.behavior_suite.task import PAPER, WORLDS, BehaviorTask, row_of
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, goals_among
from understudy_lab.figures import Dots, Panels, by_group
from understudy_lab.rows import Count, Median, Rows, Value, group_by
from understudy_lab.statistics import Numbers, interval_of_median, spread
from understudy_lab.study import Row, Study, StudyGoal, StudyPlan, Task
from understudy_lab.teachers.live_teacher import LIVE

TEACHINGS = range(51_000, 51_020)
"""The teaching seeds of the published result; none was used during development."""

FEATS: Mapping[str, BehaviorTask] = {
    feat.name: feat
    for feat in (
        chase.FEAT,
        *wall_following.WALL_TASKS,
        *wall_following.CIRCLING_TASKS,
        figure_eight.FEAT,
        waypoints.FEAT,
        scavenge.FEAT,
        triangle.FEAT,
    )
}

SUCCESS, RATIO, EXAMPLES = 0.95, 0.85, 60
LIVE_TEACHINGS = 10
"""The number of teachings of each behavior that are also taught live."""
FEWER = 0.6
"""The largest share of presses in live teaching, for the median behavior."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per behavior and seed, and one in live teaching for the first seeds."""
    teachings: list[Task] = [{"behavior": name, "seed": seed} for name in FEATS for seed in plan.seeds]
    first = plan.seeds[:LIVE_TEACHINGS]
    return teachings + [{"behavior": name, "seed": seed, "method": LIVE} for name in FEATS for seed in first]


def work(task: Task) -> Row:
    """Teach one behavior once and test it."""
    return row_of(FEATS[task["behavior"]], task["seed"], method=task.get("method", PAPER))


class Teachings(NamedTuple):
    """The rows of the paper's training and of live teaching, by behavior."""

    paper: Mapping[str, Rows]
    live: Mapping[str, Rows]


def group_teachings(rows: Rows) -> Teachings:
    """Group rows by method and behavior."""
    group = group_by("behavior")
    return Teachings(group(rows.where(method=None)), group(rows.where(method=LIVE)))


def compare_speed(row: Row) -> float:
    """Return the speed of a teaching relative to the hand-written controller."""
    return row["ratio"] or 0.0


SUCCEEDS = Count(lambda row: row["success"] >= SUCCESS)
SUCCEEDS_FAST = Count(lambda row: SUCCEEDS.condition(row) and compare_speed(row) >= RATIO)


def summarize_teachings(teachings: Sequence[Row]) -> dict[str, Any]:
    """Return medians and spread over teachings; the unit is the taught automaton, not the world."""
    rows = Rows(teachings)
    return {
        "teachings_reaching_95": SUCCEEDS.number(rows),
        "teachings_reaching_both": SUCCEEDS_FAST.number(rows),
        "of": len(rows),
        "success": summarize_values(rows.values("success")),
        "ratio": summarize_values(rows.values(compare_speed)),
        "examples": summarize_values(rows.values("examples")),
        "presses": spread(rows.values("presses")),
        "seconds": spread(rows.values("seconds")),
        "hand_success": spread(rows.values("hand.success")),
        "hand_of_bound": spread(rows.values("hand.of_bound")),
    }


def summarize_values(values: Numbers) -> dict[str, float]:
    """Return minimum, median, maximum, and a 95 % interval of the median."""
    low, high = interval_of_median(values)
    return {**spread(values), "low": round(low, 4), "high": round(high, 4)}


def _format_interval(of: Value, rows: Rows, *, digits: int = 0, percent: bool = False) -> str:
    """Format a value of rows, for example "98 % [97–99] (93–100)"."""
    summary, scale = summarize_values(rows.values(of)), 100 if percent else 1
    middle, low, high, least, most = (
        f"{scale * summary[what]:.{digits}f}" for what in ("median", "low", "high", "min", "max")
    )
    return f"{middle}{' %' if percent else ''} [{low}–{high}] ({least}–{most})"


def _name(behavior: str) -> str:
    return behavior.replace("_", ", ")


def _share_presses(rows: Rows, before: Rows) -> float:
    """Return the median presses of teachings as a share of those of others."""
    return rows.median("presses") / before.median("presses")


GOALS = (
    Goal("success on unseen worlds", "success.median", least=SUCCESS, wanted="95 %"),
    Goal("speed / hand-written", "ratio.median", ".2f", RATIO),
    Goal("examples of all automata", "examples.median", ".0f", most=EXAMPLES),
)
"""The goals of each behavior, for a summary of its teachings."""


def goals_of(name: str, summary: Mapping[str, Any]) -> tuple[StudyGoal, ...]:
    """Return each goal of a behavior with the measured median over teachings."""
    return tuple(
        goal(summary) for goal in goals_among(lambda teachings: teachings, GOALS, f"{_name(name)}: ")
    )


def _goals(teachings: Teachings) -> list[StudyGoal]:
    goals = [
        goal for name, rows in teachings.paper.items() for goal in goals_of(name, summarize_teachings(rows))
    ]
    if not teachings.live:
        return goals
    share = float(
        np.median([_share_presses(rows, teachings.paper[name]) for name, rows in teachings.live.items()])
    )
    medians = {
        name: (rows.median("success"), teachings.paper[name].median("success"))
        for name, rows in teachings.live.items()
    }
    lower = "; ".join(
        f"{_name(name)} {now:.1%} instead of {then:.1%}"
        for name, (now, then) in medians.items()
        if now < then
    )
    fewer = "taught live: presses as a share of those above, median behavior"
    as_good = "taught live: median success of each behavior"
    return [
        *goals,
        StudyGoal(fewer, f"at most {FEWER}", f"{share:.2f}", share <= FEWER),
        StudyGoal(as_good, "no lower than above", lower or "in none", not lower),
    ]


def _headline(teachings: Teachings) -> str:
    held = [
        all(goal.held for goal in goals_of(name, summarize_teachings(of)))
        for name, of in teachings.paper.items()
    ]
    rows = Rows(row for of in teachings.paper.values() for row in of)
    return (
        f"{sum(held)} of {len(held)} behaviors of the paper reach their goals in the median. {SUCCEEDS.number(rows)} "
        f"of {len(rows)} teachings succeed in at least 95 % of {WORLDS} unseen worlds each; "
        f"{SUCCEEDS_FAST.number(rows)} of them also reach {RATIO} of the speed of a hand-written controller. All "
        f"automata of a behavior together take {rows.median('examples'):.0f} examples (median)."
    )


def _notes(teachings: Teachings) -> list[str]:
    failed = {
        name: rows.filter(lambda row: row["success"] < SUCCESS) for name, rows in teachings.paper.items()
    }
    failures = "; ".join(
        f"{_name(name)} {len(rows)} (worst {min(rows.values('success')):.0%})"
        for name, rows in failed.items()
        if rows
    )
    summaries = {name: summarize_teachings(rows) for name, rows in teachings.paper.items()}
    uncertain = "; ".join(
        f"{_name(name)}, {what}"
        for name, of in summaries.items()
        for what, goal in (("success", SUCCESS), ("ratio", RATIO), ("examples", EXAMPLES))
        if of[what]["low"] < goal < of[what]["high"]
    )
    return [
        "The lower bounds ignore turning and searching for things that are not visible yet. So they only limit how far "
        "the hand-written controllers are from the optimum. These controllers run one basic behavior at a time, like "
        "the taught automata.",
        f"Teachings below 95 % success: {failures}." if failures else "",
        f"The 95 % interval includes the goal: {uncertain}." if uncertain else "",
        describe_discarded_lessons([row for rows in teachings.paper.values() for row in rows]),
    ]


def describe_discarded_lessons(rows: Sequence[Row]) -> str:
    """Return a sentence on how lessons count that were discarded and started again."""
    again = [row for row in rows if any(lesson["attempts"] > 1 for lesson in row["lessons"])]
    each = ", ".join(
        f"{_name(row['task']['behavior'])}, {row['examples']} examples kept, {row['presses']} presses in all"
        for row in again
    )
    return (
        "When a lesson fails and is discarded, it is taught again. Its presses and seconds count, its examples do not "
        f"(a press makes at most two). This happened in {len(again)} of {len(rows)} teachings"
        f"{f' ({each})' if each else ''}."
    )


def _group_with_former(teachings: Teachings) -> dict[str, Rows]:
    return {
        name: Rows({**row, "former": teachings.paper[name]} for row in rows)
        for name, rows in teachings.live.items()
    }


def _group_lessons(teachings: Teachings) -> dict[tuple[str, str], Rows]:
    return {
        (lesson["name"], name): Rows(row["lessons"][number] for row in rows)
        for name, rows in teachings.paper.items()
        for number, lesson in enumerate(rows[0]["lessons"])
    }


def _count_in(of: Value) -> Callable[[Rows], str]:
    return lambda rows: f"{rows.median(of):.0f}"


def _draw_goal(title: str, unit: str, of: Value, goal: float, scale: float = 1) -> Callable[[Any, Any], None]:
    """Return a function that draws a panel with a dashed line at a goal."""
    by_behavior = by_group(group_by("behavior"), of, scale)
    panel = Dots(
        f"{title} (goal: dashed)",
        unit,
        lambda rows: {_name(name).replace(", ", "\n"): values for name, values in by_behavior(rows).items()},
    )

    def draw(axes: Any, rows: Rows) -> None:
        axes.axhline(scale * goal, color="#9ca3af", linewidth=0.8, linestyle="--")
        panel(axes, rows)
        axes.set_ylim(0, 1.06 * axes.get_ylim()[1])

    return draw


EXPERIMENT = Study(
    name="repertoire",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=group_teachings,
        headline=_headline,
        tables=(
            LinePerGroup(
                "Results by behavior: median [95 % interval of the median] (smallest–largest)",
                ["behavior"],
                lambda teachings: teachings.paper,
                {
                    "teachings with 95 % success": SUCCEEDS,
                    f"and at {RATIO} of the speed": SUCCEEDS_FAST,
                    "success": partial(_format_interval, "success", percent=True),
                    "speed / hand-written": partial(_format_interval, compare_speed, digits=2),
                    "examples": partial(_format_interval, "examples"),
                    "presses": Median("presses"),
                    "teaching time, s": Median("seconds"),
                },
                lambda name: [_name(name)],
            ),
            LinePerGroup(
                f"Taught live, the first {LIVE_TEACHINGS} teachings: median (smallest–largest), and its share of the "
                "median above",
                ["behavior"],
                _group_with_former,
                {
                    "teachings with 95 % success": SUCCEEDS,
                    "success": Median("success", percent=True),
                    "speed / hand-written": Median(compare_speed, 2),
                    "presses": Median("presses"),
                    "share": lambda rows: f"{_share_presses(rows, rows[0]['former']):.2f}",
                    "teaching time, s": Median("seconds"),
                },
                lambda name: [_name(name)],
            ),
            LinePerGroup(
                "Success criteria and references: a hand-written controller, and a lower bound of the time",
                ["behavior", "success", "lower bound"],
                lambda teachings: teachings.paper,
                {
                    "hand-written: success": Median("hand.success", percent=True),
                    "its time / bound": Median("hand.of_bound", 2),
                },
                lambda name: [_name(name), FEATS[name].measured, FEATS[name].bounded],
            ),
            LinePerGroup(
                "Size of the lessons (medians)",
                ["lesson", "behavior"],
                _group_lessons,
                {
                    "features": _count_in("features"),
                    "states": _count_in("states"),
                    "examples": _count_in("examples"),
                    "nodes of all trees": _count_in(lambda lesson: sum(lesson["nodes"])),
                },
                lambda key: [key[0], _name(key[1])],
            ),
        ),
        goals=_goals,
        notes=_notes,
        numbers=lambda teachings: {
            "behaviors": {name: summarize_teachings(of) for name, of in teachings.paper.items()},
            "live": {name: summarize_teachings(of) for name, of in teachings.live.items()},
        },
    ),
    draw=Panels(
        (
            _draw_goal("success", "unseen worlds, %", "success", SUCCESS, 100),
            _draw_goal("speed", "% of hand-written", compare_speed, RATIO, 100),
            _draw_goal("examples of the whole hierarchy", "from presses", "examples", EXAMPLES),
        ),
        rows=3,
        wide=7.2,
        tall=2.1,
        prepare=lambda rows: rows.where(method=None),
    ),
)
