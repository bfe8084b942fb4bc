"""The experiment: the same live teachings of foraging, learned by tests of the highest gain, and by flags first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import radians
from typing import Any

from understudy.judging.paired_tests import compute_mcnemar_p
from understudy.model.learner_options import ORDERS, TreeOptions
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Node, TestKind, Tree
from understudy.model.value_kinds import TAU, Continuous, Kind, Toroidal
from understudy_lab.declaration import ColumnPerGroup, Conclusion, CountGoal, Goal, Units
from understudy_lab.figures import Dots, Panels, by_group
from understudy_lab.forage.teach import METHODS, WORLDS, judge, teach
from understudy_lab.rows import Count, Median, Rows, group_by
from understudy_lab.statistics import compute_paired_p, spread
from understudy_lab.study import Row, Study, Task
from understudy_lab.teachers.live_teacher import LIVE

TEACHINGS = range(2_000_000, 2_000_200)
"""The teaching seeds of the published result."""
REACHED, SHARE, WORST = 0.95, 0.99, 0.80
GAIN, FLAGS = ORDERS
GROUPS = group_by("order", ORDERS)
ONE_TURN = radians(7.0)
"""The angle by which a robot turns in one tick, rad."""
FAR_M = 1.0
"""The distance above which a robot should drive to its target in any direction, m."""


def work(task: Task) -> Row:
    """Teach one robot live, test it in its own unseen worlds, and look at what its GoTo has learned."""
    learner = TreeOptions(order=task["order"])
    options = {name: replace(each, learner=learner) for name, each in METHODS[LIVE].items()}
    teaching = teach(task["seed"], method=LIVE, options=options)
    judged, goto = judge(teaching.library, task["seed"]), teaching.library.taught["goto"]
    return {
        "success": judged.success,
        "relative_to_expert": round(judged.relative_to_expert, 4),
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


def reaches(row: Row) -> bool:
    """Return whether a teaching gave a robot that succeeds in enough of its worlds."""
    return bool(row["success"] >= REACHED)


def compare_orders(groups: Mapping[str, Rows]) -> tuple[int, int, float]:
    """Return how many teachings succeed only with flags first, how many only with gain first, and the p-value."""
    pairs = [(reaches(gain), reaches(flags)) for gain, flags in zip(groups[GAIN], groups[FLAGS], strict=True)]
    won, lost = pairs.count((False, True)), pairs.count((True, False))
    return won, lost, compute_mcnemar_p(lost, won)


def write_headline(groups: Mapping[str, Rows]) -> str:
    """Return how many more teachings succeed with flags first."""
    flags, gain = groups[FLAGS], groups[GAIN]
    won, lost, p = compare_orders(groups)
    return (
        f"Of {len(flags)} live teachings of foraging, {len(flags.filter(reaches))} instead of "
        f"{len(gain.filter(reaches))} give robots that succeed in at least 95 % of unseen worlds if tests that tell "
        f"flags apart come first (won {won}, lost {lost}, p = {p:.2g}, exact test of McNemar). The worst one succeeds "
        f"in {min(flags.values('success')):.0%} instead of {min(gain.values('success')):.0%}; the median teaching "
        f"takes {flags.median('presses'):.0f} instead of {gain.median('presses'):.0f} presses."
    )


def list_numbers(groups: Mapping[str, Rows]) -> dict[str, Any]:
    """Return the comparison of the orders as data."""
    won, lost, p = compare_orders(groups)
    return {
        "won": won,
        "lost": lost,
        "p": float(f"{p:.2g}"),
        "p_of_presses": float(
            f"{compute_paired_p(*(groups[each].values('presses') for each in ORDERS)):.2g}"
        ),
        "success": {order: spread(rows.values("success")) for order, rows in groups.items()},
    }


EXPERIMENT = Study(
    name="wrong_feature",
    seeds=TEACHINGS,
    quick=1,
    tasks=Units(
        {"order": ORDERS}, by_seed=True
    ),  # both orders share their teacher, lessons and unseen worlds
    work=work,
    conclude=Conclusion(
        prepare=GROUPS,
        headline=write_headline,
        tables=(
            ColumnPerGroup(
                f"Live teachings {{seeds}}, each tested in {WORLDS} unseen worlds of its own",
                dict,
                {
                    "teachings with 95 % success": Count(reaches),
                    "success": Median("success", percent=True),
                    "food per second / hand-written": Median("relative_to_expert", 3),
                    "presses": Median("presses"),
                    "presses for GoTo": Median("goto_presses"),
                    "GoTo with an arc that a robot turns past in a tick": Count(
                        lambda row: row["narrow_arcs"] > 0
                    ),
                    f"GoTo with a test for a distance above {FAR_M:g} m": Count(
                        lambda row: row["far_cuts"] > 0
                    ),
                },
            ),
        ),
        goals=(
            CountGoal(
                "teachings that reach 95 % success, flags first",
                SHARE,
                reaches,
                round,
                lambda groups: groups[FLAGS],
            ),
            Goal(
                "success of the worst teaching, flags first",
                lambda groups: min(groups[FLAGS].values("success")),
                least=WORST,
            ),
        ),
        numbers=list_numbers,
    ),
    draw=Panels(
        (
            Dots("success", "worlds finished in time, %", by_group(GROUPS, "success", 100)),
            Dots("effort", "presses", by_group(GROUPS, "presses")),
        )
    ),
    worlds=("forage",),
)
