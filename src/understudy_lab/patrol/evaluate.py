"""Evaluation of a taught patrol in unseen worlds: uncoordinated, coordinated, with a boss, with a bad radio.

Also of a patrol as a single automaton: one robot, only basic behaviors, taught as long as the whole team (section 5.1).
The paper's authors "do not believe that we could train the agents to perform a behavior of this complexity without
decomposition". This task is easier than theirs: one robot, no boss, no coordinator, and the teacher uses eleven states,
one for each step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.libraries import Libraries, collect_libraries, make_team
from understudy.training.trainee import SessionView
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
    practices,
    robots_world,
    scenario,
)
from understudy_lab.patrol.tracks import PatrolTracks, watch
from understudy_lab.tasks import patrol_teacher, patrol_wander_teacher
from understudy_lab.teachers.person import KEEP, Wish, after
from understudy_lab.teachers.teacher import (
    LessonDesign,
    LessonPlan,
    Patience,
    ScriptedTeacher,
    Situation,
    TeachingResult,
)


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


SECONDS = 2900.0
"""The teaching time in s: as long as the layered lessons of robots and coordinator take."""
PRACTICE = "on patrol"
WANDERING = {"wander_forwards": "forwards", "wander_left": "left", "wander_right": "right"}
DRIVING = {"left": "left", "right": "right", "forward_left": "forwards", "forward_right": "forwards"}
SEEKING = {f"{to}_{move}": behavior for to in ("hunt", "home") for move, behavior in DRIVING.items()}
TARGET = {"hunt": "intruder", "home": "home"}


def show_undivided(screen: SessionView) -> str | None:
    """Return the next state: wander, drive to a visible intruder, drive home with it, wander again."""
    return _wished(
        screen, patrol_wander_teacher.show_disperse, patrol_teacher.show_servo, patrol_teacher.CLOSE_PX
    )


def complain_undivided(screen: SessionView) -> str | None:
    """Return the state to correct the robot to, or None: as demonstrated, with wider margins."""
    return _wished(
        screen,
        patrol_wander_teacher.complain_disperse,
        patrol_teacher.complain_servo,
        patrol_teacher.TOO_CLOSE_PX,
    )


def _wished(screen: SessionView, wander: Wish, servo: Wish, close_px: float) -> str | None:
    task, _, move = screen.state.partition("_")
    if task == "start":
        return _within(screen, "wander", "start", wander)
    if task == "wander":
        sees = screen.features["blob_size(intruder)"] == screen.features["blob_size(intruder)"]
        return _within(screen, "hunt", "start", servo) if sees else _within(screen, task, move, wander)
    if screen.features[f"blob_size({TARGET[task]})"] >= close_px:
        return "home_left" if task == "hunt" else "wander_forwards"
    return _within(screen, task, move, servo)


def _within(screen: SessionView, task: str, move: str, wish: Wish) -> str | None:
    """Return the state that a wish for one part of the automaton asks for, with the part's name as prefix."""
    target = TARGET.get(task)
    features = dict(screen.features)
    if target is not None:
        features["blob_x(A)"] = features[f"blob_x({target})"]
    wished = wish(replace(screen, state=move, features=features))
    return wished if wished is None or wished == KEEP else f"{task}_{wished}"


UNDIVIDED = LessonPlan(
    "patrol",
    LessonDesign(
        states=[f"{state}={behavior}" for state, behavior in (WANDERING | SEEKING).items()],
        features=[
            "sonar_front_left",
            "sonar_front_right",
            "blob_x(intruder)",
            "blob_size(intruder)",
            "blob_x(home)",
            "blob_size(home)",
        ],
    ),
    show_undivided,
    complain_undivided,
    after(150.0),
    cases=(Situation(PRACTICE, enough=after(120.0)),) * 3,
    tries=8,
    limit_s=200.0,
    patience_s=100.0,
)


def teach_undivided(seed: int) -> TeachingResult:
    """Teach the single automaton, with corrections until it works or the time is over."""
    patience = Patience(corrections=100_000, lessons=1, seconds=SECONDS)
    return ScriptedTeacher(
        Library(make_scenario_kit(scenario())), robots_world, seed, options={}, patience=patience
    ).teach(UNDIVIDED)


def make_lone_robot_team(robots: Library, seeds: Sequence[int]) -> dict[str, Any]:
    """Run one robot that patrols alone, in one world per seed, and return its results."""
    world = practices()[PRACTICE]
    team = make_team(world, seeds, collect_libraries(world, robots), {ROBOT: ("patrol", {})})
    tracks = watch(team, TICKS)
    return rounds(tracks) | {
        "worlds_with_a_cycle": len({each.world for each in cycles(tracks) if each.complete})
    }
