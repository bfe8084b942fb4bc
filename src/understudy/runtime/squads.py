"""Squads as a body: what S coordinators of one sort sense of their members, and how they order them about.

A squad is a body (ARCHITECTURE section 1): its readings are statistics over its members, its basic behaviors are
theirs. Its members may be robots or coordinators; nothing here knows which.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import floor
from typing import Protocol, TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnknownName
from understudy.model.binding import Binding
from understudy.model.feature import Percept, ReadingKey
from understudy.model.kinds import BOOLEAN, Column, Kind
from understudy.model.squad import Duty, Order, Squad, Statistic
from understudy.runtime.body import ISSUED, ORDER, Body, Channel, Commands, Reading
from understudy.runtime.program import IDLE_PROGRAM, Program
from understudy.runtime.roster import Roster
from understudy.runtime.surveying import Memory, surveyed

Finds: TypeAlias = Callable[[str, Binding], Program]
"""A behavior that members can run, ready to run."""


class Runner(Protocol):
    """What runs the agents of a body: interpreters or an engine."""

    @property
    def keys(self) -> tuple[ReadingKey, ...]:
        """What they look at."""
        ...

    def begin(self, agents: NDArray[np.intp], program: Program) -> None:
        """Let these agents run a program from its start."""
        ...

    def raised(self, flag: str) -> NDArray[np.bool_]:
        """Which agents have raised a flag [N]."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """Pulse every agent on one snapshot; the commands of all."""
        ...


@dataclass
class Layer:
    """A body with those who run its agents, and what it has sensed in this tick."""

    body: Body
    runner: Runner
    percept: Percept = field(default_factory=dict)


@dataclass(frozen=True)
class Band:
    """Members of one sort: agents of a layer, who can be ordered to run what `finds` finds."""

    name: str
    layer: Layer
    finds: Finds


SpelledDuty: TypeAlias = tuple[str, dict[str, str], str | None, str | None]


class Kept(msgspec.Struct):
    """What squads are at: the orders they gave and when, their members' duties, what they remember."""

    orders: list[list[SpelledDuty] | None]
    issued: list[float]
    duties: list[SpelledDuty | None]
    memories: list[tuple[str, str | None, list[float], list[float], list[list[float]]]]


CHANNELS = (
    Channel(ORDER, doc="Which order stands."),
    Channel(ISSUED, unit="s", doc="When it was given."),
)


