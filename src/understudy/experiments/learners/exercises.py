"""What is learned: worlds to practice and to be judged in, how Understudy is taught it, how a person shows it flat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.evaluation import Decide, judge_expert, measure
from understudy.experiments.forage.teaching import make_practice
from understudy.experiments.learners.shown_flat import FLAT_FORAGE
from understudy.model.feature import ReadingKey
from understudy.model.kit import Kit
from understudy.model.lesson import Options
from understudy.model.library import Library
from understudy.runtime.body import Body
from understudy.training.demonstrators.forager import GOTO, TOPICS, WATCHED
from understudy.training.demonstrators.teacher import Topic
from understudy.worlds.forage import Forage, kit
from understudy.worlds.forage_settings import ForageSettings, practices
from understudy.worlds.world import World

Judge: TypeAlias = Callable[[World, Decide, Sequence[ReadingKey]], NDArray[np.bool_]]
"""Whether each world [B] goes well under what decides."""


@dataclass(frozen=True)
class Exercise:
    """One task, to be learned by everybody: `topics` teach it to Understudy as a hierarchy, `flat` shows it whole."""

    name: str
    kit: Kit
    world: Callable[[Sequence[int]], World]
    judge: Judge
    basics: tuple[str, ...]
    flat: Topic
    topics: tuple[Topic, ...]
    make: Callable[[str, int], Body]
    options: Mapping[str, Options]
    targets: Mapping[str, str] = field(default_factory=dict)
    rests: bool = False
    """Whether resting is something to be learned: the robot has to say when it is there."""

    @property
    def commands(self) -> list[Mapping[str, float]]:
        """What each of its basic behaviors commands."""
        return [self.kit.behaviors[name].command for name in self.basics]

    def library(self) -> Library:
        """What there is before anything is taught."""
        return Library(self.kit)


ARENA = practices()["an arena"]
GOTO_S = 60.0


def near_the_station(world: World, decide: Decide, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Whether each robot, when it first rests, is within reach of the station, and rests in time."""
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


def brings_all_home(world: World, decide: Decide, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Whether each robot brings all food home within three times the time of a forager written by hand."""
    seeds = list(dict.fromkeys(world.seeds))
    by_hand = judge_expert(ForageSettings(), seeds)
    limit = dict(zip(seeds, 3.0 * np.where(by_hand.finished, by_hand.seconds, by_hand.limit_s), strict=True))
    return measure(world, decide, keys, limit_s=np.array([limit[seed] for seed in world.seeds])).finished


EXERCISES: Mapping[str, Exercise] = {
    exercise.name: exercise
    for exercise in (
        Exercise(
            "goto",
            kit,
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
        Exercise(
            "forage",
            kit,
            Forage,
            brings_all_home,
            ("forward", "rotate_left", "rotate_right", "load_food", "unload_food"),
            FLAT_FORAGE,
            TOPICS,
            make_practice,
            WATCHED,
        ),
    )
}
