"""Squads as a body: the statistics that S coordinators of one sort sense over their members, and the orders they give.

A squad is a body: its readings are statistics over its members, its basic behaviors are theirs. Members may be robots
or coordinators; this module makes no difference between them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.model.binding import Binding
from understudy.model.drawing import format_number_of, format_repr
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import TELLING, Assignment, Order, Squad, Statistic
from understudy.model.value_kinds import BOOLEAN, Column, Kind
from understudy.runtime.body import ISSUED, ORDER, Body, Channel, Commands, Reading, check_reading_keys
from understudy.runtime.body_wrapper import BodyWrapper
from understudy.runtime.team.comms import CommsChannel, MemberReports, Traffic, make_traffic
from understudy.runtime.team.members import MemberGroup, Membership
from understudy.runtime.team.order_dispatch import OrderDispatcher
from understudy.runtime.team.statistics import StatisticMemory, compute_statistic

SpelledDuty: TypeAlias = tuple[str, dict[str, str]]
SpelledOrder: TypeAlias = list[tuple[str, dict[str, str], str | None, str | None]]


class SquadState(msgspec.Struct):
    """The state of squads: the orders they gave and when, the orders that reached members, and their memory."""

    orders: list[SpelledOrder | None]
    issued: list[float]
    duties: list[SpelledDuty | None]
    answering: list[float]
    memories: list[tuple[str, str | None, list[float], list[float], list[list[float]], list[float]]]


CHANNELS = (
    Channel(ORDER, doc="Which order stands."),
    Channel(ISSUED, unit="s", doc="When it was given."),
)


class SquadBody(BodyWrapper[Body]):
    """S squads of one sort over the bodies of their members: a body whose agents are coordinators.

    Without a delay or loss, orders and reports arrive at once.
    """

    def __init__(
        self,
        squad: Squad,
        roster: Membership,
        bands: Sequence[MemberGroup],
        ground: Body,
        radio: CommsChannel | None = None,
    ) -> None:
        super().__init__(ground)
        self.squad, self.roster, self.bands = squad, roster, tuple(bands)
        self.agents = roster.squads
        mine = [bands[band] for band in np.unique(roster.band).tolist()]
        below = [reading for band in mine for reading in band.layer.body.readings]
        self._kinds = {reading.name: reading.kind for reading in reversed(below)}
        self.readings, self.channels = list_squad_readings(squad, below), CHANNELS
        self._statistics = {each.name: each for each in squad.statistics}
        self._memories: dict[ReadingKey, StatisticMemory] = {}
        self._checked: set[ReadingKey] = set()
        self.reports = MemberReports(roster, self.bands, radio, squad.drops, self.tick_s)
        self.ordering = OrderDispatcher(squad, roster, self.bands, radio)
        self._roles: dict[str | None, NDArray[np.bool_]] = {None: np.ones(len(roster), np.bool_)}
        self._roles |= {role.name: roster.role == number for number, role in enumerate(squad.roles)}
        self.clear()

    def __repr__(self) -> str:
        squads, members = format_number_of(self.agents, "squad"), format_number_of(len(self.roster), "member")
        return format_repr(self, f"of {self.squad.name!r}", squads, members)

    def clear(self) -> None:
        """Withdraw all orders, and clear the memory."""
        self._memories.clear()
        self.reports.clear()
        self.ordering.clear()
        self._counted = np.ones(len(self.roster), np.bool_)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """The squads that have no member left [S]."""
        left = np.bincount(self.roster.squad, self._counted, minlength=self.agents)
        nobody: NDArray[np.bool_] = left == 0
        return nobody

    # Sensing

    def list_needed_readings(self, keys: Sequence[ReadingKey]) -> list[ReadingKey]:
        """List the readings that members have to sense for these readings of the squad."""
        subjects = [(self._statistics[name].reading, target) for name, target in self._remembered(keys)]
        needed = [(reading, target) for reading, target in subjects if reading is not None]
        return needed if self.squad.drops is None else [*needed, (self.squad.drops, None)]

    def _remembered(self, keys: Sequence[ReadingKey]) -> list[ReadingKey]:
        """Return the keys, and those whose past has to be followed."""
        return list(dict.fromkeys((*keys, *self._memories)))

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Compute statistics [S] over members' readings of this tick and the flags that they raised before it."""
        self._check(keys)
        now = self.time_s
        self._counted = self.reports.select_present(now)
        return {key: self._sensed(key, now) for key in self._remembered(keys)}

    def _check(self, keys: Sequence[ReadingKey]) -> None:
        if not self._checked.issuperset(keys):  # asked at every tick, mostly for what it was asked before
            where = f"squad {self.squad.name!r}"
            check_reading_keys(keys, readings=self.readings, targets=self.targets, where=where)
            self._checked.update(keys)

    def _sensed(self, key: ReadingKey, now: float) -> Column:
        statistic, target = self._statistics[key[0]], key[1]
        kind = self.kind_of(statistic)
        values = self._reported(statistic, target, now)
        statistics = compute_statistic(
            statistic, values, self._counted & self._roles[statistic.role], self.roster, kind
        )
        memory = self.memory(key)
        return statistics if memory is None else memory.update(statistics, now)

    def statistic(self, name: str) -> Statistic:
        """Get the statistic of this name."""
        return self._statistics[name]

    def kind_of(self, statistic: Statistic) -> Kind | None:
        """Get the kind of a statistic's reading; None if it is not of a reading."""
        return None if statistic.reading is None else self._kinds[statistic.reading]

    def memory(self, key: ReadingKey) -> StatisticMemory | None:
        """Get the memory of a reading; None if it needs none."""
        statistic = self._statistics[key[0]]
        if not statistic.is_timed:
            return None
        if key not in self._memories:
            self._memories[key] = self._memory(statistic)
        return self._memories[key]

    def _memory(self, statistic: Statistic) -> StatisticMemory:
        kind = statistic.kind(self.kind_of(statistic))
        return StatisticMemory(statistic, kind, self.agents, self.tick_s)

    def _reported(self, statistic: Statistic, target: str | None, now: float) -> Column:
        """Return each member's reading, or whether it has raised the flag [M]; yes if there is no subject."""
        if statistic.reading is not None:
            return self.reports.readings((statistic.reading, target), now)
        if statistic.flag is None:
            return np.ones(len(self.roster))
        ordering = self.ordering
        return self.reports.flags(statistic.flag, ordering.answering, ordering.issued[self.roster.squad], now)

    @property
    def traffic(self) -> Traffic:
        """The traffic of a tick on a network."""
        used = [self._statistics[name] for name in {reading.name for reading in self.readings}]
        readings = {each.reading for each in used if each.reading is not None}
        flags = {each.flag for each in used if each.flag is not None}
        return make_traffic(len(self.roster), len(readings), len(flags))

    # Ordering

    @property
    def presence(self) -> NDArray[np.bool_]:
        """Whether each member was present when the squad sensed last [M]."""
        return self._counted

    def index_order(self, order: Order) -> int:
        """Return the number of an order; UnknownName if members do not have the behavior that it names."""
        return self.ordering.index_order(order)

    def act(self, commands: Commands) -> None:
        """Give orders: where a coordinator entered a state, its members stop and begin what the order says."""
        tick = round(self.time_s / self.tick_s)
        self.ordering.issue(commands[ORDER].astype(np.intp), commands[ISSUED], self._counted, tick)

    # Keeping

    def capture_state(self) -> SquadState:
        """Return the state, to be passed to `restore`."""
        orders, duties = self.ordering.orders, self.ordering.duty
        memories = [
            (
                name,
                target,
                memory.last.tolist(),
                memory.since.tolist(),
                memory.values.tolist(),
                memory.times.tolist(),
            )
            for (name, target), memory in self._memories.items()
        ]
        return SquadState(
            [None if order is None else [_spelled(duty) for duty in order.duties] for order in orders],
            self.ordering.issued.tolist(),
            [None if duty is None else (duty.behavior, dict(duty.binding)) for duty in duties],
            self.ordering.answering.tolist(),
            memories,
        )

    def restore(self, state: SquadState) -> None:
        """Go back to a state; members begin the duties that they had."""
        orders = [
            None if each is None else Order(tuple(_read(*duty) for duty in each)) for each in state.orders
        ]
        duties = [None if duty is None else _read(*duty) for duty in state.duties]
        self.ordering.restore(orders, np.array(state.issued), duties, np.array(state.answering))
        for name, target, last, since, values, times in state.memories:
            memory = self._memories[name, target] = self._memory(self._statistics[name])
            memory.last, memory.since = np.array(last), np.array(since)
            memory.values = np.array(values).reshape(memory.values.shape)
            memory.times = np.array(times)


def _spelled(duty: Assignment) -> tuple[str, dict[str, str], str | None, str | None]:
    return duty.behavior, dict(duty.binding), duty.role, None if duty.share is None else str(duty.share)


def _read(
    behavior: str, binding: Mapping[str, str], role: str | None = None, share: str | None = None
) -> Assignment:
    return Assignment(behavior, Binding(binding), role, None if share is None else Fraction(share))


def list_squad_readings(squad: Squad, below: Sequence[Reading]) -> tuple[Reading, ...]:
    """List the readings of a coordinator, given those of its members."""
    named = {reading.name: reading for reading in reversed(below)}
    return tuple(_reading(each, named) for each in squad.statistics)


def _reading(statistic: Statistic, readings: Mapping[str, Reading]) -> Reading:
    """Make the reading of the squad that a statistic offers."""
    of = readings.get(statistic.reading or "")
    kind = statistic.kind(of.kind if of is not None else BOOLEAN)
    unit = "s" if statistic.since else "" if of is None or statistic.how in TELLING else of.unit
    return Reading(statistic.name, kind, unit, of_targets=of is not None and of.of_targets, doc=statistic.doc)
