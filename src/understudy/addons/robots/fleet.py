"""Fleets: several real robots as one body of N agents, in the order of their team's file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.arming_order import ArmingOrder
from understudy.addons.robots.robot import Robot, connect_robot_body, describe_exit_reason
from understudy.addons.robots.robot_file import load_robot, load_team
from understudy.addons.robots.ros.simulation_clock import SimulationClock
from understudy.errors import SettingError
from understudy.model.binding import Binding
from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import ISSUED, SKILL, Channel, Commands, Reading, check_reading_keys
from understudy.sim.kit import MOVING
from understudy.sim.scenario.schema import Scenario
from understudy.sim.skill_parts import SKILL_CHANNELS


class Fleet:
    """The robots of one scenario as a body; readings that one of them does not have are NaN for it.

    Each robot has its own guard and watchdog: if these stop or disarm one, the others continue. A stop by a person or
    the program (`disarm`, `emergency_stop`, `close`) applies to all, one after the other without waiting.

    SettingError is raised if the robot files do not fit together: different scenarios or ticks, one name for
    different readings, or the same topic of commands.
    """

    def __init__(self, robots: Sequence[Robot], *, name: str = "fleet") -> None:
        self.robots, self.name = tuple(robots), name
        self.agents = len(self.robots)
        self._check()
        self.readings: Sequence[Reading] = tuple(self._readings().values())
        self.targets: Sequence[str] = tuple(dict.fromkeys(name for each in robots for name in each.targets))
        skilled = any(robot.file.skills for robot in self.robots)
        self.channels: Sequence[Channel] = (*MOVING, *(SKILL_CHANNELS if skilled else ()))
        self._skills: list[tuple[str, Binding]] = []
        self._channels = [{channel.name for channel in each.channels} for each in self.robots]
        self._offered: dict[tuple[ReadingKey, ...], Sequence[Sequence[ReadingKey]]] = {}
        self._has = [{reading.name: reading.of_targets for reading in each.readings} for each in self.robots]

    @property
    def scenario(self) -> Scenario | None:
        """The scenario whose lessons the robots run; None if their files name none."""
        return self.robots[0].scenario

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, in s."""
        return self.robots[0].tick_s

    @property
    def time_s(self) -> float:
        """The time from connecting the first robot to the beginning of this tick, in s."""
        return self.robots[0].time_s

    @property
    def simulation_clock(self) -> SimulationClock | None:
        """The simulation's clock by which the robots tick, if there is one; that of the first robot."""
        return self.robots[0].simulation_clock

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The robots that squads must not count as members [N]: disarmed, stopped, or silent ones."""
        return np.array([robot.unfitness != "" for robot in self.robots], np.bool_)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return the latest values, a column [N] for each key; NaN where absent."""
        rows = [
            robot.read_values(mine)
            for robot, mine in zip(self.robots, self._list_offered(tuple(keys)), strict=True)
        ]
        return {key: np.array([row.get(key, np.nan) for row in rows]) for key in keys}

    def act(self, commands: Commands) -> None:
        """Command each robot for one tick; if one fails, command the others, then raise the first exception."""
        problems: list[Exception] = []
        for agent, robot in enumerate(self.robots):
            try:
                robot.act(self._select(commands, agent))
            except Exception as error:
                problems.append(error)
        if problems:
            raise problems[0]

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets, for the channel `skill`; robots without the skill stand still."""
        having = [robot for robot in self.robots if name in robot.file.skills]
        for robot in having or self.robots[:1]:
            robot.index_skill(name, binding)
        call = (name, Binding(binding))
        if call not in self._skills:
            self._skills.append(call)
        return self._skills.index(call) + 1

    def _select(self, commands: Commands, agent: int) -> dict[str, Column]:
        """Return the commands of one robot, with the number that it has given to its skill."""
        robot, selected, names = self.robots[agent], dict[str, Column](), self._channels[agent]
        for channel, column in commands.items():
            if channel not in (SKILL, ISSUED) or channel in names:
                selected[channel] = column[agent : agent + 1]
        number = int(selected[SKILL][0]) if SKILL in selected else 0
        if number:
            name, binding = self._skills[number - 1]
            has = name in robot.file.skills
            selected[SKILL] = np.array([float(robot.index_skill(name, binding)) if has else 0.0])
        return selected

    @property
    def armed(self) -> bool:
        """True if any robot is armed."""
        return any(robot.armed for robot in self.robots)

    def arm(self, by: str) -> None:
        """Arm all robots, or none: if one raises an exception, the others are disarmed and it is raised.

        Their watchdogs are started first, in parallel, which blocks for about 0.5 s.
        """
        ArmingOrder(self.robots, by).carry_out()

    def disarm(self, cause: str) -> None:
        """Send a stop to each armed robot and disarm it, even if another one raises an exception."""
        with ExitStack() as each:
            for robot in reversed(self.robots):
                each.callback(robot.disarm, cause)

    def emergency_stop(self, cause: str) -> None:
        """Send a stop to each robot at once and disarm it, armed or not, even if another one raises an exception."""
        with ExitStack() as each:
            for robot in reversed(self.robots):
                each.callback(robot.emergency_stop, cause)

    def hold_key(self, for_s: float) -> None:
        """Count the hold-to-run key of all robots as held for the given time (s), or as released if it is 0."""
        for robot in self.robots:
            robot.hold_key(for_s)

    @property
    def needs_hold_to_run(self) -> bool:
        """True if any robot moves only while a person holds a key."""
        return any(robot.file.safety.hold_to_run for robot in self.robots)

    def close(self, cause: str = "its program left") -> None:
        """Stop and disconnect all robots, even if one raises an exception."""
        with ExitStack() as each:
            for robot in reversed(self.robots):
                each.callback(robot.close, cause)
            self.disarm(cause)  # all of them before any is closed, which takes up to seconds each

    def __iter__(self) -> Iterator[Robot]:
        return iter(self.robots)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self.close(describe_exit_reason(error))

    def _list_offered(self, keys: tuple[ReadingKey, ...]) -> Sequence[Sequence[ReadingKey]]:
        """List for each robot which readings it has; the same are asked for at every tick."""
        if keys not in self._offered:
            where = f"the robots of {self.name}"
            check_reading_keys(keys, readings=self.readings, targets=self.targets, where=where)
            self._offered[keys] = [
                [key for key in keys if self._can(agent, key)] for agent in range(self.agents)
            ]
        return self._offered[keys]

    def _can(self, agent: int, key: ReadingKey) -> bool:
        name, target = key
        of_targets = self._has[agent].get(name)
        if of_targets is None:
            return False
        return target in self.robots[agent].targets if of_targets else target is None

    def _check(self) -> None:
        if not self.robots:
            raise self._wrong("robots", "are none", "give one at least")
        first = self.robots[0]
        for robot in self.robots[1:]:
            if robot.file.world != first.file.world:
                raise self._wrong(
                    f"world of {robot.file.name}",
                    f"is {robot.file.world!r}, that of {first.file.name} is {first.file.world!r}",
                    "give all the same",
                )
            if robot.tick_s != first.tick_s:
                raise self._wrong(
                    f"tick_s of {robot.file.name}",
                    f"is {robot.tick_s:g}, that of {first.file.name} is {first.tick_s:g}",
                    "give all the same",
                )
        taken: dict[str, str] = {}
        for robot in self.robots:
            topic = f"{robot.file.domain}:{robot.file.topic(robot.file.commands.topic)}"
            if topic in taken:
                raise self._wrong(
                    f"namespace of {robot.file.name}",
                    f"is also that of {taken[topic]}: both would get the same commands",
                    "give each its own",
                )
            taken[topic] = robot.file.name

    def _readings(self) -> dict[str, Reading]:
        readings: dict[str, Reading] = {}
        for robot in self.robots:
            for reading in robot.readings:
                before = readings.setdefault(reading.name, reading)
                if (before.kind, before.of_targets) != (reading.kind, reading.of_targets):
                    raise self._wrong(
                        f"readings.{reading.name} of {robot.file.name}",
                        "differs from the reading of this name of another robot",
                        "rename one of the two",
                    )
        return readings

    def _wrong(self, setting: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where=self.name, setting=setting, problem=problem, remedy=remedy)


def connect_robot(path: Path | str, *, recorder: RunRecorder | None = None) -> Fleet:
    """Connect to the robot of a robot file as a fleet of one, optionally with a recorder."""
    robot = connect_robot_body(load_robot(path), path=path, recorder=recorder)
    with ExitStack() as undone:
        undone.callback(robot.close)
        fleet = Fleet([robot], name=robot.file.name)
        undone.pop_all()
    return fleet


def connect_team(path: Path | str, *, recorder: RunRecorder | None = None) -> Fleet:
    """Connect to all robots of a team's file, or to none if one fails, optionally with a recorder."""
    team, paths = load_team(path)
    with ExitStack() as undone:
        robots = []
        for each in paths:
            robots.append(robot := connect_robot_body(load_robot(each), path=each, recorder=recorder))
            undone.callback(robot.close)
        fleet = Fleet(robots, name=team.name)
        undone.pop_all()
    return fleet
