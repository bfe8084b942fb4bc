"""The paper's foraging world: bring food from sources that deplete to the station (paper section 4.1).

One robot per world, N worlds side by side as rows. The arena spans [0, width] x [0, height].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from math import isfinite, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnknownName
from understudy.model.feature import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.runtime.body import Channel, Commands, Reading
from understudy.worlds import _forage_kernels as _kernels
from understudy.worlds import snapshots
from understudy.worlds.forage_kit import CHANNELS, READINGS, kit
from understudy.worlds.forage_places import lay_out
from understudy.worlds.forage_settings import WHERE, ForageSettings, corner_cases, wrong
from understudy.worlds.forage_view import ForageView, SourceView

__all__ = ["Forage", "ForageSettings", "ForageView", "corner_cases", "kit"]


class Forage:
    """A body of N foraging robots, each in a world of its own that its seed lays out."""

    def __init__(self, seeds: Sequence[int], settings: ForageSettings | None = None) -> None:
        self.settings = ForageSettings() if settings is None else settings
        self.agents = len(seeds)
        self._rest = np.zeros(self.agents)
        self._only = np.zeros(self.agents, np.int64)  # the index of the only station of each world
        self.reset(seeds)

    @property
    def readings(self) -> Sequence[Reading]:
        """What the robot senses."""
        return READINGS

    @property
    def channels(self) -> Sequence[Channel]:
        """What the robot obeys."""
        return CHANNELS

    @property
    def targets(self) -> Sequence[str]:
        """What there is to refer to."""
        return tuple(kit.targets)

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self.settings.tick_s

    @property
    def time_s(self) -> float:
        """Time since the last reset, s."""
        return int(self._state["tick"][0]) * self.settings.tick_s

    @property
    def delivered(self) -> NDArray[np.int64]:
        """Units unloaded at the station [N]."""
        delivered: NDArray[np.int64] = self._state["delivered"].copy()
        return delivered

    @property
    def total(self) -> NDArray[np.int64]:
        """Units there were at first [N], in the sources and on the robot."""
        total: NDArray[np.int64] = self._state["at_first"].sum(axis=1) + self.settings.stored
        return total

    def success(self) -> NDArray[np.bool_]:
        """Whether all food is at the station [N]."""
        return np.equal(self.delivered, self.total)

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, one world per seed, as many worlds as before."""
        if len(seeds) != self.agents or not all(0 <= int(seed) < 2**63 for seed in seeds):
            raise wrong("seeds", f"are {list(seeds)}", f"give {self.agents} from 0 to 2**63 - 1")
        state: dict[str, NDArray[Any]] = lay_out(np.asarray(seeds, np.int64), self.settings)
        state["at_first"] = state["amount"].copy()
        state["stored"] = np.full(self.agents, self.settings.stored, np.int64)
        for name in ("delivered", "loading", "unloading"):
            state[name] = np.zeros(self.agents, np.int64)
        state["tick"] = np.zeros(1, np.int64)
        self._state = state
        self._found: tuple[NDArray[np.int64], Column] | None = None

    def place(self, agent: int, x: float, y: float, heading: float) -> None:
        """Put a robot somewhere, as a demonstrator drives it into position; the unit at hand is broken off.

        SettingError for a place outside the arena.
        """
        low, high_x, high_y = self._bounds()
        if not (low <= x <= high_x and low <= y <= high_y and isfinite(heading)):
            where = f"x in [{low}, {high_x}], y in [{low}, {high_y}] and a finite heading"
            raise wrong("place", f"is ({x}, {y}), heading {heading}", f"give {where}")
        state = self._state
        state["x"][agent], state["y"][agent], state["heading"][agent] = x, y, heading % tau % tau
        state["loading"][agent] = state["unloading"][agent] = 0
        self._found = None

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The columns [N] of these keys; what no key needs is not computed."""
        try:
            return {key: _SENSES[key](self) for key in keys}
        except KeyError as unknown:
            name, known = _spelled(unknown.args[0]), [_spelled(key) for key in _SENSES]
            raise UnknownName(what="reading", name=name, where=WHERE, known=known) from None

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel left out rests. An unusable command raises, and nothing moves."""
        for channel in commands:
            if channel not in _CHANNEL_NAMES:
                raise UnknownName(what="channel", name=channel, where=WHERE, known=_CHANNEL_NAMES)
        drive, turn, load, unload = (self._command(commands, channel) for channel in _CHANNEL_NAMES)
        state, settings = self._state, self.settings
        load_ticks, unload_ticks = settings.load_ticks, settings.unload_ticks
        index, food_range = self._nearest()
        _kernels.transfer(
            index, food_range, self._station_range(), settings.reach, drive, turn, load, unload,
            load_ticks, unload_ticks, settings.capacity,
            state["amount"], state["stored"], state["delivered"], state["loading"], state["unloading"],
        )  # fmt: skip
        _kernels.move(
            state["x"], state["y"], state["heading"], drive, turn,
            settings.forward_speed * settings.tick_s, settings.turning_speed * settings.tick_s,
            *self._bounds(),
        )  # fmt: skip
        state["tick"] += 1
        self._found = None

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        return snapshots.pack(NAME, asdict(self.settings), self._state)

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of this body."""
        self._state = snapshots.unpack(snapshot, NAME, asdict(self.settings), self._state)
        self._found = None

    def view(self, agent: int = 0) -> ForageView:
        """One robot and its world, for drawing."""
        state, settings = self._state, self.settings
        names = ("source_x", "source_y", "amount", "at_first")
        sources = zip(*(state[name][agent].tolist() for name in names), strict=True)
        return ForageView(
            width=settings.width,
            height=settings.height,
            reach=settings.reach,
            radius=settings.radius,
            time_s=self.time_s,
            x=float(state["x"][agent]),
            y=float(state["y"][agent]),
            heading=float(state["heading"][agent]),
            stored=int(state["stored"][agent]),
            capacity=settings.capacity,
            delivered=int(state["delivered"][agent]),
            station=(float(state["station_x"][agent]), float(state["station_y"][agent])),
            sources=tuple(SourceView(*source) for source in sources if source[-1] > 0),
        )

    def _bounds(self) -> tuple[float, float, float]:
        settings = self.settings
        return settings.radius, settings.width - settings.radius, settings.height - settings.radius

    def _command(self, commands: Commands, channel: str) -> Column:
        column = commands.get(channel)
        if column is None:
            return self._rest
        column = np.asarray(column, np.float64)
        what = f"command for channel {channel!r}"
        if column.shape != (self.agents,):
            shape = f"give one number per agent: shape ({self.agents},)"
            raise DefinitionError(what=what, problem=f"its shape is {column.shape}", remedy=shape)
        row = _kernels.first_not_finite(column)
        if row >= 0:
            problem = f"it is {column[row]} for agent {row}"
            raise DefinitionError(what=what, problem=problem, remedy="give a finite number, or leave it out")
        return column

    def _nearest(self) -> tuple[NDArray[np.int64], Column]:
        """Index and range of the nearest food [N], found once per tick."""
        if self._found is None:
            state = self._state
            self._found = np.empty(self.agents, np.int64), np.empty(self.agents)
            sources = state["source_x"], state["source_y"], state["amount"]
            _kernels.nearest(state["x"], state["y"], *sources, *self._found)
        return self._found

    def _station_range(self) -> Column:
        state, out = self._state, np.empty(self.agents)
        _kernels.ranges(state["x"], state["y"], state["station_x"], state["station_y"], out)
        return out

    def _bearing(self, x: NDArray[np.float64], y: NDArray[np.float64], index: NDArray[np.int64]) -> Column:
        state, out = self._state, np.empty(self.agents)
        _kernels.bearings(state["x"], state["y"], state["heading"], x, y, index, out)
        return out

    def _station_bearing(self) -> Column:
        state = self._state
        return self._bearing(state["station_x"][:, None], state["station_y"][:, None], self._only)

    def _food_bearing(self) -> Column:
        return self._bearing(self._state["source_x"], self._state["source_y"], self._nearest()[0])

    def _food_here(self) -> Column:
        index, food_range = self._nearest()
        rows = np.flatnonzero(food_range <= self.settings.reach)
        here = np.zeros(self.agents)
        here[rows] = self._state["amount"][rows, index[rows]]
        return here


NAME = "forage"
_CHANNEL_NAMES = tuple(channel.name for channel in CHANNELS)
_SENSES: Mapping[ReadingKey, Callable[[Forage], Column]] = {
    ("range", "station"): Forage._station_range,
    ("range", "nearest_food"): lambda world: world._nearest()[1].copy(),
    ("bearing", "station"): Forage._station_bearing,
    ("bearing", "nearest_food"): Forage._food_bearing,
    ("food_here", None): Forage._food_here,
    ("food_stored", None): lambda world: world._state["stored"].astype(np.float64),
    ("food_left", None): lambda world: (world._nearest()[0] >= 0).astype(np.float64),
    ("station_here", None): lambda world: (world._station_range() <= world.settings.reach).astype(np.float64),
}


def _spelled(key: ReadingKey) -> str:
    reading, target = key
    return reading if target is None else f"{reading} of {target}"
