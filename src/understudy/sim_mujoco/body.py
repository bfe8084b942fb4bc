"""Robots in simulated physics as a body: they drive on wheels, hear rays and see rendered pixels.

Beside the physics runs the 2-D world of the same scenario and seed, as a referee. It says where everything is at first,
when intruders come and go and are captured, what is loaded and unloaded, when the goal is reached; it reads locators,
poses, bumpers and chance. Where its robots are, physics tells it, tick by tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import nan

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.library import Kit
from understudy.robots.camera.blobs import Image
from understudy.runtime.body import Channel, Commands, Reading
from understudy.sim import state as snapshots
from understudy.sim.kit import COLUMNS
from understudy.sim.scenario.schema import Scenario
from understudy.sim.view import WorldView
from understudy.sim.world import World
from understudy.sim_mujoco.model import check_physics
from understudy.sim_mujoco.robot_model import scale_to_commands
from understudy.sim_mujoco.sensors import MujocoSensors
from understudy.sim_mujoco.world import BodyPose, MujocoWorld

STUCK = 0.1
"""Who gets less far than this share of the way asked for got nowhere, as in the 2-D world."""
HEAD = 8
"""Bytes that say how long the part of physics in a snapshot is."""


class MujocoBody:
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
        self._senses = MujocoSensors(self.world)
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
        self._senses.clear()

    def follow_pose(self, agent: int, pose: BodyPose) -> tuple[float, float]:
        """Put a robot that is driven elsewhere where it is said to be, at its speeds; the commands that keep them."""
        self.arenas[agent // self.robots].set_pose(agent % self.robots, pose)
        robot = self.world.state.robots[agent]
        robot["x"], robot["y"], robot["heading"] = pose.x, pose.y, pose.heading
        self._senses.clear()
        return scale_to_commands(self._senses.kind(agent), pose.speed, pose.turning)

    def place_objects(self, things: Sequence[tuple[float, float, bool]]) -> None:
        """Objects as somebody else keeps them: of each slot x, y (m) and whether it is there; none come or go by
        themselves from now on.
        """
        objects = self.world.state.objects[0]
        objects["due"] = objects["captured"] = -1
        if len(things) != len(objects):
            return
        objects["x"], objects["y"], objects["present"] = np.array(things, np.float64).reshape(-1, 3).T
        self.arenas[0].place_objects(self.view())
        self.arenas[0].settle()
        self._senses.clear()

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, a world per seed."""
        self.world.reset(seeds)
        self._begin()

    def _begin(self) -> None:
        self.arenas = [MujocoWorld(self.scenario, self.world.view(index)) for index in range(self.worlds)]
        self._asked = np.zeros((self.agents, 2))  # speeds that the wheels are told, m/s and rad/s
        self._senses.begin(self.arenas)

    def image(self, agent: int) -> Image | None:
        """What a robot's camera sees now [H, W, 3]; None where it has none."""
        if not 0 <= agent < self.agents:
            where, remedy = f"world {self.scenario.name!r}", f"give one from 0 to {self.agents - 1}"
            raise SettingError(where=where, setting="agent", problem=f"is {agent}", remedy=remedy)
        return self._senses.image(agent)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [B*N] of these keys, absent (NaN) for robots that have no such sensor."""
        keys = tuple(dict.fromkeys(keys))
        theirs = self.world.sense([key for key in keys if key not in self._senses.keys])
        if len(theirs) == len(keys):
            return theirs
        own = {key: np.full(self.agents, nan) for key in keys if key in self._senses.keys}
        there = ~self.failed
        for agent in np.flatnonzero(there).tolist():
            for key, column in own.items():
                column[agent] = self._senses.read(agent, key)
        return {key: own[key] if key in own else theirs[key] for key in keys}

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel left out rests. An unusable command raises, and nothing moves."""
        table = self.world.check_commands(commands)
        self._senses.update_last_seen()
        table[self.failed] = 0.0
        self._asked = self._speeds(table[:, 0], table[:, 1])
        made = self._asked * self._shares()
        for index, arena in enumerate(self.arenas):
            mine = slice(index * self.robots, (index + 1) * self.robots)
            arena.drive(made[mine])
        self._tell(table)
        self._senses.clear()

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
            arena.place_objects(self.world.view(index))
            arena.settle()

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(channel.name for channel in self.channels)

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
        drawn = np.concatenate([self._senses.draw_noise(index)[:, :2] for index in range(self.worlds)])
        shares: NDArray[np.float64] = (
            1.0 + np.stack([types["noise_drive"], types["noise_turn"]], axis=1) * drawn
        )
        return shares

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        own = snapshots.encode_snapshot(self._called, self._settings(), self._arrays())
        return len(own).to_bytes(HEAD, "little") + own + self.world.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of such worlds."""
        end = HEAD + int.from_bytes(snapshot[:HEAD], "little")
        if not HEAD < end < len(snapshot):
            raise FileError(
                path="snapshot", place="", problem="is not one of physics", remedy="take it again"
            )
        own = snapshots.decode_snapshot(snapshot[HEAD:end], self._called, self._settings(), self._arrays())
        seeds = self.seeds
        self.world.restore(snapshot[end:])
        if self.seeds != seeds:
            self._begin()
        self._asked, self._senses.last = own["asked"], own["last"]
        for index, arena in enumerate(self.arenas):
            arena.restore(own[f"arena{index}"])
        self._senses.clear()

    _called = "physics"

    def _settings(self) -> dict[str, object]:
        settings: dict[str, object] = msgspec.to_builtins(self.scenario)
        return settings

    def _arrays(self) -> dict[str, NDArray[np.float64]]:
        states = {f"arena{index}": arena.state for index, arena in enumerate(self.arenas)}
        return {"asked": self._asked, "last": self._senses.last, **states}
