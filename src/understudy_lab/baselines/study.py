"""The experiment: the same tasks taught to all learners, success by number of decisions and by seconds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

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
from understudy_lab.figures import COLORS, panels
from understudy_lab.statistics import format_median, interval_of_median
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHINGS = range(55_000, 55_020)
INSTALL = format_install_command("baselines")
MODULES = {"scikit-learn": "sklearn", "PyTorch": "torch"}
AT, AHEAD, WORST = 100, 30.0, ("forage", "servoing")
"""The goal: decisions, lead over the best net in percentage points, and the tasks concerned."""
FIRST_S = 10
"""The start of the time axis in s; shorter times are drawn there."""
TIMES_S = (30, 60, 120, 240, 480)
"""The times in s of the demonstrator at which success is reported."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per exercise, installed family of learners, and seed."""
    here = [by for by in WITH if by not in MODULES or find_spec(MODULES[by]) is not None]
    return [
        {"task": name, "with": by, "seed": seed} for seed in plan.seeds for name in EXERCISES for by in here
    ]


def work(task: Task) -> Row:
    """Run all learners of a family on one exercise."""
    return {"learners": compare_learners(task["task"], task["seed"], by=task["with"])}


def get_success_at_decisions(found: Mapping[str, Any], decisions: int) -> float:
    """Return the share of successful trials of a learner that was given this number of labeled decisions.

    `found` is a row of this study, with the `success` for each number in `BUDGETS`.
    """
    return float(found["success"][BUDGETS.index(decisions)])


def get_success_at_seconds(found: Mapping[str, Any], seconds: float) -> float:
    """Return the success at the last tested number of decisions that took at most `seconds`."""
    spent = [
        share for share, until in zip(found["success"], found["seconds"], strict=True) if until <= seconds
    ]
    return float(spent[-1]) if spent else 0.0


def collect_results(rows: Sequence[Row], task: str) -> dict[str, list[Mapping[str, Any]]]:
    """Return the results of each learner in one exercise, by seed."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for learner in LEARNERS:
        each = [
            row["learners"][learner]
            for row in rows
            if row["task"]["task"] == task and learner in row["learners"]
        ]
        if each:
            found[learner] = each
    return found


def best_net(found: Mapping[str, Sequence[Mapping[str, Any]]], decisions: int) -> str | None:
    """Return the net with the highest mean success after a number of decisions, or None without nets."""
    nets = [name for name in NEURAL if name in found]
    return max(
        nets,
        key=lambda name: float(np.mean([get_success_at_decisions(each, decisions) for each in found[name]])),
        default=None,
    )


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize success by number of decisions and by seconds."""
    found = {task: collect_results(rows, task) for task in EXERCISES}
    seeds = sorted({row["task"]["seed"] for row in rows})
    return StudyFindings(
        headline=write_headline(found),
        tables=(
            *(_by_decisions(task, each, seeds) for task, each in found.items()),
            *(_by_seconds(task, each) for task, each in found.items()),
            *_behind(found),
            *_gained(found),
        ),
        goals=goals(found),
        notes=notes(found),
        numbers={
            task: {
                learner: {
                    "decisions": {
                        str(n): _middle([get_success_at_decisions(one, n) for one in each]) for n in BUDGETS
                    },
                    "seconds": {
                        str(s): _middle([get_success_at_seconds(one, s) for one in each]) for s in TIMES_S
                    },
                    "ticks": {
                        str(n): _middle([one["ticks"][k] for one in each]) for k, n in enumerate(BUDGETS)
                    },
                }
                for learner, each in all_.items()
            }
            for task, all_ in found.items()
        },
    )


def _middle(values: Sequence[float]) -> float:
    return round(float(np.median(values)), 4)


def _by_decisions(
    task: str, found: Mapping[str, Sequence[Mapping[str, Any]]], seeds: Sequence[int]
) -> ResultTable:
    return ResultTable(
        f"{NAMES[task]}: success by number of decisions of the demonstrator, seeds {seeds[0]} to {seeds[-1]}, "
        f"{WORLDS} unseen worlds each",
        ("learner", *(f"#{n}" for n in BUDGETS)),
        [
            (
                learner,
                *(
                    format_median([get_success_at_decisions(each, n) for each in of], percent=True)
                    for n in BUDGETS
                ),
            )
            for learner, of in found.items()
        ],
    )


