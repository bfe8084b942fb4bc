"""The experiment: every behavior of the suite taught many times, each teaching tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy_lab.behavior_suite import (
    chase,
    figure_eight,
    scavenge,
    triangle,
    wall_following,
    waypoints,
)
from understudy_lab.behavior_suite.task import BehaviorTask
from understudy_lab.behavior_suite.teach import PAPER, WORLDS, row_of
from understudy_lab.figures import dots, panels
from understudy_lab.statistics import Numbers, format_median, interval_of_median, spread
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    made: list[Task] = [{"behavior": name, "seed": seed} for name in FEATS for seed in plan.seeds]
    first = plan.seeds[:LIVE_TEACHINGS]
    return made + [{"behavior": name, "seed": seed, "method": LIVE} for name in FEATS for seed in first]


def work(task: Task) -> Row:
    """Teach one behavior once and test it."""
    return row_of(FEATS[task["behavior"]], task["seed"], method=task.get("method", PAPER))


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize each behavior over its teachings."""
    every, rows = rows, [row for row in rows if "method" not in row["task"]]
    live = group_by_behavior([row for row in every if "method" in row["task"]])
    groups = group_by_behavior(rows)
    behaviors = {name: summarize_teachings(of) for name, of in groups.items()}
    goals = tuple(goal for name, of in behaviors.items() for goal in goals_of(name, of))
    held = [name for name in behaviors if all(goal.held for goal in goals_of(name, behaviors[name]))]
    well, both = (
        sum(of[f"teachings_reaching_{what}"] for of in behaviors.values()) for what in ("95", "both")
    )
    count = sum(of["of"] for of in behaviors.values())
    middle = np.median([row["examples"] for row in rows])
    return StudyFindings(
        headline=f"{len(held)} of {len(behaviors)} behaviors of the paper reach their goals in the median. {well} of "
        f"{count} teachings succeed in at least 95 % of {WORLDS} unseen worlds each; {both} of them also reach {RATIO} "
        f"of the speed of a hand-written controller. All automata of a behavior together take {middle:.0f} examples "
        "(median).",
        tables=(
            ResultTable(
                "Results by behavior: median [95 % interval of the median] (smallest–largest)",
                (
                    "behavior",
                    "#teachings with 95 % success",
                    f"#and at {RATIO} of the speed",
                    "#success",
                    "#speed / hand-written",
                    "#examples",
                    "#presses",
                    "#teaching time, s",
                ),
                [make_taught_row(name, of, behaviors[name]) for name, of in groups.items()],
            ),
            ResultTable(
                f"Taught live, the first {LIVE_TEACHINGS} teachings: median (smallest–largest), and its share of the "
                "median above",
                (
                    "behavior",
                    "#teachings with 95 % success",
                    "#success",
                    "#speed / hand-written",
                    "#presses",
                    "#share",
                    "#teaching time, s",
                ),
                [make_live_row(name, of, groups[name]) for name, of in live.items()],
            ),
            ResultTable(
                "Success criteria and references: a hand-written controller, and a lower bound of the time",
                ("behavior", "success", "lower bound", "#hand-written: success", "#its time / bound"),
                [make_expert_row(name, of) for name, of in groups.items()],
            ),
            ResultTable(
                "Size of the lessons (medians)",
                ("lesson", "behavior", "#features", "#states", "#examples", "#nodes of all trees"),
                [lesson for name, of in groups.items() for lesson in lessons(name, of)],
            ),
        ),
        goals=(*goals, *make_live_goals(live, groups)),
        notes=(
            NOTE,
            *list_failed_teachings(groups),
            *list_uncertain_goals(behaviors),
            describe_discarded_lessons(rows),
        ),
        numbers={
            "behaviors": behaviors,
            "live": {name: summarize_teachings(of) for name, of in live.items()},
        },
    )


NOTE = (
    "The lower bounds ignore turning and searching for things that are not visible yet. So they only limit how far the "
    "hand-written controllers are from the optimum. These controllers run one basic behavior at a time, like the "
    "taught automata."
)


