"""The experiment: three searches look for failing worlds of robots that fail in about one of a thousand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from understudy.addons.checks.falsification.directed_search import (
    FIRST_SPREAD,
    RUNS_PER_START,
    DirectedSearch,
    run_vectors,
    search_directed,
)
from understudy.addons.checks.falsification.random_search import measure_seeds
from understudy.addons.checks.falsification.search_space import SearchSpace
from understudy.addons.checks.falsification.trial import Measure
from understudy.extras import import_cma
from understudy.judging.intervals import exact_interval_of_share
from understudy_lab.declaration import Conclusion, CountGoal, LinePerGroup
from understudy_lab.figures import COLORS, Panels
from understudy_lab.forage.teach import teach
from understudy_lab.rows import Count, Rows
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
from understudy_lab.study import Row, Study, StudyPlan, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes


RANDOM, CMA_ES, CROSS_ENTROPY = "random", "cma_es", "cross_entropy"
AT_ONCE = 100
"""The number of fresh worlds that run side by side."""
POPULATION, ELITE = 40, 4
"""The number of worlds in a generation of the cross-entropy method, and of those from which it learns."""
SMOOTHING = 0.7
"""The weight of the new mean and spread against the former ones (de Boer et al. 2005)."""


def search_by_cross_entropy(
    measure: Measure, space: SearchSpace, *, seed: int, most_runs: int
) -> DirectedSearch:
    """Search for a failing world by the cross-entropy method.

    All numbers of a vector are drawn from normal distributions, each independently. The mean and the spread of each
    then move towards those of the worlds that came nearest to failing. Like the directed search, it is restarted from
    time to time.

    Parameters
    ----------
    measure
        Runs the behavior.
    space
        The worlds.
    seed
        The seed of all draws; the same seed gives the same search.
    most_runs
        The largest number of runs.

    Returns
    -------
    DirectedSearch
        What was found until the end of the first generation with a failing world, or the last run.

    Notes
    -----
    The method is that of Rubinstein (1999), with the smoothing of de Boer, Kroese, Mannor and Rubinstein (A Tutorial on
    the Cross-Entropy Method, 2005).
    """
    rng, search = np.random.default_rng(seed), DirectedSearch()
    while True:
        mean, spread = np.full(len(space), 0.5), np.full(len(space), FIRST_SPREAD)
        begun = search.runs
        while search.runs < begun + RUNS_PER_START:
            drawn = rng.normal(mean, spread, (POPULATION, len(space)))
            vectors = np.clip(drawn, 0.0, np.nextafter(1.0, 0.0))[: most_runs - search.runs]
            robustness = run_vectors(measure, space, list(vectors), rng, search)
            if search.failures or search.runs >= most_runs:
                return search
            elite = vectors[np.argsort(robustness, kind="stable")[:ELITE]]
            mean += SMOOTHING * (elite.mean(axis=0) - mean)
            spread += SMOOTHING * (elite.std(axis=0) - spread)


CountedSearch: TypeAlias = Callable[..., int | None]
"""A function that counts the runs until a search finds a failing world; None if none of `most_runs` fails."""


def count_random_runs(measure: Measure, space: SearchSpace, *, seed: int, most_runs: int) -> int | None:
    """Count the fresh worlds, from that of `seed` on, until the first that fails."""
    for first in range(0, most_runs, AT_ONCE):
        seeds = range(seed + first, seed + min(first + AT_ONCE, most_runs))
        failed = np.flatnonzero(measure_seeds(measure, space.scenario, seeds) < 0)
        if len(failed):
            return first + int(failed[0]) + 1
    return None


def count_cma_es_runs(measure: Measure, space: SearchSpace, *, seed: int, most_runs: int) -> int | None:
    """Count the runs of the directed search, with no worlds to start from, in whole generations."""
    search = search_directed(measure, space, seed=seed, most_runs=most_runs)
    return search.runs if search.failures else None


def count_cross_entropy_runs(
    measure: Measure, space: SearchSpace, *, seed: int, most_runs: int
) -> int | None:
    """Count the runs of the cross-entropy method, in whole generations."""
    search = search_by_cross_entropy(measure, space, seed=seed, most_runs=most_runs)
    return search.runs if search.failures else None


METHODS: Mapping[str, CountedSearch] = MappingProxyType(
    {RANDOM: count_random_runs, CMA_ES: count_cma_es_runs, CROSS_ENTROPY: count_cross_entropy_runs}
)
"""The searches that are compared."""


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
    counts = np.array([np.inf if each is None else each for each in runs])
    low, middle, high = (
        np.inf
        if np.isinf(np.quantile(counts, share, method="higher"))
        else np.quantile(np.minimum(counts, MOST_RUNS), share)
        for share in (0.25, 0.5, 0.75)
    )
    return float(low), float(middle), float(high)


def is_tenth(row: Row, name: str) -> bool:
    """Return whether a method needs at most a tenth of the runs at random, both at most 1 000, by their medians."""
    searched, at_random = _list_medians(row, name)
    return FEWER * searched <= min(at_random, MOST_RUNS)


def _list_medians(row: Row, name: str) -> tuple[float, float]:
    """Return the median runs of a method and those at random."""
    return find_quartiles(row["runs"][name])[1], find_quartiles(row["runs"][RANDOM])[1]


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


def _format_ratio(row: Row, name: str) -> str:
    """Format the runs at random divided by those of a method, by medians, as a bound if a median is one."""
    searched, at_random = _list_medians(row, name)
    if np.isinf(searched) and np.isinf(at_random):
        return "unknown"
    bound = "≥ " if np.isinf(at_random) else "≤ " if np.isinf(searched) else ""
    return f"{bound}{_cap_number(at_random) / _cap_number(searched):.1f}"


def _pool(rows: Rows, rule: str, name: str) -> list[int | None]:
    return [each for row in rows.where(rule=rule) for each in row["runs"][name]]


def _compute_p(rows: Rows, rule: str, name: str) -> float:
    """Return the p-value of no difference between a method and fresh worlds at random."""
    return compute_unpaired_p(*(_cap(_pool(rows, rule, each)) for each in (name, RANDOM)))


def _headline(rows: Rows) -> str:
    shares = [100 * row["failed"] / MEASURED for row in rows]
    slow, circling = (
        {name: _format_runs(find_quartiles(_pool(rows, rule, name))[1]) for name in NAMES} for rule in RULES
    )
    return (
        f"The directed search, CMA-ES, finds a failing world in at most a tenth of the runs of a search at random for "
        f"{TENTHS[CMA_ES](rows)} robots that fail in {min(shares):.2f} to {max(shares):.2f} % of worlds; the "
        f"cross-entropy method for {TENTHS[CROSS_ENTROPY].number(rows)}. Where robots fail because they are slow, "
        f"CMA-ES needs {slow[CMA_ES]} runs in the median, cross-entropy {slow[CROSS_ENTROPY]}, and fresh worlds at "
        f"random {slow[RANDOM]}. Where they circle around a target forever, it is {circling[CMA_ES]}, "
        f"{circling[CROSS_ENTROPY]} and {circling[RANDOM]}."
    )


TENTHS = {name: Count(partial(is_tenth, name=name)) for name in (CMA_ES, CROSS_ENTROPY)}


def _note(rows: Rows) -> str:
    cma_es, cross_entropy = (
        " and ".join(f"p = {_compute_p(rows, rule, name):.2g} for {RULES[rule]} robots" for rule in RULES)
        for name in TENTHS
    )
    return (
        f"A search that finds nothing in {MOST_RUNS} runs counts as {MOST_RUNS} for the goal. CMA-ES and cross-entropy "
        f"are counted in whole generations. Over all searches, the runs of CMA-ES differ from those at random with "
        f"{cma_es}, those of cross-entropy with {cross_entropy} (rank-sum test)."
    )


def _by_robot(rows: Rows) -> dict[tuple[str, str], Rows]:
    return {(str(row["task"]["seed"]), RULES[row["task"]["rule"]]): Rows([row]) for row in rows}


def _by_method(rows: Rows) -> dict[tuple[str, str], list[int | None]]:
    return {(RULES[rule], NAMES[name]): _pool(rows, rule, name) for rule in RULES for name in NAMES}


def _of(describe: Callable[..., str]) -> Callable[[Rows], str]:
    return lambda rows: describe(rows[0])


def _describe_setting(row: Row) -> str:
    return f"{row['setting']:.1f} s" if row["task"]["rule"] == SLOW else f"{1_000 * row['setting']:.2f} mm"


def _describe_taught(row: Row) -> str:
    taught = ", ".join(f"{1_000 * each:.0f} mm" for each in row["taught"]) or "none"
    return taught if row["task"]["rule"] == CIRCLING else ""


def _describe_failures(row: Row) -> str:
    low, high = exact_interval_of_share(row["failed"], MEASURED)
    return f"{100 * row['failed'] / MEASURED:.3f} ({100 * low:.3f}–{100 * high:.3f})"


def _draw(panel: Axes, every: Rows, rule: str) -> None:
    """Draw the runs of each search until its first failing world, by robot and method."""
    rows = every.where(rule=rule)
    for k, (name, color) in enumerate(zip(NAMES, COLORS, strict=False)):
        for at, row in enumerate(rows):
            capped = np.array(_cap(row["runs"][name]))
            x = at + 0.27 * (k - 1) + np.linspace(-0.09, 0.09, len(capped))
            has_failed = capped <= MOST_RUNS
            panel.plot(
                x[has_failed],
                capped[has_failed],
                "o",
                color=color,
                markersize=3,
                alpha=0.6,
                markeredgewidth=0,
            )
            panel.plot(
                x[~has_failed],
                np.full((~has_failed).sum(), 1_700),
                "^",
                color=color,
                markersize=3,
                fillstyle="none",
            )
            median = _cap_number(find_quartiles(row["runs"][name])[1])
            label = NAMES[name] if at == 0 else ""
            panel.hlines(median, x[0] - 0.02, x[-1] + 0.02, color=color, linewidth=2.5, label=label)
    panel.set_yscale("log")
    panel.set_ylim(0.5, 2_400)
    panel.set_yticks([1, 10, 100, 1_000, 1_700], ["1", "10", "100", "1000", "none"])
    panel.set_yticks([], minor=True)
    panel.set_xticks(range(len(rows)), [str(row["task"]["seed"]) for row in rows])
    panel.set_title(f"{RULES[rule]} robots")
    if rule == next(iter(RULES)):
        panel.set_ylabel("runs until the first failing world")
        panel.legend(loc="lower left", ncols=len(NAMES), handletextpad=0.1, columnspacing=0.8)


EXPERIMENT = Study(
    name="searches",
    seeds=SEEDS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=Conclusion(
        headline=_headline,
        tables=(
            LinePerGroup(
                f"Robots: slow ones fail after a time limit, circling ones have arrived at a distance; failures in "
                f"the worlds by which these were chosen, and in {MEASURED} others (exact 95 % interval)",
                ["robot", "rule"],
                _by_robot,
                {
                    "limit or distance": _of(_describe_setting),
                    "taught distance": _of(_describe_taught),
                    "failures when chosen, %": _of(
                        lambda row: f"{100 * row['chosen by'] / CALIBRATION_WORLDS[row['task']['rule']]:.3f}"
                    ),
                    "failures, %": _of(_describe_failures),
                },
                tuple,
            ),
            LinePerGroup(
                f"Runs until the first failing world: medians of {SEARCHES} searches (quartiles), each of at most "
                f"{MOST_RUNS} runs",
                ["robot", "rule"],
                _by_robot,
                {
                    **{
                        title: _of(lambda row, name=name: _format_quartiles(row["runs"][name]))
                        for name, title in NAMES.items()
                    },
                    **{f"random / {NAMES[name]}": _of(partial(_format_ratio, name=name)) for name in TENTHS},
                },
                tuple,
            ),
            LinePerGroup(
                "All searches by rule: medians of runs (quartiles), and how many found no failing world",
                ["rule", "method"],
                _by_method,
                {"runs": _format_quartiles, "found none": lambda runs: f"{runs.count(None)} of {len(runs)}"},
                tuple,
            ),
        ),
        goals=(
            CountGoal(
                "robots for which CMA-ES needs at most a tenth of the runs at random, by medians",
                WANTED,
                TENTHS[CMA_ES].condition,
                measured=lambda rows: f" (cross-entropy {TENTHS[CROSS_ENTROPY].number(rows)})",
            ),
        ),
        notes=(_note,),
        numbers=lambda rows: {
            "tenth": {name: count.number(rows) for name, count in TENTHS.items()},
            "medians": {
                rule: {name: _cap_number(find_quartiles(_pool(rows, rule, name))[1]) for name in NAMES}
                for rule in RULES
            },
            "p": {
                rule: {name: float(f"{_compute_p(rows, rule, name):.3g}") for name in TENTHS}
                for rule in RULES
            },
        },
    ),
    draw=Panels([partial(_draw, rule=rule) for rule in RULES], wide=4.4, tall=3.4),
    worlds=("forage",),
    varies=(CMA_ES,),
)
