"""Digital twins: scenarios whose robots are real ones, and that are drawn like simulated worlds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf, isnan, nan, tau
from typing import TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.recording_transport import list_recorded_names
from understudy.addons.robots.robot_file import POSE, TargetPlaceSpec
from understudy.addons.robots.ros.state_topic import StateChangePublisher
from understudy.addons.robots.skills.stand_ins import add_robot_skills
from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Kit
from understudy.records.header import SCENARIO, RunInfo
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import Commands, list_reading_keys
from understudy.sim.body_world import BodyWorld, DrawnBody
from understudy.sim.scenario.files import format_scenario
from understudy.sim.scenario.schema import RobotGroup, Scenario
from understudy.sim.view import WorldView
from understudy.sim.world import World

Paths: TypeAlias = Callable[[], Sequence[Sequence[str]]]
"""A function that returns the states of all levels of each robot, as decided last."""


class DigitalTwin(DrawnBody[Fleet]):
    """A body with the robots of a fleet in the scenario that their robot files name.

    It has the scenario's readings, targets and channels; readings that a robot does not have are absent (NaN). Robots
    are drawn at their readings `x`, `y` and `heading`: relative to the corner of the first robot's geofence, or,
    without one, to the middle of the arena. A twin can neither be reset nor rewound.
    """

    def __init__(self, fleet: Fleet, *, recorder: RunRecorder | None = None) -> None:
        if fleet.scenario is None:
            raise SettingError(
                where=fleet.robots[0].file.name,
                setting="world",
                problem="is missing: it defines the features and behaviors",
                remedy='name the scenario whose features and behaviors it has: world = "soccer"',
            )
        self.scenario = _cast(fleet, fleet.scenario)
        super().__init__(fleet, World(self.scenario, [0]))
        self.fleet = fleet
        self._fence = fence = fleet.robots[0].file.limits.geofence
        width, height = self.scenario.size
        self._is_drawn = False
        self._origin = (-fence[0], -fence[1]) if fence else (width / 2, height / 2)
        self._empty()
        self.readings, self.channels = self._drawn.readings, self._drawn.channels
        self.targets = self._drawn.targets
        self._offered: dict[tuple[tuple[ReadingKey, ...], ...], Sequence[ReadingKey]] = {}
        self._can = {(each.name, each.of_targets) for each in fleet.readings}
        self._acted_s = -inf
        self._keys = list_reading_keys(self)
        self._paths: Paths | None = None
        self._recorder, self._recording = recorder, False
        self._sensed: Percept = {}
        self._told: list[StateChangePublisher] = []
        self._moving = {channel.name for channel in fleet.channels}

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets of the scenario."""
        return self._drawn.kit

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The robots that squads must not count as members [N]: disarmed, stopped, or silent ones."""
        return self.fleet.failed

    def view(self, world: int = 0) -> WorldView:
        """Return the drawn world, as large as the geofence if there is one."""
        view = super().view(world)
        if self._fence is None:
            return view
        x0, y0, x1, y1 = self._fence
        return replace(view, width=x1 - x0, height=y1 - y0)

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return a column [N] for each key; NaN for robots that have no such sensor."""
        wanted = tuple(self._keys if self._recording else keys)
        columns = self.fleet.sense(self._list_offered(tuple(keys), wanted))
        absent = np.full(self.agents, nan)
        self._is_drawn = False
        # Recorded is what is decided on: sensed after a slow decision, it would be another snapshot.
        self._sensed = {key: columns.get(key, absent) for key in wanted}
        return {key: self._sensed[key] for key in keys}

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill of the robots with targets, for the channel `skill`."""
        return self.fleet.index_skill(name, binding)

    def act(self, commands: Commands) -> None:
        """Send the robots their commands and skills; other channels are checked and ignored."""
        self._drawn.check_commands(commands)  # refuses what cannot be
        if self._recording and len(self._sensed) < len(self._keys):
            self.sense(self._keys)  # what was sensed before the recording began
        time_s, percept = self.time_s, self._sensed
        self._obey({name: column for name, column in commands.items() if name in self._moving})
        if self._paths is None:
            return
        paths = self._paths()
        for publisher, path, robot in zip(self._told, paths, self.fleet, strict=True):
            publisher.publish_changes(time_s, tuple(path), stopped=robot.stop_cause)
        if self._recorder is not None and self._recording:
            self._recorder.write_tick(time_s, percept, paths, commands=commands)

    def follow(self, paths: Paths) -> None:
        """Publish the robots' state changes after each tick from now on.

        `paths` returns the states of all levels of each robot.
        """
        self._paths = paths
        self._told = self._told or [
            StateChangePublisher(robot.transport, namespace=robot.file.namespace, robot=robot.file.name)
            for robot in self.fleet
        ]

    def record(self, ran: RunInfo) -> None:
        """Record all decisions from now on, if there is a recorder; it has been recording messages from the start.

        Each call begins a new run in the recording.
        """
        if self._recorder is None:
            return
        files = {SCENARIO: format_scenario(self.scenario)}
        for path in (robot.path for robot in self.fleet if robot.path.is_file()):
            files[str(path) if path.name in files else path.name] = path.read_text("utf-8-sig")
        self._recorder.begin(
            self,
            names=list_recorded_names([robot.file for robot in self.fleet]),
            ran=ran,
            files=files,
        )
        self._recording = True

    @property
    def is_recording(self) -> bool:
        """True while decisions are recorded."""
        return self._recording

    def record_action(self, agent: int, state: str | None = None, *, step: str = "press") -> None:
        """Record that a person acted before the next tick; do nothing if no recording is running.

        With `step` "press", the person pressed a `state` for a robot, or confirmed the present one (None). Other
        steps are "test", "train", "teach" and "restart".
        """
        if self._recorder is None or not self._recording:
            return
        if step == "press":
            self._recorder.write_press(state, agent=agent)
        else:
            self._recorder.write_step(step, agent=agent)

    def idle(self) -> bool:
        """Stop the robots if no command was sent for a tick; return whether that was so.

        Call it often while a session is paused: it repeats the stops and updates the drawn places.
        """
        if self.fleet.robots[0].now_s - self._acted_s < self.tick_s:
            return False
        self._obey({})
        self._is_drawn = False
        return True

    def _obey(self, commands: Commands) -> None:
        self._acted_s = self.fleet.robots[0].now_s
        self.fleet.act(commands)
        self._drawn.state.tick[0] += 1

    def close(self) -> None:
        """Stop the robots and disconnect from them."""
        self.fleet.close()

    def _list_offered(
        self, keys: tuple[ReadingKey, ...], wanted: tuple[ReadingKey, ...]
    ) -> Sequence[ReadingKey]:
        """List which of the `wanted` readings the robots have; the same are asked for at every tick."""
        if (keys, wanted) not in self._offered:
            self._drawn.check_keys(keys)
            self._offered[keys, wanted] = [key for key in wanted if self._senses(key)]
        return self._offered[keys, wanted]

    def _senses(self, key: ReadingKey) -> bool:
        name, target = key
        if (name, target is not None) not in self._can:
            return False
        return target is None or target in self.fleet.targets

    def _empty(self) -> None:
        """Remove the scenario's objects, whose places are unknown until a robot file or topic gives them."""
        state = self._drawn.state
        state.objects["present"] = 0
        state.objects["due"] = -1

    def _draw(self) -> None:
        """Draw robots and targets where they are now, when they are first looked at in a tick."""
        if self._is_drawn:
            return
        for agent, robot in enumerate(self.fleet):
            row = self._drawn.state.robots[agent]
            pose = dict(zip(POSE, (robot.senses.value(name, robot.now_s) for name in POSE), strict=True))
            if isnan(pose["x"]) or isnan(pose["y"]):
                row["x"], row["y"] = self._spare(agent)
            else:
                row["x"], row["y"] = pose["x"] + self._origin[0], pose["y"] + self._origin[1]
            row["heading"] = 0.0 if isnan(pose["heading"]) else pose["heading"] % tau % tau
            for name, target in robot.file.targets.items():
                self._place(agent, name, target)
        self._is_drawn = True

    def _spare(self, agent: int) -> tuple[float, float]:
        """Return where a robot is drawn whose place is unknown: in a row through the middle."""
        width, height = (
            self.scenario.size
            if self._fence is None
            else (self._fence[2] - self._fence[0], self._fence[3] - self._fence[1])
        )
        return width * (agent + 1) / (self.agents + 1), height / 2

    def _place(self, agent: int, name: str, target: TargetPlaceSpec) -> None:
        """Draw a target of a robot if it is an object of the scenario and its place is known."""
        of = self.scenario.targets.get(name)
        if of is None or of.object is None:
            return
        state = self._drawn.state
        robot, row = self.fleet.robots[agent], state.robots[agent]
        place = robot.senses.locate(name, robot.now_s)
        kind = self.rules.classes[self.names.classes.index(of.object)]
        thing = state.objects[0, int(kind["first"]) + of.index]
        if place is None:
            return
        x, y = place
        if target.relative:
            cosine, sine = np.cos(row["heading"]), np.sin(row["heading"])
            x, y = row["x"] + cosine * x - sine * y, row["y"] + sine * x + cosine * y
        else:
            x, y = x + self._origin[0], y + self._origin[1]
        thing["x"], thing["y"], thing["present"] = x, y, 1


Ground: TypeAlias = World | DigitalTwin | BodyWorld
"""The world that is shown while robots are taught: simulated, a twin of real robots, or a body of the user's own."""


def skip_note(agent: int, state: str | None = None, *, step: str = "press") -> None:
    """Ignore a person's action, which need not be recorded if robots are simulated."""


def find_drawn_world(ground: Ground) -> World:
    """Return the world that is drawn for a simulated world or a twin; an empty one for a body of the user's own."""
    return ground if isinstance(ground, World) else ground.display_world


def _cast(fleet: Fleet, scenario: Scenario) -> Scenario:
    """Make a scenario with only these robots, without walls and obstacles, at least as large as the first geofence."""
    kinds = [robot.file.kind or next(iter(scenario.types)) for robot in fleet]
    fence = fleet.robots[0].file.limits.geofence or (0.0, 0.0, 0.0, 0.0)
    width, height = scenario.size
    return msgspec.structs.replace(
        add_robot_skills(scenario, (robot.file for robot in fleet)),
        size=(max(width, fence[2] - fence[0]), max(height, fence[3] - fence[1])),
        tick_s=fleet.tick_s,
        robots=tuple(RobotGroup(type=kind) for kind in kinds),
        walls=(),
        obstacles=(),
    )
