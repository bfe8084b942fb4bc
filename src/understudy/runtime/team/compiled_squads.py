"""Squads as arrays, for kernels in which whole teams run many ticks by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import ReadingKey
from understudy.model.squad import TELLING, YES_OR_NO, Statistic
from understudy.model.value_kinds import BOOLEAN, Toroidal
from understudy.runtime.engine.engine import Engine
from understudy.runtime.feature_columns import get_feature_key
from understudy.runtime.link import IDLE_PROGRAM
from understudy.runtime.team.members import AgentLayer
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.statistics import StatisticMemory

HOW = ("any", "all", "none", "count", "fraction", "mean", "minimum", "maximum", "spread")
READING, FLAG, THERE = range(3)
NOW, WITHIN, SINCE, FOR = range(4)
NOWHERE = -1

STATISTIC = np.dtype(
    [
        ("how", "i4"),
        ("of", "i4"),  # READING, FLAG or THERE
        ("role", "i4"),  # -1: everybody
        ("when", "i4"),  # NOW, WITHIN, SINCE or FOR
        ("plain", "i8"),  # whether yes is what counts, not least and below
        ("least", "f8"),
        ("below", "f8"),
        ("seconds", "f8"),
    ],
    align=True,
)
MEMBER = np.dtype([("layer", "i8"), ("row", "i8"), ("role", "i8"), ("band", "i8")], align=True)

Bands: TypeAlias = tuple[tuple[Any, ...], ...]
"""Of each layer: tables, stacks, values [N, V], which agents are present [N], and the program that each runs [N]."""
Leads: TypeAlias = tuple[tuple[Any, ...], ...]
"""Of each layer of squads: the arrays that `_SquadLayer.record` returns."""


class SquadTables(NamedTuple):
    """All data of a team for the kernels (see `_squad_kernels.py`), and the readings that the robots have to sense."""

    bands: Bands
    leads: Leads
    keys: tuple[ReadingKey, ...]


class SquadCompiler:
    """A compiler of a team's layers (robots first, then their coordinators level by level) into tables for kernels.

    `is_possible` says whether kernels can run a team; others run in Python.
    """

    def __init__(
        self, layers: Sequence[AgentLayer], keys: Sequence[tuple[ReadingKey, ...]], worlds: int
    ) -> None:
        self._layers, self._worlds = layers, worlds
        self._columns = [_columns(layer, needed) for layer, needed in zip(layers, keys, strict=True)]
        self._led = [
            _SquadLayer(layer.body, layers, self._columns, level + 1, worlds)
            for level, layer in enumerate(layers[1:])
            if isinstance(layer.body, SquadBody)
        ]

    @staticmethod
    def is_possible(layers: Sequence[AgentLayer]) -> bool:
        """Return whether all parts are data, messages take no time, no duty is shared out, and no angle is averaged."""
        engines = [layer.runner for layer in layers]
        if len(layers) < 2 or not all(
            isinstance(each, Engine) and each.plan() is not None for each in engines
        ):
            return False
        return all(isinstance(layer.body, SquadBody) and _is_plain(layer.body) for layer in layers[1:])

    def make_tables(self) -> SquadTables:
        """Make arrays of the present state. Changes that kernels make reach the team when `write_back` is called."""
        bands = []
        for layer, columns in zip(self._layers, self._columns, strict=True):
            engine, agents = _engine(layer), layer.body.agents
            values, there = np.full((agents, max(1, len(columns))), np.nan), np.ones(agents, np.bool_)
            bands.append((tuple(engine.compiled.tables), tuple(engine.stacks), values, there, engine.running))
        return SquadTables(tuple(bands), tuple(led.record() for led in self._led), tuple(self._columns[0]))

    def write_back(self) -> None:
        """Write the memory of squads back."""
        for led in self._led:
            led.write_back()


def _engine(layer: AgentLayer) -> Engine:
    if not isinstance(layer.runner, Engine):
        raise TypeError("agents that no engine runs")
    return layer.runner


def _columns(layer: AgentLayer, needed: Sequence[ReadingKey]) -> list[ReadingKey]:
    """List the readings in the order of a feature vector, and then those of the statistics above."""
    engine = _engine(layer)
    own = [get_feature_key(bound) for bound in engine.compiled.features]
    return [*own, *(key for key in needed if key not in own)]


def _is_plain(body: SquadBody) -> bool:
    if not body.reports.is_perfect or any(
        duty.share for order in body.ordering.all_orders for duty in order.duties
    ):
        return False
    engine = next(iter(body.readings), None)
    return engine is None or (
        not any(
            isinstance(body.kind_of(each), Toroidal) and each.how not in TELLING
            for each in body.squad.statistics
        )
        and not any(each.is_timed and each.how not in YES_OR_NO for each in body.squad.statistics)
    )


class _SquadLayer:
    """One layer of squads as arrays."""

    def __init__(
        self,
        body: SquadBody,
        layers: Sequence[AgentLayer],
        columns: Sequence[Sequence[ReadingKey]],
        level: int,
        worlds: int,
    ) -> None:
        self._body, self._squads = body, body.agents // worlds
        self._keys = columns[level]
        numbers = {id(layer): number for number, layer in enumerate(layers)}
        roster = body.roster
        self._members = np.zeros(len(roster), MEMBER)
        self._members["row"], self._members["role"], self._members["band"] = (
            roster.row,
            roster.role,
            roster.band,
        )
        of_band = np.array([numbers.get(id(band.layer), 0) for band in body.bands], np.int64)
        self._members["layer"] = of_band[roster.band]
        self._first = np.searchsorted(roster.squad, np.arange(body.agents + 1)).astype(np.int64)
        self._statistics = np.zeros(len(self._keys), STATISTIC)
        self._sources = np.full((len(self._keys), len(layers)), NOWHERE, np.int32)
        for index, (name, target) in enumerate(self._keys):
            statistic = body.statistic(name)
            self._statistics[index] = _record(statistic, body)
            for number, (layer, of_layer) in enumerate(zip(layers, columns, strict=True)):
                self._sources[index, number] = _source(statistic, target, layer, of_layer)
        drops = (body.squad.drops, None) if body.squad.drops else None
        self._drops = np.array(
            [of.index(drops) if drops in of else NOWHERE for of in map(list, columns)], np.int64
        )
        engine = _engine(layers[level])
        self._ordered = engine.orders
        self._duties = body.ordering.compute_fixed_assignments()
        self._roots = self._rooted(layers)

    def _rooted(self, layers: Sequence[AgentLayer]) -> NDArray[np.int32]:
        """Return the root of a member of each band for each duty."""
        ordering, bands = self._body.ordering, self._body.bands
        roots = np.full((len(ordering.duties), len(bands)), NOWHERE, np.int32)
        for number, fits in ordering.find_assignable_groups().items():
            duty = ordering.duties[number]
            for band in fits:
                engine = _engine(bands[band].layer)
                program = IDLE_PROGRAM if duty is None else bands[band].finds(duty.behavior, duty.binding)
                roots[number, band] = engine.root_of(program)
        return roots

    def record(self) -> tuple[Any, ...]:
        """Return the arrays of the layer, in the order that the kernels expect.

        Statistics, sources, members, the first member of each squad, dropouts, orders by basic behavior, counted
        members, when a statistic was last yes and since when, the state of the orders, squads in a world.
        """
        body = self._body
        counted = np.ones(len(body.roster), np.bool_)
        memories = [body.memory(key) for key in self._keys]
        nothing = np.full(body.agents, np.nan)
        self._last = np.array([nothing if each is None else each.last for each in memories]).reshape(
            -1, body.agents
        )
        self._since = np.array([nothing if each is None else each.since for each in memories]).reshape(
            -1, body.agents
        )
        state = (*body.ordering.state, self._duties, self._roots)
        return (
            self._statistics, self._sources, self._members, self._first, self._drops, self._ordered,
            counted, self._last, self._since, state, self._squads,
        )  # fmt: skip

    def write_back(self) -> None:
        """Write the memory of these squads back."""
        for index, key in enumerate(self._keys):
            memory = self._body.memory(key)
            if isinstance(memory, StatisticMemory):
                memory.last, memory.since = self._last[index].copy(), self._since[index].copy()


def _record(statistic: Statistic, body: SquadBody) -> tuple[float, ...]:
    kind = body.kind_of(statistic)
    of = READING if statistic.reading is not None else FLAG if statistic.flag is not None else THERE
    roles = [role.name for role in body.squad.roles]
    role = NOWHERE if statistic.role is None else roles.index(statistic.role)
    when = WITHIN if statistic.within_s else SINCE if statistic.since else FOR if statistic.for_s else NOW
    plain = kind is None or (kind == BOOLEAN and statistic.least is None and statistic.below is None)
    least = -np.inf if statistic.least is None else statistic.least
    below = np.inf if statistic.below is None else statistic.below
    seconds = round(statistic.within_s or statistic.for_s or 0.0, 9)
    return HOW.index(statistic.how), of, role, when, plain, least, below, seconds


def _source(
    statistic: Statistic, target: str | None, layer: AgentLayer, columns: Sequence[ReadingKey]
) -> int:
    """Return where a layer has the subject of a statistic: a column, or the number of a flag."""
    if statistic.reading is not None:
        key = statistic.reading, target
        return columns.index(key) if key in columns else NOWHERE
    engine = _engine(layer)
    return engine.compiled.flags.get(statistic.flag or "", NOWHERE)
