"""The base task in Mesa 3: agents in its (experimental) ContinuousSpace, activated in two stages.

It is as fast as Mesa's own parts allow: distances come from `calculate_distances` as one array, of which the minimum is
taken (its `get_nearest_neighbors` also makes lists of agents); the 20 beacons are plain numbers; positions are written
in place, which skips the space's check of its bounds. Robots do not collide. The space measures all distances for each
agent, which grows with the square of their number; `kd_tree` uses SciPy's tree instead, as an expert user would.
"""

from __future__ import annotations

from importlib import import_module
from math import atan2, cos, inf, nan, pi, sin, sqrt
from random import Random
from typing import Any

import numpy as np

from understudy.model.value_kinds import TAU
from understudy_lab.bench import standard_task
from understudy_lab.bench.harness import PeerMissing
from understudy_lab.bench.standard_task import AHEAD, ARRIVED, PERSONAL, Column


class MesaBase:
    """N robots in a Mesa model."""

    def __init__(self, robots: int, *, kd_tree: bool = False) -> None:
        self.robots = robots
        self._model = _parts(kd_tree=kd_tree)
        self.reset()

    def reset(self, seed: int = 0) -> None:
        """Make a new model, at the start."""
        self.model = self._model(standard_task.StartLayout.of(self.robots, seed))

    def run(self, ticks: int) -> None:
        """Run the given number of ticks."""
        for _ in range(ticks):
            self.model.step()

    @property
    def places(self) -> Column:
        """Return x, y and heading [N, 3]."""
        return np.array([(*robot.position, robot.heading) for robot in self.model.agents])

    @property
    def readings(self) -> Column:
        """Return range and bearing of the nearest beacon and robot [N, 4] at the last tick."""
        return np.array([robot.readings for robot in self.model.agents])


def _parts(*, kd_tree: bool) -> Any:
    """Return the model's class; Mesa is imported only when needed."""
    try:
        mesa = import_module("mesa")
        spaces = import_module("mesa.experimental.continuous_space")
        tree = import_module("scipy.spatial").cKDTree  # Mesa brings SciPy
    except ImportError:
        raise PeerMissing(peer="Mesa 3") from None

    class Robot(spaces.ContinuousSpaceAgent):  # type: ignore[misc, name-defined]
        def __init__(self, model: Any, index: int, x: float, y: float, heading: float) -> None:
            super().__init__(model.space, model)
            self.position = np.array((x, y))
            self.index, self.heading = index, heading
            self.readings = (nan, nan, nan, nan)

        def sense(self) -> None:
            x, y = self.position.tolist()
            best, dx, dy = inf, nan, nan
            for beacon_x, beacon_y in self.model.beacons:
                u, v = beacon_x - x, beacon_y - y
                squared = u * u + v * v
                if squared < best:
                    best, dx, dy = squared, u, v
            angle = (atan2(dy, dx) - self.heading) % TAU
            nearest, distance = self.model.nearest(self)
            if distance > standard_task.SIGHT:
                self.readings = (sqrt(best), angle, nan, nan)
                return
            other_x, other_y = self.space.agent_positions[nearest].tolist()
            bearing = (atan2(other_y - y, other_x - x) - self.heading) % TAU
            self.readings = (sqrt(best), angle, distance, bearing)

        def act(self) -> None:
            beacon, angle, robot, bearing = self.readings
            if robot < PERSONAL and (bearing < pi / 2 or bearing >= TAU - pi / 2):
                turn = -standard_task.TURN if bearing < pi else standard_task.TURN
            elif beacon < ARRIVED:
                return
            elif angle < AHEAD or angle >= TAU - AHEAD:
                x, y = self.position.tolist()
                low, high = self.model.bounds
                x += standard_task.STEP * cos(self.heading)
                y += standard_task.STEP * sin(self.heading)
                self.position[:] = min(max(x, low), high), min(max(y, low), high)
                return
            else:
                turn = standard_task.TURN if angle < pi else -standard_task.TURN
            self.heading = (self.heading + turn) % TAU

    class Swarm(mesa.Model):  # type: ignore[misc, name-defined]
        def __init__(self, start: standard_task.StartLayout) -> None:
            super().__init__(seed=0)
            robots = len(start.x)
            side = standard_task.side(robots)
            self.bounds = (standard_task.RADIUS, side - standard_task.RADIUS)
            self.space = spaces.ContinuousSpace([[0, side], [0, side]], random=Random(0), n_agents=robots)
            self.beacons = list(zip(start.beacon_x.tolist(), start.beacon_y.tolist(), strict=True))
            places = zip(start.x.tolist(), start.y.tolist(), start.heading.tolist(), strict=True)
            for index, (x, y, heading) in enumerate(places):
                Robot(self, index, x, y, heading)

        def step(self) -> None:
            self.before()
            self.agents.do("sense")
            self.agents.do("act")

        def before(self) -> None:
            """Prepare one tick, before any agent senses."""

        def nearest(self, robot: Any) -> tuple[int, float]:
            distances, _ = self.space.calculate_distances(robot.position)
            distances[robot.index] = inf
            nearest = int(distances.argmin())
            return nearest, float(distances[nearest])

    class SwarmWithTree(Swarm):
        def before(self) -> None:
            distances, indices = tree(self.space.agent_positions).query(self.space.agent_positions, k=2)
            self.distances, self.indices = distances[:, 1].tolist(), indices[:, 1].tolist()

        def nearest(self, robot: Any) -> tuple[int, float]:
            return self.indices[robot.index], self.distances[robot.index]

    return SwarmWithTree if kd_tree else Swarm
