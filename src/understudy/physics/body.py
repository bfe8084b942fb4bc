"""Robots in simulated physics as a body: they drive on wheels, hear rays and see rendered pixels.

Beside the physics runs the 2-D world of the same scenario and seed, as a referee. It says where everything is at first,
when intruders come and go and are captured, what is loaded and unloaded, when the goal is reached; it reads locators,
poses, bumpers and chance. Where its robots are, physics tells it, tick by tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import nan, radians

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.model.feature import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.kit import Kit
from understudy.physics.arena import Arena, Pose
from understudy.physics.model import check_physics
from understudy.physics.ranging import Ranging
from understudy.physics.robot_files import colors_of
from understudy.physics.rover import camera_of
from understudy.robots.camera import LEAST_PX, Frame, Image
from understudy.robots.camera import Camera as Decoding
from understudy.runtime.body import Channel, Commands, Reading
from understudy.worlds import snapshots
from understudy.worlds.kits import CAMERA, COLUMNS
from understudy.worlds.scenario import RobotType, Scenario, Since, Sonar
from understudy.worlds.view import WorldView
from understudy.worlds.world import World

BLOB_X, BLOB_SIZE = (each.name for each in CAMERA)
STUCK = 0.1
"""Who gets less far than this share of the way asked for got nowhere, as in the 2-D world."""
HEAD = 8
"""Bytes that say how long the part of physics in a snapshot is."""


class Physics:
    """A body of the robots of B worlds of a scenario in physics, one world per seed; ExtraMissing without MuJoCo.

    Row w*N + i is robot i of world w. Cameras add no noise to their pixels, and sensors answer in every tick.
    SettingError for a scenario with boxes to push or pull.
    """

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,)) -> None:
        check_physics(scenario)
        self.world = World(scenario, seeds)
        self.scenario = scenario
        self.readings: Sequence[Reading] = self.world.readings
        self.channels: Sequence[Channel] = self.world.channels
        self.targets: Sequence[str] = self.world.targets
        self.agents, self.worlds, self.robots = self.world.agents, self.world.worlds, self.world.robots
        self.tick_s = self.world.tick_s
        self._eyes = {name: _decoding(scenario, name) for name in scenario.types}
        self._sonars = {
            name: [(sonar, Ranging(kind, sonar)) for sonar in kind.sensors if isinstance(sonar, Sonar)]
            for name, kind in scenario.types.items()
        }
        self._since = [
            (kind, each)
            for kind in scenario.types.values()
            for each in kind.sensors
            if isinstance(each, Since) and each.of in (BLOB_X, BLOB_SIZE)
        ]
        self._own = self._own_keys()
        self._begin()

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that go with the scenario."""
        return self.world.kit

    @property
    def time_s(self) -> float:
        """Time since the last reset, s."""
        return self.world.time_s

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each world."""
        return self.world.seeds

    @property
    def finished_s(self) -> Column:
        """When each world reached its goal [B], s; absent where it has not."""
        return self.world.finished_s

    @property
    def delivered(self) -> NDArray[np.int64]:
        """Units of food brought home in each world [B]."""
        return self.world.delivered

    @property
    def gathered(self) -> NDArray[np.int64]:
        """Boxes brought home in each world [B]: none."""
        return self.world.gathered

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which robots have failed [B*N]."""
        return self.world.failed

    def view(self, world: int = 0) -> WorldView:
        """One world as plain data, for drawing."""
        return self.world.view(world)

    def freeze(self, agent: int) -> None:
        """Let a robot fail: it senses nothing and moves no more."""
        self.world.freeze(agent)

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere free, at rest."""
        self.world.place(agent, x, y, heading)
        self.arenas[agent // self.robots].place(agent % self.robots, x, y, heading)
        self._asked[agent] = 0.0
        self._forget()

    def follow(self, agent: int, pose: Pose) -> tuple[float, float]:
        """Put a robot that is driven elsewhere where it is said to be, at its speeds; the commands that keep them."""
        kind = self._kind(agent)
        self.arenas[agent // self.robots].put(agent % self.robots, pose)
        robot = self.world.state.robots[agent]
        robot["x"], robot["y"], robot["heading"] = pose.x, pose.y, pose.heading
        self._forget()
        return pose.speed / kind.speed, pose.turning / radians(kind.turning_deg)

    def show(self, things: Sequence[tuple[float, float, bool]]) -> None:
        """Objects as somebody else keeps them: of each slot x, y (m) and whether it is there; none come or go by
        themselves from now on.
        """
        objects = self.world.state.objects[0]
        objects["due"] = objects["captured"] = -1
        if len(things) != len(objects):
            return
        objects["x"], objects["y"], objects["present"] = np.array(things, np.float64).reshape(-1, 3).T
        self.arenas[0].show(self.view())
        self.arenas[0].settle()
        self._forget()

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, a world per seed."""
        self.world.reset(seeds)
        self._begin()

    def _begin(self) -> None:
        self.arenas = [Arena(self.scenario, self.world.view(index)) for index in range(self.worlds)]
        self._asked = np.zeros((self.agents, 2))  # speeds that the wheels are told, m/s and rad/s
        self._last = np.full((self.agents, len(self.targets)), nan)  # when each was last seen, s
        self._forget()

    def _forget(self) -> None:
        """What was sensed in this tick is no more."""
        self._ranges: dict[int, dict[ReadingKey, float]] = {}
        self._blobs: dict[int, dict[ReadingKey, float]] = {}
        self._drawn: dict[int, NDArray[np.float64]] = {}

    def image(self, agent: int) -> Image | None:
        """What a robot's camera sees now [H, W, 3]; None where it has none."""
        camera = camera_of(self._kind(agent))
        return (
            None if camera is None else self.arenas[agent // self.robots].image(agent % self.robots, camera)
        )

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [B*N] of these keys, absent (NaN) for robots that have no such sensor."""
        keys = tuple(dict.fromkeys(keys))
        theirs = self.world.sense([key for key in keys if key not in self._own])
        if len(theirs) == len(keys):
            return theirs
        own = {key: np.full(self.agents, nan) for key in keys if key in self._own}
        there = ~self.failed
        for agent in np.flatnonzero(there).tolist():
            for key, column in own.items():
                column[agent] = self._read(agent, key)
        return {key: own[key] if key in own else theirs[key] for key in keys}

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel left out rests. An unusable command raises, and nothing moves."""
        table = self.world.commanded(commands)
        self._note_seen()
        table[self.failed] = 0.0
        self._asked = self._speeds(table[:, 0], table[:, 1])
        made = self._asked * self._shares()
        for index, arena in enumerate(self.arenas):
            mine = slice(index * self.robots, (index + 1) * self.robots)
            arena.drive(made[mine])
        self._tell(table)
        self._forget()

    def _tell(self, table: NDArray[np.float64]) -> None:
        """Tell the referee where all robots have got to, have it go on by a tick, and follow what it decides."""
        poses = np.array(
            [arena.pose(robot) for arena in self.arenas for robot in range(self.robots)], np.float64
        )
        state = self.world.state.robots
        moved = np.hypot(poses[:, 0] - state["x"], poses[:, 1] - state["y"])
        width, height = self.scenario.size
        state["x"], state["y"] = np.clip(poses[:, 0], 0.0, width), np.clip(poses[:, 1], 0.0, height)
        state["heading"] = poses[:, 2]
        blocked = state["blocked"].copy()
        busy = (table[:, :2] != 0.0).any(axis=1)  # who drives or turns neither loads nor unloads
        table = table.copy()
        table[:, :2] = 0.0
        table[:, 2:4][busy] = 0.0
        self.world.act({name: table[:, COLUMNS.index(name)] for name in self._names})
        wanted = np.abs(self._asked[:, 0]) * self.tick_s
        state = self.world.state.robots
        state["blocked"] = np.where((wanted > 0.0) & (moved < STUCK * wanted), blocked + 1, 0)
        state["speed"], state["spin"] = poses[:, 3] * self.tick_s, poses[:, 4] * self.tick_s
        for index, arena in enumerate(self.arenas):
            arena.show(self.world.view(index))
            arena.settle()

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(channel.name for channel in self.channels)

    def _kind(self, agent: int) -> RobotType:
        kind: RobotType = self.arenas[agent // self.robots].kinds[agent % self.robots]
        return kind

    def _type_name(self, agent: int) -> str:
        return list(self.scenario.types)[int(self.world.state.robots["type"][agent])]

    def _speeds(self, drive: Column, turn: Column) -> NDArray[np.float64]:
        """What commands ask for [B*N, 2], no further from what was asked last than accelerations allow."""
        types = self.world.rules.types[self.world.state.robots["type"]]
        wanted = np.stack(
            [drive.clip(-1.0, 1.0) * types["speed"], turn.clip(-1.0, 1.0) * types["turning"]], axis=1
        )
        most = np.stack([types["acceleration"], types["turning_acceleration"]], axis=1) / self.tick_s
        speeds: NDArray[np.float64] = np.clip(wanted / self.tick_s, self._asked - most, self._asked + most)
        return speeds

    def _shares(self) -> NDArray[np.float64]:
        """What comes of the speeds asked for [B*N, 2]: the noise of the scenario's types, beside that of physics."""
        types = self.world.rules.types[self.world.state.robots["type"]]
        drawn = np.concatenate([self._noise(index)[:, :2] for index in range(self.worlds)])
        shares: NDArray[np.float64] = (
            1.0 + np.stack([types["noise_drive"], types["noise_turn"]], axis=1) * drawn
        )
        return shares

    def _noise(self, index: int) -> NDArray[np.float64]:
        """Numbers from the normal distribution for each robot of a world, in this tick: driving, turning, sonar."""
        if index not in self._drawn:
            tick, seed = int(self.world.state.tick[index]), self.seeds[index]
            most = max((len(each.names) for of in self._sonars.values() for _, each in of), default=0)
            self._drawn[index] = np.random.default_rng((seed, tick)).standard_normal((self.robots, 2 + most))
        return self._drawn[index]

    def _own_keys(self) -> frozenset[ReadingKey]:
        """Readings that physics gives; the referee has all others."""
        sonars = {
            (name, None) for each in self._sonars.values() for _, ranging in each for name in ranging.names
        }
        of_targets = {each.name for _, each in self._since}
        if any(self._eyes.values()):
            of_targets |= {BLOB_X, BLOB_SIZE}
        return frozenset(sonars | {(name, target) for name in of_targets for target in self.targets})

    def _read(self, agent: int, key: ReadingKey) -> float:
        """The value of one reading now."""
        name, target = key
        if target is None:
            return float(self._ranged(agent).get(key, nan))
        if name in (BLOB_X, BLOB_SIZE):
            return self._seen(agent).get(key, nan)
        kind = self._kind(agent)
        if not any(of is kind and each.name == name for of, each in self._since):
            return nan
        if not np.isnan(self._seen(agent).get((BLOB_X, target), nan)):
            return 0.0
        return self.time_s - float(self._last[agent, self.targets.index(target)])

    def _ranged(self, agent: int) -> dict[ReadingKey, float]:
        """The sonar of a robot in this tick."""
        if agent not in self._ranges:
            self._ranges[agent] = found = {}
            arena, robot = self.arenas[agent // self.robots], agent % self.robots
            for sonar, ranging in self._sonars[self._type_name(agent)]:
                far = ranging.distances(arena.model, arena.data, int(arena.built.bodies[robot]))
                if sonar.noise:
                    noise = self._noise(agent // self.robots)[robot, 2 : 2 + len(far)]
                    far = np.where(far < sonar.range, (far + sonar.noise * noise).clip(0.0, sonar.range), far)
                found.update(
                    {(name, None): float(each) for name, each in zip(ranging.names, far, strict=True)}
                )
        return self._ranges[agent]

    def _seen(self, agent: int) -> dict[ReadingKey, float]:
        """The blobs in a robot's picture in this tick."""
        if agent not in self._blobs:
            eye, image = self._eyes[self._type_name(agent)], self.image(agent)
            self._blobs[agent] = {} if eye is None or image is None else eye.readings(image)
        return self._blobs[agent]

    def _note_seen(self) -> None:
        """Note who sees what, where a sensor tells since when it did not."""
        if not self._since:
            return
        now = self.time_s
        for agent in np.flatnonzero(~self.failed).tolist():
            for (name, target), value in self._seen(agent).items():
                if name == BLOB_X and target is not None and not np.isnan(value):
                    self._last[agent, self.targets.index(target)] = now

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        own = snapshots.pack(self._called, self._settings(), self._arrays())
        return len(own).to_bytes(HEAD, "little") + own + self.world.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of such worlds."""
        end = HEAD + int.from_bytes(snapshot[:HEAD], "little")
        if not HEAD < end < len(snapshot):
            raise FileError(
                path="snapshot", place="", problem="is not one of physics", remedy="take it again"
            )
        own = snapshots.unpack(snapshot[HEAD:end], self._called, self._settings(), self._arrays())
        seeds = self.seeds
        self.world.restore(snapshot[end:])
        if self.seeds != seeds:
            self._begin()
        self._asked, self._last = own["asked"], own["last"]
        for index, arena in enumerate(self.arenas):
            arena.restore(own[f"arena{index}"])
        self._forget()

    _called = "physics"

    def _settings(self) -> dict[str, object]:
        settings: dict[str, object] = msgspec.to_builtins(self.scenario)
        return settings

    def _arrays(self) -> dict[str, NDArray[np.float64]]:
        states = {f"arena{index}": arena.state for index, arena in enumerate(self.arenas)}
        return {"asked": self._asked, "last": self._last, **states}


def _decoding(scenario: Scenario, name: str) -> Decoding | None:
    """What reads the pictures of a type's camera; None where it has none."""
    camera = camera_of(scenario.types[name])
    if camera is None:
        return None
    frame = Frame(camera.width_px, camera.height_px, camera.view_deg)
    return Decoding(colors_of(scenario, name), frame=frame, least_px=max(LEAST_PX, camera.least_px))
