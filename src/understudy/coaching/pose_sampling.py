"""Poses: a robot placed in its world, and the values of its features there."""

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
    """Position (m) and heading (rad) of a robot."""

    x: float
    y: float
    heading: float


@runtime_checkable
class Placeable(Protocol):
    """A body whose robots can be placed by hand, such as a simulated one."""

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Place a robot somewhere free; SettingError if the place is not."""
        ...

    def view(self, world: int = 0) -> WorldView:
        """Return one world as plain data."""
        ...


class PoseSampler:
    """Places one robot of a body, and reads the body's features, with parameters bound to `targets`."""

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
        """Draw a random pose: anywhere in the arena, or `near` one of the objects."""
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
        """Draw a pose near another; `wide` is the distance, as a share of the arena and of half a turn."""
        view = self._place.view(self._world)
        off = draws.normal(0.0, wide, 3).tolist()
        size = max(view.width, view.height)
        heading = (pose.heading + off[2] * tau / 2) % tau
        return self._inside(RobotPose(pose.x + off[0] * size, pose.y + off[1] * size, heading))

    def _inside(self, pose: RobotPose) -> RobotPose:
        view = self._place.view(self._world)
        return RobotPose(min(max(pose.x, 0.0), view.width), min(max(pose.y, 0.0), view.height), pose.heading)

    def values(self, pose: RobotPose) -> NDArray[np.float64] | None:
        """Return the values of the features at a pose [F], own features absent; None if the robot cannot be there."""
        try:
            self._place.place(self.agent, *pose)
        except SettingError:
            return None
        return self.read()

    def read(self) -> NDArray[np.float64]:
        """Return the values of the features at the present pose [F], own features absent."""
        values = np.full(len(self._features), np.nan)
        if self._columns:
            percept = self.body.sense(self._sensing.keys)
            values[self._columns] = self._sensing.columns(percept)[:, self.agent]
        return values


def sample_posed_situations(
    body: Body,
    features: Sequence[BoundFeature],
    targets: Mapping[str, str],
    *,
    agent: int = 0,
    count: int = 192,
    seed: int = 0,
) -> NDArray[np.float64]:
    """Sample feature vectors [count at most, F] of one robot at random poses in its world, half of them near objects.

    The automaton's own features are absent. The robot stays where it was placed last.
    """
    poser, draws = PoseSampler(body, agent, features, targets), np.random.default_rng(seed)
    drawn = (poser.values(poser.draw_pose(draws, near=bool(turn % 2))) for turn in range(2 * count))
    vectors = [values for values in drawn if values is not None][:count]
    return np.array(vectors, np.float64).reshape(len(vectors), len(features))
