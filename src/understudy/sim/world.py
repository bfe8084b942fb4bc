"""Worlds of robots: B worlds side by side, laid out by their seeds from one scenario; a body of B*N robots.

Row w*N + i is robot i of world w. A tick is: everyone senses, everyone decides, everyone moves as far as the free
gaps let it, then loads, then objects come, go and walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from math import isfinite, nan, tau
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, SettingError, UnknownName, join_names
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.library import Kit
from understudy.runtime.body import Channel, Commands, FusedPlan, Reading, check_reading_keys
from understudy.sim import state as snapshots
from understudy.sim.kernel_context import (
    KernelContext,
    KernelWorlds,
    find_world_contents,
    make_thread_scratch,
)
from understudy.sim.kernels.dtypes import DISC
from understudy.sim.kit import (
    COLUMNS,
    list_readings,
    make_channels,
    make_command_table,
    make_scenario_kit,
    make_targets,
)
from understudy.sim.layout.clearance import find_overlap
from understudy.sim.layout.neighbor_grid import make_robot_grid, make_static_neighbors
from understudy.sim.layout.placement import lay_out_worlds
from understudy.sim.params import collect_names, make_world_params
from understudy.sim.scenario.schema import MOUSE, Scenario
from understudy.sim.scenario.validation import check_scenario
from understudy.sim.sensing.sense_plan import SensePlanner
from understudy.sim.state import WorldState
from understudy.sim.step import advance_worlds, apply_commands, sense_worlds
from understudy.sim.view import WorldView, make_world_view


class World:
    """A body of the robots of B worlds of a scenario, one world per seed."""

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
        self.columns = [COLUMNS.index(channel.name) for channel in self.channels]
        self.robots = self.rules.robots
        self.agents = self.worlds * self.robots
        self._planner = SensePlanner(scenario, self.rules, self.names)
        self._plan = lru_cache(16)(self._planner.plan)

    def __getstate__(self) -> dict[str, Any]:
        """What a copy is made of: all but what follows from the scenario and the state."""
        return {name: value for name, value in vars(self).items() if name not in _REMADE}

    def __setstate__(self, kept: dict[str, Any]) -> None:
        vars(self).update(kept)
        self._read_scenario(self.scenario)
        self._begin(deepcopy(self.state))

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that go with the scenario."""
        return make_scenario_kit(self.scenario)

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self.scenario.tick_s

    @property
    def time_s(self) -> float:
        """Time since the last reset, s; SettingError where some worlds ended early, so that there is no one time."""
        ticks = self.state.tick
        if self.worlds > 1 and (ticks != ticks[0]).any():
            remedy = "reset it first, or read the time of each world from its view"
            raise self._wrong("time_s", "differs between its worlds, some of which have ended", remedy)
        return int(ticks[0]) * self.scenario.tick_s

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each world."""
        return tuple(self.state.seeds.tolist())

    @property
    def finished_s(self) -> Column:
        """When each world reached its goal [B], s; absent where it has not."""
        ticks = self.state.finished
        return np.where(ticks >= 0, ticks * self.tick_s, np.nan)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which robots have failed [B*N]."""
        failed: NDArray[np.bool_] = self.state.robots["frozen"] != 0
        return failed

    @property
    def delivered(self) -> NDArray[np.int64]:
        """Units of food brought home in each world [B]."""
        delivered: NDArray[np.int64] = self.state.robots["delivered"].reshape(self.worlds, -1).sum(axis=1)
        return delivered

    @property
    def total(self) -> NDArray[np.int64]:
        """Units of food there are in each world [B]: in sources, on robots, and brought home."""
        sources = np.where(self.rules.classes["food"][self.rules.class_of], self.state.objects["amount"], 0)
        stored: NDArray[np.int64] = self.state.robots["stored"].reshape(self.worlds, -1).sum(axis=1)
        total: NDArray[np.int64] = sources.sum(axis=1) + stored + self.delivered
        return total

    @property
    def gathered(self) -> NDArray[np.int64]:
        """Boxes brought home in each world [B]."""
        gathered: NDArray[np.int64] = self.state.objects["gathered"].sum(axis=1)
        return gathered

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, one world per seed, as many worlds as before."""
        seeds = self._listed(seeds)
        if (
            len(seeds) != self.worlds
            or not len(seeds)
            or not all(_is_whole(seed, 2**63 - 1) for seed in seeds)
        ):
            count = max(1, self.worlds)
            raise self._wrong("seeds", f"are {seeds}", f"give {count} from 0 to 2**63 - 1")
        state = lay_out_worlds(self.scenario, self.rules, np.asarray(seeds, np.int64))
        state.robots["aim"] = np.nan
        memory = np.full((self.agents, self._planner.slots), np.nan)
        self._begin(state._replace(memory=memory))

    def _begin(self, state: WorldState) -> None:
        self.state = state
        near = make_static_neighbors(state, self.rules, reach=max(self._planner.reach, self._touch()))
        self._kernel_worlds = KernelWorlds(state, self.rules, near, self._has)
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
        """The columns [B*N] of these keys, absent (NaN) for robots that have no such sensor."""
        keys = tuple(dict.fromkeys(keys))
        out = np.empty((self.agents, len(keys)))
        sense_worlds(self._context(self.check_keys(keys)), self.worlds, out)
        columns = np.ascontiguousarray(out.T)
        return dict(zip(keys, columns, strict=True))

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel left out rests. An unusable command raises, and nothing moves."""
        apply_commands(self._context(()), self.worlds, self.check_commands(commands))

    def check_commands(self, commands: Commands) -> NDArray[np.float64]:
        """Commands as a table [B*N, 5], whose columns are COLUMNS and none left out; an unusable one raises."""
        names = [channel.name for channel in self.channels]
        return make_command_table(commands, agents=self.agents, channels=names, where=self._where)

    def advance(
        self, plan: FusedPlan, ticks: int, threads: int | None = None, *, until_finished: bool = False
    ) -> None:
        """Sense, decide and act so many times in one go, exactly as tick by tick (see `runtime.body.Fused`).

        Where `until_finished`, a world ends with the tick in which it reaches its goal. Worlds that ended at different
        times have no one `time_s`: reset them before they go on tick by tick.
        """
        sensing = self._plan(self.check_keys(plan.keys))
        commands = np.zeros((len(plan.commands), len(COLUMNS)))
        commands[:, self.columns] = plan.commands
        plan = replace(plan, commands=commands)
        advance_worlds(self._kernel_worlds, sensing, plan, ticks, threads, until_finished=until_finished)

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        robots = self.state.robots.copy()
        robots["aim"], robots["cosine"], robots["sine"] = (
            np.nan,
            0.0,
            0.0,
        )  # at hand for speed, no part of the state
        state = self.state._replace(robots=robots)
        return snapshots.encode_snapshot(self.scenario.name, self._settings(), state._asdict())

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of such worlds."""
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
        """One world as plain data, for drawing."""
        return make_world_view(self.state, self.rules, self.names, world)

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere free, as a demonstrator drives it into position; what it has at hand is left."""
        robot = self.state.robots[self._index("agent", agent, self.agents)]
        kind, world = self.rules.types[robot["type"]], agent // self.robots
        self._finite(f"place of robot {agent}", x, y, heading)
        self._free(
            f"place of robot {agent}", x, y, kind["radius"], world=world,
            robot=int(robot["id"]), collides=bool(kind["collides"]),
        )  # fmt: skip
        if robot["holding"]:
            self.state.objects["hands"][world, robot["holding"] - 1] -= 1
        robot["x"], robot["y"], robot["heading"] = x, y, float(heading) % tau % tau
        for name in ("speed", "spin", "loading", "unloading", "blocked", "holding"):
            robot[name] = 0

    def move_object(self, slot: int, x: float, y: float, *, world: int = 0) -> None:
        """Put an object that is there somewhere, out of the hands that hold it; `make_world_view` has the slots."""
        thing = self._object(slot, world)
        self._free_for(f"place of object {slot}", self.rules.class_of[slot], x, y, world=world, slot=slot)
        self._let_go(slot, world)
        thing["x"], thing["y"] = x, y

    def add_object(self, name: str, x: float, y: float, *, amount: int = 0, world: int = 0) -> int:
        """Add an object of a class; its slot. SettingError where the world has no room for more of it."""
        kind = self._class(name)
        self._index("world", world, self.worlds)
        self._free_for(f"place of {name!r}", self.names.classes.index(name), x, y, world=world)
        most = 2**31 - 1 if kind["food"] else 0
        if not _is_whole(amount, most):
            remedy = "give a whole number from 0 up" if kind["food"] else "leave it out: it is not food"
            raise self._wrong(f"amount of {name!r}", f"is {amount}", remedy)
        things = self.state.objects[world, kind["first"] : kind["end"]]
        free = np.flatnonzero((things["present"] == 0) & (things["due"] < 0))
        if not len(free):
            raise self._wrong(
                f"objects {name!r}", f"are {len(things)} already", "remove one, or give more spare_objects"
            )
        slot = int(kind["first"]) + int(free[0])
        gathered = self.state.objects["gathered"][world, slot]  # a box that was there once still counts
        self.state.objects[world, slot] = np.zeros((), self.state.objects.dtype)
        thing = self.state.objects[world, slot]
        thing["x"], thing["y"], thing["present"], thing["gathered"] = x, y, 1, gathered
        thing["amount"] = thing["at_first"] = amount
        thing["due"] = thing["captured"] = -1
        return slot

    def remove_object(self, slot: int, *, world: int = 0) -> None:
        """Remove an object that is there; it does not come again."""
        thing = self._object(slot, world)
        self._let_go(slot, world)
        thing["present"], thing["due"], thing["amount"] = 0, -1, 0

    def _let_go(self, slot: int, world: int) -> None:
        """Take an object out of all hands."""
        robots = self.state.robots[world * self.robots : (world + 1) * self.robots]
        robots["holding"][robots["holding"] == slot + 1] = 0
        self.state.objects["hands"][world, slot] = 0

    def add_obstacle(self, x: float, y: float, radius: float, *, world: int = 0) -> None:
        """Add a round obstacle to a world, where it overlaps no robot and no solid object."""
        self._index("world", world, self.worlds)
        self._finite("place of an obstacle", x, y, radius)
        if not radius > 0:
            raise self._wrong("radius of an obstacle", f"is {radius}", "give a number above 0")
        self._free("place of an obstacle", x, y, radius, world=world, stays=True)
        discs = np.zeros((self.worlds, self.state.discs.shape[1] + 1), DISC)
        discs[:, :-1] = self.state.discs
        discs["color"][:, -1] = -1
        discs[world, -1] = (x, y, radius, 2 * radius, -1)
        self._begin(self.state._replace(discs=discs))

    def move_obstacle(self, index: int, x: float, y: float, *, world: int = 0) -> None:
        """Put a round obstacle elsewhere, where it overlaps no robot and no solid object; numbers as in
        `make_world_view`.
        """
        disc = self._obstacle(index, world)
        self._finite("place of an obstacle", x, y, 0.0)
        self._free("place of an obstacle", x, y, float(disc["radius"]), world=world, stays=True)
        disc["x"], disc["y"] = x, y
        self._begin(self.state)

    def remove_obstacle(self, index: int, *, world: int = 0) -> None:
        """Remove a round obstacle; those behind it count one less from now on."""
        self._obstacle(index, world)["radius"] = 0
        self._begin(self.state)

    def place_pointer(self, x: float | None, y: float | None = None, *, world: int = 0) -> None:
        """Put the mouse pointer somewhere, as the target `mouse`; None takes it away."""
        self._index("world", world, self.worlds)
        thing = self.state.objects[world, self._class(MOUSE)["first"]]
        if x is None and y is None:
            thing["present"] = 0
            return
        x, y = nan if x is None else x, nan if y is None else y  # one of the two alone is no place
        self._finite("pointer", x, y, 0.0)
        thing["x"], thing["y"], thing["present"] = x, y, 1

    def freeze(self, agent: int) -> None:
        """Let a robot fail: it senses nothing and moves no more."""
        self.state.robots["frozen"][self._index("agent", agent, self.agents)] = 1

    # What is refused.

    @property
    def _where(self) -> str:
        return f"world {self.scenario.name!r}"

    def _wrong(self, setting: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where=self._where, setting=setting, problem=problem, remedy=remedy)

    def _listed(self, seeds: Sequence[int]) -> list[int]:
        try:
            return list(seeds)
        except TypeError:  # one number, say
            remedy = "give a list of whole numbers, one for each world: [5]"
            raise self._wrong("seeds", f"are {seeds!r:.60}", remedy) from None

    def _class(self, name: str) -> Any:
        if name not in self.names.classes:
            raise UnknownName(what="class of objects", name=name, where=self._where, known=self.names.classes)
        return self.rules.classes[self.names.classes.index(name)]

    def _index(self, what: str, index: int, count: int) -> int:
        if not _is_whole(index, count - 1):
            raise self._wrong(what, f"is {index!r}", f"give one from 0 to {count - 1}")
        return int(index)

    def _object(self, slot: int, world: int) -> Any:
        """The object in a slot, which has to be there."""
        things = self.state.objects[self._index("world", world, self.worlds)]
        if not things[self._index("slot", slot, len(things))]["present"]:
            there = join_names(map(str, np.flatnonzero(things["present"])))
            raise self._wrong(
                "slot", f"is {slot}, but there is no object with this index", f"give one of {there}"
            )
        return things[slot]

    def _obstacle(self, index: int, world: int) -> Any:
        """The round obstacle of this number, among those that are there."""
        discs = self.state.discs[self._index("world", world, self.worlds)]
        there = np.flatnonzero(discs["radius"] > 0)
        if not len(there):
            raise self._wrong("obstacle", f"is {index}, but there is no such index", "add one first")
        return discs[there[self._index("obstacle", index, len(there))]]

    def _finite(self, what: str, x: float, y: float, third: float) -> None:
        width, height = self.rules.width, self.rules.height
        numbers = all(isinstance(each, int | float | np.floating | np.integer) for each in (x, y, third))
        if not (numbers and 0 <= x <= width and 0 <= y <= height and isfinite(third)):
            problem = f"is ({x}, {y}{f', {third}' if third else ''})"
            where = f"x in [0, {width}] and y in [0, {height}]"
            raise self._wrong(what, problem, f"give {where}, all finite")

    def _free_for(self, what: str, index: int, x: float, y: float, *, world: int, slot: int = -1) -> None:
        """Refuse a place for an object of a class where it cannot be."""
        self._finite(what, x, y, 0.0)
        kind = self.rules.classes[index]
        if kind["solid"]:
            self._free(what, x, y, kind["radius"], world=world, slot=slot)

    def _free(self, what: str, x: float, y: float, radius: float, *, world: int, **but: Any) -> None:
        """Refuse a place for something solid where it overlaps something else."""
        found = find_overlap(self.state, self.rules, self.names, world, x, y, radius, **but)
        if found is not None:
            raise self._wrong(what, f"is ({x}, {y}), which overlaps {found}", "give a free place")

    def check_keys(self, keys: Sequence[ReadingKey]) -> tuple[ReadingKey, ...]:
        """These keys, all of which its robots have or may have; an error as of `check_reading_keys` otherwise."""
        check_reading_keys(keys, readings=self.readings, targets=self.targets, where=self._where)
        return tuple(keys)


_REMADE = ("rules", "_planner", "_plan", "_kernel_worlds", "_room", "_context")
"""Attributes of a world that are made anew in its copies: caches, and what kernels work with."""


def _is_whole(value: object, most: int) -> bool:
    """Whether something is a whole number from 0 to `most`."""
    return isinstance(value, int | np.integer) and 0 <= int(value) <= most
