"""The experiment: independent teachings of scouts, carriers and their coordinator, each tested in its own worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy_lab import teams
from understudy_lab.declaration import Conclusion, Goal, LinePerGroup, Units
from understudy_lab.figures import Dots, Panels, by_value
from understudy_lab.lesson_stats import LessonTable, examples_in, lessons_of
from understudy_lab.mixed_teams.practice import (
    CARRIER,
    SCOUT,
    SQUAD,
    make_coordinated_team,
    make_single_type_team,
    make_uncoordinated_team,
    teach,
)
from understudy_lab.rows import Median, Rows, group_by_arm
from understudy_lab.study import Row, Study, Task
from understudy_lab.teams import FAILING, run_with_failures, world_of

WORLDS, TICKS = 50, 12_000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: twenty minutes."""
FAILS_TICK = (2_000, 6_000)
"""The range of ticks in which robots fail at random; only the yield after it counts."""
ALONE: Mapping[str, str] = {SCOUT: "lookout", CARRIER: "haul"}
"""The behavior of each type in a mixed team without a coordinator."""
SINGLE: Mapping[str, tuple[str, str]] = {
    "all carriers, searching": (CARRIER, "gather"),
    "all carriers, going back": (CARRIER, "return"),
    "all scouts": (SCOUT, "lookout"),
}
"""The teams of one type: the type and its behavior."""
LED, MIXED = "led", "mixed, each by itself"


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_mixed_teams(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Measure the yield of each team, and of the mixed ones also after a third of their members failed."""
    makers: dict[str, Callable[[], Team]] = {
        LED: lambda: make_coordinated_team(libraries, worlds),
        MIXED: lambda: make_uncoordinated_team(libraries, worlds, ALONE),
    }
    whole = {name: measure_delivered(make(), ticks) for name, make in makers.items()}
    killed = {
        name: measure_delivered(make(), ticks, schedule_failures(worlds)) for name, make in makers.items()
    }
    single = {
        name: measure_delivered(make_single_type_team(kind, libraries, worlds, behavior), ticks)
        for name, (kind, behavior) in SINGLE.items()
    }
    return {
        "rate": {name: each["rate"] for name, each in (whole | single).items()},
        "kept": {name: _share(killed[name]["late"], whole[name]["late"]) for name in makers},
        "after_failures": {name: killed[name]["late"] for name in makers},
        "found": whole[LED]["total"],
    }


def measure_delivered(
    team: Team, ticks: int, fails: Mapping[int, Sequence[int]] | None = None
) -> dict[str, float]:
    """Run a team and return units per hour and world in the whole run and after all failures, and the initial units.

    `fails` maps a tick to the robots that fail in it.
    """
    world = world_of(team)
    total = float(world.total.mean())
    at = max([*(fails or {}), min(FAILS_TICK[1], ticks)])
    run_with_failures(team, at, fails or {})
    early = float(world.delivered.mean())
    team.run(ticks - at)
    hours, rest = ticks * world.tick_s / 3600, (ticks - at) * world.tick_s / 3600
    end = float(world.delivered.mean())
    late = round((end - early) / rest, 1) if rest else 0.0
    return {"rate": round(end / hours, 1), "late": late, "total": total}


schedule_failures = partial(teams.schedule_failures, robots=12, within=FAILS_TICK)


def _share(part: float, whole: float) -> float:
    return round(part / whole, 4) if whole else 0.0


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
    lessons = {
        "coordinator" if sort == SQUAD else sort: lessons_of(each) for sort, each in taught.by_sort.items()
    }
    return {**measure_mixed_teams(taught.libraries, worlds_of(task["seed"])), "lessons": lessons}


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
