"""The tasks of following walls and circling obstacles with two sonars: lesson plans and hand-written controllers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import pi, tau

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.random_rooms import (
    RoomLayout,
    build_world,
    concave,
    convex,
    lengths,
    measure_line_distances,
    middles,
    room,
)
from understudy_lab.behavior_suite.task import RADIUS, SPEED, BehaviorTask, Expert, TaskResult, TaskTrial
from understudy_lab.behavior_suite.tracks import (
    GroundTruth,
    Table,
    count_turns,
    length_of,
    measure_gain,
    medians,
)
from understudy_lab.teachers.person import after
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

LEFT, RIGHT = "left", "right"
OTHER = {LEFT: RIGHT, RIGHT: LEFT}

BLOCKED_M, CLEAR_M = 0.45, 0.8  # ahead
WIDE_M, WELL_M = 0.55, 0.45  # on the hand
AHEAD = "sonar_ahead"
EARLY_M = 0.15
"""The distance by which a switch must come too early, m, to be taken back in live teaching."""


def choose_wall_action(state: str, ahead: float, beside: float, hand: str, slack: float = 0.0) -> str | None:
    """Return the next state of a wall follower for an allowed error of `slack` m, or None."""
    away, near = f"rotate_{OTHER[hand]}", f"veer_{hand}"
    if state == "start":
        return "seek"
    if state == away:
        return "along" if ahead > CLEAR_M + 2 * slack else None
    if ahead < BLOCKED_M - slack:
        return away
    if state in ("seek", near):
        return "along" if beside < WELL_M - slack else None
    return near if beside > WIDE_M + slack else None


def make_wall_topic(name: str, hand: str, practice: str, *, cases: int, seconds: float) -> LessonPlan:
    """Return the plan of following a wall on one side: find it, go along it, veer to it, turn off at a wall ahead."""
    beside = f"sonar_{hand}"

    def pressing(slack: float) -> Callable[[SessionView], str | None]:
        return lambda screen: choose_wall_action(
            screen.state, screen.features[AHEAD], screen.features[beside], hand, slack
        )

    def complain_live(screen: SessionView) -> str | None:
        """Return the state to direct to, or None: as in a test, and where the robot goes along too far away."""
        wide = screen.state == "along" and screen.features[beside] > WIDE_M
        return pressing(0.0 if wide else 0.1)(screen)

    states = ["seek=forward", "along=forward", f"rotate_{OTHER[hand]}", f"veer_{hand}"]
    return LessonPlan(
        name,
        LessonDesign(states=states, features=[AHEAD, beside]),
        pressing(0.0),
        pressing(0.1),
        after(3 * seconds),
        cases=(Situation(practice, enough=after(seconds)),) * cases,
        tries=4,
        limit_s=4 * seconds,
        accepts=lambda screen, state: pressing(0.1)(replace(screen, state=state)) in (None, state),
        complain_live=complain_live,
        takes_back=lambda screen, before: pressing(-EARLY_M)(replace(screen, state=before)) is None,
    )


class ExpertWallFollower:
    """A hand-written controller with the same sonars that reacts at once."""

    def __init__(self, world: World, hand: str) -> None:
        self.keys: Sequence[ReadingKey] = ((AHEAD, None), (f"sonar_{hand}", None))
        self._side = 1.0 if hand == LEFT else -1.0
        self._seeking = np.ones(world.agents, np.bool_)
        self._turning, self._veering = np.zeros((2, world.agents), np.bool_)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        ahead, beside = (percept[key] for key in self.keys)
        self._turning = ahead < np.where(self._turning, CLEAR_M, BLOCKED_M)
        self._seeking &= ~self._turning & (beside > WELL_M)
        self._veering = beside > np.where(self._veering, WELL_M, WIDE_M)
        veer = (self._veering & ~self._seeking).astype(np.float64)
        return {
            "drive": np.where(self._turning, 0.0, 1.0 - 0.2 * veer),
            "turn": self._side * np.where(self._turning, -1.0, 0.6 * veer),
        }


def make_wall_expert(hand: str) -> Callable[[World], Expert]:
    """Return a function that makes the controller for a wall on the given side."""
    return lambda world: ExpertWallFollower(world, hand)


NEAR_M, CIRCLING_LIMIT_S = 1.0, 90.0


def judge_circling(tracks: GroundTruth, plots: Sequence[RoomLayout]) -> TaskResult:
    """Return when the robot had circled the obstacle within 1 m of it, and its distance until then."""
    far, _ = measure_line_distances(tracks.x, tracks.y, plots)
    middle = middles(len(plots))
    gone = measure_gain(count_turns(tracks.x, tracks.y, middle[:, 0], middle[:, 1]), far <= NEAR_M)
    seconds = tracks.first(gone >= 1.0)
    last = np.where(np.isnan(seconds), np.inf, seconds / tracks.tick_s + 0.5)
    till_then = np.where((far <= NEAR_M) & (np.arange(len(far))[:, None] <= last), far, np.nan)
    return TaskResult(seconds, {"turns": gone.max(axis=0), "distance kept, m": medians(till_then)})


def compute_circling_bound(tracks: GroundTruth, plots: Sequence[RoomLayout]) -> Column:
    """Return the least time in s [W] to reach and circle the obstacle at full speed.

    The path leads to within a meter, then around the convex hull at the rover's radius, less the meter that closing the
    loop may save.
    """
    far, _ = measure_line_distances(tracks.x[:1], tracks.y[:1], plots)
    loops = np.array([length_of(hull(plot.corners)) for plot in plots]) + tau * RADIUS
    seconds: Column = (np.maximum(0.0, far[0] - NEAR_M) + loops - NEAR_M) / SPEED
    return seconds


def hull(corners: Table) -> Table:
    """Return the corners [P, 2] of the convex hull, counter-clockwise (Andrew 1979)."""
    points = sorted((float(x), float(y)) for x, y in corners)

    def half(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in points:
            while len(chain) > 1:
                (x0, y0), (x1, y1) = chain[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(points) + half(points[::-1]))


def _make_circling_trial(seeds: Sequence[int], make: Callable[[int], RoomLayout]) -> TaskTrial:
    plots = [make(seed) for seed in seeds]
    return TaskTrial(
        build_world(plots, solid=True),
        CIRCLING_LIMIT_S,
        lambda tracks: judge_circling(tracks, plots),
        lambda tracks: compute_circling_bound(tracks, plots),
    )


def _make_circling_task(name: str, what: str, make: Callable[[int], RoomLayout]) -> BehaviorTask:
    return BehaviorTask(
        name=name,
        does=f"goes once around a {what}",
        measured="once around in 90 s, never more than 1 m away from it",
        bounded="once around the obstacle's convex hull",
        kit=build_world([make(0)], solid=True).kit,
        topics=(make_wall_topic(name, LEFT, "obstacle", cases=2, seconds=20.0),),
        options={name: LearnerOptions(watched=True, reaction_s=0.2)},
        practice=lambda practice, seed: build_world([make(seed)], solid=True),
        trial=lambda seeds: _make_circling_trial(seeds, make),
        hand=make_wall_expert(LEFT),
    )


CIRCLING_TASKS = (
    _make_circling_task("around_convex", "convex obstacle", convex),
    _make_circling_task("around_concave", "concave obstacle (an L or a U)", concave),
)


AT_WALL_M, WALL_LIMIT_S = 1.0, 120.0


def judge_wall_following(tracks: GroundTruth, plots: Sequence[RoomLayout], hand: str) -> TaskResult:
    """Return when the loop was closed without leaving the wall, and the distance from it until then."""
    far, along = measure_line_distances(tracks.x, tracks.y, plots)
    way, whole = (1.0 if hand == RIGHT else -1.0), lengths(plots)
    gone = measure_gain(way * _unwrapped(along, whole), far <= AT_WALL_M)
    seconds = tracks.first(gone >= whole)
    last = np.where(np.isnan(seconds), np.inf, seconds / tracks.tick_s + 0.5)
    till_then = np.where((far <= AT_WALL_M) & (np.arange(len(far))[:, None] <= last), far, np.nan)
    return TaskResult(
        seconds,
        {"loops": gone.max(axis=0) / whole, "distance kept, m": medians(till_then)},
    )


def _unwrapped(along: Table, whole: Column) -> Table:
    """Return the total distance along a line, also where its position restarts after the whole length."""
    return np.unwrap(along / whole * tau, axis=0) * whole / tau


def compute_wall_following_bound(tracks: GroundTruth, plots: Sequence[RoomLayout]) -> Column:
    """Return the least time in s [W]: straight to within 1 m of the wall, then around the room 1 m inside."""
    far, _ = measure_line_distances(tracks.x[:1], tracks.y[:1], plots)
    inner = np.array([compute_corner_savings(plot.corners) for plot in plots])
    seconds: Column = (np.maximum(0.0, far[0] - AT_WALL_M) + lengths(plots) - inner) / SPEED
    return seconds


def compute_corner_savings(corners: Table) -> float:
    """Return by how much a path 1 m inside the corners [P, 2] is shorter, m; only convex corners save length."""
    edges = np.roll(corners, -1, axis=0) - corners
    angles = np.arctan2(edges[:, 1], edges[:, 0])
    bends = (np.roll(angles, -1) - angles + pi) % tau - pi
    return float(sum(2 * AT_WALL_M * np.tan(bend / 2) for bend in bends if bend > 0))


def _make_room_trial(seeds: Sequence[int], hand: str) -> TaskTrial:
    plots = [room(seed) for seed in seeds]
    return TaskTrial(
        build_world(plots, solid=False),
        WALL_LIMIT_S,
        lambda tracks: judge_wall_following(tracks, plots, hand),
        lambda tracks: compute_wall_following_bound(tracks, plots),
    )


def _make_wall_task(hand: str) -> BehaviorTask:
    name = f"wall_{hand}"
    return BehaviorTask(
        name=name,
        does=f"follows the walls of a random room, its {hand} hand on them",
        measured="the loop along the wall closed in 120 s, never more than 1 m away",
        bounded="once around the room, shrunk by 1 m",
        kit=build_world([room(0)], solid=False).kit,
        topics=(make_wall_topic(name, hand, "room", cases=2, seconds=20.0),),
        options={name: LearnerOptions(watched=True, reaction_s=0.2)},
        practice=lambda practice, seed: build_world([room(seed)], solid=False),
        trial=lambda seeds: _make_room_trial(seeds, hand),
        hand=make_wall_expert(hand),
    )


WALL_TASKS = (_make_wall_task(LEFT), _make_wall_task(RIGHT))
