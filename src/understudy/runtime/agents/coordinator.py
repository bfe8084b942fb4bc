"""The coordinator of one squad, on each agent that may lead it: one leads, the others follow its state.

All of them hear the reports and keep the statistics, so that a deputy that takes over knows the past. Only the leader
decides, gives orders, and reports to the squad above.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from secrets import randbits
from typing import NamedTuple, TypeVar

import numpy as np

from understudy.errors import UnderstudyError
from understudy.model.binding import Binding
from understudy.model.squad import Assignment, Order, Squad
from understudy.runtime.agents.agent import Agent, AgentSpec, order_key, report_key
from understudy.runtime.agents.lateness import LatenessMeter
from understudy.runtime.agents.leadership import Leadership, is_term_of
from understudy.runtime.agents.messages import (
    MemberReport,
    OrderId,
    Orders,
    UnreadableMessage,
    decode_orders,
    decode_report,
    list_reported_readings,
    pack_message,
)
from understudy.runtime.agents.network import Network
from understudy.runtime.agents.remote_members import RemoteMembers, RemoteRunner, TickClock
from understudy.runtime.body import Reading
from understudy.runtime.interpreter import RunningAutomaton, RunningBehavior
from understudy.runtime.team.members import AgentLayer, Finds, Member, MemberGroup, Membership
from understudy.runtime.team.squad_body import SquadBody

LEASE_S = 1.0
"""The time for which an order holds after it was received, unless the team file says otherwise, s."""
REMEMBERED = 8
"""The number of orders of which the run state of a leader is kept."""
T = TypeVar("T")


class SquadPlan(NamedTuple):
    """A squad of a team: its kind, its members in order, and what they can do.

    Attributes
    ----------
    kind
        The kind of squad.
    members
        The name, the sort and the index of the role of each member.
    readings
        The readings that members of each sort offer.
    finds
        For each sort of members, the function that makes a behavior ready to run.
    libraries
        The fingerprint that the members' library must have, by sort; a sort that is missing may have any.
    lease_s
        The time for which an order holds after it was received, s.
    library
        The fingerprint that the library of the leader must have; None: any.
    """

    kind: Squad
    members: Sequence[tuple[str, str, int]]
    readings: Mapping[str, Sequence[Reading]]
    finds: Mapping[str, Finds]
    libraries: Mapping[str, str] = {}
    lease_s: float = LEASE_S
    library: str | None = None


class SquadCoordinator:
    """One agent's part in leading a squad.

    Parameters
    ----------
    spec
        What the coordinator runs; its name is that of the squad in the team.
    squad
        The squad that it leads.
    host
        The name of the agent that this is.
    candidates
        All agents that may lead the squad, the first choice first.
    clock
        This agent's clock, with the tick and the targets of the team.
    network
        This agent's access to the network.
    leads
        Whether it leads from the beginning, without listening first.
    lease_clock
        The clock of leases and of silence, s; None: `clock`.
    """

    def __init__(
        self,
        spec: AgentSpec,
        squad: SquadPlan,
        *,
        host: str,
        candidates: Sequence[str],
        clock: TickClock,
        network: Network,
        leads: bool = False,
        lease_clock: Callable[[], float] | None = None,
    ) -> None:
        self.spec, self.squad, self._clock, self._network = spec, squad, clock, network
        self._read_clock = lease_clock or (lambda: clock.time_s)
        self._now = self._read_clock()
        """The time of this tick, s."""
        self.groups = _make_groups(squad, clock, lambda: self._now)
        self.squads = _make_body(squad, self.groups, clock)
        self.agent = Agent(spec, self.squads, network, unfit=self._find_unfitness, clock=lease_clock)
        self._keys = list(self.agent.keys)
        self._timed = [key for key in self._keys if self.squads.statistic(key[0]).is_timed]
        self.leadership = Leadership(host, candidates, self._now, leads=leads)
        self.order: OrderId | None = None
        """The present order."""
        self._orders, self._reports = (
            network.listen(order_key(spec.name)),
            network.listen(report_key(spec.name)),
        )
        self._lateness = LatenessMeter(len(candidates))
        self._remembered: OrderedDict[OrderId | None, tuple[Orders, float]] = OrderedDict()
        self._issued = np.nan
        self._counted = np.zeros(len(squad.members), np.bool_)
        self.sent = 0
        """The number of messages that it has sent in its term."""
        self._start, self._number = randbits(53), 0
        self._led = False

    @property
    def leads(self) -> bool:
        """Whether this agent leads the squad."""
        return self.leadership.leads

    @property
    def members(self) -> list[RemoteMembers]:
        """The members of each sort, as they were last heard."""
        return [body for body, _ in self.groups]

    def sense(self) -> None:
        """Receive messages of leaders and members, decide which agent leads, and compute the statistics of this tick.

        An agent that only follows computes just the statistics that depend on the past.
        """
        orders, reports = self._orders.take_all(), self._reports.take_all()
        self._now = now = self._read_clock()  # after they were taken: the program may have been frozen before
        for message in _decoded(orders, decode_orders):
            if message.leader == self.leadership.name or self.squad.library not in (None, message.library):
                continue
            heard_s = now - self._lateness.measure(message.start, message.sent_s, now)
            if self.leadership.hear_orders(message.term, message.leader, heard_s, message.sequence):
                self._remember(message, heard_s)
        for report in _decoded(reports, decode_report):
            for body in self.members:
                if (sent_s := body.receive(report)) is not None:
                    self.leadership.hear_report(report.member, report.term, report.heard, sent_s)
                    self._remember_kept(report, sent_s)
        leads = self.leadership.update(now, self._network.present, is_unknowing=self._is_unknowing)
        if leads and not self._led:
            self._take_over(now)
        self._led = leads
        present = self.order if leads else next(reversed(self._remembered), None)
        needed = self.squads.list_needed_readings(self._keys if leads else self._timed)
        for body, group in self.groups:
            body.order = present
            group.layer.percept = body.sense(needed)
        if leads:
            self.agent.sense()
        elif self._timed:  # of the past, a deputy that takes over has to know
            self.squads.sense(self._timed)

    def report(self) -> None:
        """Report to the squad above, if this agent leads."""
        if self.leads:
            self.agent.report()

    def obey(self) -> None:
        """Hear the orders of the squad above."""
        self.agent.obey()

    def act(self) -> None:
        """Decide and give orders, if this agent leads."""
        if not self.leads:
            return
        self.agent.act()
        issued = float(self.squads.ordering.issued[0])
        if issued != self._issued and not np.isnan(issued):
            self._issued = issued
            self._number += 1
            self.order = self.leadership.term, self._number
        counted = self.squads.presence
        if (counted & ~self._counted).any():  # such as robots that have been armed
            self.squads.ordering.deal_again(counted)
        self._counted = counted.copy()
        self.sent += 1
        message = self._make_message()
        self._remember(message, self._now)
        self._network.publish(order_key(self.spec.name), pack_message(message))

    # Leading

    def _make_message(self) -> Orders:
        duties = [
            None if duty is None else (duty.behavior, dict(duty.binding))
            for duty in self.squads.ordering.duty
        ]
        interpreter = self.agent.interpreter
        return Orders(
            squad=self.spec.name,
            leader=self.leadership.name,
            term=self.leadership.term,
            start=self._start,
            sequence=self.sent,
            sent_s=self._now,
            order=self.order,
            lease_s=self.squad.lease_s,
            library=self.spec.library,
            duties=dict(zip((name for name, _, _ in self.squad.members), duties, strict=True)),
            frames=list(interpreter.snapshot(self._clock.time_s)),
        )

    def _find_unfitness(self) -> str:
        return "has no member left" if bool(self.squads.failed[0]) else ""

    # Taking over

    def _remember(self, message: Orders, now: float) -> None:
        self._remembered[message.order] = message, now
        self._remembered.move_to_end(message.order)
        while len(self._remembered) > REMEMBERED:
            self._remembered.popitem(last=False)

    def _remember_kept(self, report: MemberReport, heard_s: float) -> None:
        """Remember a leader's message that a member has kept, unless its order is known: this agent may be new."""
        if report.kept is None or self.leads:
            return
        message, age_s = report.kept
        candidates = self.leadership.candidates
        if message.order is None or message.order in self._remembered or message.squad != self.spec.name:
            return
        if not is_term_of(message.term, message.leader, candidates) or self.squad.library not in (
            None,
            message.library,
        ):
            return
        latest = next(reversed(self._remembered), None)
        self._remember(message, heard_s - age_s)
        if latest is not None and latest > message.order:
            self._remembered.move_to_end(message.order, last=False)  # the present one is the last

    def _is_unknowing(self) -> bool:
        """Return whether most members execute an order that this agent has never heard."""
        votes = self._count_votes()
        return bool(votes) and max(votes, key=lambda order: (votes[order], order)) not in self._remembered

    def _count_votes(self) -> dict[OrderId, int]:
        """Count the members that execute each order."""
        votes: dict[OrderId, int] = {}
        for body in self.members:
            for member in body.members:
                if (
                    member.report is not None
                    and member.report.order is not None
                    and body.find_problem(member) == ""
                ):
                    votes[member.report.order] = votes.get(member.report.order, 0) + 1
        return votes

    def _take_over(self, now: float) -> None:
        """Begin in the state that most members' reports answer, so that no member is restarted."""
        self.agent.renew_start()
        self.sent = self._number = 0
        answered = self._find_answered_order()
        if answered is None or not self._restore(*answered, now):
            self.agent.begin()
            self.squads.ordering.clear()
            self._issued, self.order = np.nan, None

    def _restore(self, message: Orders, heard_s: float, now: float) -> bool:
        """Go on from a leader's message; return False if it does not fit what this agent runs."""
        interpreter = self.agent.interpreter
        passed = now - heard_s
        frames = [
            type(frame)(
                frame.automaton,
                frame.state,
                frame.time_in_state + passed,
                frame.counters,
                {name: seconds + passed for name, seconds in frame.timers.items()},
            )
            for frame in message.frames
        ]
        interpreter.restore(frames, now=self._clock.time_s)
        active = [(machine.automaton.name, machine.state_name) for machine in interpreter.active]
        if active != [(frame.automaton, frame.state) for frame in frames]:
            return False  # this agent's library, or its own order, is another one than the leader's
        given_s = interpreter.behavior_start_s
        start_times = np.full(len(self.squad.members), given_s)
        try:
            duties = [
                None if (duty := message.duties.get(name)) is None else Assignment(duty[0], Binding(duty[1]))
                for name, _, _ in self.squad.members
            ]
            self.squads.ordering.restore(
                [self._find_present_order()], np.array([given_s]), duties, start_times
            )
        except UnderstudyError:
            return False
        self._issued, self.order = given_s, message.order
        self._number = 0 if message.order is None else message.order[1]
        return True

    def _find_answered_order(self) -> tuple[Orders, float] | None:
        """Return the last message with the order that most members execute, and when it was heard."""
        now = self._now
        votes = self._count_votes()
        candidates = [order for order in votes if order in self._remembered]
        if candidates:
            return self._remembered[max(candidates, key=lambda order: (votes[order], order))]
        last = next(reversed(self._remembered.values()), None)
        return last if last is not None and now - last[1] <= self.squad.lease_s else None

    def _find_present_order(self) -> Order | None:
        interpreter = self.agent.interpreter
        active: RunningAutomaton | RunningBehavior = interpreter.root
        while isinstance(active, RunningAutomaton):
            active = active.active
        ground = interpreter.program.basics[active.index]
        order = ground.behavior.order
        return None if order is None else order.substitute(ground.binding)


