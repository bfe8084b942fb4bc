"""Evaluation of a taught patrol in unseen worlds: uncoordinated, coordinated, with a boss, with a bad radio."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from understudy.model.library import Library
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.libraries import Libraries
from understudy_lab.patrol.metrics import (
    attackers,
    captures,
    count_joint_attacks,
    cycles,
    encounters,
    false_homes,
    residual_s,
    sighting_to_capture,
)
from understudy_lab.patrol.practice import (
    ROBOT,
    ROBOTS,
    SQUAD,
    make_coordinated_team,
    make_uncoordinated_team,
)
from understudy_lab.patrol.tracks import PatrolTracks, watch


def states_of(library: Library, behavior: str) -> int:
    """Return the number of states of a behavior when flattened into one automaton; a basic behavior counts one."""
    if behavior not in library.taught:
        return 1
    states = library.automaton(behavior).states
    return sum(states_of(library, state.behavior) for state in states if state.behavior is not None)


def count_ordered_states(robots: Library, coordinators: Library, behavior: str) -> list[int]:
    """Return the flattened robot states for each lowest-level state of a coordinator's behavior."""
    if behavior not in coordinators.taught:
        return [states_of(robots, behavior)]
    states = coordinators.automaton(behavior).states
    return [
        count
        for state in states
        if state.behavior is not None
        for count in count_ordered_states(robots, coordinators, state.behavior)
    ]


def count_flat_states(robots: Library, coordinators: Library, behavior: str) -> tuple[int, int]:
    """Return the states of a coordinated behavior as one automaton, for one robot and for all robots jointly."""
    counts = count_ordered_states(robots, coordinators, behavior)
    return sum(counts), sum(count**ROBOTS for count in counts)


WORLDS, TICKS = 100, 6000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: ten minutes."""
PATROL, DEFER = "collective_patrol", "collective_patrol_and_defer"
BAD_RADIO = CommsSpec(delay_s=0.2, loss=0.1)
FAILS_TICK = (600, 2400)
"""The range of ticks in which one robot of each world fails at random; only captures after it count."""
ON_TIME_S = 0.3
RESUMES_S = 10.0


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_patrol(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Return all measurements of one taught team."""
    together = watch(make_coordinated_team(libraries, worlds, PATROL), ticks)
    deferring = watch(make_coordinated_team(libraries, worlds, DEFER), ticks)
    bad = watch(make_coordinated_team(libraries, worlds, PATROL, BAD_RADIO), ticks)
    failing = watch(make_coordinated_team(libraries, worlds, PATROL), ticks, _failing(worlds))
    of_one, of_all = count_flat_states(libraries[ROBOT], libraries[SQUAD], DEFER)
    return {
        "alone": rounds(watch(make_uncoordinated_team(libraries, worlds), ticks)),
        "coordinated": rounds(together),
        "deferring": deferrals(deferring),
        "bad_radio": rounds(bad),
        "one_failed": _captured_late(failing) / max(1, _captured_late(together)),
        "states_of_one": of_one,
        "states_of_all": of_all,
    }


def rounds(tracks: PatrolTracks) -> dict[str, Any]:
    """Return how a team patrols: cycles, captures, joint attacks, and attacks on intruders that are gone."""
    ended, number = list(cycles(tracks)), len(captures(tracks))
    seconds = sighting_to_capture(tracks)
    sighted, joined = count_joint_attacks(tracks)
    seldom = false_homes(tracks)
    return {
        "cycles": len(ended),
        "complete": _share(sum(cycle.complete for cycle in ended), len(ended)),
        "false_captures": _share(seldom, len(ended) + seldom),
        "captures_per_hour": round(number / tracks.hours, 2),
        "sighting_to_capture_s": [round(float(each), 1) for each in np.quantile(seconds, (0.5, 0.9))]
        if len(seconds)
        else None,
        "attackers": round(float(attackers(tracks).mean()), 3) if number else None,
        "sightings": sighted,
        "joined_at_once": _share(joined, sighted),
        "residual_s": round(residual_s(tracks), 1),
    }


def deferrals(tracks: PatrolTracks) -> dict[str, Any]:
    """Return how a team treats the boss: encounters, the share in which all faced him, the share resumed on time."""
    meetings = list(encounters(tracks))
    met = [each for each in meetings if each.in_sight]
    resumed = [each.resumed_s for each in meetings if not np.isnan(each.resumed_s)]
    on_time = sum(abs(each - RESUMES_S) <= ON_TIME_S + 1e-6 for each in resumed)
    return {
        "encounters": len(met),
        "deferred": _share(sum(each.deferred for each in met), len(met)),
        "on_time": _share(on_time, len(resumed)),
    }


def _share(count: int, of: int) -> float | None:
    return round(count / of, 4) if of else None


def _failing(worlds: Sequence[int]) -> Mapping[int, Sequence[int]]:
    """Return the failing robots by tick: one random robot of each world."""
    draws = np.random.default_rng(list(worlds))
    robots_by_tick: dict[int, list[int]] = {}
    for world in range(len(worlds)):
        robots_by_tick.setdefault(int(draws.integers(*FAILS_TICK)), []).append(
            world * ROBOTS + int(draws.integers(ROBOTS))
        )
    return robots_by_tick


def _captured_late(tracks: PatrolTracks) -> int:
    return sum(tick >= FAILS_TICK[1] for _, tick in captures(tracks))
