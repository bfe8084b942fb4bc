"""The 2-D simulator's body: robots in one or more copies (worlds) of a scenario, each laid out by its own seed.

With B worlds of N robots, row w*N + i of every array is robot i of world w. In each tick all robots sense, then all
decide, then all move as far as collisions permit, then they load or unload, and then objects appear, vanish and walk.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.model.drawing import call_markup, format_number_of, format_repr
from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Kit
from understudy.model.value_kinds import Column
from understudy.runtime.body import Channel, Commands, FusedPlan, Reading, check_reading_keys
from understudy.sim import state as snapshots
from understudy.sim.kernel_context import (
    KernelContext,
    KernelWorlds,
    find_world_contents,
    make_thread_scratch,
)
from understudy.sim.kit import (
    COLUMNS,
    list_readings,
    make_channels,
    make_command_table,
    make_scenario_kit,
    make_targets,
)
from understudy.sim.layout.breakdowns import draw_failure_ticks
from understudy.sim.layout.neighbor_grid import make_robot_grid, make_static_neighbors
from understudy.sim.layout.placement import lay_out_worlds
from understudy.sim.params import collect_names, make_world_params
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.sensing.sense_plan import SensePlanner
from understudy.sim.simulated_skills import SkillStandIns
from understudy.sim.state import WorldState
from understudy.sim.step import advance_worlds, apply_commands, sense_worlds
from understudy.sim.view import WorldView, make_world_view
from understudy.sim.world_edits import EditableWorld, is_whole


class World(EditableWorld):
    """The simulated robots of a scenario, in one world per seed, as a body that automata can run on.

    Robots of all worlds are numbered in one row: robot i of world w is agent w*N + i, with N robots in each world.
    SettingError if the scenario is not valid, does not fit into its arena, or a seed is not a whole number from 0 up.
    """

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,)) -> None:
        check_scenario(scenario)
        self.scenario = scenario
        seeds = self._listed(seeds)
        self.worlds = len(seeds)
        self._read_scenario(scenario)
        self._has = find_world_contents(scenario, self.rules)
        self.reset(seeds)

    def _read_scenario(self, scenario: Scenario) -> None:
        self.rules, self.names = make_world_params(scenario), collect_names(scenario)
        self.readings: Sequence[Reading] = list_readings(scenario)
        self.channels: Sequence[Channel] = make_channels(scenario)
        self.targets: Sequence[str] = tuple(target.name for target in make_targets(scenario))
        self.columns = [COLUMNS.index(channel.name) for channel in self.channels if channel.name in COLUMNS]
        self.robots = self.rules.robots
        self.agents = self.worlds * self.robots
        self._planner = SensePlanner(scenario, self.rules, self.names)
        self._plan = lru_cache(16)(self._planner.plan)
        self._skills = SkillStandIns(scenario, first=self._planner.slots)

    def __repr__(self) -> str:
        seeds = [str(seed) for seed in self.seeds]
        listed = ", ".join(seeds if len(seeds) <= 4 else [*seeds[:3], "…", seeds[-1]])
        worlds, robots = format_number_of(self.worlds, "world"), format_number_of(self.robots, "robot")
        facts = [f"{robots} in {worlds}", f"{'seed' if self.worlds == 1 else 'seeds'} {listed}"]
        return format_repr(self, f"of {self.scenario.name!r}", *facts)

    def _repr_svg_(self) -> str:
        return call_markup("run_plot:draw_world_svg", self.view())

    def __getstate__(self) -> dict[str, Any]:
        """Return the attributes to copy: all that `__setstate__` cannot derive from the scenario and the state."""
        return {name: value for name, value in vars(self).items() if name not in _REMADE}

    def __setstate__(self, attributes: dict[str, Any]) -> None:
        vars(self).update(attributes)
        self._read_scenario(self.scenario)
        self._begin(deepcopy(self.state))

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that automata for this scenario can use."""
        return make_scenario_kit(self.scenario)

    @property
    def tick_s(self) -> float:
        """The simulated time of one tick, s."""
        return self.scenario.tick_s

    @property
    def time_s(self) -> float:
        """The simulated time since the last reset, s; SettingError if worlds that ended early have different times."""
        ticks = self.state.tick
        if self.worlds > 1 and (ticks != ticks[0]).any():
            remedy = "reset it first, or read the time of each world from its view"
            raise self._wrong("time_s", "differs between its worlds, some of which have ended", remedy)
        return int(ticks[0]) * self.scenario.tick_s

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the worlds, in order."""
        return tuple(self.state.seeds.tolist())

    @property
    def finished_s(self) -> Column:
        """The time at which each world first reached the scenario's goal [B], s; NaN if it has not."""
        ticks = self.state.finished
        return np.where(ticks >= 0, ticks * self.tick_s, np.nan)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """A flag per robot [B*N]: true if it has failed, as its scenario says or by `freeze`."""
        failed: NDArray[np.bool_] = self.state.robots["frozen"] != 0
        return failed

    @property
    def delivered(self) -> NDArray[np.int64]:
        """The units of food that robots have unloaded at a home, per world [B]."""
        delivered: NDArray[np.int64] = self.state.robots["delivered"].reshape(self.worlds, -1).sum(axis=1)
        return delivered

    @property
    def total(self) -> NDArray[np.int64]:
        """The units of food that exist, per world [B]: in sources, carried by robots, and delivered."""
        sources = np.where(self.rules.classes["food"][self.rules.class_of], self.state.objects["amount"], 0)
        stored: NDArray[np.int64] = self.state.robots["stored"].reshape(self.worlds, -1).sum(axis=1)
        total: NDArray[np.int64] = sources.sum(axis=1) + stored + self.delivered
        return total

    @property
    def gathered(self) -> NDArray[np.int64]:
        """The number of boxes that robots have pulled to a home, per world [B]."""
        gathered: NDArray[np.int64] = self.state.objects["gathered"].sum(axis=1)
        return gathered

    def reset(self, seeds: Sequence[int]) -> None:
        """Restart all worlds at time 0, laid out by new seeds.

        Parameters
        ----------
        seeds
            One whole number from 0 to 2**63 - 1 per world; as many as before. SettingError otherwise.
        """
        seeds = self._listed(seeds)
        if (
            len(seeds) != self.worlds
            or not len(seeds)
            or not all(is_whole(seed, 2**63 - 1) for seed in seeds)
        ):
            count = max(1, self.worlds)
            raise self._wrong("seeds", f"are {seeds}", f"give {count} from 0 to 2**63 - 1")
        state = lay_out_worlds(self.scenario, self.rules, np.asarray(seeds, np.int64))
        state.robots["aim"] = np.nan
        memory = np.full((self.agents, self._planner.slots + self._skills.columns), np.nan)
        self._begin(state._replace(memory=memory))
        state.robots["frozen"][self.failure_ticks == 0] = 1

    def with_seeds(self, seeds: Sequence[int]) -> World:
        """Make worlds of the same scenario with other seeds, at time 0.

        Parameters
        ----------
        seeds
            One whole number from 0 to 2**63 - 1 per world.

        Returns
        -------
        World
            The worlds; these ones do not change.
        """
        return World(self.scenario, seeds)

    def _begin(self, state: WorldState) -> None:
        self.state = state
        near = make_static_neighbors(state, self.rules, reach=max(self._planner.reach, self._touch()))
        none_ended = np.zeros(len(state.seeds), np.bool_)
        self.failure_ticks: NDArray[np.int64] = draw_failure_ticks(self.scenario, state.seeds).reshape(-1)
        """The tick from which each robot has failed [B*N]; -1 never."""
        self._kernel_worlds = KernelWorlds(state, self.rules, near, self._has, none_ended, self.failure_ticks)
        self._room = make_thread_scratch(self._kernel_worlds, make_robot_grid(self.rules))
        self._context = lru_cache(8)(
            lambda keys: KernelContext(self._kernel_worlds, self._plan(keys), self._room)
        )

    def _touch(self) -> float:
        types = self.rules.types
        classes = self.rules.classes
        return float((types["radius"] + 2.0 * types["speed"]).max()) + float(
            (classes["radius"] + classes["walk"]).max()
        )

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Measure readings of all robots in the current tick.

        Parameters
        ----------
        keys
            The readings to measure, each with its target if it needs one. UnknownName if no robot has it.

        Returns
        -------
        Percept
            A column [B*N] for each key; NaN for robots without that sensor, or where nothing is detected.
        """
        keys = self.check_keys(tuple(dict.fromkeys(keys)))
        measured = tuple(key for key in keys if not self._skills.is_reading(key))
        out = np.empty((self.agents, len(measured)))
        sense_worlds(self._context(measured), self.worlds, out)
        columns = dict(zip(measured, np.ascontiguousarray(out.T), strict=True))
        if len(measured) == len(keys):
            return columns
        return {key: columns[key] if key in columns else self._skills.sense(self, key[0]) for key in keys}

    def act(self, commands: Commands) -> None:
        """Advance all worlds by one tick under these commands; nothing moves if a command is not valid.

        Parameters
        ----------
        commands
            A finite column [B*N] per channel; omitted channels are 0. UnknownName or DefinitionError otherwise.
        """
        table = self.check_commands(commands)
        running = self.begin_skills(commands)
        table[running] = 0.0
        apply_commands(self._context(()), self.worlds, table)
        for agent in running:
            self._skills.advance(self, agent)

    def begin_skills(self, commands: Commands) -> list[int]:
        """Start and end skills by the commands of a tick, as `act` does; doing it again changes nothing.

        Parameters
        ----------
        commands
            The commands of the tick, as `act` takes them.

        Returns
        -------
        list[int]
            The robots that carry out a skill in this tick, by index.
        """
        if not self._skills.columns:
            return []
        self._skills.begin(self, commands)
        return list(self._skills.list_running(self))

    def measure(self, keys: tuple[ReadingKey, ...]) -> NDArray[np.float64]:
        """Measure readings as `sense` does, without its checks, as one table.

        Parameters
        ----------
        keys
            Readings of sensors, each once, as `check_keys` returns them.

        Returns
        -------
        NDArray[np.float64]
            The readings [B*N, F]; NaN where absent.
        """
        measured = np.empty((self.agents, len(keys)))
        sense_worlds(self._context(keys), self.worlds, measured)
        return measured

    def advance_under(
        self, commands: NDArray[np.float64], keys: tuple[ReadingKey, ...]
    ) -> NDArray[np.float64]:
        """Advance all worlds by one tick, then measure: as `act` and `sense`, without their checks and without skills.

        Parameters
        ----------
        commands
            A table [B*N, 5] such as `check_commands` returns.
        keys
            The readings, as for `measure`.

        Returns
        -------
        NDArray[np.float64]
            The readings [B*N, F] after the tick; NaN where absent.
        """
        apply_commands(self._context(()), self.worlds, commands)
        return self.measure(keys)

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets, for the channel `skill`.

        Parameters
        ----------
        name
            Name of the skill. UnknownName if no type of robots has it.
        binding
            The target of each of its parameters.

        Returns
        -------
        int
            The number, from 1.
        """
        return self._skills.index(name, binding)

    def check_commands(self, commands: Commands) -> NDArray[np.float64]:
        """Convert commands to a table, without executing them.

        Parameters
        ----------
        commands
            A finite column [B*N] per channel; omitted channels are 0. UnknownName or DefinitionError otherwise.

        Returns
        -------
        NDArray[np.float64]
            The commands [B*N, 5], with the columns of `COLUMNS`.
        """
        names = [channel.name for channel in self.channels]
        return make_command_table(commands, agents=self.agents, channels=names, where=self._where)

    def advance(
        self,
        plan: FusedPlan,
        ticks: int,
        threads: int | None = None,
        *,
        until_finished: bool = False,
        ended: NDArray[np.bool_] | None = None,
    ) -> None:
        """Sense, decide and act for many ticks in compiled code, with the same results as tick by tick.

        Parameters
        ----------
        plan
            The compiled programs of all robots and their current states, which are updated.
        ticks
            The number of ticks.
        threads
            The most threads to use; None chooses by the number of robots and processors. Results do not depend on it.
        until_finished
            Whether a world stops in the tick in which it reaches its goal; if worlds stop apart, `time_s` is undefined.
        ended
            The worlds that stay as they are [B]. None: none.
        """
        keys = self.check_keys(plan.keys)
        commands = np.zeros((len(plan.commands), len(COLUMNS)))
        commands[:, self.columns] = plan.commands
        plan = replace(plan, commands=commands)
        worlds = self._kernel_worlds
        worlds.ended[:] = False if ended is None else ended
        try:
            advance_worlds(
                self._context(keys),
                worlds,
                self._plan(keys),
                plan,
                ticks,
                threads,
                until_finished=until_finished,
            )
        finally:
            worlds.ended[:] = False

    def snapshot(self) -> bytes:
        """Save the complete state of all worlds.

        Returns
        -------
        bytes
            Data for `restore`, of this world or one of the same scenario and number of worlds.
        """
        robots = self.state.robots.copy()
        robots["aim"], robots["cosine"], robots["sine"] = (
            np.nan,
            0.0,
            0.0,
        )  # at hand for speed, no part of the state
        state = self.state._replace(robots=robots)
        return snapshots.encode_snapshot(self.scenario.name, self._settings(), state._asdict())

    def restore(self, snapshot: bytes) -> None:
        """Set the state of all worlds, bit for bit, to that of a snapshot.

        Parameters
        ----------
        snapshot
            The result of `snapshot`. FileError if it was taken in a world of another scenario or number of worlds.
        """
        like = self.state._asdict()
        arrays = snapshots.decode_snapshot(
            snapshot, self.scenario.name, self._settings(), like, growing=("discs",)
        )
        state = WorldState(**arrays)
        ids, types, holding = (state.robots[name] for name in ("id", "type", "holding"))
        if not (
            np.array_equal(ids, np.tile(np.arange(self.robots), self.worlds))
            and np.all((types >= 0) & (types < len(self.rules.types)))
            and np.all((holding >= 0) & (holding <= len(self.rules.class_of)))
        ):
            raise FileError(
                path="snapshot", place="robots", problem="do not belong to this world", remedy="take it again"
            )
        self._begin(state)

    def _settings(self) -> dict[str, Any]:
        settings: dict[str, Any] = msgspec.to_builtins(self.scenario)
        return settings

    def view(self, world: int = 0) -> WorldView:
        """Copy one world's current state into a plain value, for drawing.

        Parameters
        ----------
        world
            The index of the world, from 0.

        Returns
        -------
        WorldView
            Places and properties of robots, objects and obstacles, in m and rad.
        """
        return make_world_view(self.state, self.rules, self.names, world, failure_ticks=self.failure_ticks)

    def _listed(self, seeds: Sequence[int]) -> list[int]:
        try:
            return list(seeds)
        except TypeError:  # one number, say
            remedy = "give a list of whole numbers, one for each world: [5]"
            raise self._wrong("seeds", f"are {seeds!r:.60}", remedy) from None

    def check_keys(self, keys: Sequence[ReadingKey]) -> tuple[ReadingKey, ...]:
        """Check that the robots can measure readings.

        Parameters
        ----------
        keys
            The readings, each with its target if it needs one. UnknownName or SettingError if there is none.

        Returns
        -------
        tuple[ReadingKey, ...]
            The same keys.
        """
        check_reading_keys(keys, readings=self.readings, targets=self.targets, where=self._where)
        return tuple(keys)


_REMADE = ("rules", "_planner", "_skills", "_plan", "_kernel_worlds", "_room", "_context", "failure_ticks")
"""Attributes that a copy of a world computes for itself: caches, and arrays that kernels work with."""