def _make_groups(
    squad: SquadPlan, clock: TickClock, lease_clock: Callable[[], float]
) -> list[tuple[RemoteMembers, MemberGroup]]:
    """Make the members of each sort, in the order in which the sorts first occur."""
    groups = []
    for sort in dict.fromkeys(sort for _, sort, _ in squad.members):
        names = [name for name, of, _ in squad.members if of == sort]
        readings = squad.readings[sort]
        keys = list_reported_readings(squad.kind, readings, clock.targets)
        library = squad.libraries.get(sort)
        body = RemoteMembers(names, readings, keys, clock, library=library, lease_clock=lease_clock)
        layer = AgentLayer(body, RemoteRunner(body))
        groups.append((body, MemberGroup(sort, layer, squad.finds[sort])))
    return groups


def _make_body(
    squad: SquadPlan, groups: Sequence[tuple[RemoteMembers, MemberGroup]], clock: TickClock
) -> SquadBody:
    sorts = [group.name for _, group in groups]
    rows = {member.name: row for body, _ in groups for row, member in enumerate(body.members)}
    members = [Member(sorts.index(sort), rows[name], role) for name, sort, role in squad.members]
    first = groups[0][0]
    return SquadBody(squad.kind, Membership.from_squads([members]), [group for _, group in groups], first)


def _decoded(messages: Sequence[bytes], decode: Callable[[bytes], T]) -> list[T]:
    """Decode messages, without those that are unreadable."""
    decoded = []
    for data in messages:
        try:
            decoded.append(decode(data))
        except UnreadableMessage:
            continue
    return decoded
