"""The experiment: three searches look for failing worlds of robots that fail in about one of a thousand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy.analysis.intervals import exact_interval_of_share
from understudy.extras import import_cma
from understudy.falsification.search_space import SearchSpace
from understudy_lab.figures import COLORS, panels
from understudy_lab.forage.teach import teach
from understudy_lab.searches.methods import CMA_ES, CROSS_ENTROPY, METHODS, RANDOM
from understudy_lab.searches.rare_failures import (
    CALIBRATION_WORLDS,
    CIRCLING,
    MAKERS,
    SCENARIO,
    SLOW,
    find_arrival_tests,
    run_forager,
)
from understudy_lab.statistics import compute_unpaired_p
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SEEDS = range(73_000, 73_005)
"""The seeds of the teachings; the searches were developed on seeds 72000 to 72004."""
SEARCHES = 20
"""The number of searches per robot and method."""
MOST_RUNS = 1_000
"""The number of runs after which a search ends."""
MEASURED = 20_000
"""The number of worlds in which the failure rate of each robot is measured."""
WORLDS_PER_ROBOT = 1_000_000
"""The number of seeds that each robot has for its worlds; no two share one."""
MEASURED_FROM, SEARCHED_FROM = 100_000, 200_000
"""The first of these seeds for the failure rate, and for the searches; those before choose the limit or distance."""
FEWER, WANTED = 10, 0.9
"""The goal: by which factor there are to be fewer runs, and for which share of the robots."""
NAMES = {RANDOM: "random", CMA_ES: "CMA-ES", CROSS_ENTROPY: "cross-entropy"}
RULES = {SLOW: "slow", CIRCLING: "circling"}


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per robot; ExtraMissing if the package of CMA-ES is not installed."""
    import_cma()
    return [{"rule": rule, "seed": seed} for rule in MAKERS for seed in plan.seeds]


def work(task: Task) -> Row:
    """Teach a forager, make a robot of it that seldom fails, measure how often it does, and search for failures."""
    rule, first = task["rule"], first_world_of(task)
    library = teach(task["seed"], method="live").library
    robot = MAKERS[rule](library, range(first, first + CALIBRATION_WORLDS[rule]))
    unseen = range(first + MEASURED_FROM, first + MEASURED_FROM + MEASURED)
    space = SearchSpace(SCENARIO)
    return {
        "setting": robot.setting,
        "chosen by": robot.failed,
        "taught": find_arrival_tests(library.automaton("goto")),
        "failed": int(run_forager(robot.measure, unseen).failed.sum()),
        "runs": {
            name: [
                count(robot.measure, space, seed=seed_of_search(task, number), most_runs=MOST_RUNS)
                for number in range(SEARCHES)
            ]
            for name, count in METHODS.items()
        },
    }


def first_world_of(task: Task) -> int:
    """Return the seed of the first world of a robot."""
    return WORLDS_PER_ROBOT * (len(RULES) * int(task["seed"]) + list(RULES).index(task["rule"]))


def seed_of_search(task: Task, number: int) -> int:
    """Return the seed of a search for failures of a robot: for fresh worlds, that of the first of them."""
    return first_world_of(task) + SEARCHED_FROM + MOST_RUNS * number


def find_quartiles(runs: Sequence[int | None]) -> tuple[float, float, float]:
    """Find the first quartile, median and third quartile of runs; infinity where a search that found nothing counts."""
    found = np.array([np.inf if each is None else each for each in runs])
    low, middle, high = (
        np.inf
        if np.isinf(np.quantile(found, share, method="higher"))
        else np.quantile(np.minimum(found, MOST_RUNS), share)
        for share in (0.25, 0.5, 0.75)
    )
    return float(low), float(middle), float(high)


