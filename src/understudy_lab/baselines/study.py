"""The experiment: the same tasks taught to all learners, success by number of decisions and by seconds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from importlib.util import find_spec
from operator import itemgetter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from understudy.extras import format_install_command
from understudy_lab.baselines.compare import (
    BUDGETS,
    CHOSEN,
    DAGGER,
    LEARNERS,
    NEURAL,
    TREE,
    UNDERSTUDY,
    WITH,
    WORLDS,
    compare_learners,
)
from understudy_lab.baselines.tasks import EXERCISES
from understudy_lab.declaration import Cell, Conclusion, LinePerGroup
from understudy_lab.figures import COLORS, Panels
from understudy_lab.rows import Median, Rows
from understudy_lab.statistics import interval_of_median
from understudy_lab.study import ResultTable, Row, Study, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Results: TypeAlias = Mapping[str, Mapping[str, Rows]]
"""The results by exercise and learner."""

TEACHINGS = range(55_000, 55_020)
INSTALL = format_install_command("baselines")
MODULES = {"scikit-learn": "sklearn", "PyTorch": "torch"}
AT, AHEAD, WORST = 100, 30.0, ("forage", "servoing")
"""The goal: decisions, lead over the best net in percentage points, and the tasks concerned."""
FIRST_S = 10
"""The start of the time axis in s; shorter times are drawn there."""
TIMES_S = (30, 60, 120, 240, 480)
"""The times in s of the demonstrator at which success is reported."""
NAMES = {"goto": "GoTo", "forage": "Forage", "servoing": "Servoing", "walls": "Wall following"}


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per exercise, installed family of learners, and seed."""
    here = [by for by in WITH if by not in MODULES or find_spec(MODULES[by]) is not None]
    return [
        {"task": name, "with": by, "seed": seed} for seed in plan.seeds for name in EXERCISES for by in here
    ]


def work(task: Task) -> Row:
    """Run all learners of a family on one exercise."""
    return {"learners": compare_learners(task["task"], task["seed"], by=task["with"])}


def get_success_at_decisions(row: Row, decisions: int) -> float:
    """Return the share of successful trials of a learner that was given this number of labeled decisions.

    `row` is a learner's result, with the `success` for each number in `BUDGETS`.
    """
    return float(row["success"][BUDGETS.index(decisions)])


def get_success_at_seconds(row: Row, seconds: float) -> float:
    """Return the success at the last tested number of decisions that took at most `seconds`."""
    spent = [share for share, until in zip(row["success"], row["seconds"], strict=True) if until <= seconds]
    return float(spent[-1]) if spent else 0.0


AT_DECISIONS = {n: partial(get_success_at_decisions, decisions=n) for n in BUDGETS}
AT_SECONDS = {s: partial(get_success_at_seconds, seconds=s) for s in TIMES_S}


def collect_results(rows: Rows) -> Results:
    """Return the results of each learner in each exercise, by seed."""
    exercises = {task: rows.where(task=task) for task in EXERCISES}
    results = {
        task: {
            learner: Rows(
                {**row["learners"][learner], "task": row["task"]} for row in of if learner in row["learners"]
            )
            for learner in LEARNERS
        }
        for task, of in exercises.items()
    }
    return {task: {learner: of for learner, of in each.items() if of} for task, each in results.items()}


def _find_ahead(of: Callable[[Row], float], learners: Mapping[str, Rows]) -> str:
    """Format the learner ahead of Understudy with both values, "tree 95.2 : 30.0 %", or "–" without one."""
    means = {name: float(np.mean(rows.values(of))) for name, rows in learners.items()}
    best, ours = max(means, key=lambda name: means[name], default=UNDERSTUDY), means.get(UNDERSTUDY, 0.0)
    return f"{best} {100 * means[best]:.1f} : {100 * ours:.1f} %" if means.get(best, 0.0) > ours else "–"


