"""The exercises: practice and test worlds, Understudy's lesson plans, and the flat demonstration."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from understudy.judging.baseline import DecideCommands
from understudy.model.features import ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.body import Body, list_reading_keys
from understudy.runtime.feature_columns import get_feature_key
from understudy.runtime.link import link
from understudy.sim.forage import FORAGE_KIT, Forage, ForageSettings, make_practice_worlds
from understudy.sim.world import World
from understudy_lab.baselines.demonstrations import Robots
from understudy_lab.baselines.flat_teachers import FLAT_FORAGE, FLAT_SERVOING, FLAT_WALLS, FOLLOWING
from understudy_lab.behavior_suite.random_rooms import make_scenario, room
from understudy_lab.behavior_suite.tracks import record
from understudy_lab.behavior_suite.wall_following import LEFT, WALL_LIMIT_S, WALL_TASKS, judge_wall_following
from understudy_lab.forage.teach import make_practice
from understudy_lab.tasks import servo_teacher, soccer
from understudy_lab.tasks.forage_expert import evaluate_expert
from understudy_lab.tasks.forage_teacher import GOTO, TOPICS, WATCHED
from understudy_lab.tasks.servo_teacher import BASIC_STATES, PUSH_S
from understudy_lab.tasks.soccer import PUSHED_LEFT, PUSHED_RIGHT, Soccer, approach, approach_by_hand
from understudy_lab.teachers.teacher import LessonPlan, PushAway

(FEAT,) = (feat for feat in WALL_TASKS if feat.name == f"wall_{LEFT}")


class RoomsWorld(World):
    """Random rooms side by side, with a robot in each."""

    def __init__(self, seeds: Sequence[int]) -> None:
        self.plots = [room(seed) for seed in seeds]
        super().__init__(make_scenario(self.plots, solid=False), [0])


def closes_the_loop(world: Robots, decide: DecideCommands, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Return whether each robot follows the whole wall of its room in time without leaving it."""
    rooms = cast("RoomsWorld", world)
    tracks = record(rooms, lambda: rooms.act(decide(rooms.sense(keys))), WALL_LIMIT_S)
    return ~np.isnan(judge_wall_following(tracks, rooms.plots, LEFT).seconds)


Judge: TypeAlias = Callable[[Robots, DecideCommands, Sequence[ReadingKey]], NDArray[np.bool_]]
"""Whether each world [B] goes well under what decides."""


@dataclass(frozen=True)
class BaselineTask:
    """One exercise for all learners: `topics` teach it to Understudy as a hierarchy, `flat` demonstrates it whole."""

    name: str
    kit: Kit
    world: Callable[[Sequence[int]], Robots]
    judge: Judge
    basics: tuple[str, ...]
    flat: LessonPlan
    topics: tuple[LessonPlan, ...]
    make: Callable[[str, int], Body]
    options: Mapping[str, LearnerOptions]
    targets: Mapping[str, str] = field(default_factory=dict)
    rests: bool = False
    """Whether resting has to be learned, because the robot must report its arrival by resting."""
    pushes: tuple[PushAway | None, ...] = (None,)
    """The pushes by world, in cyclic order, as in Understudy's lessons."""

    @property
    def commands(self) -> list[Mapping[str, float]]:
        """The commands of each basic behavior."""
        return [self.kit.behaviors[name].command for name in self.basics]

    @property
    def kinds(self) -> list[Kind]:
        """The kind of each sensor value of the robots."""
        robots = self.world([0])
        return [
            reading.kind
            for reading in robots.readings
            for _ in (robots.targets if reading.of_targets else (None,))
        ]

    @property
    def chosen(self) -> list[int]:
        """The indices of the sensor values that Understudy's lessons use, for the targets that they bind."""
        library = self.library()
        for topic in self.topics:
            library = library.with_automaton(TrainedAutomaton(topic.choose(library).automaton))
        features = link(library, self.topics[-1].name, self.targets).features
        keys = list_reading_keys(self.world([0]))
        return sorted(keys.index(get_feature_key(feature)) for feature in features)

    def library(self) -> Library:
        """Return the library before anything is taught."""
        return Library(self.kit)


ARENA = make_practice_worlds()["an arena"]
GOTO_S = 60.0
LOST_S = 90.0
SERVOING = 1.5
"""The time limit relative to the hand-written robot; 2 would suffice for policies that turn the wrong way."""


