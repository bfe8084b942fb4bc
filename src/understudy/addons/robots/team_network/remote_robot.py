"""Robots of a team whose agents run elsewhere, as bodies that a studio trains and draws.

Such a robot has the readings that its agent sends. While it is driven, it gets the command of each tick as a message
with a short lease; its agent obeys through its own guard. All other decisions stay with its agent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, nan
from pathlib import Path
from secrets import randbits
from threading import Lock

import msgspec
import numpy as np

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import POSE, RobotFile
from understudy.addons.robots.ros.transport import Answered, Publish, Publisher, Received, WireType
from understudy.addons.robots.safety.guard import ArmingRefused
from understudy.addons.robots.team_network.team_watch import NO_ANSWER, TeamWatch
from understudy.errors import SettingError
from understudy.model.features import ReadingKey
from understudy.runtime.agents.messages import Duty, UnreadableMessage, compute_layout
from understudy.runtime.agents.training_link import (
    TRAINER_LEASE_S,
    MemberView,
    TrainerCommand,
    decode_member_view,
    trainer_command_key,
    view_key,
)
from understudy.runtime.body import SKILL, Commands, list_reading_keys

STALE_S = 0.5
"""The age in s from which the readings of an agent count as absent."""


class SilentTransport:
    """A transport over which nothing goes: the robot's own agent speaks with it."""

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Do nothing."""

    def publisher(self, topic: str, type: str) -> Publish:
        """Return a function that does nothing."""
        return lambda data: None

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Answer that there is no server."""
        answered(None)

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Do nothing."""

    def find_service_problem(self, service: str, type: WireType) -> str:
        """Return that services are asked by the robot's agent."""
        return "is asked by the robot's own agent"

    def peers(self) -> Sequence[Publisher]:
        """Return no publishers."""
        return ()

    def close(self) -> None:
        """Do nothing."""


class RemoteInputs(SensorInputs):
    """The inputs of a robot as its agent has sent them last."""

    def __init__(self, file: RobotFile, path: Path | str, targets: Sequence[str]) -> None:
        super().__init__(file, SilentTransport(), path=path, targets=targets)
        self.camera = None
        self.view: MemberView | None = None

    def value(self, reading: str, now: float) -> float:
        """Return a part of the robot's pose; NaN if it is unknown."""
        if self.view is None or reading not in POSE:
            return nan
        return self.view.pose[POSE.index(reading)]

    def locate(self, target: str, now: float) -> tuple[float, float] | None:
        """Return the place (x, y) of a target, or None if it is unknown."""
        return None if self.view is None else self.view.places.get(target)


