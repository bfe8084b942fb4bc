"""Poses: a robot put somewhere, and what its features read there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin, tau
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.features import BoundFeature
from understudy.runtime.body import Body
from understudy.runtime.feature_columns import FeatureColumns
from understudy.sim.view import WorldView


class RobotPose(NamedTuple):
    """Where a robot stands, m, and where it looks, rad."""

    x: float
    y: float
    heading: float


@runtime_checkable
class Placeable(Protocol):
    """A body whose robots can be put elsewhere by hand: simulated ones."""

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere free; SettingError where it is not."""
        ...

    def view(self, world: int = 0) -> WorldView:
        """One world as plain data."""
        ...


class PoseSampler:
    """Puts one robot of a body here and there, and reads the body's features, whose parameters stand for `targets`."""

    def __init__(
        self, body: Body, agent: int, features: Sequence[BoundFeature], targets: Mapping[str, str]
    ) -> None:
        if not isinstance(body, Placeable):
            raise SettingError(
                where="coach",
                setting="body",
                problem="has no robots that can be put elsewhere",
                remedy="drive the robot into position yourself",
            )
        self.body, self._place, self.agent = body, body, agent
        self._features = tuple(features)
        self._columns = [column for column, bound in enumerate(self._features) if not bound.is_own]
        ground = [
            BoundFeature(self._features[column].feature, self._features[column].binding.substitute(targets))
            for column in self._columns
        ]
        self._sensing = FeatureColumns(ground, body)
        self._world = agent // len(body.view(0).robots)

    def draw_pose(self, draws: np.random.Generator, *, near: bool) -> RobotPose:
        """A pose drawn at random: anywhere in the arena, or `near` one of the things in it."""
        view = self._place.view(self._world)
        heading = float(draws.random()) * tau
        things = [*zip(view.objects.x.tolist(), view.objects.y.tolist(), strict=True)]
        if not near or not things:
            return RobotPose(float(draws.random()) * view.width, float(draws.random()) * view.height, heading)
        x, y = things[int(draws.integers(len(things)))]
        far = float(draws.random()) ** 2 * max(view.width, view.height) / 2
        side = float(draws.random()) * tau
        return self._inside(RobotPose(x + far * cos(side), y + far * sin(side), heading))

    def draw_nearby_pose(self, pose: RobotPose, draws: np.random.Generator, wide: float) -> RobotPose:
        """A pose a little off another; `wide` is how far, as a share of the arena and of half a turn."""
        view = self._place.view(self._world)
        off = draws.normal(0.0, wide, 3).tolist()
        size = max(view.width, view.height)
        heading = (pose.heading + off[2] * tau / 2) % tau
        return self._inside(RobotPose(pose.x + off[0] * size, pose.y + off[1] * size, heading))

    def _inside(self, pose: RobotPose) -> RobotPose:
        view = self._place.view(self._world)
        return RobotPose(min(max(pose.x, 0.0), view.width), min(max(pose.y, 0.0), view.height), pose.heading)

    def values(self, pose: RobotPose) -> NDArray[np.float64] | None:
        """What the features read there [F], the automaton's own left absent; None where the robot cannot stand."""
        try:
            self._place.place(self.agent, *pose)
        except SettingError:
            return None
        return self.read()

    def read(self) -> NDArray[np.float64]:
        """What the features read where the robot is [F], the automaton's own left absent."""
        found = np.full(len(self._features), np.nan)
        if self._columns:
            percept = self.body.sense(self._sensing.keys)
            found[self._columns] = self._sensing.columns(percept)[:, self.agent]
        return found


def sample_posed_situations(
    body: Body,
    features: Sequence[BoundFeature],
    targets: Mapping[str, str],
    *,
    agent: int = 0,
    count: int = 192,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Feature vectors [count at most, F] of one robot put here and there in its world, half of it near things.

    The automaton's own features are left absent. The robot is left where it was put last.
    """
    poser, draws = PoseSampler(body, agent, features, targets), np.random.default_rng(seed)
    drawn = (poser.values(poser.draw_pose(draws, near=bool(turn % 2))) for turn in range(2 * count))
    found = [values for values in drawn if values is not None][:count]
    return np.array(found, np.float64).reshape(len(found), len(features))
