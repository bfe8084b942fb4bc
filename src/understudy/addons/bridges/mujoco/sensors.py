"""Measure the sonar and camera readings of all robots in MuJoCo, at most once a tick."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, cos, nan, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.mujoco.optional import import_mujoco
from understudy.addons.bridges.mujoco.robot_files import calibrate_camera_colors
from understudy.addons.bridges.mujoco.robot_model import find_camera
from understudy.addons.bridges.mujoco.shapes import OBSTACLES, ROBOTS, UNSEEN, WALLS
from understudy.addons.bridges.mujoco.world import MujocoWorld
from understudy.addons.robots.camera.blobs import LEAST_PX, BlobDetector, FrameGeometry, Image
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Column
from understudy.sim.scenario.schema import ElapsedSensor, RobotType, Scenario
from understudy.sim.sensing.sensor_row import RangeScan
from understudy.sim.sensing.sensor_table import BLOBS, find_sensor_row, list_range_scans
from understudy.sim.world import World

APART_DEG = 2.5
"""The largest angle between neighboring rays, degrees: 13 cm at 3 m, less than the width of any solid thing."""
HEIGHT = 0.7
"""The height of rays above the floor, as a share of the robot's radius: within its chassis."""


class RaycastScan:
    """The rays of one range sensor of a type of robots."""

    def __init__(self, robot_type: RobotType, scan: RangeScan) -> None:
        self._radius, self._range = robot_type.radius, scan.range
        rays, self._first = list[tuple[float, float, float]](), list[int]()
        for arc in scan.arcs:
            low, turn = arc.from_deg, arc.to_deg - arc.from_deg
            self._first.append(len(rays))
            width = turn if turn >= 360.0 else turn % 360.0
            angles = np.linspace(radians(low), radians(low + width), ceil(width / APART_DEG) + 1)
            rays += [(cos(angle), sin(angle), 0.0) for angle in angles.tolist()]
        self._rays = np.array(rays)
        groups = {"walls": (WALLS,), "obstacles": (OBSTACLES, UNSEEN), "robots": (ROBOTS,)}
        self._groups = np.zeros(6, np.uint8)
        for each in scan.sees:
            self._groups[list(groups[each])] = 1
        self._hit = np.zeros(len(rays), np.int32)
        self._far = np.zeros(len(rays))

    def distances(self, model: Any, data: Any, body: int) -> Column:
        """Return the distance (m, from the rim) to the nearest thing in each arc; the sensor's range if none."""
        turn: NDArray[np.float64] = data.xmat[body].reshape(3, 3)
        flat = np.array([turn[0, 0], turn[1, 0], 0.0])
        ahead = flat / np.linalg.norm(flat)
        left = np.array([-ahead[1], ahead[0], 0.0])
        rays = self._rays[:, :1] * ahead + self._rays[:, 1:2] * left
        start = np.array([*data.xpos[body][:2], HEIGHT * self._radius])
        limit = self._range + self._radius
        import_mujoco().mj_multiRay(
            model,
            data,
            start,
            rays.ravel(),
            self._groups,
            1,
            body,
            self._hit,
            self._far,
            None,
            len(rays),
            limit,
        )
        reached = np.where(self._far < 0.0, limit, self._far)
        nearest: Column = np.minimum.reduceat(reached, self._first)
        return np.clip(nearest - self._radius, 0.0, self._range)


BLOB_X, BLOB_SIZE = (each.name for each in BLOBS)


