"""Programs that stand still in the middle of a tick: what is sent meanwhile is late, what is sent afterwards is not."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from tests.bodies import TICK_S, Scripted
from tests.runtime.agents.test_lost_agents import NAMES, make_team

from understudy.runtime.agents.agent import Agent, order_key, report_key
from understudy.runtime.agents.coordinator import SquadCoordinator
from understudy.runtime.agents.messages import MemberReport, Orders, compute_layout, pack_message
from understudy.runtime.agents.network import Inbox, LocalNetwork, Observe

FROZEN_TICKS = 18
SQUAD_NAME = "pair_0"


class LateInbox(Inbox):
    """An inbox whose program may stand still just before it takes the messages."""

    def __init__(self, stand_still: Callable[[], None]) -> None:
        super().__init__()
        self._stand_still = stand_still

    def take_all(self) -> list[bytes]:
        self._stand_still()
        return super().take_all()


class Computer:
    """The clock and the network of one program, to which others send at every tick, whether it runs or not."""

    present = frozenset((SQUAD_NAME, *NAMES))

    def __init__(self, send: Callable[[int], Iterable[tuple[str, bytes]]]) -> None:
        self.ticks, self._send = 0, send
        self._inboxes: list[tuple[str, Inbox]] = []
        self._still = 0

    def read_clock(self) -> float:
        return self.ticks * TICK_S

    def advance(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.ticks += 1
            for key, message in self._send(self.ticks):
                for of, inbox in self._inboxes:
                    if of == key:
                        inbox.add(message)

    def freeze(self) -> None:
        """Let the program stand still before it takes messages the next time."""
        self._still = FROZEN_TICKS

    def _stand_still(self) -> None:
        ticks, self._still = self._still, 0
        self.advance(ticks)

    def listen(self, key: str, observe: Observe | None = None) -> Inbox:
        self._inboxes.append((key, LateInbox(self._stand_still)))
        return self._inboxes[-1][1]

    def publish(self, key: str, message: bytes) -> None: ...

    def announce(self, name: str) -> None: ...

    def close(self) -> None: ...


def send_orders(tick: int) -> list[tuple[str, bytes]]:
    message = Orders(
        squad=SQUAD_NAME, leader=SQUAD_NAME, term=1, start=1, sequence=tick, sent_s=tick * TICK_S, order=(1, 1),
        lease_s=1.0, library="", duties={"scout_1": ("go", {})}, frames=[],
    )  # fmt: skip
    return [(order_key(SQUAD_NAME), pack_message(message))]


def send_reports(tick: int) -> list[tuple[str, bytes]]:
    return [(report_key(SQUAD_NAME), pack_message(make_report(name, tick))) for name in NAMES]


def make_report(member: str, tick: int) -> MemberReport:
    return MemberReport(
        member=member, start=1, sequence=tick, sent_s=tick * TICK_S, term=0, heard=0, order=None, library="",
        unfit="", flag=None, path=[], layout=compute_layout([]), readings=[],
    )  # fmt: skip


def test_a_member_obeys_the_first_order_after_it_stood_still() -> None:
    computer = Computer(send_orders)
    plan = make_team(LocalNetwork()).plan
    agent = Agent(plan.make_agent_spec("scout_1"), Scripted(), computer, clock=computer.read_clock)
    executed = []
    for tick in range(30):
        computer.advance()
        agent.sense()
        if tick == 10:
            computer.freeze()
        agent.obey()
        agent.act()
        executed.append(None if agent.follower is None else agent.follower.order)
    assert executed == [(1, 1)] * 10 + [None] + [(1, 1)] * 19
    assert agent.refusals == {}


def test_a_deputy_counts_all_members_after_it_stood_still_and_can_lead() -> None:
    computer = Computer(send_reports)
    plan = make_team(LocalNetwork()).plan
    coordinator = SquadCoordinator(
        plan.make_agent_spec(SQUAD_NAME), plan.make_squad_spec(SQUAD_NAME), host="scout_1",
        candidates=plan.list_candidates(SQUAD_NAME), clock=Scripted(), network=computer,
        lease_clock=computer.read_clock,
    )  # fmt: skip
    counted = []
    for tick in range(30):
        computer.advance()
        if tick == 3:
            computer.freeze()
        coordinator.sense()
        counted.append(np.count_nonzero(~coordinator.members[0].failed))
    assert counted[4:] == [len(NAMES)] * 26
    assert coordinator.leads
