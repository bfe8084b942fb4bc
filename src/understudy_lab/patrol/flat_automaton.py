"""Patrol as a single automaton: one robot, only basic behaviors, taught as long as the whole team (section 5.1).

The paper's authors "do not believe that we could train the agents to perform a behavior of this complexity without
decomposition". This task is easier than theirs: one robot, no boss, no coordinator, and the teacher uses eleven states,
one for each step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from understudy.model.library import Library
from understudy.sim.kit import make_scenario_kit
from understudy.sim.team.libraries import collect_libraries, make_team
from understudy.training.trainee import SessionView
from understudy_lab.patrol.evaluate import TICKS, rounds
from understudy_lab.patrol.metrics import cycles
from understudy_lab.patrol.practice import ROBOT, practices, robots_world, scenario
from understudy_lab.patrol.tracks import watch
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

SECONDS = 2900.0
"""The teaching time in s: as long as the layered lessons of robots and coordinator take."""
PRACTICE = "on patrol"
WANDERING = {"wander_forwards": "forwards", "wander_left": "left", "wander_right": "right"}
DRIVING = {"left": "left", "right": "right", "forward_left": "forwards", "forward_right": "forwards"}
SEEKING = {f"{to}_{move}": behavior for to in ("hunt", "home") for move, behavior in DRIVING.items()}
TARGET = {"hunt": "intruder", "home": "home"}


def show(screen: SessionView) -> str | None:
    """Return the next state: wander, drive to a visible intruder, drive home with it, wander again."""
    return _wished(
        screen, patrol_wander_teacher.show_disperse, patrol_teacher.show_servo, patrol_teacher.CLOSE_PX
    )


def find_complaint(screen: SessionView) -> str | None:
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
    show,
    find_complaint,
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
