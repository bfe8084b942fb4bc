"""Evaluation of teams of scouts and carriers in unseen worlds, in units brought home per hour."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from understudy.errors import SettingError
from understudy.runtime.team.team import Team
from understudy.sim.world import World
from understudy_lab.mixed_teams.practice import (
    CARRIER,
    SCOUT,
    MixedTeaching,
    make_coordinated_team,
    make_single_type_team,
    make_uncoordinated_team,
)

WORLDS, TICKS = 50, 12_000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: twenty minutes."""
FAILS_TICK = (2_000, 6_000)
"""The range of ticks in which robots fail at random; only the yield after it counts."""
FAILING = 3
"""One robot of this many fails."""
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
    world = _world(team)
    total = float(world.total.mean())
    at, early = 0, 0.0
    for tick in sorted({*(fails or {}), min(FAILS_TICK[1], ticks)}):
        team.run(tick - at)
        at = tick
        for robot in (fails or {}).get(tick, ()):
            world.freeze(robot)
        early = float(world.delivered.mean())
    team.run(ticks - at)
    hours, rest = ticks * world.tick_s / 3600, (ticks - at) * world.tick_s / 3600
    end = float(world.delivered.mean())
    late = round((end - early) / rest, 1) if rest else 0.0
    return {"rate": round(end / hours, 1), "late": late, "total": total}


def schedule_failures(worlds: Sequence[int], robots: int = 12) -> dict[int, list[int]]:
    """Return which robots fail, by the tick at which they do.

    `worlds` are the seeds of the worlds. In each, a random third of the robots fails, each at a random tick. Robots are
    counted through all worlds: number `world * robots + robot`.
    """
    draws = np.random.default_rng(list(worlds))
    found: dict[int, list[int]] = {}
    for world in range(len(worlds)):
        for robot in draws.choice(robots, robots // FAILING, replace=False).tolist():
            found.setdefault(int(draws.integers(*FAILS_TICK)), []).append(world * robots + robot)
    return found


def _share(part: float, whole: float) -> float:
    return round(part / whole, 4) if whole else 0.0


def _world(team: Team) -> World:
    if not isinstance(team.ground, World):
        raise SettingError(where="roles", setting="team", problem="is in no world", remedy="give it one")
    return team.ground