def group_by_behavior(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Group rows by behavior."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row["task"]["behavior"], []).append(row)
    return found


def ratios(rows: Sequence[Row]) -> list[float]:
    """Return the speed of each teaching relative to the hand-written controller."""
    return [row["ratio"] or 0.0 for row in rows]


def summarize_teachings(rows: Sequence[Row]) -> dict[str, Any]:
    """Return medians and spread over teachings; the unit is the taught automaton, not the world."""
    success = np.array([row["success"] for row in rows])
    reaching = success >= SUCCESS
    return {
        "teachings_reaching_95": int(reaching.sum()),
        "teachings_reaching_both": int((reaching & (np.array(ratios(rows)) >= RATIO)).sum()),
        "of": len(rows),
        "success": summarize_values(success),
        "ratio": summarize_values(ratios(rows)),
        "examples": summarize_values([row["examples"] for row in rows]),
        "presses": spread([row["presses"] for row in rows]),
        "seconds": spread([row["seconds"] for row in rows]),
        "hand_success": spread([row["hand"]["success"] for row in rows]),
        "hand_of_bound": spread([row["hand"]["of_bound"] for row in rows]),
    }


def summarize_values(values: Numbers) -> dict[str, float]:
    """Return minimum, median, maximum, and a 95 % interval of the median."""
    low, high = interval_of_median(values)
    return {**spread(values), "low": round(low, 4), "high": round(high, 4)}


def format_behavior_name(name: str) -> str:
    """Format a behavior's name as words."""
    return name.replace("_", ", ")


def make_taught_row(name: str, rows: Sequence[Row], of: Mapping[str, Any]) -> list[str]:
    """Return a behavior's row of the first table."""
    return [
        format_behavior_name(name),
        f"{of['teachings_reaching_95']} of {of['of']}",
        f"{of['teachings_reaching_both']} of {of['of']}",
        format_interval({what: 100 * value for what, value in of["success"].items()}, unit=" %"),
        format_interval(of["ratio"], digits=2),
        format_interval(of["examples"]),
        format_median([row["presses"] for row in rows]),
        format_median([row["seconds"] for row in rows]),
    ]


def make_live_row(name: str, rows: Sequence[Row], before: Sequence[Row]) -> list[str]:
    """Return a behavior's row of the table of live teaching."""
    return [
        format_behavior_name(name),
        f"{sum(row['success'] >= SUCCESS for row in rows)} of {len(rows)}",
        format_median([row["success"] for row in rows], percent=True),
        format_median(ratios(rows), 2),
        format_median([row["presses"] for row in rows]),
        f"{share_presses(rows, before):.2f}",
        format_median([row["seconds"] for row in rows]),
    ]


def share_presses(rows: Sequence[Row], before: Sequence[Row]) -> float:
    """Return the median presses of teachings as a share of those of others."""
    now, then = (float(np.median([row["presses"] for row in of])) for of in (rows, before))
    return now / then


def make_live_goals(
    live: Mapping[str, Sequence[Row]], groups: Mapping[str, Sequence[Row]]
) -> tuple[StudyGoal, ...]:
    """Return the goals of live teaching: as successful everywhere, with fewer presses for the median behavior."""
    if not live:
        return ()
    shares = [share_presses(of, groups[name]) for name, of in live.items()]
    medians = {
        name: tuple(float(np.median([row["success"] for row in each])) for each in (of, groups[name]))
        for name, of in live.items()
    }
    lower = [
        f"{format_behavior_name(name)} {now:.1%} instead of {then:.1%}"
        for name, (now, then) in medians.items()
        if now < then
    ]
    return (
        StudyGoal(
            "taught live: presses as a share of those above, median behavior",
            f"at most {FEWER}",
            f"{np.median(shares):.2f}",
            float(np.median(shares)) <= FEWER,
        ),
        StudyGoal(
            "taught live: median success of each behavior",
            "no lower than above",
            "; ".join(lower) or "in none",
            not lower,
        ),
    )


def format_interval(of: Mapping[str, float], *, digits: int = 0, unit: str = "") -> str:
    """Format the result of `summarize_values`, for example "98 % [97–99] (93–100)"."""
    middle, *rest = (f"{of[what]:.{digits}f}" for what in ("median", "low", "high", "min", "max"))
    low, high, smallest, largest = rest
    return f"{middle}{unit} [{low}–{high}] ({smallest}–{largest})"


def make_expert_row(name: str, rows: Sequence[Row]) -> list[str]:
    """Return a behavior's row of the second table."""
    feat = FEATS[name]
    return [
        format_behavior_name(name),
        feat.measured,
        feat.bounded,
        format_median([row["hand"]["success"] for row in rows], percent=True),
        format_median([row["hand"]["of_bound"] for row in rows], 2),
    ]


def lessons(name: str, rows: Sequence[Row]) -> list[list[str]]:
    """Return a behavior's rows of the third table."""
    found = []
    for k, lesson in enumerate(rows[0]["lessons"]):
        same = [row["lessons"][k] for row in rows]
        middle = np.median([[each["examples"], sum(each["nodes"])] for each in same], axis=0)
        numbers = (lesson["features"], lesson["states"], *middle)
        found.append([lesson["name"], format_behavior_name(name), *(f"{number:.0f}" for number in numbers)])
    return found


def goals_of(name: str, of: Mapping[str, Any]) -> tuple[StudyGoal, ...]:
    """Return each goal of a behavior with the measured median over teachings."""
    success, ratio, examples = (of[what]["median"] for what in ("success", "ratio", "examples"))
    return (
        StudyGoal(
            f"{format_behavior_name(name)}: success on unseen worlds",
            "95 %",
            f"{success:.0%}",
            success >= SUCCESS,
        ),
        StudyGoal(
            f"{format_behavior_name(name)}: speed / hand-written", f"{RATIO}", f"{ratio:.2f}", ratio >= RATIO
        ),
        StudyGoal(
            f"{format_behavior_name(name)}: examples of all automata",
            f"at most {EXAMPLES}",
            f"{examples:.0f}",
            examples <= EXAMPLES,
        ),
    )


def list_failed_teachings(groups: Mapping[str, Sequence[Row]]) -> list[str]:
    """Return a sentence on the teachings below 95 % success, or an empty list."""
    found = {
        format_behavior_name(name): [row["success"] for row in of if row["success"] < SUCCESS]
        for name, of in groups.items()
    }
    told_ = [f"{name} {len(short)} (worst {min(short):.0%})" for name, short in found.items() if short]
    return [f"Teachings below 95 % success: {'; '.join(told_)}."] if told_ else []


def list_uncertain_goals(behaviors: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the goals whose threshold lies within the interval of the measured value."""
    asked = {"success": SUCCESS, "ratio": RATIO, "examples": EXAMPLES}
    found = [
        f"{format_behavior_name(name)}, {what}"
        for name, of in behaviors.items()
        for what, goal in asked.items()
        if of[what]["low"] < goal < of[what]["high"]
    ]
    return [f"The 95 % interval includes the goal: {'; '.join(found)}."] if found else []


def describe_discarded_lessons(rows: Sequence[Row]) -> str:
    """Return a sentence on how lessons count that were discarded and started again."""
    anew = [row for row in rows if any(lesson["attempts"] > 1 for lesson in row["lessons"])]
    each = ", ".join(
        f"{format_behavior_name(row['task']['behavior'])}, {row['examples']} examples kept, "
        f"{row['presses']} presses in all"
        for row in anew
    )
    return (
        "When a lesson fails and is discarded, it is taught again. Its presses and seconds count, its examples do not "
        f"(a press makes at most two). This happened in {len(anew)} of {len(rows)} teachings"
        f"{f' ({each})' if each else ''}."
    )


SHOWN: Mapping[str, tuple[str, float, Callable[[Row], float]]] = {
    "success": ("unseen worlds, %", 100 * SUCCESS, lambda row: 100 * row["success"]),
    "speed": ("% of hand-written", 100 * RATIO, lambda row: 100 * (row["ratio"] or 0.0)),
    "examples of the whole hierarchy": ("from presses", EXAMPLES, lambda row: row["examples"]),
}


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success, speed and examples of every teaching, by behavior."""
    groups = group_by_behavior([row for row in rows if "method" not in row["task"]])
    figure, found = panels(3, rows=3, wide=7.2, tall=2.1)
    names = {name: format_behavior_name(name).replace(", ", "\n") for name in groups}
    for axes, (title, (unit, goal, values)) in zip(found, SHOWN.items(), strict=True):
        axes.axhline(goal, color="#9ca3af", linewidth=0.8, linestyle="--")
        dots(axes, {names[name]: [values(row) for row in of] for name, of in groups.items()}, unit)
        axes.set_ylim(0, 1.06 * axes.get_ylim()[1])
        axes.set_title(f"{title} (goal: dashed)")
    return figure


EXPERIMENT = Study(
    name="repertoire",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
)