def _table_ahead(how: str, cells: Mapping[str, Cell]) -> LinePerGroup:
    title = (
        f"Cases in which another learner has a higher mean success, {how} (best other learner : Understudy)"
    )
    return LinePerGroup(title, ["task"], lambda results: results, cells, lambda task: [NAMES[task]])


def _table_gains(results: Results) -> ResultTable | None:
    """Return a table of what flat learners gain with only the chosen features, by seed."""
    lines = [
        (NAMES[task], name, *(_format_gain(of[name + CHOSEN], rows, at) for at in AT_DECISIONS.values()))
        for task, of in results.items()
        for name, rows in of.items()
        if name + CHOSEN in of
    ]
    title = (
        "Gain in success from using only the chosen features instead of all readings, by number of decisions, "
        "percentage points: median over seeds (95 % interval)"
    )
    return ResultTable(title, ("task", "learner", *(f"#{n}" for n in BUDGETS)), lines) if lines else None


def _format_gain(chosen: Rows, every: Rows, of: Callable[[Row], float]) -> str:
    gains = [100 * (of(one) - of(other)) for one, other in zip(chosen, every, strict=True)]
    middle, low, high = (round(value) for value in (float(np.median(gains)), *interval_of_median(gains)))
    return f"{middle:+d} ({low:+d} to {high:+d})".replace("+0", "0")


def measure_lead(learners: Mapping[str, Rows], decisions: int) -> dict[str, Any] | None:
    """Return Understudy's lead over the best net in percentage points, with a 95 % interval."""
    of = AT_DECISIONS[decisions]
    nets = {name: float(np.mean(learners[name].values(of))) for name in NEURAL if name in learners}
    if not nets or UNDERSTUDY not in learners:
        return None
    net = max(nets, key=lambda name: nets[name])
    ours, theirs = (np.array(learners[name].values(of)) for name in (UNDERSTUDY, net))
    low, high = interval_of_median(100 * (ours - theirs))
    return {
        "net": net,
        "points": round(100 * float(np.median(ours - theirs)), 1),
        "low": round(low, 1),
        "high": round(high, 1),
        "ours": float(np.median(ours)),
        "theirs": float(np.median(theirs)),
    }


def _headline(results: Results) -> str:
    leads = {task: lead for task, each in results.items() if (lead := measure_lead(each, AT)) is not None}
    if not leads:
        return "Without PyTorch and scikit-learn there is nothing to compare with."
    parts = (f"{NAMES[task]} {lead['ours']:.0%} against {lead['theirs']:.0%}" for task, lead in leads.items())
    return (
        f"Median success after {AT} decisions of the demonstrator, Understudy against the best neural network: "
        f"{', '.join(parts)}."
    )


def _goals(results: Results) -> list[StudyGoal]:
    leads = {task: lead for task in WORST if (lead := measure_lead(results[task], AT)) is not None}
    return [
        StudyGoal(
            f"{NAMES[task]}: success at {AT} decisions above the best net's",
            f"{AHEAD:.0f} points",
            f"{lead['points']:.0f} points above {lead['net']} ({lead['low']:.0f} to {lead['high']:.0f})",
            lead["points"] >= AHEAD,
        )
        for task, lead in leads.items()
    ]


def _notes(results: Results) -> list[str]:
    same = " and ".join(NAMES[task] for task, of in results.items() if TREE in of and TREE + CHOSEN not in of)
    labeled = ", ".join(
        f"{NAMES[task]} {of[DAGGER].median(lambda one: one['ticks'][BUDGETS.index(AT)]):.0f}"
        for task, of in results.items()
        if DAGGER in of
    )
    return [
        f"The lessons of {same} together use every reading. So there are no features to choose for flat learners, and "
        "Understudy's teacher chose only which lesson uses which feature."
        if same
        else "",
        f"Ticks that the teacher of DAgger labeled in {AT} decisions (median): {labeled}." if labeled else "",
    ]