def is_tenth(row: Row, name: str) -> bool:
    """Return whether a method needs at most a tenth of the runs at random, both at most 1 000, by their medians."""
    (_, searched, _), (_, at_random, _) = (
        find_quartiles(row["runs"][name]),
        find_quartiles(row["runs"][RANDOM]),
    )
    return FEWER * searched <= min(at_random, MOST_RUNS)


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Summarize the runs of each method by robot and by rule."""
    tenth = {name: sum(is_tenth(row, name) for row in rows) for name in (CMA_ES, CROSS_ENTROPY)}
    wanted = int(np.ceil(WANTED * len(rows)))
    pooled = {rule: {name: _pool(rows, rule, name) for name in NAMES} for rule in RULES}
    medians = {
        rule: {name: find_quartiles(runs)[1] for name, runs in each.items()} for rule, each in pooled.items()
    }
    ps = {
        rule: {
            name: compute_unpaired_p(_cap(pooled[rule][name]), _cap(pooled[rule][RANDOM]))
            for name in (CMA_ES, CROSS_ENTROPY)
        }
        for rule in RULES
    }
    shares = [100 * row["failed"] / MEASURED for row in rows]
    slow, circling = ({name: _format_runs(each) for name, each in medians[rule].items()} for rule in RULES)
    return StudyFindings(
        headline=f"The directed search, CMA-ES, finds a failing world in at most a tenth of the runs of a search at "
        f"random for {tenth[CMA_ES]} of {len(rows)} robots that fail in {min(shares):.2f} to {max(shares):.2f} % of "
        f"worlds; the cross-entropy method for {tenth[CROSS_ENTROPY]}. Where robots fail because they are slow, "
        f"CMA-ES needs {slow[CMA_ES]} runs in the median, cross-entropy {slow[CROSS_ENTROPY]}, and fresh worlds at "
        f"random {slow[RANDOM]}. Where they circle around a target forever, it is {circling[CMA_ES]}, "
        f"{circling[CROSS_ENTROPY]} and {circling[RANDOM]}.",
        tables=(
            ResultTable(
                f"Robots: slow ones fail after a time limit, circling ones have arrived at a distance; failures in "
                f"the worlds by which these were chosen, and in {MEASURED} others (exact 95 % interval)",
                (
                    "robot",
                    "rule",
                    "#limit or distance",
                    "#taught distance",
                    "#failures when chosen, %",
                    "#failures, %",
                ),
                [_describe_robot(row) for row in rows],
            ),
            ResultTable(
                f"Runs until the first failing world: medians of {SEARCHES} searches (quartiles), each of at most "
                f"{MOST_RUNS} runs",
                (
                    "robot",
                    "rule",
                    *(f"#{name}" for name in NAMES.values()),
                    "#random / CMA-ES",
                    "#random / cross-entropy",
                ),
                [_describe_searches(row) for row in rows],
            ),
            ResultTable(
                "All searches by rule: medians of runs (quartiles), and how many found no failing world",
                ("rule", "method", "#runs", "#found none"),
                [
                    (RULES[rule], NAMES[name], _format_quartiles(runs), f"{runs.count(None)} of {len(runs)}")
                    for rule, each in pooled.items()
                    for name, runs in each.items()
                ],
            ),
        ),
        goals=(
            StudyGoal(
                "robots for which CMA-ES needs at most a tenth of the runs at random, by medians",
                f"{wanted} of {len(rows)}",
                f"{tenth[CMA_ES]} of {len(rows)} (cross-entropy {tenth[CROSS_ENTROPY]})",
                tenth[CMA_ES] >= wanted,
            ),
        ),
        notes=(
            f"A search that finds nothing in {MOST_RUNS} runs counts as {MOST_RUNS} for the goal. CMA-ES and "
            "cross-entropy are counted in whole generations. Over all searches, the runs of CMA-ES differ from those "
            f"at random with {_format_ps(ps, CMA_ES)}, those of cross-entropy with {_format_ps(ps, CROSS_ENTROPY)} "
            "(rank-sum test).",
        ),
        numbers={
            "tenth": tenth,
            "medians": {
                rule: {name: _cap_number(each) for name, each in found.items()}
                for rule, found in medians.items()
            },
            "p": {rule: {name: float(f"{p:.3g}") for name, p in each.items()} for rule, each in ps.items()},
        },
    )


def _pool(rows: Sequence[Row], rule: str, name: str) -> list[int | None]:
    return [each for row in rows if row["task"]["rule"] == rule for each in row["runs"][name]]


def _format_ps(ps: Mapping[str, Mapping[str, float]], name: str) -> str:
    return " and ".join(f"p = {ps[rule][name]:.2g} for {RULES[rule]} robots" for rule in RULES)


def _cap(runs: Sequence[int | None]) -> list[float]:
    """Return the runs, where a search that found nothing counts more than any that did."""
    return [MOST_RUNS + 1.0 if each is None else float(each) for each in runs]


def _cap_number(runs: float) -> float:
    return min(runs, float(MOST_RUNS))


def _format_runs(runs: float) -> str:
    return f"≥ {MOST_RUNS}" if np.isinf(runs) else f"{runs:.0f}"


def _format_quartiles(runs: Sequence[int | None]) -> str:
    low, middle, high = map(_format_runs, find_quartiles(runs))
    return f"{middle} ({low}–{high})"


def _describe_robot(row: Row) -> tuple[str, ...]:
    rule, failed = row["task"]["rule"], row["failed"]
    low, high = exact_interval_of_share(failed, MEASURED)
    setting = f"{row['setting']:.1f} s" if rule == SLOW else f"{1_000 * row['setting']:.2f} mm"
    taught = ", ".join(f"{1_000 * each:.0f} mm" for each in row["taught"]) or "none"
    return (
        str(row["task"]["seed"]),
        RULES[rule],
        setting,
        taught if rule == CIRCLING else "",
        f"{100 * row['chosen by'] / CALIBRATION_WORLDS[rule]:.3f}",
        f"{100 * failed / MEASURED:.3f} ({100 * low:.3f}–{100 * high:.3f})",
    )


def _describe_searches(row: Row) -> tuple[str, ...]:
    runs: Mapping[str, Sequence[int | None]] = row["runs"]
    return (
        str(row["task"]["seed"]),
        RULES[row["task"]["rule"]],
        *(_format_quartiles(runs[name]) for name in NAMES),
        *(_format_ratio(row, name) for name in (CMA_ES, CROSS_ENTROPY)),
    )


def _format_ratio(row: Row, name: str) -> str:
    """Format the runs at random divided by those of a method, by medians, as a bound if a median is one."""
    (_, searched, _), (_, at_random, _) = (
        find_quartiles(row["runs"][name]),
        find_quartiles(row["runs"][RANDOM]),
    )
    if np.isinf(searched) and np.isinf(at_random):
        return "unknown"
    bound = "≥ " if np.isinf(at_random) else "≤ " if np.isinf(searched) else ""
    return f"{bound}{_cap_number(at_random) / _cap_number(searched):.1f}"


def draw(rows: Sequence[Row]) -> Figure:
    """Draw the runs of each search until its first failing world, by rule, robot and method."""
    figure, axes = panels(len(RULES), wide=4.4, tall=3.4)
    for panel, rule in zip(axes, RULES, strict=True):
        _draw_rule(panel, [row for row in rows if row["task"]["rule"] == rule])
        panel.set_title(f"{RULES[rule]} robots")
    axes[0].set_ylabel("runs until the first failing world")
    axes[0].legend(loc="lower left", ncols=len(NAMES), handletextpad=0.1, columnspacing=0.8)
    return figure


def _draw_rule(panel: Axes, rows: Sequence[Row]) -> None:
    for k, (name, color) in enumerate(zip(NAMES, COLORS, strict=False)):
        for at, row in enumerate(rows):
            capped = np.array(_cap(row["runs"][name]))
            x = at + 0.27 * (k - 1) + np.linspace(-0.09, 0.09, len(capped))
            found = capped <= MOST_RUNS
            panel.plot(x[found], capped[found], "o", color=color, markersize=3, alpha=0.6, markeredgewidth=0)
            panel.plot(
                x[~found], np.full((~found).sum(), 1_700), "^", color=color, markersize=3, fillstyle="none"
            )
            median = _cap_number(find_quartiles(row["runs"][name])[1])
            label = NAMES[name] if at == 0 else ""
            panel.hlines(median, x[0] - 0.02, x[-1] + 0.02, color=color, linewidth=2.5, label=label)
    panel.set_yscale("log")
    panel.set_ylim(0.5, 2_400)
    panel.set_yticks([1, 10, 100, 1_000, 1_700], ["1", "10", "100", "1000", "none"])
    panel.set_yticks([], minor=True)
    panel.set_xticks(range(len(rows)), [str(row["task"]["seed"]) for row in rows])


EXPERIMENT = Study(
    name="searches",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage",),
    varies=(CMA_ES,),
)
