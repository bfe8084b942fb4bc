"""The task of driving a figure eight around two targets: circle A on one side, B on the other, in turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import ArenaRegion, ObjectClass, RobotGroup, Scenario, TargetSpec
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.task import (
    SPEED,
    BehaviorTask,
    TaskResult,
    TaskTrial,
    alternate_moves,
    rover,
)
from understudy_lab.behavior_suite.tracks import GroundTruth, Table, Yes, count_reached_in_turn, wrap_signed
from understudy_lab.teachers.person import Seen, after, find_bearing, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

EIGHTS, BEHIND_M, LIMIT_S = 2, 2.0, 150.0
LEFT, RIGHT = 1, -1
SIDES = {LEFT: "left", RIGHT: "right"}

SCENARIO = Scenario(
    name="eight",
    about="A rover, and two poles to trace a figure eight around.",
    size=(12.0, 12.0),
    limit_s=LIMIT_S,
    objects=(
        ObjectClass(name="red_pole", color="red", within="middle", apart=1.8),
        ObjectClass(name="blue_pole", color="blue", within="middle", apart=1.8),
    ),
    regions={"middle": ArenaRegion(box=(3.0, 3.0, 9.0, 9.0))},
    types={"rover": rover("forward", "veer_left", "veer_right")},
    robots=(RobotGroup(type="rover", apart=0.5),),
    targets={
        "red_pole": TargetSpec(object="red_pole", doc="One pole."),
        "blue_pole": TargetSpec(object="blue_pole", doc="The other."),
    },
)

LEAST, STRAIGHT, BACK, MOST = 0.12, 0.35, 0.85, 1.65
"""Where the pole is to be, how far aside, rad: a robot that has it less than least aside, or more than most, veers
until it is between straight and back; so it comes nearer leg by leg, and in the end goes around it.
"""
LEAVING = (0.2, 0.7)
"""The bearings of the other pole, toward its future side, at which to leave for it, rad."""


def choose_circling_action(state: str, aside: float, side: int, slack: float = 0.0) -> str | None:
    """Return the next state of a robot that circles a pole seen `aside` rad to the given side, or None."""
    toward, off = f"veer_{SIDES[side]}", f"veer_{SIDES[-side]}"
    if aside > MOST + slack:
        return toward
    if aside < LEAST - slack:
        return off
    straight = (state == toward and aside < BACK - slack) or (state == off and aside > STRAIGHT + slack)
    return "forward" if state == "start" or straight else None


def circle(side: int) -> LessonPlan:
    """Return the plan of circling A, which stays to the left of the robot (`side` 1) or to its right (-1)."""
    name, across = f"circle_{SIDES[side]}", PushAway("forward", f"veer_{SIDES[side]}", 2.2)

    def show(screen: SessionView) -> str | None:
        return choose_circling_action(screen.state, side * find_bearing(screen), side)

    def complain(screen: SessionView) -> str | None:
        return choose_circling_action(screen.state, side * find_bearing(screen), side, slack=0.4)

    return LessonPlan(
        name,
        LessonDesign(
            parameters=["A"], states=["forward", "veer_left", "veer_right"], features=["angle_to(A)"]
        ),
        show,
        complain,
        after(25.0),
        cases=(
            Situation("poles", {"A": "red_pole"}, _at(side, 0.3, 1.2), after(15.0)),
            Situation("poles", {"A": "blue_pole"}, _at(side, 2.0, 2.9), _straight, push=across),
        ),
        tries=4,
        limit_s=50.0,
    )


def _straight(screen: SessionView) -> bool:
    return screen.state == "forward"


def _at(side: int, least: float, most: float) -> Seen:
    """Return a predicate: the pole is between `least` and `most` rad to the given side."""
    return lambda screen: least < side * find_bearing(screen) < most


def lap(side: int) -> LessonPlan:
    """Return the plan of going around A until B comes ahead, to be passed on the other side."""
    name, circling = f"lap_{SIDES[side]}", f"circle_{SIDES[side]}"

    def wanted(screen: SessionView, least: float) -> str | None:
        if screen.state == "start":
            return circling
        return "done" if least < -side * find_bearing(screen, "B") < LEAVING[1] else None

    def complain(screen: SessionView) -> str | None:
        if screen.state == "done":
            return None if 0.0 < -side * find_bearing(screen, "B") < 1.1 else circling
        return wanted(screen, LEAVING[0] + 0.15)

    return LessonPlan(
        name,
        LessonDesign(
            parameters=["A", "B"], states=[f"{circling}(A)"], flags=["done"], features=["angle_to(B)"]
        ),
        lambda screen: wanted(screen, LEAVING[0]),
        complain,
        has_raised_flag,
        cases=(
            Situation("poles", {"A": "red_pole", "B": "blue_pole"}, _turned_from),
            Situation("poles", {"A": "blue_pole", "B": "red_pole"}, _turned_from),
        ),
        tries=8,
        limit_s=60.0,
    )


def _turned_from(screen: SessionView) -> bool:
    """Return whether B is behind the robot."""
    return abs(find_bearing(screen, "B")) > 1.5


LAPS = alternate_moves("lap_left", "lap_right")
"""The rule that alternates between a lap around A and one around B."""

EIGHT = LessonPlan(
    "eight",
    LessonDesign(parameters=["A", "B"], states=["lap_left(A, B)", "lap_right(B, A)"], features=["done"]),
    LAPS,
    LAPS,
    lambda screen: screen.time_s >= 40.0 and screen.examples >= 6,
    cases=(Situation("poles", {"A": "red_pole", "B": "blue_pole"}),),
    tries=1,
    limit_s=120.0,
)


class ExpertFigureEight:
    """A hand-written controller for the same task that reacts at once."""

    keys: Sequence[ReadingKey] = (("bearing", "red_pole"), ("bearing", "blue_pole"))

    def __init__(self, world: World) -> None:
        self._first = np.ones(world.agents, np.bool_)
        self._steer = np.zeros(world.agents)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        red, blue = wrap_signed(percept["bearing", "red_pole"]), -wrap_signed(percept["bearing", "blue_pole"])
        other = np.where(self._first, blue, red)
        self._first ^= (LEAVING[0] < other) & (other < LEAVING[1])
        aside = np.where(self._first, red, blue)
        begun = np.where(aside > MOST, 1.0, np.where(aside < LEAST, -1.0, 0.0))
        goes_on = ((self._steer > 0) & (aside > BACK)) | ((self._steer < 0) & (aside < STRAIGHT))
        self._steer = np.where((begun == 0) & goes_on, self._steer, begun)
        side = np.where(self._first, LEFT, RIGHT)
        return {"drive": np.where(self._steer == 0, 1.0, 0.8), "turn": 0.6 * self._steer * side}


def judge(tracks: GroundTruth) -> TaskResult:
    """Return when two eights were complete (behind A, behind B, and so on, five times), and how many there were."""
    count = count_reached_in_turn(find_passings(tracks))
    return TaskResult(tracks.first(count > 2 * EIGHTS), {"eights": np.maximum(count[-1] - 1, 0) / 2})


def find_passings(tracks: GroundTruth) -> Yes:
    """Return whether the line behind A (counter-clockwise) and B (clockwise) was crossed within 2 m [T+1, W, 2]."""
    a, b = (
        np.stack([tracks.objects_x[:, :, k], tracks.objects_y[:, :, k]])
        for k in (slot_of("red"), slot_of("blue"))
    )
    place = np.stack([tracks.x, tracks.y])
    return np.stack([_crossed(place, a, b, LEFT), _crossed(place, b, a, RIGHT)], axis=2)


def slot_of(color: str) -> int:
    """Return the index of a pole among a world's objects, where each class is followed by its spare ones."""
    world = World(SCENARIO, [0])
    return int(world.rules.classes["first"][world.names.classes.index(f"{color}_pole")])