def _list_numbers(rows: Rows) -> dict[str, dict[str, float]]:
    values: dict[str, dict[int, Callable[..., float]]] = {
        "decisions": {**AT_DECISIONS},
        "seconds": {**AT_SECONDS},
        "ticks": {n: lambda one, at=at: one["ticks"][at] for at, n in enumerate(BUDGETS)},
    }
    return {
        what: {str(n): round(rows.median(of), 4) for n, of in each.items()} for what, each in values.items()
    }


def _draw(axes: Axes, results: Results, task: str, by: str) -> None:
    """Draw median success over decisions or over seconds, with a band that holds half of the seeds.

    Dashed lines are learners with only the features that Understudy's teacher chose.
    """
    decisions = by == "decisions"
    for learner, each in results[task].items():
        kind = learner.removesuffix(CHOSEN)
        color, style = COLORS[LEARNERS.index(kind)], "o-" if kind == learner else "o--"
        success = 100 * np.array(each.values("success"))
        low, middle, high = np.percentile(success, [25, 50, 75], axis=0)
        x = BUDGETS if decisions else np.maximum(np.median(each.values("seconds"), axis=0), FIRST_S)
        width, over = (2.4, 3) if learner == UNDERSTUDY else (1.3, 2)
        axes.plot(x, middle, style, color=color, linewidth=width, markersize=3, label=learner, zorder=over)
        if kind == learner:
            axes.fill_between(x, low, high, color=color, alpha=0.08, linewidth=0)
    ticks = BUDGETS if decisions else (FIRST_S, 30, 100, 300, 1_000)
    axes.set_xscale("log", nonpositive="mask")
    axes.set_ylim(-4, 104)
    axes.set_xlabel(by)
    axes.set_xticks(ticks, [f"{n:,}" for n in ticks])
    axes.minorticks_off()
    if decisions:
        axes.set_title(NAMES[task])
    if task == LEFTMOST:
        axes.set_ylabel("success, %")
    if decisions and task == WITH_LEGEND:
        lines, _ = axes.figure.axes[0].get_legend_handles_labels()  # the first panel has all learners
        if lines:
            axes.legend(handles=lines, fontsize=7, loc="lower right")


LEFTMOST, WITH_LEGEND = list(EXERCISES)[0:3:2]
"""The exercises whose panels have the label of the vertical axis, and the names of learners."""

EXPERIMENT = Study(
    name="learners",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        prepare=collect_results,
        headline=_headline,
        tables=(
            *(
                LinePerGroup(
                    f"{NAMES[task]}: success by number of decisions of the demonstrator, seeds {{seeds}}, {WORLDS} "
                    "unseen worlds each",
                    ["learner"],
                    itemgetter(task),
                    {str(n): Median(of, percent=True) for n, of in AT_DECISIONS.items()},
                )
                for task in EXERCISES
            ),
            *(
                LinePerGroup(
                    f"{NAMES[task]}: success by demonstration time",
                    ["learner"],
                    itemgetter(task),
                    {f"{s} s": Median(of, percent=True) for s, of in AT_SECONDS.items()},
                )
                for task in EXERCISES
            ),
            _table_ahead(
                "by number of decisions", {str(n): partial(_find_ahead, of) for n, of in AT_DECISIONS.items()}
            ),
            _table_ahead(
                "by demonstration time", {f"{s} s": partial(_find_ahead, of) for s, of in AT_SECONDS.items()}
            ),
            _table_gains,
        ),
        goals=_goals,
        notes=_notes,
        numbers=lambda results: {
            task: {learner: _list_numbers(rows) for learner, rows in of.items()}
            for task, of in results.items()
        },
    ),
    draw=Panels(
        [
            partial(_draw, task=task, by=by)
            for by in ("decisions", "seconds of demonstration")
            for task in EXERCISES
        ],
        rows=2,
        wide=3.2,
        tall=2.6,
        prepare=collect_results,
    ),
    worlds=("forage",),
    varies=NEURAL,  # the last digits of other machines' arithmetic grow while a net is trained
    needs={"sklearn": INSTALL, "torch": INSTALL},
)
