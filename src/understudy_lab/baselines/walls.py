"""Following the walls of random rooms with the left hand on them, as in the repertoire."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.evaluation import Decide
from understudy.model.features import ReadingKey
from understudy.sim.world import World
from understudy_lab.baselines.recording_body import Robots
from understudy_lab.behavior_suite.random_rooms import laid_out, room
from understudy_lab.behavior_suite.rooms import WALL_LIMIT_S, WALL_TASKS, judge_wall_following
from understudy_lab.behavior_suite.tracks import record
from understudy_lab.behavior_suite.wall_following import LEFT

(FEAT,) = (feat for feat in WALL_TASKS if feat.name == f"wall_{LEFT}")


class Rooms(World):
    """Random rooms side by side, a robot in each."""

    def __init__(self, seeds: Sequence[int]) -> None:
        self.plots = [room(seed) for seed in seeds]
        super().__init__(laid_out(self.plots, solid=False), [0])


def closes_the_loop(world: Robots, decide: Decide, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Whether each robot goes all along the wall of its room in time, and never far from it."""
    rooms = cast(Rooms, world)
    tracks = record(rooms, lambda: rooms.act(decide(rooms.sense(keys))), WALL_LIMIT_S)
    return ~np.isnan(judge_wall_following(tracks, rooms.plots, LEFT).seconds)
