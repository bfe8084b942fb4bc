"""Twins: a scenario whose robots are real ones. It is drawn as a world is, and moves only as they do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, isnan, nan, tau
from typing import TypeAlias

import msgspec
import numpy as np

from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Kit
from understudy.robots.fleet import Fleet
from understudy.robots.inputs import POSE
from understudy.robots.recording.header import SCENARIO, RunInfo
from understudy.robots.recording.recorder import RunRecorder
from understudy.robots.robot_file import TargetPlaceSpec
from understudy.robots.ros.state_topic import StateChangePublisher
from understudy.runtime.body import Channel, Commands, Reading, list_reading_keys
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import RobotGroup, Scenario
from understudy.sim.state import WorldParams, WorldState
from understudy.sim.view import WorldView
from understudy.sim.world import World

Paths: TypeAlias = Callable[[], Sequence[Sequence[str]]]
"""The states of all levels of each robot, as they were decided last."""


class DigitalTwin:
    """The robots of a fleet in the scenario that their files name: a Body with its readings, targets and channels.

    What robots do not sense is absent. Where they are is drawn by their readings `x`, `y` and `heading`, from the
    corner of the first one's geofence if it has one, else around the middle. It can be neither reset nor rewound.
    """

    worlds = 1

    def __init__(self, fleet: Fleet, *, recorder: RunRecorder | None = None) -> None:
        if fleet.scenario is None:
            raise SettingError(
                where=fleet.robots[0].file.name,
                setting="world",
                problem="is missing: it defines the features and behaviors",
                remedy='name the scenario whose features and behaviors it has: world = "soccer"',
            )
        self.fleet = fleet
        self._fence = fence = fleet.robots[0].file.limits.geofence
        self.scenario = _cast(fleet, fleet.scenario)
        self._drawn = World(self.scenario, [0])
        width, height = self.scenario.size
        self._origin = (-fence[0], -fence[1]) if fence else (width / 2, height / 2)
        self._empty()
        self.readings: Sequence[Reading] = self._drawn.readings
        self.channels: Sequence[Channel] = self._drawn.channels
        self.targets: Sequence[str] = self._drawn.targets
        self.agents = self.robots = fleet.agents
        self._can = {(each.name, each.of_targets) for each in fleet.readings}
        self._acted_s = -inf
        self._keys = list_reading_keys(self)
        self._paths: Paths | None = None
        self._recorder, self._recording = recorder, False
        self._sensed: Percept = {}
        self._told: list[StateChangePublisher] = []
        self._moving = {channel.name for channel in fleet.channels}

    @property
    def display_world(self) -> World:
        """A world as the robots and what is known of their targets are, to look at only."""
        return self._drawn

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that go with the scenario."""
        return self._drawn.kit

    @property
    def names(self) -> ScenarioNames:
        """What the types and classes are called."""
        return self._drawn.names

    @property
    def rules(self) -> WorldParams:
        """The scenario as numbers."""
        return self._drawn.rules

    @property
    def state(self) -> WorldState:
        """Where everything is drawn."""
        return self._drawn.state

    @property
    def seeds(self) -> tuple[int, ...]:
        """0: there is one real world."""
        return self._drawn.seeds

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        return self.fleet.tick_s

    @property
    def time_s(self) -> float:
        """The robots' time, s."""
        return self.fleet.time_s

    def view(self, world: int = 0) -> WorldView:
        """What there is to draw: the geofence, if there is one."""
        found = self._drawn.view(world)
        if self._fence is None:
            return found
        x0, y0, x1, y1 = self._fence
        return replace(found, width=x1 - x0, height=y1 - y0)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [N] of these keys; absent (NaN) for robots that have no such sensor."""
        self._drawn.check_keys(keys)
        asked = self._keys if self._recording else keys
        found = self.fleet.sense([key for key in asked if self._senses(key)])
        absent = np.full(self.agents, nan)
        self._see()
        # Recorded is what is decided on: sensed after a slow decision, it would be another snapshot.
        self._sensed = {key: found.get(key, absent) for key in asked}
        return {key: self._sensed[key] for key in keys}

    def act(self, commands: Commands) -> None:
        """Let the robots drive and turn; they have no other channels, so that what these say is not done."""
        self._drawn.check_commands(commands)  # refuses what cannot be
        if self._recording and len(self._sensed) < len(self._keys):
            self.sense(self._keys)  # what was sensed before the recording began
        time_s, percept = self.time_s, self._sensed
        self._obey({name: column for name, column in commands.items() if name in self._moving})
        if self._paths is None:
            return
        paths = self._paths()
        for told, path in zip(self._told, paths, strict=True):
            told.publish_changes(time_s, tuple(path))
        if self._recorder is not None and self._recording:
            self._recorder.write_tick(time_s, percept, paths)

    def follow(self, paths: Paths) -> None:
        """From now on tell the robots' topic of transitions, after each tick, the states of all levels of each."""
        self._paths = paths
        self._told = self._told or [
            StateChangePublisher(robot.transport, namespace=robot.file.namespace, robot=robot.file.name)
            for robot in self.fleet
        ]

    def record(self, ran: RunInfo) -> None:
        """From now on record what is decided, if there is a recorder; its messages are recorded from the beginning.

        Said again, as where another session begins, the run that is recorded begins anew.
        """
        if self._recorder is None:
            return
        files = {SCENARIO: format_scenario(self.scenario)}
        for path in (robot.path for robot in self.fleet if robot.path.is_file()):
            files[str(path) if path.name in files else path.name] = path.read_text("utf-8-sig")
        self._recorder.begin(
            self,
            names=_apart([robot.file.namespace or robot.file.name for robot in self.fleet]),
            ran=ran,
            files=files,
        )
        self._recording = True

    @property
    def is_recording(self) -> bool:
        """Whether what is decided is recorded."""
        return self._recording

    def record_action(self, agent: int, state: str | None = None, *, step: str = "press") -> None:
        """A person presses a state for a robot, or confirms the present one (None); or takes another step: test, train,
        restart. It comes before the next tick, and is recorded.
        """
        if self._recorder is None or not self._recording:
            return
        if step == "press":
            self._recorder.write_press(state, agent=agent)
        else:
            self._recorder.write_step(step, agent=agent)

    def idle(self) -> bool:
        """Let the robots stand still where nobody commanded them for a tick; whether that was so.

        To be called often while time stands still: they are stopped again and again, and seen where they are.
        """
        if self.fleet.robots[0].now_s - self._acted_s < self.tick_s:
            return False
        self._obey({})
        self._see()
        return True

    def _obey(self, commands: Commands) -> None:
        self._acted_s = self.fleet.robots[0].now_s
        self.fleet.act(commands)
        self.state.tick[0] += 1

    def close(self) -> None:
        """Stop the robots, and leave them."""
        self.fleet.close()

    def _senses(self, key: ReadingKey) -> bool:
        name, target = key
        if (name, target is not None) not in self._can:
            return False
        return target is None or target in self.fleet.targets

    def _empty(self) -> None:
        """Nobody knows what else is there: only what the robots' files or topics tell of is drawn."""
        state = self.state
        state.objects["present"] = 0
        state.objects["due"] = -1

    def _see(self) -> None:
        """Draw robots and targets where they are now."""
        for agent, robot in enumerate(self.fleet):
            row = self.state.robots[agent]
            pose = dict(zip(POSE, (robot.senses.value(name, robot.now_s) for name in POSE), strict=True))
            if isnan(pose["x"]) or isnan(pose["y"]):
                row["x"], row["y"] = self._spare(agent)
            else:
                row["x"], row["y"] = pose["x"] + self._origin[0], pose["y"] + self._origin[1]
            row["heading"] = 0.0 if isnan(pose["heading"]) else pose["heading"] % tau % tau
            for name, target in robot.file.targets.items():
                self._place(agent, name, target)

    def _spare(self, agent: int) -> tuple[float, float]:
        """Where a robot is drawn whose place is unknown: in a row through the middle."""
        width, height = (
            self.scenario.size
            if self._fence is None
            else (self._fence[2] - self._fence[0], self._fence[3] - self._fence[1])
        )
        return width * (agent + 1) / (self.agents + 1), height / 2

    def _place(self, agent: int, name: str, target: TargetPlaceSpec) -> None:
        """Draw the object that is this target, if it is one and its place is known."""
        of = self.scenario.targets.get(name)
        if of is None or of.object is None:
            return
        robot, row = self.fleet.robots[agent], self.state.robots[agent]
        place = robot.senses.locate(name, robot.now_s)
        kind = self.rules.classes[self.names.classes.index(of.object)]
        thing = self.state.objects[0, int(kind["first"]) + of.index]
        if place is None:
            return
        x, y = place
        if target.relative:
            cosine, sine = np.cos(row["heading"]), np.sin(row["heading"])
            x, y = row["x"] + cosine * x - sine * y, row["y"] + sine * x + cosine * y
        else:
            x, y = x + self._origin[0], y + self._origin[1]
        thing["x"], thing["y"], thing["present"] = x, y, 1