def _by_seconds(task: str, found: Mapping[str, Sequence[Mapping[str, Any]]]) -> ResultTable:
    return ResultTable(
        f"{NAMES[task]}: success by demonstration time",
        ("learner", *(f"#{s} s" for s in TIMES_S)),
        [
            (
                learner,
                *(
                    format_median([get_success_at_seconds(each, s) for each in of], percent=True)
                    for s in TIMES_S
                ),
            )
            for learner, of in found.items()
        ],
    )


def _behind(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> tuple[ResultTable, ...]:
    """Return a table of where another learner has a higher mean success than Understudy."""
    limits = (
        ("by number of decisions", "", BUDGETS, get_success_at_decisions),
        ("by demonstration time", " s", TIMES_S, get_success_at_seconds),
    )
    return tuple(
        ResultTable(
            f"Cases in which another learner has a higher mean success, {said} (best other learner : Understudy)",
            ("task", *(f"#{limit}{unit}" for limit in of)),
            [
                (
                    NAMES[task],
                    *(
                        _best({name: _mean(by(one, n) for one in each) for name, each in all_.items()})
                        for n in of
                    ),
                )
                for task, all_ in found.items()
            ],
        )
        for said, unit, of, by in limits
    )


def _gained(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> tuple[ResultTable, ...]:
    """Return a table of what flat learners gain with only the chosen features, by seed."""
    rows = []
    for task, each in found.items():
        for name in (name for name in each if name + CHOSEN in each):
            pairs = list(zip(each[name + CHOSEN], each[name], strict=True))
            apart = {
                n: [
                    100 * (get_success_at_decisions(one, n) - get_success_at_decisions(other, n))
                    for one, other in pairs
                ]
                for n in BUDGETS
            }
            rows.append((NAMES[task], name, *(_signed(apart[n]) for n in BUDGETS)))
    title = (
        "Gain in success from using only the chosen features instead of all readings, by number of decisions, "
        "percentage points: median over seeds (95 % interval)"
    )
    return (ResultTable(title, ("task", "learner", *(f"#{n}" for n in BUDGETS)), rows),) if rows else ()


def _signed(values: Sequence[float]) -> str:
    middle, low, high = (round(value) for value in (float(np.median(values)), *interval_of_median(values)))
    return f"{middle:+d} ({low:+d} to {high:+d})".replace("+0", "0")


def _best(means: Mapping[str, float]) -> str:
    """Format the learner ahead of Understudy with both values, "tree 95.2 : 30.0 %", or "–" without one."""
    best, ours = max(means, key=lambda name: means[name], default=UNDERSTUDY), means.get(UNDERSTUDY, 0.0)
    return f"{best} {100 * means[best]:.1f} : {100 * ours:.1f} %" if means.get(best, 0.0) > ours else "–"


def _mean(values: Iterable[float]) -> float:
    return float(np.mean(list(values)))


NAMES = {"goto": "GoTo", "forage": "Forage", "servoing": "Servoing", "walls": "Wall following"}


def measure_lead(found: Mapping[str, Sequence[Mapping[str, Any]]], decisions: int) -> dict[str, Any] | None:
    """Return Understudy's lead over the best net in percentage points, with a 95 % interval and p."""
    net = best_net(found, decisions)
    if net is None or UNDERSTUDY not in found:
        return None
    ours = np.array([get_success_at_decisions(each, decisions) for each in found[UNDERSTUDY]])
    theirs = np.array([get_success_at_decisions(each, decisions) for each in found[net]])
    low, high = interval_of_median(100 * (ours - theirs))
    return {
        "net": net,
        "points": round(100 * float(np.median(ours - theirs)), 1),
        "low": round(low, 1),
        "high": round(high, 1),
        "ours": float(np.median(ours)),
        "theirs": float(np.median(theirs)),
    }


def write_headline(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> str:
    """Return the headline of the experiment."""
    parts = []
    for task, each in found.items():
        lead = measure_lead(each, AT)
        if lead is not None:
            parts.append(f"{NAMES[task]} {lead['ours']:.0%} against {lead['theirs']:.0%}")
    if not parts:
        return "Without PyTorch and scikit-learn there is nothing to compare with."
    return (
        f"Median success after {AT} decisions of the demonstrator, Understudy against the best neural network: "
        f"{', '.join(parts)}."
    )


def goals(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> tuple[StudyGoal, ...]:
    """Return the goals: 30 points above the best net at 100 decisions."""
    made = []
    for task in WORST:
        lead = measure_lead(found[task], AT)
        if lead is not None:
            said = (
                f"{lead['points']:.0f} points above {lead['net']} ({lead['low']:.0f} to {lead['high']:.0f})"
            )
            made.append(
                StudyGoal(
                    f"{NAMES[task]}: success at {AT} decisions above the best net's",
                    f"{AHEAD:.0f} points",
                    said,
                    lead["points"] >= AHEAD,
                )
            )
    return tuple(made)


def notes(found: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> tuple[str, ...]:
    """Return notes on the features of each learner and on the number of labels."""
    same = [NAMES[task] for task, each in found.items() if TREE in each and TREE + CHOSEN not in each]
    labeled = ", ".join(
        f"{NAMES[task]} {np.median([one['ticks'][BUDGETS.index(AT)] for one in each[DAGGER]]):.0f}"
        for task, each in found.items()
        if DAGGER in each
    )
    return (
        *(
            (
                f"The lessons of {' and '.join(same)} together use every reading. So there are no features to choose "
                "for flat learners, and Understudy's teacher chose only which lesson uses which feature.",
            )
            if same
            else ()
        ),
        *(
            (f"Ticks that the teacher of DAgger labeled in {AT} decisions (median): {labeled}.",)
            if labeled
            else ()
        ),
    )


def draw(rows: Sequence[Row]) -> Figure:
    """Draw median success over decisions and over seconds, with a band that holds half of the seeds.

    Dashed lines are learners with only the features that Understudy's teacher chose.
    """
    names = list(EXERCISES)
    figure, axes = panels(2 * len(names), rows=2, wide=3.2, tall=2.6)
    for k, task in enumerate(names):
        found = collect_results(rows, task)
        for learner, each in found.items():
            kind = learner.removesuffix(CHOSEN)
            color, style = COLORS[LEARNERS.index(kind)], "o-" if kind == learner else "o--"
            success = 100 * np.array([one["success"] for one in each])
            low, middle, high = np.percentile(success, [25, 50, 75], axis=0)
            seconds = np.maximum(np.median([one["seconds"] for one in each], axis=0), FIRST_S)
            width, over = (2.4, 3) if learner == UNDERSTUDY else (1.3, 2)
            for axis, x in ((axes[k], BUDGETS), (axes[len(names) + k], seconds)):
                axis.plot(
                    x, middle, style, color=color, linewidth=width, markersize=3, label=learner, zorder=over
                )
                if kind == learner:
                    axis.fill_between(x, low, high, color=color, alpha=0.08, linewidth=0)
        for axis, said in ((axes[k], "decisions"), (axes[len(names) + k], "seconds of demonstration")):
            axis.set_xscale("log", nonpositive="mask")
            axis.set_ylim(-4, 104)
            axis.set_xlabel(said)
        for axis, ticks in ((axes[k], BUDGETS), (axes[len(names) + k], (FIRST_S, 30, 100, 300, 1_000))):
            axis.set_xticks(ticks, [f"{n:,}" for n in ticks])
            axis.minorticks_off()
        axes[k].set_title(NAMES[task])
    for row in (0, len(names)):
        axes[row].set_ylabel("success, %")
    if lines := axes[0].get_legend_handles_labels()[0]:
        axes[2].legend(handles=lines, fontsize=7, loc="lower right")
    return figure


EXPERIMENT = Study(
    name="learners",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage",),
    varies=NEURAL,  # the last digits of other machines' arithmetic grow while a net is trained
    needs={"sklearn": INSTALL, "torch": INSTALL},
)