class RemoteRobot(Robot):
    """A robot of a team whose agent runs on another computer.

    Parameters
    ----------
    file
        The content of its file.
    path
        The file.
    watch
        The team that is watched; its clock is the robot's, too.
    """

    def __init__(self, file: RobotFile, path: Path | str, watch: TeamWatch) -> None:
        super().__init__(file, SilentTransport(), path=path, clock=watch.clock)
        self._inputs = RemoteInputs(file, path, self.targets)
        self.senses = self._inputs
        self._watch = watch
        self._views = watch.network.listen(view_key(file.name))
        self._keys = list_reading_keys(self)
        self._layout = compute_layout(self._keys)
        self._heard_s = -inf
        self._start, self._sequence = randbits(53), 0
        self._calls: list[Duty] = []
        self.is_driven = False
        """Whether this program drives it; its agent decides otherwise."""
        self._is_armed_here = False
        self._arming = Lock()

    @property
    def armed(self) -> bool:
        """Whether its agent has armed it, as far as is known."""
        watched = self._watch.find_agent(self.file.name)
        return watched.status is not None and not watched.is_silent and watched.status.armed is True

    @property
    def stop_cause(self) -> str:
        """Why it does not move; empty while it may."""
        watched = self._watch.find_agent(self.file.name)
        if watched.status is None or watched.is_silent:
            return "its agent is silent" if watched.is_present else "its agent is not there"
        return "" if watched.status.unfit == "is being trained" else watched.status.unfit

    @property
    def unfitness(self) -> str:
        """Why it must not be counted as a member of its squad; empty if it is fit."""
        return self.stop_cause

    def read_values(self, keys: Sequence[ReadingKey]) -> dict[ReadingKey, float]:
        """Return what its agent has sent last, a number for each key; NaN where absent or too old."""
        now = self._clock()
        self._at = now
        for data in self._views.take_all():
            try:
                view = decode_member_view(data)
            except UnreadableMessage:
                continue
            if self._fits(view):
                self._inputs.view, self._heard_s = view, now
        latest = self._inputs.view
        values: Mapping[ReadingKey, float] = {}
        if latest is not None and now - self._heard_s <= STALE_S:
            values = dict(zip(self._keys, latest.readings, strict=True))
        return {key: values.get(key, nan) for key in keys}

    def _fits(self, view: MemberView) -> bool:
        sizes = len(view.readings), len(view.pose)
        return view.layout == self._layout and sizes == (len(self._keys), len(POSE))

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets, for the channel `skill`."""
        super().index_skill(name, binding)
        call = (name, dict(binding))
        if call not in self._calls:
            self._calls.append(call)
        return self._calls.index(call) + 1

    def act(self, commands: Commands) -> None:
        """Send the command of this tick, if this program drives the robot.

        SettingError is raised if the team's file names no trainer.
        """
        if not self.is_driven:
            return
        if not self._trainer:
            raise SettingError(
                where=f"team {self._watch.team.name}", setting="agents.trainer", problem="is missing",
                remedy='add trainer = "NAME" to [agents] in the file of every agent, to train robots from here',
            )  # fmt: skip
        self._sequence += 1
        values = {channel: float(np.asarray(column)[0]) for channel, column in commands.items()}
        number = int(values.pop(SKILL, 0.0))
        message = TrainerCommand(
            trainer=self._trainer,
            start=self._start,
            sequence=self._sequence,
            sent_s=self._clock(),
            lease_s=TRAINER_LEASE_S,
            commands=values,
            skill=self._calls[number - 1] if number else None,
        )
        self._watch.network.publish(trainer_command_key(self.file.name), msgspec.msgpack.encode(message))

    @property
    def _trainer(self) -> str:
        return self._watch.team.settings.trainer or ""

    def prepare(self) -> None:
        """Ask its agent to prepare arming; raise SettingError if it cannot."""
        self._refuse(self._watch.order("ready", "the studio", self.file.name))

    def arm(self, by: str, *, stop_count: int | None = None) -> None:
        """Ask its agent to arm it, because the person `by` orders it, and wait for the answer.

        SettingError is raised if the agent refuses or does not answer, ArmingRefused if another thread stopped the
        robot since the order: `stop_count` is that of the moment of the order, if that was earlier. Unless it refused,
        its agent is then asked to stop it.
        """
        with self._arming:
            stop_count = self.stop_count if stop_count is None else stop_count
            self._refuse_stopped(stop_count)
            self._is_armed_here = True  # before the answer, which may get lost
            try:
                problem = self._watch.order("arm", by, self.file.name)
            except BaseException:
                self.emergency_stop("arming failed")
                raise
            was_stopped = stop_count != self.stop_count  # and the agent may have got the stop first
            if was_stopped or problem == NO_ANSWER:
                self.emergency_stop("arming failed")
            elif problem:
                self._is_armed_here = False
            if was_stopped:
                self._refuse_stopped(stop_count)
            self._refuse(problem)

    def _refuse_stopped(self, stop_count: int) -> None:
        if stop_count != self.stop_count:
            raise ArmingRefused(robot=self.file.name, problem="it was stopped meanwhile", remedy="arm again")

    def _refuse(self, problem: str) -> None:
        if problem:
            raise SettingError(
                where=f"robot {self.file.name!r}", setting="arming", problem=f"was refused: {problem}",
                remedy="remove the cause, then arm it again",
            )  # fmt: skip

    def disarm(self, cause: str = "disarmed") -> None:
        """Ask its agent to stop it, if it was armed by this program or is driven by it; cancel arming under way."""
        self.guard.disarm(cause)  # it is never armed here: it counts the stops
        if self._is_armed_here or (self.is_driven and self.armed):
            self._is_armed_here = False
            self._watch.order_soon("stop", f"the studio: {cause}", self.file.name)

    def emergency_stop(self, cause: str) -> None:
        """Ask its agent to stop it at once; cancel arming under way."""
        self.guard.disarm(cause)
        self._is_armed_here = False
        self._watch.order_soon("stop", f"the studio: {cause}", self.file.name)

    def hold_key(self, for_s: float) -> None:
        """Do nothing: a hold-to-run key must be held at the robot's own computer."""

    def close(self, cause: str = "its program left") -> None:
        """Drive it no longer; wait for the end of arming that was cancelled, at which its agent is asked to stop it."""
        self.is_driven = False
        with self._arming:
            pass


def make_remote_fleet(watch: TeamWatch) -> Fleet:
    """Make the fleet of all robots of a team that is watched.

    Parameters
    ----------
    watch
        The team.

    Returns
    -------
    Fleet
        The robots, in the order of the team's file.
    """
    robots = [RemoteRobot(file, path, watch) for file, path in watch.team.robots.values()]
    return Fleet(robots, name=watch.team.name)


def drive_robots(fleet: Fleet, agents: Sequence[int]) -> None:
    """Drive these robots of a fleet from now on, by their numbers, and no others; local robots are always driven."""
    for number, robot in enumerate(fleet):
        if isinstance(robot, RemoteRobot):
            robot.is_driven = number in agents
