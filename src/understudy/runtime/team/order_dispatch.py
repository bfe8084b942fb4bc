"""Orders: the duty of each of a coordinator's members, and the time at which the order reaches the member."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnknownName
from understudy.model.squad import Assignment, Order, Squad
from understudy.model.value_kinds import Column
from understudy.runtime.link import IDLE_PROGRAM
from understudy.runtime.team.comms import DOWN, CommsChannel, DelayedValues
from understudy.runtime.team.members import MemberGroup, Membership

SAME_S = 1e-6
"""The difference below which times are equal: a restored run state knows its start only as a duration, rounded."""


class OrderDispatcher:
    """The orders of S squads.

    `duty` is what each of the M members was last ordered to do, and `answering` [M] when the order was given to which
    that belongs; with delayed messages, both are of the last order that arrived. `meant` and `heard` [M] are indices
    into `duties`, the list of all that were ever ordered.
    """

    def __init__(
        self, squad: Squad, roster: Membership, bands: Sequence[MemberGroup], radio: CommsChannel | None
    ) -> None:
        self.squad, self.roster, self.bands, self._radio = squad, roster, bands, radio
        self._orders: list[Order | None] = [None]
        self.duties: list[Assignment | None] = [None]
        self.clear()

    def clear(self) -> None:
        """Withdraw all orders."""
        self.order = np.zeros(self.roster.squads, np.intp)
        self.issued = np.full(self.roster.squads, np.nan)
        self.meant = np.zeros(len(self.roster), np.intp)
        self.heard = np.zeros(len(self.roster), np.intp)
        self.answering = np.full(len(self.roster), np.nan)
        radio = self._radio
        self._delayed = None if radio is None else (DelayedValues(radio, DOWN), DelayedValues(radio, DOWN))

    @property
    def duty(self) -> list[Assignment | None]:
        """The duty of each member, by the last order that reached it."""
        return [self.duties[number] for number in self.heard.tolist()]

    @property
    def orders(self) -> list[Order | None]:
        """The order of each squad."""
        return [self._orders[number] for number in self.order.tolist()]

    @property
    def all_orders(self) -> list[Order]:
        """All orders that exist."""
        return [order for order in self._orders if order is not None]

    @property
    def state(self) -> tuple[NDArray[Any], ...]:
        """The present state, to be changed in place: order, issued [S], meant, heard, answering [M]."""
        return self.order, self.issued, self.meant, self.heard, self.answering

    def compute_fixed_assignments(self) -> NDArray[np.int64]:
        """Compute the duty that each order gives to members of each role [orders, roles], if none is shared out."""
        assignments = np.zeros((len(self._orders), len(self.squad.roles)), np.int64)
        for number, order in enumerate(self._orders):
            for place, role in enumerate(self.squad.roles):
                duties = () if order is None else order.duties
                fit = next((duty for duty in duties if duty.role in (None, role.name)), None)
                assignments[number, place] = 0 if fit is None else self._number(fit)
        return assignments

    def find_assignable_groups(self) -> dict[int, set[int]]:
        """Find the bands of members that may be ordered to do each duty."""
        dealt = self.compute_fixed_assignments()
        bands_by_duty: dict[int, set[int]] = {0: set(range(len(self.bands)))}
        for place in range(len(self.squad.roles)):
            bands = set(np.unique(self.roster.band[self.roster.role == place]).tolist())
            for duty in dealt[:, place].tolist():
                bands_by_duty[duty] = bands_by_duty.get(duty, set()) | bands
        return bands_by_duty

    def index_order(self, order: Order | None) -> int:
        """Return the number of an order; UnknownName if members do not have the behavior that it names."""
        if order is not None and order not in self._orders:
            self._check(order)
            self._orders.append(order)
        return self._orders.index(order)

    def _check(self, order: Order) -> None:
        names = [role.name for role in self.squad.roles]
        for duty in order.duties:
            if duty.role not in (None, *names):
                raise UnknownName(
                    what="role", name=duty.role or "", where=f"squad {self.squad.name}", known=names
                )
            fit = np.array([duty.role in (None, name) for name in names])[self.roster.role]
            for band in np.unique(self.roster.band[fit]).tolist():
                self.bands[band].finds(duty.behavior, duty.binding)

    def issue(self, order: NDArray[np.intp], issued: Column, counted: NDArray[np.bool_], tick: int) -> None:
        """Give orders [S] with the times [S] at which they were given; members stop and begin where one is new."""
        anew = (order != self.order) | ~(np.abs(issued - self.issued) <= SAME_S)
        self.order, self.issued = order, np.where(anew, issued, self.issued)
        if anew.any():
            for number in np.unique(order[anew]).tolist():
                self._assign(self._orders[number], self.roster.of_squads(anew & (order == number)), counted)
        issued_s = self.issued[self.roster.squad]
        heard, answering = self.meant, issued_s
        if self._delayed is not None:
            which, when = self._delayed
            sent, answering = (
                which.push_and_get(self.meant.astype(np.float64), tick),
                when.push_and_get(issued_s, tick),
            )
            nothing = np.isnan(answering)  # has come through since the run began, or was gone back in
            heard = np.where(nothing, self.heard, sent).astype(np.intp)
            answering = np.where(nothing, self.answering, answering)
        new = np.flatnonzero((answering != self.answering) & ~np.isnan(answering))
        self.heard, self.answering = heard.copy(), answering.copy()
        self.start(new)

    def deal_again(self, counted: NDArray[np.bool_]) -> None:
        """Deal the shares of present orders among the members that are present; a member keeps its duty if it can."""
        for number in np.unique(self.order).tolist():
            order = self._orders[number]
            if order is not None and any(duty.share is not None for duty in order.duties):
                self._assign(order, self.roster.of_squads(self.order == number), counted)
        if self._delayed is None:
            changed = np.flatnonzero(self.heard != self.meant)
            self.heard = self.meant.copy()
            self.start(changed)

    def _assign(self, order: Order | None, members: NDArray[np.intp], counted: NDArray[np.bool_]) -> None:
        if order is None:
            self.meant[members] = 0
            return
        numbers = [self._number(duty) for duty in order.duties]
        if len(numbers) == 1 and order.duties[0].role is None and order.duties[0].share is None:
            self.meant[members] = numbers[0]
            return
        names = [role.name for role in self.squad.roles]
        for squad in np.unique(self.roster.squad[members]).tolist():
            mine = members[self.roster.squad[members] == squad].tolist()
            before = {member: int(self.meant[member]) for member in mine}
            roles = {member: names[self.roster.role[member]] for member in mine}
            there = [member for member in mine if counted[member]]
            for member, number in distribute_assignments(order, numbers, roles, before, there).items():
                self.meant[member] = number

    def _number(self, duty: Assignment) -> int:
        plain = Assignment(duty.behavior, duty.binding)
        if plain not in self.duties:
            self.duties.append(plain)
        return self.duties.index(plain)

    def start(self, members: NDArray[np.intp]) -> None:
        """Let members begin the duty that reached them."""
        if not len(members):
            return
        band, heard = self.roster.band[members], self.heard[members]
        for number, duty in {*zip(band.tolist(), heard.tolist(), strict=True)}:
            mine = members[(band == number) & (heard == duty)]
            what = self.duties[duty]
            program = IDLE_PROGRAM if what is None else self.bands[number].finds(what.behavior, what.binding)
            self.bands[number].layer.runner.begin(self.roster.row[mine], program)

    def restore(
        self,
        orders: Sequence[Order | None],
        issued: Column,
        duties: Sequence[Assignment | None],
        answering: Column,
    ) -> None:
        """Go back to earlier orders; members begin their duties again."""
        self.order = np.array([self.index_order(order) for order in orders], np.intp)
        self.issued, self.answering = issued.copy(), answering.copy()
        numbers = [0 if duty is None else self._number(duty) for duty in duties]
        self.meant, self.heard = np.array(numbers, np.intp), np.array(numbers, np.intp)
        self.start(np.arange(len(self.roster)))


def distribute_assignments(
    order: Order,
    numbers: Sequence[int],
    roles: Mapping[int, str],
    before: Mapping[int, int],
    there: Sequence[int],
) -> dict[int, int]:
    """Assign the duties of an order (0: none) to the members of one squad, in their order.

    Members keep their former duty as far as there is room, so that as few as possible change. Shares are of the members
    that are present; absent ones get what is left over.
    """
    dealt = dict.fromkeys(roles, 0)
    left = dict.fromkeys([*there, *roles])
    for duty, number in zip(order.duties, numbers, strict=True):
        fit = [member for member in left if duty.role in (None, roles[member])]
        if duty.share is not None:
            everyone = sum(duty.role in (None, roles[member]) for member in there)
            share = duty.share if duty.share >= 1 else duty.share * everyone
            fit.sort(key=lambda member: (member not in there, before[member] != number))
            fit = fit[: max(1, floor(share + 0.5))]
        for member in fit:
            dealt[member] = number
            del left[member]
    return dealt
