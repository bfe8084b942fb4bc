"""A scenario as a task of reinforcement learning: numbers in, numbers out, with a reward and an end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from operator import index
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError, UnknownName, join_names
from understudy.model.features import ReadingKey
from understudy.model.kinds import Categorical, Kind, Toroidal
from understudy.runtime.body import check_reading_keys, list_reading_keys
from understudy.sim.kit import COLUMNS, make_behaviors
from understudy.sim.params import SIGNAL, list_signals
from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.skill_parts import SKILL_CHANNELS, list_skill_readings
from understudy.sim.world import World

Floats32: TypeAlias = NDArray[np.float32]
RewardFunction: TypeAlias = Callable[[World], Any]
"""The reward of the last tick: a number for all robots, or one per robot."""
EndFunction: TypeAlias = Callable[[World], bool]
"""Whether the episode has ended in the task's own sense."""
ABSENT = -1.0
"""The number that is observed where a reading is absent. Ranges, angles and labels are never below 0."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskOptions:
    """The options of a scenario as an environment.

    Parameters
    ----------
    readings
        The readings to observe, as "range(station)" or "food_stored"; all, except those of skills, if None.
    actions
        "behaviors": an action is the number of a basic behavior. "channels": an action is a value for each channel.
        Or the names of the basic behaviors to choose from.
    reward
        Function of the world after a tick that returns the reward of that tick, a number or one per robot. None: the
        units of food that each robot has unloaded, if food must be delivered; the boxes that all have gathered, if
        boxes must be; 1 in the tick in which robots reach the goal's target; 0 if the scenario has no goal.
    terminated
        Function of the world after a tick that returns whether the episode has ended. None: at the scenario's goal.
    limit_s
        Time after which an episode is truncated, s. None: the scenario's limit.
    absent
        The number that is observed where a reading is absent.
    """

    readings: Sequence[str] | None = None
    actions: Literal["behaviors", "channels"] | Sequence[str] = "behaviors"
    reward: RewardFunction | None = None
    terminated: EndFunction | None = None
    limit_s: float | None = None
    absent: float = ABSENT


class ScenarioTask:
    """One world of a scenario, with observations, actions, rewards and an end.

    Parameters
    ----------
    scenario
        The scenario, or the name or path of one.
    options
        What is observed, commanded and rewarded.

    Raises
    ------
    SettingError
        If the scenario has no such reading or behavior.
    """

    def __init__(self, scenario: Scenario | str, options: TaskOptions) -> None:
        self.scenario = load_scenario(scenario) if isinstance(scenario, str) else scenario
        self.options = options
        self.world = World(self.scenario, [0])
        self.robots = self.world.robots
        self.keys = self._choose_keys(options.readings)
        kinds = {reading.name: reading.kind for reading in self.world.readings}
        limits = [_limit_reading(kinds[name], options.absent) for name, _ in self.keys]
        self.low, self.high = np.array(limits, np.float32).reshape(-1, 2).T
        self._list_actions()
        self._nothing = [0.0] * self.robots
        self._limit_ticks = round((options.limit_s or self.scenario.limit_s) / self.scenario.tick_s)
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

    def _list_actions(self) -> None:
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
        known = {
            name: behavior
            for name, behavior in make_behaviors(self.scenario).items()
            if not behavior.parameters and "skill" not in behavior.command
        }
        chosen = self.options.actions
        self.behaviors: tuple[str, ...] = ()
        if chosen == "channels":
            return
        self.behaviors = tuple(known) if chosen == "behaviors" else tuple(chosen)
        for name in self.behaviors:
            if name not in known:
                raise UnknownName(what="basic behavior", name=name, where=self.where, known=list(known))
        if not self.behaviors:
            remedy = 'give "channels", or a scenario whose robots have basic behaviors'
            raise SettingError(
                where=self.where, setting="actions", problem="are no basic behaviors", remedy=remedy
            )
        self._commands = np.zeros((len(self.behaviors), len(COLUMNS)))
        for row, name in enumerate(self.behaviors):
            for channel, value in known[name].command.items():
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
        ends = self.options.terminated
        terminated = bool(self._finished[0] >= 0) if ends is None else bool(ends(self.world))
        return observed, reward, terminated, bool(self._tick[0] >= self._limit_ticks)

    def _encode(self, measured: NDArray[np.float64]) -> Floats32:
        observed = measured.astype(np.float32)
        observed[observed != observed] = self.options.absent  # NaN
        return observed

    def _reward(self) -> list[float]:
        if self.options.reward is not None:
            return self._check_reward(self.options.reward(self.world))
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
        given = actions[0] if len(actions) == 1 else list(actions)
        return DefinitionError(what=f"action in {self.where}", problem=f"it is {given!r:.60}", remedy=remedy)


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