def _apart(names: Sequence[str]) -> list[str]:
    """Names of topics that are no other's: in two domains, two robots may have one namespace."""
    plain = [name.strip("/") for name in names]
    return [
        name if plain.count(name.strip("/")) == 1 else f"{name.rstrip('/')}/robot{number}"
        for number, name in enumerate(names)
    ]


Ground: TypeAlias = World | DigitalTwin
"""What a person looks at while robots are taught: a simulated world, or a real one."""


def skip_note(agent: int, state: str | None = None, *, step: str = "press") -> None:
    """What nobody has to be told, where robots are simulated."""


def find_drawn_world(ground: Ground) -> World:
    """The world that is drawn of it."""
    return ground.display_world if isinstance(ground, DigitalTwin) else ground


def _cast(fleet: Fleet, scenario: Scenario) -> Scenario:
    """The scenario with these robots alone, in an arena that the first one's geofence fits into."""
    kinds = [robot.file.kind or next(iter(scenario.types)) for robot in fleet]
    fence = fleet.robots[0].file.limits.geofence or (0.0, 0.0, 0.0, 0.0)
    width, height = scenario.size
    return msgspec.structs.replace(
        scenario,
        size=(max(width, fence[2] - fence[0]), max(height, fence[3] - fence[1])),
        tick_s=fleet.tick_s,
        robots=tuple(RobotGroup(type=kind) for kind in kinds),
        walls=(),
        obstacles=(),
    )
