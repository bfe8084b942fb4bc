"""The experiment: independent teachings of scouts, carriers and their coordinator, each tested in its own worlds."""

from __future__ import annotations

import numpy as np

from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, Units
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.lesson_stats import LessonTable, examples_in, lessons_of
from understudy_lab.mixed_teams.evaluate import (
    LED,
    MIXED,
    SINGLE,
    WORLDS,
    measure_mixed_teams,
    worlds_of,
)
from understudy_lab.mixed_teams.practice import teach
from understudy_lab.rows import Median, Rows, group_by_arm
from understudy_lab.study import Row, Study, Task
from understudy_lab.team_runs import FAILING

TEACHINGS = range(59_000, 59_010)
"""The teaching seeds of the published result; none was used during development."""
BETTER = 1.5
SURVIVORS = 1 - 1 / FAILING
KEPT = 0.8 * SURVIVORS
NAMES = {LED: "mixed, under their coordinator", MIXED: MIXED} | {name: name for name in SINGLE}
"""The teams, and what they are called in tables."""


def work(task: Task) -> Row:
    """Teach a mixed team with one seed and test it in its own unseen worlds."""
    taught = teach(task["seed"])
    lessons = {kind: lessons_of(teaching) for kind, teaching in taught.robots.items()}
    lessons["coordinator"] = lessons_of(taught.coordinator)
    return {**measure_mixed_teams(taught, worlds_of(task["seed"])), "lessons": lessons}


def compare_with_single(row: Row) -> float:
    """Return the yield of a coordinated team relative to the best team of one type."""
    best = max(float(row["rate"][name]) for name in SINGLE)
    return float(round(row["rate"][LED] / max(1.0, best), 3))


def compare_with_uncoordinated(row: Row, what: str = "rate") -> float:
    """Return the yield of a coordinated team relative to the same robots without their coordinator."""
    return float(row[what][LED] / max(1.0, row[what][MIXED]))


def write_headline(rows: Rows) -> str:
    """Return what the mix and the coordinator are worth."""
    return (
        "A mixed team of four scouts and eight carriers, each type taught its own behaviors, brings home "
        f"{rows.median(compare_with_single):.1f} times as much under its coordinator as the best team of twelve robots "
        f"of one type, in unseen worlds (median: {Median(f'rate.{LED}')(rows)} units an hour). All automata together "
        f"take {np.median(examples_in(rows)):.0f} examples. Without the coordinator, the same robots bring home "
        f"{1 / rows.median(compare_with_uncoordinated):.2f} times as much as with it."
    )


def write_contribution(rows: Rows) -> str:
    """Return a note on the contribution of the coordinator."""
    failing = rows.median(lambda row: compare_with_uncoordinated(row, "after_failures"))
    return (
        f"The mix makes the difference: under the coordinator, the team brings home "
        f"×{rows.median(compare_with_uncoordinated):.2f} of what the same robots bring home on their own, and "
        f"×{failing:.2f} after a third was killed. A carrier that follows an exploring scout is close by when the "
        "scout finds something, so the coordinator can add little."
    )


BY_TEAM = ("rate", "after_failures", "kept")
SHORT = ("mixed,\nled", "mixed,\nalone", "carriers,\nsearching", "carriers,\ngoing back", "scouts")
"""What the teams are called in the figure."""

EXPERIMENT = Study(
    name="roles",
    seeds=TEACHINGS,
    quick=1,
    tasks=Units({}),
    work=work,
    conclude=Conclusion(
        headline=write_headline,
        tables=(
            LinePerGroup(
                f"Salvage, teachings {{seeds}}, {WORLDS} unseen worlds of 20 minutes each: median (worst–best)",
                ["team of twelve"],
                group_by_arm(NAMES, *BY_TEAM),
                {"units an hour": Median("rate")},
                lambda team: [NAMES[team]],
            ),
            LinePerGroup(
                "Yield after a third of the members was killed at random moments",
                ["team of twelve"],
                group_by_arm((LED, MIXED), *BY_TEAM),
                {
                    "units an hour": Median("after_failures"),
                    "share of the yield without failures": Median("kept", percent=True),
                },
                lambda team: [NAMES[team]],
            ),
            LessonTable("type"),
        ),
        goals=(
            Goal(
                "units brought home, relative to the best team of one type",
                lambda rows: rows.median(compare_with_single),
                "×{}",
                BETTER,
                measured=lambda rows: (
                    f"×{rows.median(compare_with_single):.2f}, "
                    f"worst ×{min(rows.values(compare_with_single)):.2f}"
                ),
            ),
            Goal(
                "share of the yield kept after a third of the members was killed",
                f"kept.{LED}",
                least=KEPT,
                wanted=f"{KEPT:.0%}: 0.8 of the {SURVIVORS:.0%} who survive",
            ),
        ),
        notes=(
            write_contribution,
            "A carrier cannot distinguish a dead scout at an empty wreck from a scout on guard. This is what failures "
            "cost beyond the loss of the members themselves.",
            lambda rows: (
                "Scouts cannot carry anything: a team of scouts brings home "
                f"{max(rows.values('rate.all scouts')):.0f} units."
            ),
        ),
        numbers=lambda rows: {
            "teachings": len(rows),
            "better": rows.values(compare_with_single),
            "examples": examples_in(rows),
        },
    ),
    draw=Panels(
        (
            Dots(
                "all twelve",
                "units an hour",
                by_value(dict(zip((f"rate.{name}" for name in NAMES), SHORT, strict=True))),
            ),
            Dots(
                "after a third was killed",
                "units an hour",
                by_value(
                    dict(zip((f"after_failures.{name}" for name in (LED, MIXED)), SHORT[:2], strict=True))
                ),
            ),
        ),
        wide=4.2,
    ),
    worlds=("salvage",),
)
