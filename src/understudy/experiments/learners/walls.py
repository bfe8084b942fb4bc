"""Following the walls of random rooms with the left hand on them, as in the repertoire."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from understudy.evaluation import Decide
from understudy.experiments.learners.recording import Robots
from understudy.experiments.repertoire.plots import laid_out, room
from understudy.experiments.repertoire.rooms import FEATS, LIMIT_S, judged
from understudy.experiments.repertoire.tracks import record
from understudy.experiments.repertoire.walls import LEFT
from understudy.model.feature import ReadingKey
from understudy.worlds.world import World

(FEAT,) = (feat for feat in FEATS if feat.name == f"wall_{LEFT}")


class Rooms(World):
    """Random rooms side by side, a robot in each."""

    def __init__(self, seeds: Sequence[int]) -> None:
        self.plots = [room(seed) for seed in seeds]
        super().__init__(laid_out(self.plots, solid=False), [0])


def closes_the_loop(world: Robots, decide: Decide, keys: Sequence[ReadingKey]) -> NDArray[np.bool_]:
    """Whether each robot goes all along the wall of its room in time, and never far from it."""
    rooms = cast(Rooms, world)
    tracks = record(rooms, lambda: rooms.act(decide(rooms.sense(keys))), LIMIT_S)
    return ~np.isnan(judged(tracks, rooms.plots, LEFT).seconds)
