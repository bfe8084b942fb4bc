"""A scenario as a task of reinforcement learning: numbers in, numbers out, with a reward and an end.

`ScenarioEnvironment` is what environments of all packages have in common.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from math import inf
from operator import index
from typing import Any, Literal, TypeAlias

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError, UnknownName, join_names
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Categorical, Kind, Toroidal
from understudy.runtime.body import check_reading_keys, list_reading_keys
from understudy.sim.kit import COLUMNS, make_behaviors
from understudy.sim.params import SIGNAL, list_signals
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.skill_parts import SKILL_CHANNELS, list_skill_readings
from understudy.sim.world import World
from understudy.viz.world_picture import draw_world_picture

Floats32: TypeAlias = NDArray[np.float32]
RewardFunction: TypeAlias = Callable[[World], Any]
"""The reward of the last tick: a number for all robots, or one per robot."""
EndFunction: TypeAlias = Callable[[World], bool]
"""Whether the episode has ended in the task's own sense."""
ActionChoice: TypeAlias = Literal["behaviors", "channels"] | Sequence[str]
ABSENT = -1.0
"""The number that is observed where a reading is absent. Ranges, angles and labels are never below 0."""
SEEDS = 2**31
"""The number of worlds from which a reset without a seed draws one."""


class ScenarioEnvironment(ABC):
    """The world of a scenario as an environment for reinforcement learning; packages' own interfaces are built on it.

    Parameters
    ----------
    scenario
        The scenario, or the name or path of one.
    readings
        The readings to observe, in order, such as "range(station)" or "food_stored"; all, except those of skills, if
        None.
    actions
        "behaviors": an action is the number of a basic behavior (`Discrete`). "channels": an action has a value for
        each channel (`Box`). Or the names of the basic behaviors to choose from.
    reward
        Function of the `World` after a tick that returns the reward of that tick, a number for all robots or one per
        robot. None: the units of food that each robot has unloaded, if food must be delivered; the boxes that all
        have gathered, if boxes must be; 1 for all in the tick in which robots reach the goal's target; 0 if the
        scenario has no goal.
    terminated
        Function of the `World` after a tick that returns whether the episode has ended. None: at the scenario's goal.
    limit_s
        Time after which an episode is truncated, s; the scenario's limit if None.
    absent
        The number that is observed where a reading is absent.
    render_mode
        "rgb_array", to draw the world with `render`; or None.

    Raises
    ------
    SettingError
        If the scenario has no such reading or behavior.

    Notes
    -----
    What a robot observes is a `Box` with a float32 per reading. Angles are in radians from 0 to 2π, and a categorical
    reading is the index of its label.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 (as packages have it)

    def __init__(
        self,
        scenario: Scenario | str,
        *,
        readings: Sequence[str] | None = None,
        actions: ActionChoice = "behaviors",
        reward: RewardFunction | None = None,
        terminated: EndFunction | None = None,
        limit_s: float | None = None,
        absent: float = ABSENT,
        render_mode: str | None = None,
    ) -> None:
        self.task = ScenarioTask(
            scenario, readings=readings, actions=actions, reward=reward, terminated=terminated, limit_s=limit_s,
            absent=absent,
        )  # fmt: skip
        if render_mode not in (None, "rgb_array"):
            problem, remedy = f"is {render_mode!r}", 'give "rgb_array" or None'
            raise SettingError(where=self.task.where, setting="render_mode", problem=problem, remedy=remedy)
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self.task.scenario.tick_s)}
        self.render_mode = render_mode
        self._set_up()

    @abstractmethod
    def _set_up(self) -> None:
        """Set the attributes that a package's environments need in addition, such as their spaces."""

    def _make_spaces(self) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
        """Make the observation and action space of one robot."""
        task = self.task
        return spaces.Box(task.low, task.high, dtype=np.float32), (
            spaces.Discrete(len(task.behaviors))
            if task.behaviors
            else spaces.Box(task.least, task.most, dtype=np.float32)
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Draw the world.

        Returns
        -------
        NDArray or None
            Red, green and blue of each pixel, 0 to 255 [height, width, 3]; None without a render mode.
        """
        return None if self.render_mode is None else draw_world_picture(self.task.world.view())


class ScenarioTask:
    """One world of a scenario, with the observations, actions, rewards and end that `ScenarioEnvironment` describes."""

    def __init__(
        self,
        scenario: Scenario | str,
        *,
        readings: Sequence[str] | None,
        actions: ActionChoice,
        reward: RewardFunction | None,
        terminated: EndFunction | None,
        limit_s: float | None,
        absent: float,
    ) -> None:
        self.scenario = load_scenario(scenario) if isinstance(scenario, str) else scenario
        self._compute_reward, self._has_ended, self._absent = reward, terminated, absent
        self.world = World(self.scenario, [0])
        self.robots = self.world.robots
        self.keys = self._choose_keys(readings)
        kinds = {reading.name: reading.kind for reading in self.world.readings}
        limits = [_limit_reading(kinds[name], absent) for name, _ in self.keys]
        self.low, self.high = np.array(limits, np.float32).reshape(-1, 2).T
        self._list_actions(actions)
        self._nothing = [0.0] * self.robots
        self._limit_ticks = round((limit_s or self.scenario.limit_s) / self.scenario.tick_s)
        self.reset(0)

    @property
    def where(self) -> str:
        """The scenario, for error messages."""
        return f"scenario {self.scenario.name!r}"

    def _choose_keys(self, readings: Sequence[str] | None) -> tuple[ReadingKey, ...]:
        of_skills = {
            reading.name for kind in self.scenario.types.values() for _, reading in list_skill_readings(kind)
        }
        if readings is None:
            keys = tuple(key for key in list_reading_keys(self.world) if key[0] not in of_skills)
        else:
            keys = tuple(_parse_reading(text) for text in readings)
            where = self.where
            check_reading_keys(keys, readings=self.world.readings, targets=self.world.targets, where=where)
        for setting, problem in (
            ("readings", "are none" if not keys else ""),
            ("readings", "name one twice" if len(set(keys)) < len(keys) else ""),
            ("readings", "name one of a skill" if any(name in of_skills for name, _ in keys) else ""),
        ):
            if problem:
                remedy = "give some of the readings of sensors, each once"
                raise SettingError(where=self.where, setting=setting, problem=problem, remedy=remedy)
        return keys

    def _list_actions(self, chosen: ActionChoice) -> None:
        """Make the tables of commands of all actions, or the limits of the channels."""
        self.channels = tuple(
            channel.name for channel in self.world.channels if channel not in SKILL_CHANNELS
        )
        self._columns = [COLUMNS.index(channel) for channel in self.channels]
        signals = float(len(list_signals(self.scenario)))
        least = {"drive": -1.0, "turn": -1.0}
        self.least = np.array([least.get(channel, 0.0) for channel in self.channels], np.float32)
        most = [signals if channel == SIGNAL else 1.0 for channel in self.channels]
        self.most = np.array(most, np.float32)
        self._signal = self.channels.index(SIGNAL) if SIGNAL in self.channels else None
        behaviors = {
            name: behavior
            for name, behavior in make_behaviors(self.scenario).items()
            if not behavior.parameters and "skill" not in behavior.command
        }
        self.behaviors: tuple[str, ...] = ()
        if chosen == "channels":
            return
        self.behaviors = tuple(behaviors) if chosen == "behaviors" else tuple(chosen)
        for name in self.behaviors:
            if name not in behaviors:
                raise UnknownName(what="basic behavior", name=name, where=self.where, known=list(behaviors))
        if not self.behaviors:
            remedy = 'give "channels", or a scenario whose robots have basic behaviors'
            raise SettingError(
                where=self.where, setting="actions", problem="are no basic behaviors", remedy=remedy
            )
        self._commands = np.zeros((len(self.behaviors), len(COLUMNS)))
        for row, name in enumerate(self.behaviors):
            for channel, value in behaviors[name].command.items():
                self._commands[row, COLUMNS.index(channel)] = value
        self._rows = list(self._commands[:, None])

    def reset(self, seed: int) -> Floats32:
        """Begin a new episode in the world of a seed; return what is observed [N, F]."""
        self.world.reset([seed])
        state, goal = self.world.state, self.scenario.goal
        self._finished, self._tick = state.finished, state.tick
        self._counted: NDArray[Any] | None = None  # where the goal's progress is counted
        if goal is not None and goal.delivered:
            self._counted = np.asarray(state.robots)["delivered"]
        elif goal is not None and goal.gathered:
            self._counted = np.asarray(state.objects)["gathered"]
        self._before = [] if self._counted is None else self._counted.tolist()
        self._was_finished = bool(self._finished[0] >= 0)
        return self._encode(self.world.measure(self.keys))

    def step(self, commands: NDArray[np.float64]) -> tuple[Floats32, list[float], bool, bool]:
        """Advance one tick under commands [N, 5].

        Return what is observed [N, F], the reward of each robot, and whether the episode is terminated and truncated.
        """
        observed = self._encode(self.world.advance_under(commands, self.keys))
        reward = self._reward()
        ends = self._has_ended
        terminated = bool(self._finished[0] >= 0) if ends is None else bool(ends(self.world))
        return observed, reward, terminated, bool(self._tick[0] >= self._limit_ticks)

    def _encode(self, measured: NDArray[np.float64]) -> Floats32:
        observed = measured.astype(np.float32)
        observed[observed != observed] = self._absent  # NaN
        return observed

    def _reward(self) -> list[float]:
        if self._compute_reward is not None:
            return self._check_reward(self._compute_reward(self.world))
        if self._counted is None:
            finished = bool(self._finished[0] >= 0)
            value = float(finished and not self._was_finished)
            self._was_finished = finished
            return [value] * self.robots
        counted = self._counted.tolist()
        if counted == self._before:  # as in most ticks
            return self._nothing
        gained = np.subtract(counted, self._before)
        self._before = counted
        if gained.ndim > 1:
            return [float(gained.sum())] * self.robots
        return [float(each) for each in gained.tolist()]

    def _check_reward(self, reward: Any) -> list[float]:
        values = np.asarray(reward, np.float64)
        if values.shape not in ((), (self.robots,)) or not np.isfinite(values).all():
            raise DefinitionError(
                what=f"reward of {self.where}",
                problem=f"it is {reward!r:.60}",
                remedy=f"return a finite number, or {self.robots} of them",
            )
        return [float(each) for each in np.broadcast_to(values, self.robots).tolist()]

    def look_up_behavior(self, actions: tuple[Any]) -> NDArray[np.float64]:
        """Return the commands [1, 5] of one action: as `look_up_behaviors`, in a tenth of the time."""
        try:
            number = index(actions[0])
        except TypeError:
            number = -1
        if 0 <= number < len(self._rows):
            row: NDArray[np.float64] = self._rows[number]
            return row
        return self.look_up_behaviors(actions)

    def look_up_behaviors(self, actions: Sequence[Any]) -> NDArray[np.float64]:
        """Return the commands [N, 5] of actions that are numbers of basic behaviors; refuse others."""
        numbers = np.zeros(0, np.int64)
        try:
            numbers = np.array(actions, np.int64)
            inside = bool(((numbers >= 0) & (numbers < len(self._commands))).all())
        except (TypeError, ValueError):
            inside = False
        if not inside or numbers.shape != (len(actions),):
            last = len(self.behaviors) - 1
            names = join_names(f"{at} {name}" for at, name in enumerate(self.behaviors))
            raise self._wrong_action(actions, f"give a whole number from 0 to {last}: {names}")
        return self._commands[numbers]

    def look_up_channels(self, actions: Sequence[Any]) -> NDArray[np.float64]:
        """Return the commands [N, 5] of actions that are a value for each channel; refuse others."""
        width = len(self.channels)
        values: NDArray[Any] = np.zeros(0, np.float32)
        try:
            values = np.array(actions, np.float32)
            inside = values.shape == (len(actions), width) and bool(
                ((values >= self.least) & (values <= self.most)).all()
            )
        except (TypeError, ValueError):
            inside = False
        if not inside:
            limits = zip(self.channels, self.least.tolist(), self.most.tolist(), strict=True)
            ranges = join_names(f"{name} from {low:g} to {high:g}" for name, low, high in limits)
            raise self._wrong_action(actions, f"give {width} numbers: {ranges}")
        table = np.zeros((len(actions), len(COLUMNS)))
        table[:, self._columns] = values
        if self._signal is not None:
            table[:, COLUMNS.index(SIGNAL)] = np.rint(values[:, self._signal])
        return table

    def _wrong_action(self, actions: Sequence[Any], remedy: str) -> DefinitionError:
        action = actions[0] if len(actions) == 1 else list(actions)
        return DefinitionError(what=f"action in {self.where}", problem=f"it is {action!r:.60}", remedy=remedy)


def _limit_reading(kind: Kind, absent: float) -> tuple[float, float]:
    """Return the least and greatest number that is observed of a reading, with the one for absent."""
    low, high = -inf, inf
    if isinstance(kind, Toroidal):
        low, high = 0.0, kind.period
    elif isinstance(kind, Categorical):
        low, high = 0.0, len(kind.labels) - 1.0
    return min(low, absent), max(high, absent)


def _parse_reading(text: str) -> ReadingKey:
    name, _, target = text.partition("(")
    return name.strip(), target.rstrip(") ").strip() or None
