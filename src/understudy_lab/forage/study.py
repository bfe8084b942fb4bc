"""The experiment: many teachings with two methods, each tested in its own unseen worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.analysis.baseline import ControllerRun
from understudy.analysis.rollout import measure_success
from understudy.sim.forage import Forage
from understudy_lab.figures import dots, panels
from understudy_lab.forage.teach import METHODS, WORLDS, summary, teach_and_judge, worlds_of
from understudy_lab.statistics import format_median, spread
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.tasks.forage_expert import ExpertForager, lower_bound
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHINGS = range(41_000, 41_020)
"""The teaching seeds of the published result; none was used during development."""

LIVE_GOALS = {"taught well": 0.95, "relative_to_expert": 0.94, "presses": 24, "seconds": 240.0}
GOALS = {"taught well": 0.95, "worst": 0.85, "relative_to_expert": 0.92, "examples": 80, "seconds": 600.0}


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per method and seed."""
    return [{"method": method, "seed": seed} for method in METHODS for seed in plan.seeds]


def work(task: Task) -> Row:
    """Teach one robot, test it in its own unseen worlds, and compare the baseline there with its lower bound."""
    return {
        **summary(teach_and_judge(task["seed"], method=task["method"])),
        "yardstick": measure_expert_ratio(task["seed"]),
    }


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize the methods over all teachings as a headline, tables, goals and notes."""
    by_method = {name: [row for row in rows if row["task"]["method"] == name] for name in METHODS}
    methods = {name: summarize_rows(of) for name, of in by_method.items()}
    watched = methods["watched"]
    first, last = rows[0]["task"]["seed"], rows[-1]["task"]["seed"]
    bound = spread([row["yardstick"] for row in by_method["watched"]])
    return StudyFindings(
        headline=f"{watched['teachings_reaching_95']} of {watched['of']} taught robots succeed in at least 95 % of "
        f"unseen worlds. They collect {watched['relative_to_expert']['median']:.0%} of the food per second that a "
        f"hand-written controller collects, after {watched['examples']['median']:.0f} examples and "
        f"{watched['teaching_seconds']['median'] / 60:.0f} minutes of teaching (medians). Taught live, it takes "
        f"{methods[LIVE]['presses']['median']:.0f} instead of {watched['presses']['median']:.0f} presses and "
        f"{methods[LIVE]['teaching_seconds']['median'] / 60:.1f} minutes.",
        tables=(
            ResultTable(
                f"Teachings {first} to {last}, each tested in {WORLDS} unseen worlds of its own (live: live "
                "teaching; watched: the paper's training, with watched examples; plain: without them)",
                ("", *(f"#{name}" for name in METHODS)),
                [
                    (what, *(tell(methods[name], by_method[name]) for name in METHODS))
                    for what, tell in TOLD.items()
                ],
            ),
            ResultTable(
                "Success of the worst teaching in the paper's corner cases",
                ("corner case", *(f"#{name}" for name in METHODS)),
                [
                    (case, *(f"{methods[name]['corner_cases'][case]['min']:.0%}" for name in METHODS))
                    for case in watched["corner_cases"]
                ],
            ),
        ),
        goals=(*goals(watched), *live_goals(methods[LIVE])),
        notes=(
            f"The hand-written controller takes {bound['median']:.3f} ({bound['min']:.3f} to {bound['max']:.3f}) times "
            "the lower bound of the time for robots that always go to the nearest food (medians over the worlds of a "
            "teaching).",
        ),
        numbers={"methods": methods, "yardstick": bound},
    )


TOLD: Mapping[str, Callable[[dict[str, Any], Sequence[Row]], str]] = {
    "teachings with 95 % success": lambda all_, rows: f"{all_['teachings_reaching_95']} of {all_['of']}",
    "success": lambda all_, rows: format_median([row["success"] for row in rows], percent=True),
    "food per second / hand-written": lambda all_, rows: format_median(
        [row["relative_to_expert"] for row in rows], 3
    ),
    "examples from presses": lambda all_, rows: format_median([row["examples"]["total"] for row in rows]),
    "presses": lambda all_, rows: format_median([row["presses"] for row in rows]),
    "teaching time, s": lambda all_, rows: format_median([row["teaching_seconds"] for row in rows]),
}


def summarize_rows(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the medians and spread over teachings; the unit is the taught automaton, not the world."""
    success = np.array([row["success"] for row in rows])
    return {
        "teachings_reaching_95": int((success >= 0.95).sum()),
        "of": len(rows),
        "success": spread(success),
        "relative_to_expert": spread([row["relative_to_expert"] for row in rows]),
        "examples": spread([row["examples"]["total"] for row in rows]),
        "presses": spread([row["presses"] for row in rows]),
        "teaching_seconds": spread([row["teaching_seconds"] for row in rows]),
        "corner_cases": {
            name: spread([row["corner_cases"][name] for row in rows]) for name in rows[0]["corner_cases"]
        },
    }


