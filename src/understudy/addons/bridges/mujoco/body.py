"""A body whose robots drive on wheels in MuJoCo, measure distances with rays and see rendered images.

A 2-D world of the same scenario and seed runs beside the physics. It lays out the world, and decides when objects
appear, vanish and are captured, when food is loaded and unloaded, and when the goal is reached. It also gives the
readings of locators, poses, bumpers and chance. Its robots are moved to their places in physics in each tick, except
those that carry out a skill: its stand-in in the 2-D world moves them, through everything.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import nan

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.mujoco.model import check_physics
from understudy.addons.bridges.mujoco.robot_model import scale_to_commands
from understudy.addons.bridges.mujoco.sensors import MujocoSensors
from understudy.addons.bridges.mujoco.world import BodyPose, MujocoWorld
from understudy.addons.robots.camera.blobs import Image
from understudy.errors import SettingError
from understudy.model.drawing import call_markup, format_number_of, format_repr
from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import ISSUED, SKILL, Commands
from understudy.sim.kit import COLUMNS
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World
from understudy.sim.world_wrapper import WorldWrapper

STUCK = 0.1
"""The share of the commanded way below which a robot counts as blocked, as in the 2-D world."""


class MujocoBody(WorldWrapper):
    """A body of the robots of B worlds of a scenario in MuJoCo, one world per seed.

    Row w*N + i is robot i of world w. Cameras have no pixel noise, and sensors measure in every tick. ExtraMissing if
    MuJoCo is not installed; SettingError for a scenario with boxes to push or pull.
    """

    snapshot_name = "physics"

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,)) -> None:
        check_physics(scenario)
        super().__init__(World(scenario, seeds))
        self._senses = MujocoSensors(self.world)
        self._begin()

    def __repr__(self) -> str:
        robots, worlds = format_number_of(self.robots, "robot"), format_number_of(self.worlds, "world")
        return format_repr(self, f"of {self.scenario.name!r}", f"{robots} in {worlds}")

    def _repr_svg_(self) -> str:
        return call_markup("run_plot:draw_world_svg", self.view())

    @property
    def delivered(self) -> NDArray[np.int64]:
        """The units of food that robots have unloaded at a home, per world [B]."""
        return self.world.delivered

    @property
    def gathered(self) -> NDArray[np.int64]:
        """The number of boxes gathered, per world [B]: always 0, since physics has no boxes."""
        return self.world.gathered

    @property
    def failed(self) -> NDArray[np.bool_]:
        """A flag per robot [B*N]: true if it has failed, as its scenario says or by `freeze`."""
        return self.world.failed

    def freeze(self, agent: int) -> None:
        """Make a robot fail: from now on all its readings are absent (NaN), and it does not move.

        Parameters
        ----------
        agent
            Index of the robot, from 0 to B*N - 1.
        """
        self.world.freeze(agent)

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Move a robot to a free place, where it rests.

        Parameters
        ----------
        agent
            Index of the robot, from 0 to B*N - 1.
        x
            Coordinate of its center, m.
        y
            Coordinate of its center, m.
        heading
            The direction that it faces, rad from the x axis to the left.

        Raises
        ------
        SettingError
            If the place is not free.
        """
        self.world.place(agent, x, y, heading)
        self.arenas[agent // self.robots].place(agent % self.robots, x, y, heading)
        self._asked[agent] = 0.0
        self._senses.clear()

    def follow_pose(self, agent: int, pose: BodyPose) -> tuple[float, float]:
        """Set a robot to a pose and speeds that were simulated elsewhere.

        Parameters
        ----------
        agent
            Index of the robot, from 0 to B*N - 1.
        pose
            Its place (m), heading (rad) and speeds (m/s and rad/s).

        Returns
        -------
        tuple of float
            The commands of the channels `drive` and `turn`, each from -1 to 1, that keep these speeds.
        """
        self.arenas[agent // self.robots].set_pose(agent % self.robots, pose)
        robot = self.world.state.robots[agent]
        robot["x"], robot["y"], robot["heading"] = pose.x, pose.y, pose.heading
        self._senses.clear()
        return scale_to_commands(self._senses.kind(agent), pose.speed, pose.turning)

    def place_objects(self, things: Sequence[tuple[float, float, bool]]) -> None:
        """Set the objects of world 0 to states from another process: x, y (m) and presence of each slot.

        From then on no object appears or vanishes by itself. A list of another length than the number of slots is
        ignored.

        Parameters
        ----------
        things
            A tuple (x, y, present) for each slot.
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
        """Restart all worlds at time 0, laid out by new seeds.

        Parameters
        ----------
        seeds
            One whole number from 0 to 2**63 - 1 per world; as many as before. SettingError otherwise.
        """
        self.world.reset(seeds)
        self._begin()

    def _begin(self) -> None:
        self.arenas = [MujocoWorld(self.scenario, self.world.view(index)) for index in range(self.worlds)]
        self._asked = np.zeros((self.agents, 2))  # speeds that the wheels are told, m/s and rad/s
        self._senses.begin(self.arenas)

    def image(self, agent: int) -> Image | None:
        """Render the image of a robot's camera.

        Parameters
        ----------
        agent
            Index of the robot, from 0 to B*N - 1. SettingError if there is none.

        Returns
        -------
        Image or None
            Red, green and blue of each pixel, 0 to 255 [H, W, 3]; None if the robot has no camera.
        """
        if not 0 <= agent < self.agents:
            where, remedy = f"world {self.scenario.name!r}", f"give one from 0 to {self.agents - 1}"
            raise SettingError(where=where, setting="agent", problem=f"is {agent}", remedy=remedy)
        return self._senses.image(agent)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return a column [B*N] for each key; NaN for robots without that sensor or that have failed."""
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
        """Advance all worlds by one tick under these commands; omitted channels are 0, invalid ones raise an error."""
        table = self.world.check_commands(commands)
        self._senses.update_last_seen()
        carried = self.world.begin_skills(commands)
        table[self.failed] = table[carried] = 0.0
        self._asked = self._speeds(table[:, 0], table[:, 1])
        self._asked[carried] = 0.0
        commanded = self._asked * self._shares()
        for index, arena in enumerate(self.arenas):
            mine = range(index * self.robots, (index + 1) * self.robots)
            arena.lift([agent - mine.start for agent in carried if agent in mine])
            arena.drive(commanded[mine.start : mine.stop])
        skills = {name: commands[name] for name in (SKILL, ISSUED) if name in commands}
        self._tell(table, skills, carried)
        self._senses.clear()

    def _tell(self, table: NDArray[np.float64], skills: Commands, carried: Sequence[int]) -> None:
        """Copy the robots' places into the 2-D world, advance it by a tick, and copy what it moved into physics.

        It moves the objects, and the robots that carry out a skill.
        """
        poses = np.array(
            [arena.pose(robot) for arena in self.arenas for robot in range(self.robots)], np.float64
        )
        state = self.world.state.robots
        moved = np.hypot(poses[:, 0] - state["x"], poses[:, 1] - state["y"])
        width, height = self.scenario.size
        state["x"], state["y"] = np.clip(poses[:, 0], 0.0, width), np.clip(poses[:, 1], 0.0, height)
        state["heading"] = poses[:, 2]
        blocked = state["blocked"].copy()
        busy = (table[:, :2] != 0.0).any(axis=1)  # a robot that drives or turns neither loads nor unloads
        table = table.copy()
        table[:, :2] = 0.0
        table[:, 2:4][busy] = 0.0
        self.world.act({**skills, **{name: table[:, COLUMNS.index(name)] for name in self._names}})
        wanted = np.abs(self._asked[:, 0]) * self.tick_s
        state = self.world.state.robots
        state["blocked"] = np.where((wanted > 0.0) & (moved < STUCK * wanted), blocked + 1, 0)
        state["speed"], state["spin"] = poses[:, 3] * self.tick_s, poses[:, 4] * self.tick_s
        for agent in carried:
            state["speed"][agent] = state["spin"][agent] = 0.0
            place = (float(state[name][agent]) for name in ("x", "y", "heading"))
            self.arenas[agent // self.robots].place(agent % self.robots, *place)
        for index, arena in enumerate(self.arenas):
            arena.place_objects(self.world.view(index))
            arena.settle()

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(channel.name for channel in self.channels if channel.name in COLUMNS)

    def _speeds(self, drive: Column, turn: Column) -> NDArray[np.float64]:
        """Return the commanded speeds [B*N, 2] (m/s, rad/s), changed no faster than accelerations permit."""
        types = self.world.rules.types[self.world.state.robots["type"]]
        wanted = np.stack(
            [drive.clip(-1.0, 1.0) * types["speed"], turn.clip(-1.0, 1.0) * types["turning"]], axis=1
        )
        most = np.stack([types["acceleration"], types["turning_acceleration"]], axis=1) / self.tick_s
        speeds: NDArray[np.float64] = np.clip(wanted / self.tick_s, self._asked - most, self._asked + most)
        return speeds

    def _shares(self) -> NDArray[np.float64]:
        """Return factors [B*N, 2] of the commanded speeds: the noise of robot types, in addition to that of physics."""
        types = self.world.rules.types[self.world.state.robots["type"]]
        drawn = np.concatenate([self._senses.draw_noise(index)[:, :2] for index in range(self.worlds)])
        shares: NDArray[np.float64] = (
            1.0 + np.stack([types["noise_drive"], types["noise_turn"]], axis=1) * drawn
        )
        return shares

    def restore(self, snapshot: bytes) -> None:
        """Set the state of all worlds, bit for bit, to that of a snapshot.

        Parameters
        ----------
        snapshot
            The result of `snapshot`. FileError if it was taken in a world of another scenario or number of worlds.
        """
        seeds = self.seeds
        own = self._restore_worlds(snapshot)
        if self.seeds != seeds:
            self._begin()
        self._asked, self._senses.last = own["asked"], own["last"]
        for index, arena in enumerate(self.arenas):
            arena.restore(own[f"arena{index}"])
        self._senses.clear()

    def _settings(self) -> dict[str, object]:
        settings: dict[str, object] = msgspec.to_builtins(self.scenario)
        return settings

    def _arrays(self) -> dict[str, NDArray[np.float64]]:
        states = {f"arena{index}": arena.state for index, arena in enumerate(self.arenas)}
        return {"asked": self._asked, "last": self._senses.last, **states}