def near_the_station(world: Robots, decide: DecideCommands, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Return whether each robot first rests within reach of the station, and in time."""
    there = np.zeros(world.agents, np.bool_)
    moving = np.ones(world.agents, np.bool_)
    for _ in range(round(GOTO_S / world.tick_s)):
        percept = world.sense((*keys, ("station_here", None)))
        commands = decide(percept)
        resting = moving & ~np.any([column != 0 for column in commands.values()], axis=0)
        there |= resting & (percept["station_here", None] == 1.0)
        moving &= ~resting
        if not moving.any():
            break
        world.act({name: np.where(moving, column, 0.0) for name, column in commands.items()})
    return there


def brings_all_home(world: Robots, decide: DecideCommands, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Return whether each robot brings all food home within three times the time of the hand-written controller.

    A robot fails early when it neither loads nor unloads for the time in which it could cross the arena twice.
    """
    last = np.floor(_limits(tuple(world.seeds)) / world.tick_s)
    stored = np.full(world.agents, np.nan)
    since = np.zeros(world.agents)
    well = np.zeros(world.agents, np.bool_)
    running = np.ones(world.agents, np.bool_)
    tick = 0
    while running.any():
        percept = world.sense((*keys, ("food_stored", None)))
        world.act(decide(percept))
        tick += 1
        changed = percept["food_stored", None] != stored
        stored, since = percept["food_stored", None], np.where(changed, tick, since)
        well |= running & ~np.isnan(world.finished_s)
        running &= ~well & (tick < last) & (tick - since < LOST_S / world.tick_s)
    return well


@lru_cache(4)
def _limits(seeds: tuple[int, ...]) -> Column:
    """Return three times the time of the hand-written controller in each world, s."""
    distinct = list(dict.fromkeys(seeds))
    by_hand = evaluate_expert(ForageSettings(), distinct)
    seconds = 3.0 * np.where(by_hand.finished, by_hand.seconds, by_hand.limit_s)
    return np.array([dict(zip(distinct, seconds.tolist(), strict=True))[seed] for seed in seeds])


def reaches_the_ball(world: Robots, decide: DecideCommands, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Return whether each robot is within 15 cm of the ball within SERVOING times the time of the hand-written one.

    Half of the robots, also the hand-written ones, are pushed aside on their way.
    """
    body = cast("Soccer", world)
    by_hand = _servoed(tuple(body.seeds))
    limit_s = SERVOING * float(np.nanmax(by_hand))
    seconds = approach(
        body, lambda: body.act(decide(body.sense(keys))), pushes=_pushes(body), limit_s=limit_s
    )
    return seconds <= SERVOING * by_hand


def _pushes(body: Soccer) -> dict[int, soccer.Disturbance]:
    """Return the pushes by world: two worlds in four, by their seeds, one to each side."""
    sides = {1: PUSHED_LEFT, 3: PUSHED_RIGHT}
    return {row: sides[seed % 4] for row, seed in enumerate(body.seeds) if seed % 4 in sides}


@lru_cache(4)
def _servoed(seeds: tuple[int, ...]) -> Column:
    """Return the time of the hand-written robot in each world, s."""
    distinct = list(dict.fromkeys(seeds))
    body = Soccer(distinct)
    seconds = dict(zip(distinct, approach_by_hand(body, pushes=_pushes(body)).tolist(), strict=True))
    return np.array([seconds[seed] for seed in seeds])


EXERCISES: Mapping[str, BaselineTask] = {
    exercise.name: exercise
    for exercise in (
        BaselineTask(
            "goto",
            FORAGE_KIT,
            lambda seeds: Forage(seeds, ARENA),
            near_the_station,
            ("forward", "rotate_left", "rotate_right"),
            GOTO,
            (GOTO,),
            make_practice,
            WATCHED,
            targets={"A": "station"},
            rests=True,
        ),
        BaselineTask(
            "forage",
            FORAGE_KIT,
            Forage,
            brings_all_home,
            ("forward", "rotate_left", "rotate_right", "load_food", "unload_food"),
            FLAT_FORAGE,
            TOPICS,
            make_practice,
            WATCHED,
        ),
        BaselineTask(
            "servoing",
            soccer.kit,
            Soccer,
            reaches_the_ball,
            BASIC_STATES,
            FLAT_SERVOING,
            (servo_teacher.topics("left")["four states"],),
            lambda practice, seed: Soccer([seed]),
            {},
            pushes=(
                None,
                PushAway("walk_forward", "turn_left", PUSH_S),
                None,
                PushAway("walk_forward", "turn_right", PUSH_S),
            ),
        ),
        BaselineTask(
            "walls",
            FEAT.kit,
            RoomsWorld,
            closes_the_loop,
            FOLLOWING,
            FLAT_WALLS,
            tuple(FEAT.topics),
            FEAT.practice,
            FEAT.options,
        ),
    )
}
