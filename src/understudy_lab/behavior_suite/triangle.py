"""The task of forming an equilateral triangle: three robots run one automaton, each with its own A and B."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from msgspec.structs import replace

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import YES, Column
from understudy.runtime.body import Commands
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import ArenaRegion, RobotGroup, Scenario, TargetSpec
from understudy.sim.world import World
from understudy.training.trainee import Mode, SessionView
from understudy_lab.behavior_suite.task import (
    RADIUS,
    SPEED,
    BehaviorTask,
    TaskResult,
    TaskTrial,
    alternate_moves,
    make_turn_controller,
    rover,
)
from understudy_lab.behavior_suite.tracks import GroundTruth, Table, has_held_for, wrap_signed
from understudy_lab.teachers.person import find_bearing, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

SIDE_M, WITHIN_M, WITHIN_DEG = 2.0, 0.4, 12.0
HELD_S, LIMIT_S = 5.0, 90.0
ROBOTS = ("ant", "bee", "cat")
BINDINGS = tuple({"A": ROBOTS[k - 2], "B": ROBOTS[k - 1]} for k in range(3))
"""The bindings of each robot: A and B are the two robots after it."""

SCENARIO = Scenario(
    name="triangle",
    about="Three rovers that know where the others are.",
    size=(14.0, 14.0),
    limit_s=LIMIT_S,
    regions={"middle": ArenaRegion(box=(4.0, 4.0, 10.0, 10.0))},
    types={
        name: rover("forward", "backward", "rotate_left", "rotate_right", "wait", team=name)
        for name in ROBOTS
    },
    robots=tuple(RobotGroup(type=name, within="middle", apart=0.6) for name in ROBOTS),
    targets={name: TargetSpec(team=name, doc="A robot.") for name in ROBOTS},
)

GOES_M, THERE_M = 0.15, 0.12
AWAY_M, TOUCHES_M = 9.0, 2 * RADIUS + 0.05
"""No two robots begin so far apart, or so close to each other."""
FACING = 0.15
SEEN_TWICE = 10
TO_AND_FRO_S = 10.0
BEE_AND_CAT = {"A": "bee", "B": "cat"}


def _turned(screen: SessionView, facing: float) -> str | None:
    off = find_bearing(screen)
    if screen.state == "done" or abs(off) < facing:
        return "done"
    if screen.state == "start":
        return "rotate_left" if off > 0 else "rotate_right"
    return "done" if (off < 0) == (screen.state == "rotate_left") and abs(off) < 1.5 else None


def complain_face(screen: SessionView) -> str | None:
    """Return the state to correct facing to, or None: turning past the target, idling, or `done` too early."""
    off = find_bearing(screen)
    if screen.state == "start":
        return _turned(screen, FACING)
    if screen.state == "done":
        return None if abs(off) < 3 * FACING else "rotate_left" if off > 0 else "rotate_right"
    past = off < -2 * FACING if screen.state == "rotate_left" else off > 2 * FACING
    return "done" if past and abs(off) < 1.5 else None


def complain_live_face(screen: SessionView) -> str | None:
    """Return the state to direct facing to in live teaching, or None: also where it stops a little beside the target.

    In live teaching the robot stops by itself from the second time on, so how well it stops is seen more often.
    """
    off = find_bearing(screen)
    if screen.state == "done" and abs(off) > 1.5 * FACING:
        return "rotate_left" if off > 0 else "rotate_right"
    return complain_face(screen)


FACE = LessonPlan(
    "face",
    LessonDesign(
        parameters=["A"], states=["rotate_left", "rotate_right"], flags=["done"], features=["angle_to(A)"]
    ),
    lambda screen: _turned(screen, FACING),
    complain_face,
    has_raised_flag,
    cases=(
        Situation("two wait", {"A": "bee"}, lambda screen: 0.5 < find_bearing(screen) < 2.8),
        Situation("two wait", {"A": "cat"}, lambda screen: -2.8 < find_bearing(screen) < -0.5),
        Situation("two wait", {"A": "bee"}, lambda screen: abs(find_bearing(screen)) < 0.5 * FACING),
    ),
    tries=6,
    limit_s=20.0,
    complain_live=complain_live_face,
)


def choose_settling_action(screen: SessionView, slack: float) -> str | None:
    """Return the next state, or None, for an allowed error of `slack` m: face A, drive on or back, raise `done`."""
    off = screen.features["distance_to(A)"] - SIDE_M
    if screen.state in ("start", "done"):
        return "done" if abs(off) < GOES_M + (slack if screen.state == "done" else 0.0) else "face"
    if screen.state == "face":
        return None if screen.features["done"] != YES else "forward" if off > 0 else "backward"
    return "done" if (off if screen.state == "forward" else -off) < THERE_M - slack else None


def settle_distance(screen: SessionView) -> str | None:
    """Return the state that a robot which switches back and forth should be in."""
    off = screen.features["distance_to(A)"] - SIDE_M
    return "done" if abs(off) < GOES_M else "forward" if off > 0 else "backward"


def complain_live_settle(screen: SessionView) -> str | None:
    """Return the state to direct settling to in live teaching, or None: also where it drives the wrong way."""
    off = screen.features["distance_to(A)"] - SIDE_M
    wrong = screen.state == "forward" and off < -GOES_M, screen.state == "backward" and off > GOES_M
    return settle_distance(screen) if any(wrong) else choose_settling_action(screen, 0.08)


def find_way_out(screen: SessionView) -> str | None:
    """Return the state that leads out of a dead end, or None: it drives past A and away, pushes, or stands wrongly."""
    distance = screen.features["distance_to(A)"]
    away = screen.state == "forward" and distance > AWAY_M
    pushes = screen.state == "backward" and distance < TOUCHES_M
    stands = screen.state in ("start", "done") and abs(distance - SIDE_M) > GOES_M
    return "face" if away or pushes or stands else None


def _at(least: float, most: float) -> Situation:
    return Situation(
        "two wait", {"A": "bee"}, lambda screen: least < screen.features["distance_to(A)"] < most
    )


SETTLE = LessonPlan(
    "settle",
    LessonDesign(
        parameters=["A"],
        states=["face(A)", "forward", "backward"],
        flags=["done"],
        features=["done", "distance_to(A)"],
    ),
    lambda screen: choose_settling_action(screen, 0.0),
    lambda screen: choose_settling_action(screen, 0.08),
    has_raised_flag,
    cases=(_at(2.4, 3.0), _at(1.0, 1.6), _at(2.18, 2.3), _at(1.7, 1.82), _at(2.04, 2.13), _at(1.87, 1.96)),
    tries=6,
    limit_s=40.0,
    complain_live=complain_live_settle,
    settle=settle_distance,
    tries_cases=True,
)


complain_line_up = alternate_moves("settle_A", "settle_B")
"""The correction: where the robot does not go on to the other robot, which may have moved."""


def show_line_up(screen: SessionView) -> str | None:
    """Return the next state, or None: settle with A, then with B, repeatedly, until this was shown twice."""
    return None if screen.examples >= SEEN_TWICE else complain_line_up(screen)


def has_lined_up(screen: SessionView) -> bool:
    """Return whether the robot has gone to and fro for a while: in live teaching, far fewer presses show it."""
    if screen.mode is Mode.LIVE:
        return screen.time_s >= TO_AND_FRO_S
    return screen.time_s >= 2.0 and screen.examples >= SEEN_TWICE


LINE_UP = LessonPlan(
    "line_up",
    LessonDesign(
        parameters=["A", "B"], states=["settle_A=settle(A)", "settle_B=settle(B)"], features=["done"]
    ),
    show_line_up,
    complain_line_up,
    has_lined_up,
    cases=(Situation("two wait", BEE_AND_CAT),) * 2,
    tries=2,
    limit_s=60.0,
)


def practice(name: str, seed: int) -> World:
    """Return a world in which two robots wait two meters apart and the third is anywhere."""
    waiting = (RobotGroup(type="bee", at=((6.0, 7.0, 0.0),)), RobotGroup(type="cat", at=((8.0, 7.0, 0.0),)))
    return World(replace(SCENARIO, robots=(SCENARIO.robots[0], *waiting)), [seed])


class ExpertTriangle:
    """A hand-written controller for the triangle of three robots, which reacts without a person's delay.

    Learned automata are compared with it.
    """

    keys: Sequence[ReadingKey] = tuple((what, name) for name in ROBOTS for what in ("range", "bearing"))

    def __init__(self, world: World) -> None:
        self._turning = make_turn_controller(world.agents)
        self._going = np.zeros(world.agents)
        self._to_b = np.zeros(world.agents, np.bool_)
        self._a, self._b = ([ROBOTS.index(BINDINGS[k % 3][of]) for k in range(world.agents)] for of in "AB")

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        rows = np.arange(len(self._going))
        far = np.stack([percept["range", name] for name in ROBOTS])
        off = wrap_signed(np.stack([percept["bearing", name] for name in ROBOTS]))
        error_a, error_b = far[self._a, rows] - SIDE_M, far[self._b, rows] - SIDE_M
        error = np.where(self._to_b, error_b, error_a)
        self._going = np.where(self._going * error < 0.5 * THERE_M, 0.0, self._going)
        rests = self._going == 0
        self._to_b = np.where(rests, np.abs(error_a) <= GOES_M, self._to_b)
        error = np.where(self._to_b, error_b, error_a)
        self._going = np.where(rests & (np.abs(error) > GOES_M), np.sign(error), self._going)
        faced = np.where(self._to_b, off[self._b, rows], off[self._a, rows])
        turn = self._turning.toward(faced, self._going != 0)
        return {"drive": np.where(turn == 0, self._going, 0.0), "turn": turn}


def sides(tracks: GroundTruth) -> Table:
    """Return the sides of each triangle [3, T+1, B], m; the first is opposite the first robot."""
    x, y = (each.reshape(len(each), -1, 3) for each in (tracks.x, tracks.y))
    return np.stack(
        [np.hypot(x[..., k - 2] - x[..., k - 1], y[..., k - 2] - y[..., k - 1]) for k in range(3)]
    )


def angles(lengths: Table) -> Table:
    """Return the angles of triangles from their sides [3, ...], rad, by the law of cosines."""
    a, b, c = (np.roll(lengths, -k, axis=0) for k in range(3))
    return np.arccos(np.clip((b**2 + c**2 - a**2) / np.maximum(2 * b * c, 1e-9), -1.0, 1.0))


def judge(tracks: GroundTruth) -> TaskResult:
    """Return when sides and angles had been right for five seconds, and the largest error of an angle at the end."""
    lengths = sides(tracks)
    off = np.degrees(np.abs(angles(lengths) - pi / 3)).max(axis=0)
    right = (np.abs(lengths - SIDE_M).max(axis=0) <= WITHIN_M) & (off <= WITHIN_DEG)
    return TaskResult(
        tracks.first(has_held_for(right, tracks.ticks(HELD_S))), {"worst angle off, degrees": off[-1]}
    )


def bound(tracks: GroundTruth) -> Column:
    """Return the least time in s [W]: to correct the worst side at full speed, and to hold the triangle."""
    off = np.abs(sides(tracks)[:, 0] - SIDE_M).max(axis=0) - WITHIN_M
    seconds: Column = np.maximum(0.0, off) / (2 * SPEED) + HELD_S
    return seconds


FEAT = BehaviorTask(
    name="triangle",
    does="three robots line up in an equilateral triangle",
    measured="sides within 0.4 m of 2 m and angles within 12 degrees of 60, for 5 s, in 90 s",
    bounded="straight motion of both ends of the side that is farthest off, plus 5 s",
    kit=make_scenario_kit(SCENARIO),
    topics=(FACE, SETTLE, LINE_UP),
    options={
        "face": LearnerOptions(watched=True, reaction_s=0.2),
        "settle": LearnerOptions(watched=True),
        "line_up": LearnerOptions(watched=True),
    },
    practice=practice,
    trial=lambda seeds: TaskTrial(World(SCENARIO, seeds), LIMIT_S, judge, bound, BINDINGS),
    hand=ExpertTriangle,
    dead_ends={"settle": find_way_out},
)