class MujocoSensors:
    """The distances, color blobs and times since a blob was seen that MuJoCo measures for all robots of a `World`.

    That world gives all other readings. `last` [B*N, T] is the time (s) at which each target was last seen; NaN if
    never.
    """

    def __init__(self, world: World) -> None:
        scenario = world.scenario
        self._world, self._names = world, list(scenario.types)
        self._eyes = {name: _decoding(scenario, name) for name in scenario.types}
        self._scans = {
            name: [(scan, RaycastScan(kind, scan)) for scan in list_range_scans(kind)]
            for name, kind in scenario.types.items()
        }
        self._since = [
            (kind, each)
            for kind in scenario.types.values()
            for each in kind.sensors
            if isinstance(each, ElapsedSensor) and each.of in (BLOB_X, BLOB_SIZE)
        ]
        self._noisy = max(sum(len(scan.arcs) for scan, _ in of) for of in self._scans.values())
        self.keys = self._own_keys()
        """The readings that this object measures."""

    def begin(self, arenas: Sequence[MujocoWorld]) -> None:
        """Start to measure in these worlds, one per seed; nothing has been seen yet."""
        self._arenas = arenas
        self.last = np.full((self._world.agents, len(self._world.targets)), nan)
        self.clear()

    def clear(self) -> None:
        """Discard the measurements and random numbers of this tick."""
        self._ranges: dict[int, dict[ReadingKey, float]] = {}
        self._blobs: dict[int, dict[ReadingKey, float]] = {}
        self._drawn: dict[int, NDArray[np.float64]] = {}

    def image(self, agent: int) -> Image | None:
        """Render the image of a robot's camera [H, W, 3]; None if it has no camera."""
        arena, robot = self._at(agent)
        camera = find_camera(self.kind(agent))
        return None if camera is None else arena.image(robot, camera)

    def kind(self, agent: int) -> RobotType:
        """Return the type of a robot."""
        arena, robot = self._at(agent)
        kind: RobotType = arena.kinds[robot]
        return kind

    def _at(self, agent: int) -> tuple[MujocoWorld, int]:
        """Return the physics world of a robot, and its number in that world."""
        world, robot = divmod(agent, self._world.robots)
        return self._arenas[world], robot

    def _name(self, agent: int) -> str:
        return self._names[int(self._world.state.robots["type"][agent])]

    def draw_noise(self, index: int) -> NDArray[np.float64]:
        """Return standard normal numbers [N, 2 + D] for a world's robots: driving, turning, D distances."""
        if index not in self._drawn:
            tick, seed = int(self._world.state.tick[index]), self._world.seeds[index]
            self._drawn[index] = np.random.default_rng((seed, tick)).standard_normal(
                (self._world.robots, 2 + self._noisy)
            )
        return self._drawn[index]

    def read(self, agent: int, key: ReadingKey) -> float:
        """Return the value of one reading of a robot in this tick; NaN if it is absent."""
        name, target = key
        if target is None:
            return float(self._ranged(agent).get(key, nan))
        if name in (BLOB_X, BLOB_SIZE):
            return self._seen(agent).get(key, nan)
        kind = self.kind(agent)
        if not any(of is kind and each.name == name for of, each in self._since):
            return nan
        if not np.isnan(self._seen(agent).get((BLOB_X, target), nan)):
            return 0.0
        return self._world.time_s - float(self.last[agent, self._world.targets.index(target)])

    def _ranged(self, agent: int) -> dict[ReadingKey, float]:
        """Return the readings of a robot's range sensors in this tick."""
        if agent not in self._ranges:
            self._ranges[agent] = ranges = {}
            (arena, robot), drawn = self._at(agent), 2
            for scan, rays in self._scans[self._name(agent)]:
                far = rays.distances(arena.model, arena.data, int(arena.built.bodies[robot]))
                if scan.noise:
                    noise = self.draw_noise(agent // self._world.robots)[robot, drawn : drawn + len(far)]
                    far = np.where(far < scan.range, (far + scan.noise * noise).clip(0.0, scan.range), far)
                drawn += len(far)
                ranges.update({(name, None): each for name, each in scan.summarize(far.tolist()).items()})
        return self._ranges[agent]

    def _seen(self, agent: int) -> dict[ReadingKey, float]:
        """Return the blobs in a robot's camera image in this tick."""
        if agent not in self._blobs:
            detector, image = self._eyes[self._name(agent)], self.image(agent)
            self._blobs[agent] = {} if detector is None or image is None else detector.readings(image)
        return self._blobs[agent]

    def update_last_seen(self) -> None:
        """Record which targets each robot sees now, if some sensor measures the time since then."""
        if not self._since:
            return
        now = self._world.time_s
        for agent in np.flatnonzero(~self._world.failed).tolist():
            for (name, target), value in self._seen(agent).items():
                if name == BLOB_X and target is not None and not np.isnan(value):
                    self.last[agent, self._world.targets.index(target)] = now

    def _own_keys(self) -> frozenset[ReadingKey]:
        """Return the readings that are measured in physics rather than in the 2-D world."""
        ranges = {
            (reading.name, None)
            for kind in self._world.scenario.types.values()
            for sensor in kind.sensors
            if (row := find_sensor_row(sensor)).scan is not None
            for reading in row.readings(sensor)
        }
        of_targets = {each.name for _, each in self._since}
        if any(self._eyes.values()):
            of_targets |= {BLOB_X, BLOB_SIZE}
        return frozenset(ranges | {(name, target) for name in of_targets for target in self._world.targets})


def _decoding(scenario: Scenario, name: str) -> BlobDetector | None:
    """Return the detector of blobs for the images of a type's camera; None if it has no camera."""
    camera = find_camera(scenario.types[name])
    if camera is None:
        return None
    frame = FrameGeometry(camera.width_px, camera.height_px, camera.view_deg)
    return BlobDetector(
        calibrate_camera_colors(scenario, name), frame=frame, least_px=max(LEAST_PX, camera.least_px)
    )
