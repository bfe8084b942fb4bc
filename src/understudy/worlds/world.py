"""Worlds of robots: B worlds side by side, laid out by their seeds from one scenario; a body of B*N robots.

Row w*N + i is robot i of world w. A tick is: everyone senses, everyone decides, everyone moves as far as the free
gaps let it, then loads, then objects come, go and walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import isfinite, tau
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError, UnknownName
from understudy.model.feature import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.model.kit import Kit
from understudy.runtime.body import Channel, Commands, FusedPlan, Reading
from understudy.worlds import snapshots
from understudy.worlds.advancing import advance, obey, sense
from understudy.worlds.checking import check
from understudy.worlds.contexts import Context, Stage, has, shared
from understudy.worlds.grids import grid_for, near_for
from understudy.worlds.kits import channels_of, kit_of, readings_of, targets_of
from understudy.worlds.placing import lay_out
from understudy.worlds.plans import Planner
from understudy.worlds.rules import names_of, rules_of
from understudy.worlds.scenario import MOUSE, Scenario
from understudy.worlds.state import DISC, State
from understudy.worlds.view import WorldView, view


class World:
    """A body of the robots of B worlds of a scenario, one world per seed."""

    def __init__(self, scenario: Scenario, seeds: Sequence[int] = (0,)) -> None:
        check(scenario)
        self.scenario = scenario
        self.rules, self.names = rules_of(scenario), names_of(scenario)
        self.readings: Sequence[Reading] = readings_of(scenario)
        self.channels: Sequence[Channel] = channels_of(scenario)
        self.targets: Sequence[str] = tuple(target.name for target in targets_of(scenario))
        self.worlds, self.robots = len(seeds), self.rules.robots
        self.agents = self.worlds * self.robots
        self._planner = Planner(scenario, self.rules, self.names)
        self._has = has(scenario, self.rules)
        self._plan = lru_cache(16)(self._planner.plan)
        self.reset(seeds)

    @property
    def kit(self) -> Kit:
        """The features, behaviors and targets that go with the scenario."""
        return kit_of(self.scenario)

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self.scenario.tick_s

    @property
    def time_s(self) -> float:
        """Time since the last reset, s; that of the first world."""
        return int(self.state.tick[0]) * self.scenario.tick_s

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

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, one world per seed, as many worlds as before."""
        if len(seeds) != self.worlds or not seeds or not all(0 <= int(seed) < 2**63 for seed in seeds):
            count = max(1, self.worlds)
            raise self._wrong("seeds", f"are {list(seeds)}", f"give {count} from 0 to 2**63 - 1")
        state = lay_out(self.scenario, self.rules, np.asarray(seeds, np.int64))
        state.robots["aim"] = np.nan
        memory = np.full((self.agents, self._planner.slots), np.nan)
        self._begin(state._replace(memory=memory))

    def _begin(self, state: State) -> None:
        self.state = state
        near = near_for(state, self.rules, reach=max(self._planner.reach, self._touch()))
        self._stage = Stage(state, self.rules, near, self._has)
        self._room = shared(self._stage, grid_for(self.rules))
        self._context = lru_cache(8)(lambda keys: Context(self._stage, self._plan(keys), self._room))

    def _touch(self) -> float:
        types = self.rules.types
        return float((types["radius"] + 2.0 * types["speed"]).max()) + float(
            self.rules.classes["radius"].max()
        )

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [B*N] of these keys, absent (NaN) for robots that have no such sensor."""
        out = np.empty((self.agents, len(keys)))
        sense(self._context(self._known(tuple(keys))), self.worlds, out)
        columns = np.ascontiguousarray(out.T)
        return dict(zip(keys, columns, strict=True))

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel left out rests. An unusable command raises, and nothing moves."""
        names = [channel.name for channel in self.channels]
        table = np.zeros((self.agents, 4))
        for channel, column in commands.items():
            if channel not in names:
                raise UnknownName(what="channel", name=channel, where=self._where, known=names)
            table[:, names.index(channel)] = self._column(channel, column)
        obey(self._context(()), self.worlds, table)

    def advance(
        self, plan: FusedPlan, ticks: int, threads: int | None = None, *, until_finished: bool = False
    ) -> None:
        """Sense, decide and act so many times in one go, exactly as tick by tick (see `runtime.body.Fused`)."""
        sensing = self._plan(self._known(plan.keys))
        advance(self._stage, sensing, plan, ticks, threads, until_finished=until_finished)

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        robots = self.state.robots.copy()
        robots["aim"], robots["cosine"], robots["sine"] = (
            np.nan,
            0.0,
            0.0,
        )  # at hand for speed, no part of the state
        state = self.state._replace(robots=robots)
        return snapshots.pack(self.scenario.name, self._settings(), state._asdict())

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of such worlds."""
        arrays = snapshots.unpack(snapshot, self.scenario.name, self._settings(), self.state._asdict())
        self._begin(State(**arrays))

    def _settings(self) -> dict[str, Any]:
        settings: dict[str, Any] = msgspec.to_builtins(self.scenario)
        return settings

    def view(self, world: int = 0) -> WorldView:
        """One world as plain data, for drawing."""
        return view(self.state, self.rules, self.names, world)

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere, as a demonstrator drives it into position; the unit at hand is broken off."""
        self._refuse_outside("place", x, y, heading)
        robot = self.state.robots[agent]
        robot["x"], robot["y"], robot["heading"] = x, y, heading % tau % tau
        for name in ("speed", "spin", "loading", "unloading", "blocked"):
            robot[name] = 0

    def move_object(self, slot: int, x: float, y: float, *, world: int = 0) -> None:
        """Put an object somewhere; slots are those of `view`."""
        self._refuse_outside("move_object", x, y, 0.0)
        thing = self.state.objects[world, slot]
        thing["x"], thing["y"] = x, y

    def add_object(self, name: str, x: float, y: float, *, amount: int = 0, world: int = 0) -> int:
        """Add an object of a class; its slot. SettingError where the world has no room for more of it."""
        kind = self._class(name)
        self._refuse_outside("add_object", x, y, 0.0)
        things = self.state.objects[world, kind["first"] : kind["end"]]
        free = np.flatnonzero((things["present"] == 0) & (things["due"] < 0))
        if not len(free):
            raise self._wrong(
                f"objects {name!r}", f"are {len(things)} already", "remove one, or give more spare_objects"
            )
        slot = int(kind["first"]) + int(free[0])
        self.state.objects[world, slot] = np.zeros((), self.state.objects.dtype)
        thing = self.state.objects[world, slot]
        thing["x"], thing["y"], thing["present"] = x, y, 1
        thing["amount"] = thing["at_first"] = amount
        thing["due"] = thing["captured"] = -1
        return slot

    def remove_object(self, slot: int, *, world: int = 0) -> None:
        """Remove an object; it does not come again."""
        thing = self.state.objects[world, slot]
        thing["present"], thing["due"], thing["amount"] = 0, -1, 0

    def add_obstacle(self, x: float, y: float, radius: float, *, world: int = 0) -> None:
        """Add a round obstacle to a world."""
        self._refuse_outside("add_obstacle", x, y, radius)
        discs = np.zeros((self.worlds, self.state.discs.shape[1] + 1), DISC)
        discs[:, :-1] = self.state.discs
        discs["color"][:, -1] = -1
        discs[world, -1] = (x, y, radius, 2 * radius, -1)
        self._begin(self.state._replace(discs=discs))

    def point(self, x: float | None, y: float | None = None, *, world: int = 0) -> None:
        """Put the mouse pointer somewhere, as the target `mouse`; None takes it away."""
        thing = self.state.objects[world, self._class(MOUSE)["first"]]
        thing["present"] = x is not None and y is not None
        if x is not None and y is not None:
            thing["x"], thing["y"] = x, y

    def freeze(self, agent: int) -> None:
        """Let a robot fail: it senses nothing and moves no more."""
        self.state.robots["frozen"][agent] = 1

    # What is refused.

    @property
    def _where(self) -> str:
        return f"world {self.scenario.name!r}"

    def _wrong(self, setting: str, problem: str, remedy: str) -> SettingError:
        return SettingError(where=self._where, setting=setting, problem=problem, remedy=remedy)

    def _class(self, name: str) -> Any:
        if name not in self.names.classes:
            raise UnknownName(what="class of objects", name=name, where=self._where, known=self.names.classes)
        return self.rules.classes[self.names.classes.index(name)]

    def _refuse_outside(self, what: str, x: float, y: float, third: float) -> None:
        if not (0 <= x <= self.rules.width and 0 <= y <= self.rules.height and isfinite(third)):
            where = f"x in [0, {self.rules.width}] and y in [0, {self.rules.height}]"
            raise self._wrong(what, f"is ({x}, {y})", f"give {where}, all finite")

    def _known(self, keys: tuple[ReadingKey, ...]) -> tuple[ReadingKey, ...]:
        of_targets = {reading.name: reading.of_targets for reading in self.readings}
        for name, target in keys:
            if name not in of_targets or of_targets[name] != (target is not None):
                raise UnknownName(what="reading", name=name, where=self._where, known=list(of_targets))
            if target is not None and target not in self.targets:
                raise UnknownName(what="target", name=target, where=self._where, known=self.targets)
        return keys

    def _column(self, channel: str, column: Column) -> Column:
        values: Column = np.asarray(column, np.float64)
        if values.shape != (self.agents,):
            raise DefinitionError(
                what=f"command {channel!r}",
                problem=f"it has shape {values.shape}",
                remedy=f"give one value per robot: shape ({self.agents},)",
            )
        wrong = np.flatnonzero(~np.isfinite(values))
        if len(wrong):
            raise DefinitionError(
                what=f"command {channel!r}",
                problem=f"it is {values[wrong[0]]} for robot {wrong[0]}",
                remedy="give finite numbers",
            )
        return values
