"""Who decided on an order, found in the messages that agents recorded."""

from __future__ import annotations

from pathlib import Path

import pytest

from understudy.judging.explain_team import list_first_messages
from understudy.records.merge import TeamClock
from understudy.records.team_reader import LoggedOrders, TeamRecording
from understudy.runtime.agents.messages import OrderId, Orders

FIRST, DEPUTY, ROBOT = "patrol_0", "pioneer_2", "pioneer_1"
LOGGED = [  # recorded by, whether it sent it, leader, its term, order
    (ROBOT, False, FIRST, 1, None),
    (ROBOT, False, FIRST, 1, (1, 1)),
    (ROBOT, False, DEPUTY, 3, (1, 1)),  # goes on with it
    (ROBOT, True, ROBOT, 5, (1, 1)),  # so does this robot, while it leads
    (DEPUTY, True, DEPUTY, 3, (1, 1)),
    (DEPUTY, True, DEPUTY, 3, (3, 1)),
    (DEPUTY, True, DEPUTY, 3, (3, 1)),
    (ROBOT, False, DEPUTY, 3, (3, 1)),
]


def make_orders(leader: str, term: int, order: OrderId | None, squad: str = FIRST) -> Orders:
    return Orders(squad, leader, term, 7, 1, 0.0, order, 1.0, "", {}, [])


@pytest.mark.parametrize(
    ("order", "leader", "by"),
    [
        ((1, 1), FIRST, [(ROBOT, False)]),
        ((3, 1), DEPUTY, [(DEPUTY, True), (DEPUTY, True), (ROBOT, False)]),
        ((1, 2), None, []),
        ((5, 1), None, []),
    ],
)
def test_a_leader_that_goes_on_with_an_order_has_not_decided_on_it(
    order: OrderId, leader: str | None, by: list[tuple[str, bool]]
) -> None:
    logged = [
        LoggedOrders(agent, is_sent, number, make_orders(leader, term, given))
        for number, (agent, is_sent, leader, term, given) in enumerate(LOGGED)
    ]
    logged.insert(0, LoggedOrders(ROBOT, False, 0, make_orders(FIRST, 1, (1, 1), "another squad")))
    team = TeamRecording(
        Path("team.mcap"), TeamClock(reference=ROBOT, start_ns=0, members=[]), {}, logged, []
    )
    found = list_first_messages(team, FIRST, order)
    assert {each.orders.leader for each in found} == ({leader} if leader else set())
    assert [(each.agent, each.is_sent) for each in found] == by
