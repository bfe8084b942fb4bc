"""The experiment: the same live teachings of foraging, learned by tests of the highest gain, and by flags first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import radians
from typing import TYPE_CHECKING

import numpy as np

from understudy.analysis.paired_tests import compute_mcnemar_p
from understudy.model.kinds import TAU, Continuous, Kind, Toroidal
from understudy.model.learner_options import ORDERS, TreeOptions
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree
from understudy_lab.figures import dots, panels
from understudy_lab.forage.teach import METHODS, WORLDS, judge, teach
from understudy_lab.statistics import compute_paired_p, format_median, spread
from understudy_lab.study import ResultTable, Row, Study, StudyFindings, StudyGoal, StudyPlan, Task
from understudy_lab.teachers.live_teacher import LIVE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHINGS = range(2_000_000, 2_000_200)
"""The teaching seeds of the published result."""
REACHED, SHARE, WORST = 0.95, 0.99, 0.80
ONE_TURN = radians(7.0)
"""The angle by which a robot turns in one tick, rad."""
FAR_M = 1.0
"""The distance above which a robot should drive to its target wherever that is, m."""


def tasks(plan: StudyPlan) -> list[Task]:
    """Return one task per order of tests and seed; both orders share their teacher, lessons and unseen worlds."""
    return [{"order": order, "seed": seed} for seed in plan.seeds for order in ORDERS]


def work(task: Task) -> Row:
    """Teach one robot live, test it in its own unseen worlds, and look at what its GoTo has learned."""
    learner = TreeOptions(order=task["order"])
    options = {name: replace(each, learner=learner) for name, each in METHODS[LIVE].items()}
    teaching = teach(task["seed"], method=LIVE, options=options)
    found, goto = judge(teaching.library, task["seed"]), teaching.library.taught["goto"]
    return {
        "success": found.success,
        "relative_to_expert": round(found.relative_to_expert, 4),
        "presses": sum(account.presses for account in teaching.accounts.values()),
        "goto_presses": teaching.accounts["goto"].presses,
        "narrow_arcs": count_narrow_arcs(goto),
        "far_cuts": count_far_cuts(goto),
    }


def count_narrow_arcs(taught: TrainedAutomaton) -> int:
    """Count the tests of an automaton for an arc, or for all but an arc, narrower than one tick turns."""
    widths = [
        (node.high - node.low) % kind.period / kind.period
        for node, kind in list_tests(taught)
        if node.test == TestKind.ARC and isinstance(kind, Toroidal)
    ]
    return sum(min(width, 1.0 - width) * TAU < ONE_TURN for width in widths)


def count_far_cuts(taught: TrainedAutomaton) -> int:
    """Count the tests of GoTo for a distance that is too far to matter."""
    return sum(node.high > FAR_M for node, kind in list_tests(taught) if isinstance(kind, Continuous))


def list_tests(taught: TrainedAutomaton) -> list[tuple[Node, Kind]]:
    """List the tests of an automaton's trees, each with the kind of its feature."""
    trees = [tree for tree in taught.automaton.transitions.values() if isinstance(tree, Tree)]
    tests = [node for tree in trees for node in tree.nodes if node.test != TestKind.LEAF]
    return [(node, taught.automaton.features[node.feature].kind) for node in tests]


def conclude(rows: Sequence[Row]) -> StudyFindings:
    """Compare the orders over all teachings."""
    by_order = {order: [row for row in rows if row["task"]["order"] == order] for order in ORDERS}
    gain, flags = by_order["gain first"], by_order["flags first"]
    lost, won = (
        sum(reaches(one) and not reaches(other) for one, other in zip(first, second, strict=True))
        for first, second in ((gain, flags), (flags, gain))
    )
    p = compute_mcnemar_p(lost, won)
    seeds = [row["task"]["seed"] for row in flags]
    worst = {order: min(row["success"] for row in found) for order, found in by_order.items()}
    presses = {
        order: float(np.median([row["presses"] for row in found])) for order, found in by_order.items()
    }
    headline = (
        f"Of {len(flags)} live teachings of foraging, {sum(map(reaches, flags))} instead of {sum(map(reaches, gain))} "
        f"give robots that succeed in at least 95 % of unseen worlds if tests that tell flags apart come first "
        f"(won {won}, lost {lost}, p = {p:.2g}, exact test of McNemar). The worst one succeeds in "
        f"{worst['flags first']:.0%} instead of {worst['gain first']:.0%}; the median teaching takes "
        f"{presses['flags first']:.0f} instead of {presses['gain first']:.0f} presses."
    )
    return StudyFindings(
        headline=headline,
        tables=(
            ResultTable(
                f"Live teachings {seeds[0]} to {seeds[-1]}, each tested in {WORLDS} unseen worlds of its own",
                ("", *(f"#{order}" for order in ORDERS)),
                [(what, *(tell(by_order[order]) for order in ORDERS)) for what, tell in TOLD.items()],
            ),
        ),
        goals=(
            StudyGoal(
                "teachings that reach 95 % success, flags first",
                f"{round(SHARE * len(flags))} of {len(flags)}",
                f"{sum(map(reaches, flags))} of {len(flags)}",
                sum(map(reaches, flags)) >= round(SHARE * len(flags)),
            ),
            StudyGoal(
                "success of the worst teaching, flags first",
                f"{WORST:.0%}",
                f"{worst['flags first']:.0%}",
                worst["flags first"] >= WORST,
            ),
        ),
        numbers={
            "won": won,
            "lost": lost,
            "p": float(f"{p:.2g}"),
            "p_of_presses": float(
                f"{compute_paired_p(*([row['presses'] for row in by_order[order]] for order in ORDERS)):.2g}"
            ),
            "success": {order: spread([row["success"] for row in by_order[order]]) for order in ORDERS},
        },
    )


def reaches(row: Row) -> bool:
    """Return whether a teaching gave a robot that succeeds in enough of its worlds."""
    return bool(row["success"] >= REACHED)


TOLD: Mapping[str, Callable[[Sequence[Row]], str]] = {
    "teachings with 95 % success": lambda rows: f"{sum(map(reaches, rows))} of {len(rows)}",
    "success": lambda rows: format_median([row["success"] for row in rows], percent=True),
    "food per second / hand-written": lambda rows: format_median(
        [row["relative_to_expert"] for row in rows], 3
    ),
    "presses": lambda rows: format_median([row["presses"] for row in rows]),
    "presses for GoTo": lambda rows: format_median([row["goto_presses"] for row in rows]),
    "GoTo with an arc that a robot turns past in a tick": lambda rows: _count(rows, "narrow_arcs"),
    f"GoTo with a test for a distance above {FAR_M:g} m": lambda rows: _count(rows, "far_cuts"),
}


def _count(rows: Sequence[Row], what: str) -> str:
    return f"{sum(row[what] > 0 for row in rows)} of {len(rows)}"


def draw(rows: Sequence[Row]) -> Figure:
    """Draw success and presses of every teaching, by order."""
    figure, (left, right) = panels(2)
    for axes, what, of, said, scale in (
        (left, "success", "success", "worlds finished in time, %", 100),
        (right, "effort", "presses", "presses", 1),
    ):
        groups = {
            order: [scale * row[of] for row in rows if row["task"]["order"] == order] for order in ORDERS
        }
        dots(axes, groups, said)
        axes.set_title(what)
    return figure


EXPERIMENT = Study(
    name="wrong_feature",
    seeds=TEACHINGS,
    quick=1,
    tasks=tasks,
    work=work,
    conclude=conclude,
    draw=draw,
    worlds=("forage",),
)