def _crossed(place: Table, pole: Table, other: Table, side: int) -> Yes:
    """Return the crossings of the line from a pole away from the other, counter-clockwise (1) or clockwise (-1)."""
    away = (pole - other) / np.hypot(*(pole - other))
    off = place - pole
    along = off[0] * away[0] + off[1] * away[1]
    aside = side * (away[0] * off[1] - away[1] * off[0])
    crossed = np.zeros(along.shape, np.bool_)
    crossed[1:] = (aside[:-1] < 0) & (aside[1:] >= 0) & (along[1:] > 0) & (along[1:] < BEHIND_M)
    return crossed


def bound(tracks: GroundTruth) -> Column:
    """Return the time in s [W] of the straight lines from pole to pole, four times, at full speed."""
    red, blue = slot_of("red"), slot_of("blue")
    x, y = tracks.objects_x[0], tracks.objects_y[0]
    apart: Column = np.hypot(x[:, red] - x[:, blue], y[:, red] - y[:, blue])
    return 2 * EIGHTS * apart / SPEED


def _trial(seeds: Sequence[int]) -> TaskTrial:
    return TaskTrial(World(SCENARIO, seeds), LIMIT_S, judge, bound, ({"A": "red_pole", "B": "blue_pole"},))


FEAT = BehaviorTask(
    name="eight",
    does="traces a figure eight around two targets",
    measured="two complete figure eights in 150 s",
    bounded="straight lines from target to target",
    kit=make_scenario_kit(SCENARIO),
    topics=(circle(LEFT), circle(RIGHT), lap(LEFT), lap(RIGHT), EIGHT),
    options={
        **{f"circle_{side}": LearnerOptions(watched=True, reaction_s=0.2) for side in SIDES.values()},
        **{f"lap_{side}": LearnerOptions(watched=True, reaction_s=0.2) for side in SIDES.values()},
        "eight": LearnerOptions(watched=True),
    },
    practice=lambda practice, seed: World(SCENARIO, [seed]),
    trial=_trial,
    hand=ExpertFigureEight,
)
