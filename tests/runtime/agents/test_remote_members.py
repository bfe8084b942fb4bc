"""Reports that a coordinator takes: a table of starts and sequence numbers."""

from __future__ import annotations

import pytest
from tests.bodies import Scripted

from understudy.runtime.agents.messages import MemberReport, compute_layout
from understudy.runtime.agents.remote_members import RemoteMembers


def report(start: int, sequence: int, member: str = "scout") -> MemberReport:
    return MemberReport(
        member=member, start=start, sequence=sequence, term=1, order=None, library="L", unfit="", flag=None,
        path=[], layout=compute_layout([]), readings=[],
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
    assert [members.receive(each) for each, _ in STORIES[story]] == [taken for _, taken in STORIES[story]]