class Squads:
    """S squads of one sort over the bodies of their members: a body whose agents are coordinators."""

    def __init__(self, squad: Squad, roster: Roster, bands: Sequence[Band], ground: Body) -> None:
        self.squad, self.roster, self.bands = squad, roster, tuple(bands)
        self._ground = ground
        self.agents = roster.squads
        below = [reading for band in bands for reading in band.layer.body.readings]
        self._kinds = {reading.name: reading.kind for reading in reversed(below)}
        self.readings: Sequence[Reading] = readings_of(squad, below)
        self.channels: Sequence[Channel] = CHANNELS
        self.targets: Sequence[str] = ground.targets
        self._statistics = {each.name: each for each in squad.statistics}
        self._orders: list[Order | None] = [None]
        self._memories: dict[ReadingKey, Memory] = {}
        self.clear()

    def clear(self) -> None:
        """Begin anew: nothing remembered, nothing ordered."""
        self._memories.clear()
        self.order = np.zeros(self.agents, np.intp)
        self.issued = np.full(self.agents, np.nan)
        self.duty: list[Duty | None] = [None] * len(self.roster)

    @property
    def tick_s(self) -> float:
        """The length of a tick, s."""
        return self._ground.tick_s

    @property
    def time_s(self) -> float:
        """The clock of the robots, s."""
        return self._ground.time_s

    # Keeping

    def kept(self) -> Kept:
        """What they are at, for `restore`."""
        orders = [None if each is None else [_spelled(duty) for duty in each.duties] for each in self._orders]
        memories = [
            (name, target, memory.last.tolist(), memory.since.tolist(), memory.values.tolist())
            for (name, target), memory in self._memories.items()
        ]
        duties = [None if duty is None else _spelled(duty) for duty in self.duty]
        return Kept([orders[number] for number in self.order], self.issued.tolist(), duties, memories)

    def restore(self, kept: Kept) -> None:
        """Go back to what they were at; their members begin what they were ordered to do."""
        orders = [None if each is None else Order(tuple(map(_read, each))) for each in kept.orders]
        self.order = np.array([0 if each is None else self.numbered(each) for each in orders], np.intp)
        self.issued = np.array(kept.issued)
        self.duty = [None if duty is None else _read(duty) for duty in kept.duties]
        for name, target, last, since, values in kept.memories:
            memory = self._memories[name, target] = Memory(self._statistics[name], self.agents, self.tick_s)
            memory.last, memory.since = np.array(last), np.array(since)
            memory.values = np.array(values).reshape(memory.values.shape)
        self._start(np.arange(len(self.roster)))

    # Sensing

    def needs(self, keys: Sequence[ReadingKey]) -> list[ReadingKey]:
        """What members have to sense, so that these readings are there."""
        found = [(self._statistics[name].reading, target) for name, target in self._remembered(keys)]
        return [(reading, target) for reading, target in found if reading is not None]

    def _remembered(self, keys: Sequence[ReadingKey]) -> list[ReadingKey]:
        """The keys, and those whose past has to be followed."""
        return list(dict.fromkeys((*keys, *self._memories)))

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Statistics [S] over what the members have sensed in this tick, and the flags that they raised before it."""
        counted = np.ones(len(self.roster), np.bool_)
        return {key: self._sensed(key, counted) for key in self._remembered(keys)}

    def _sensed(self, key: ReadingKey, counted: NDArray[np.bool_]) -> Column:
        statistic, target = self._statistics[key[0]], key[1]
        chosen = counted & self._in_role(statistic.role)
        found = surveyed(
            statistic, self._gathered(statistic, target), chosen, self.roster, self._kind(statistic)
        )
        if not statistic.timed:
            return found
        if key not in self._memories:
            self._memories[key] = Memory(statistic, self.agents, self.tick_s)
        return self._memories[key].seen(found, self.time_s)

    def _kind(self, statistic: Statistic) -> Kind | None:
        return None if statistic.reading is None else self._kinds[statistic.reading]

    def _in_role(self, name: str | None) -> NDArray[np.bool_]:
        if name is None:
            return np.ones(len(self.roster), np.bool_)
        names = [role.name for role in self.squad.roles]
        inside: NDArray[np.bool_] = self.roster.role == (names.index(name) if name in names else -1)
        return inside

    def _gathered(self, statistic: Statistic, target: str | None) -> Column:
        """What each member reads, or whether its flag is up [M]; of nothing in particular, yes."""
        if statistic.reading is None and statistic.flag is None:
            return np.ones(len(self.roster))
        values = np.full(len(self.roster), np.nan)
        for number, band in enumerate(self.bands):
            there = self.roster.band == number
            if statistic.flag is not None:
                values[there] = band.layer.runner.raised(statistic.flag)[self.roster.row[there]]
            elif (statistic.reading, target) in band.layer.percept:
                values[there] = band.layer.percept[statistic.reading or "", target][self.roster.row[there]]
        return values

    # Ordering

    def numbered(self, order: Order) -> int:
        """The number of an order; UnknownName where members do not know what it says."""
        if order not in self._orders:
            self._check(order)
            self._orders.append(order)
        return self._orders.index(order)

    def _check(self, order: Order) -> None:
        names = [role.name for role in self.squad.roles]
        for duty in order.duties:
            for band in np.unique(self.roster.band[self._in_role(duty.role)]).tolist():
                self.bands[band].finds(duty.behavior, duty.binding)
            if duty.role not in (None, *names):
                raise UnknownName(
                    what="role", name=duty.role or "", where=f"squad {self.squad.name}", known=names
                )

    def act(self, commands: Commands) -> None:
        """Give orders: where a state was entered anew, the members stop what they do and start what it says."""
        order, issued = commands[ORDER].astype(np.intp), commands[ISSUED]
        anew = (order != self.order) | (issued != self.issued)
        self.order, self.issued = order, issued.copy()
        for number in np.unique(order[anew]).tolist():
            members = self.roster.of_squads(anew & (order == number))
            self._assign(self._orders[number], members)
            self._start(members)

    def _assign(self, order: Order | None, members: NDArray[np.intp]) -> None:
        for member in members.tolist():
            self.duty[member] = None
        if order is None:
            return
        names = [role.name for role in self.squad.roles]
        for squad in np.unique(self.roster.squad[members]).tolist():
            mine = members[self.roster.squad[members] == squad]
            _share(order, {member: names[self.roster.role[member]] for member in mine.tolist()}, self.duty)

    def _start(self, members: NDArray[np.intp]) -> None:
        together: dict[tuple[int, Duty | None], list[int]] = {}
        for member in members.tolist():
            together.setdefault((int(self.roster.band[member]), self.duty[member]), []).append(member)
        for (number, duty), mine in together.items():
            band = self.bands[number]
            program = IDLE_PROGRAM if duty is None else band.finds(duty.behavior, duty.binding)
            band.layer.runner.begin(self.roster.row[mine], program)


def _spelled(duty: Duty) -> SpelledDuty:
    return duty.behavior, dict(duty.binding), duty.role, None if duty.share is None else str(duty.share)


def _read(spelled: SpelledDuty) -> Duty:
    behavior, binding, role, share = spelled
    return Duty(behavior, Binding(binding), role, None if share is None else Fraction(share))


def _share(order: Order, roles: Mapping[int, str], duties: list[Duty | None]) -> None:
    """Deal the duties of an order to the members of one squad, in their order."""
    left = dict(roles)
    for duty in order.duties:
        fit = [member for member, role in left.items() if duty.role in (None, role)]
        everyone = sum(duty.role in (None, role) for role in roles.values())
        if duty.share is not None:
            share = duty.share if duty.share >= 1 else duty.share * everyone
            fit = fit[: max(1, floor(share + 0.5))]
        for member in fit:
            duties[member] = duty
            del left[member]


def readings_of(squad: Squad, below: Sequence[Reading]) -> tuple[Reading, ...]:
    """What a coordinator senses, given what its members do."""
    named = {reading.name: reading for reading in reversed(below)}
    return tuple(_reading(each, named) for each in squad.statistics)


def _reading(statistic: Statistic, readings: Mapping[str, Reading]) -> Reading:
    """What a statistic offers as a reading of the squad."""
    of = readings.get(statistic.reading or "")
    kind = statistic.kind(of.kind if of is not None else BOOLEAN)
    unit = "s" if statistic.since else "" if of is None or kind == BOOLEAN else of.unit
    return Reading(statistic.name, kind, unit, of_targets=of is not None and of.of_targets, doc=statistic.doc)