def measure_expert_ratio(seed: int) -> float:
    """Return the median ratio of the baseline's time to the lower bound, over the worlds of a teaching."""
    body = Forage(worlds_of(seed))
    bound = lower_bound(body)
    hand = ExpertForager(body.agents, body.settings)
    seconds = measure_success(ControllerRun(body, hand.decide, hand.keys), 10.0 * bound + 60.0).seconds
    return round(float(np.median(seconds / bound)), 4)


def goals(result: Mapping[str, Any]) -> tuple[StudyGoal, ...]:
    """Return each goal with the value that the watched method reached."""
    wanted = int(np.ceil(GOALS["taught well"] * result["of"]))
    worst, near = result["success"]["min"], result["relative_to_expert"]["median"]
    examples, seconds = result["examples"]["median"], result["teaching_seconds"]["median"]
    well = result["teachings_reaching_95"]
    return (
        StudyGoal(
            "teachings that reach 95 % success",
            f"{wanted} of {result['of']}",
            f"{well} of {result['of']}",
            well >= wanted,
        ),
        StudyGoal("success of the worst teaching", "85 %", f"{worst:.0%}", worst >= GOALS["worst"]),
        StudyGoal(
            "food per second / hand-written, median",
            "0.92",
            f"{near:.3f}",
            near >= GOALS["relative_to_expert"],
        ),
        StudyGoal(
            "examples of a median teaching", "at most 80", f"{examples:.0f}", examples <= GOALS["examples"]
        ),
        StudyGoal(
            "seconds of a median teaching", "at most 600", f"{seconds:.0f}", seconds <= GOALS["seconds"]
        ),
    )


def live_goals(result: Mapping[str, Any]) -> tuple[StudyGoal, ...]:
    """Return each goal of live teaching with the value that was reached."""
    wanted, well = int(np.ceil(LIVE_GOALS["taught well"] * result["of"])), result["teachings_reaching_95"]
    near, presses = result["relative_to_expert"]["median"], result["presses"]["median"]
    seconds, said = result["teaching_seconds"]["median"], "taught live"
    least, most = LIVE_GOALS["relative_to_expert"], LIVE_GOALS["presses"]
    return (
        StudyGoal(
            f"{said}: teachings that reach 95 % success",
            f"{wanted} of {result['of']}",
            f"{well} of {result['of']}",
            well >= wanted,
        ),
        StudyGoal(
            f"{said}: food per second / hand-written, median", f"{least:.2f}", f"{near:.3f}", near >= least
        ),
        StudyGoal(
            f"{said}: presses of a median teaching", f"at most {most:.0f}", f"{presses:.0f}", presses <= most
        ),
        StudyGoal(
            f"{said}: seconds of a median teaching",
            f"at most {LIVE_GOALS['seconds']:.0f}",
            f"{seconds:.0f}",
            seconds <= LIVE_GOALS["seconds"],
        ),
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success and speed of every teaching, by method."""
    figure, (left, right) = panels(2)
    for axes, what, of, said in (
        (left, "success", "success", "worlds finished in time, %"),
        (right, "speed", "relative_to_expert", "food per second, % of hand-written"),
    ):
        groups = {name: [100 * row[of] for row in rows if row["task"]["method"] == name] for name in METHODS}
        dots(axes, groups, said)
        axes.set_title(what)
    return figure


EXPERIMENT = Study(
    name="forage",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage",),
)
