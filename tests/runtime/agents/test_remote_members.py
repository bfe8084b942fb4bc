"""Reports that a coordinator takes: a table of starts and sequence numbers."""

from __future__ import annotations

import msgspec
import pytest
from tests.bodies import Scripted

from understudy.runtime.agents.messages import MemberReport, OrderId, compute_layout
from understudy.runtime.agents.remote_members import RemoteMembers, RemoteRunner
from understudy.runtime.team.comms import SILENT_S


def report(start: int, sequence: int, member: str = "scout") -> MemberReport:
    return MemberReport(
        member=member, start=start, sequence=sequence, sent_s=7.0, term=1, heard=1, order=None, library="L",
        unfit="", flag=None, path=[], layout=compute_layout([]), readings=[],
    )  # fmt: skip


STORIES: dict[str, list[tuple[MemberReport, bool]]] = {
    "one after the other": [(report(5, 1), True), (report(5, 2), True)],
    "doubled": [(report(5, 1), True), (report(5, 1), False)],
    "overtaken": [(report(5, 2), True), (report(5, 1), False), (report(5, 3), True)],
    "started again": [(report(5, 9), True), (report(3, 1), True), (report(3, 2), True)],
    "late ones of the former program": [(report(5, 9), True), (report(3, 1), True), (report(5, 10), False)],
    "of somebody else": [(report(5, 1, "stranger"), False)],
}


@pytest.mark.parametrize("story", STORIES)
def test_stories(story: str) -> None:
    members = RemoteMembers(["scout"], Scripted.readings, [], Scripted())
    found = [members.receive(each) is not None for each, _ in STORIES[story]]
    assert found == [taken for _, taken in STORIES[story]]


def test_a_report_that_was_held_up_counts_from_when_it_would_have_come() -> None:
    clock = Scripted()
    members = RemoteMembers(["scout"], Scripted.readings, [], clock)
    members.receive(report(5, 1))  # sent at 7 s by the member's clock
    assert not members.failed[0]
    for _ in range(round((SILENT_S + 0.5) / clock.tick_s)):
        clock.act({})
    held = msgspec.structs.replace(report(5, 2), sent_s=7.2)
    assert members.receive(held) == pytest.approx(0.2)
    assert members.failed[0]


@pytest.mark.parametrize(
    ("order", "answered", "counts"),
    [
        ((1, 1), (1, 1), True),
        ((1, 2), (1, 1), False),
        ((1, 1), None, False),
        (None, (1, 1), False),
        (None, None, False),  # what a robot that is alone has done answers no coordinator
    ],
)
def test_a_flag_counts_in_reports_that_answer_the_present_order(
    order: OrderId | None, answered: OrderId | None, counts: bool
) -> None:
    members = RemoteMembers(["scout"], Scripted.readings, [], Scripted())
    members.receive(msgspec.structs.replace(report(5, 1), order=answered, flag="done"))
    members.order = order
    assert RemoteRunner(members).find_raised("done").tolist() == [counts]
