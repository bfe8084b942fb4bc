"""Evaluation of teams of scouts and carriers in unseen worlds, in units brought home per hour."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from understudy.runtime.team.team import Team
from understudy_lab import team_runs
from understudy_lab.mixed_teams.practice import (
    CARRIER,
    SCOUT,
    MixedTeaching,
    make_coordinated_team,
    make_single_type_team,
    make_uncoordinated_team,
)
from understudy_lab.team_runs import run_with_failures, world_of

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


def measure_mixed_teams(taught: MixedTeaching, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Measure the yield of each team, and of the mixed ones also after a third of their members failed."""
    robots, coordinator = taught.libraries, taught.coordinator.library
    teams: dict[str, Callable[[], Team]] = {
        LED: lambda: make_coordinated_team(robots, coordinator, worlds),
        MIXED: lambda: make_uncoordinated_team(robots, worlds, ALONE),
    }
    whole = {name: measure_delivered(make(), ticks) for name, make in teams.items()}
    killed = {
        name: measure_delivered(make(), ticks, schedule_failures(worlds)) for name, make in teams.items()
    }
    single = {
        name: measure_delivered(make_single_type_team(kind, robots, worlds, behavior), ticks)
        for name, (kind, behavior) in SINGLE.items()
    }
    return {
        "rate": {name: each["rate"] for name, each in (whole | single).items()},
        "kept": {name: _share(killed[name]["late"], whole[name]["late"]) for name in teams},
        "after_failures": {name: killed[name]["late"] for name in teams},
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


schedule_failures = partial(team_runs.schedule_failures, robots=12, within=FAILS_TICK)


def _share(part: float, whole: float) -> float:
    return round(part / whole, 4) if whole else 0.0
