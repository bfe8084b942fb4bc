"""Who leads: tables of messages and silence."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from understudy.runtime.agents.leadership import (
    APART_S,
    GONE_S,
    SILENT_S,
    Leadership,
    find_next_term,
    is_term_of,
)

ALL = ("lead", "scout_1", "scout_2")
TICK_S = 0.05


def find_takeover(candidate: Leadership, present: tuple[str, ...], *, until_s: float = 2.0) -> float | None:
    """When this candidate begins to lead, hearing no leader, but another member."""
    for tick in range(round(until_s / TICK_S)):
        candidate.hear_report("scout_9", 0, 0, tick * TICK_S)
        if candidate.update(tick * TICK_S, present):
            return round(tick * TICK_S, 6)
    return None


TAKEOVERS = [  # who is there, who is asked, after how many seconds of silence it leads
    (ALL, "scout_1", SILENT_S),  # the leader is there and frozen: its first deputy
    (ALL, "scout_2", SILENT_S + APART_S),
    (("scout_1", "scout_2"), "scout_1", GONE_S),  # the leader is gone
    (("scout_1", "scout_2"), "scout_2", GONE_S + APART_S),
    (("scout_2",), "scout_2", GONE_S),  # the first deputy is gone, too
]


@pytest.mark.parametrize(("present", "who", "after_s"), TAKEOVERS)
def test_takeovers(present: tuple[str, ...], who: str, after_s: float) -> None:
    candidate = Leadership(who, ALL, 0.0)
    candidate.hear_orders(1, "lead", 0.0)
    found = find_takeover(candidate, present)
    assert found is not None
    assert after_s - 1e-9 <= found < after_s + TICK_S
    assert candidate.term == 1 + ALL.index(who)


def test_a_leader_that_only_others_hear_is_not_replaced() -> None:
    candidate = Leadership("scout_1", ALL, 0.0)
    candidate.hear_orders(1, "lead", 0.0)
    for tick in range(1, 20):
        candidate.hear_report("scout_2", 1, tick, tick * TICK_S)
        assert not candidate.update(tick * TICK_S, ALL)
    for tick in range(20, 40):
        candidate.hear_report("scout_2", 1, 19, tick * TICK_S)  # they have not heard it since
        assert candidate.update(tick * TICK_S, ALL) == ((tick - 19) * TICK_S > SILENT_S - 1e-9)


def test_a_message_that_members_report_later_counts_from_when_it_was_sent() -> None:
    candidate = Leadership("scout_1", ALL, 0.0)
    candidate.hear_orders(1, "lead", 0.0, message=7)
    for tick in range(1, 20):
        candidate.hear_report("scout_2", 1, 7, tick * TICK_S)
        assert candidate.update(tick * TICK_S, ALL) == (tick * TICK_S > SILENT_S - 1e-9)


def test_who_is_cut_off_does_not_begin_to_lead() -> None:
    """Its own robot reports to it, too; a term of its own would outrank that of the others when it is back."""
    candidate = Leadership("scout_1", ALL, 0.0)
    candidate.hear_orders(1, "lead", 0.0)
    candidate.hear_report("scout_2", 1, 1, 0.0)
    for tick in range(1, 60):
        candidate.hear_report("scout_1", 1, 1, tick * TICK_S)
        assert not candidate.update(tick * TICK_S, ALL)
    assert candidate.term == 1


def test_the_former_leader_follows_when_it_hears_a_higher_term() -> None:
    former = Leadership("lead", ALL, 0.0, leads=True)
    assert former.update(0.1, ALL)
    assert former.hear_orders(2, "scout_1", 0.2)
    assert not former.update(0.2, ALL)
    assert not former.hear_orders(1, "scout_2", 0.3)


def test_a_leader_that_was_frozen_listens_first() -> None:
    former = Leadership("lead", ALL, 0.0, leads=True)
    assert former.update(0.1, ALL)
    assert not former.update(5.0, ALL)
    former.hear_report("scout_9", 1, 0, 5.0 + SILENT_S)
    assert not former.update(5.0 + SILENT_S - 0.01, ALL)
    assert former.update(5.0 + SILENT_S + 0.01, ALL)
    assert former.term == 4  # its second one


def test_a_leader_goes_beyond_the_term_that_members_obey_once_its_leader_is_silent() -> None:
    leader = Leadership("lead", ALL, 0.0, leads=True)
    for tick in range(1, 20):
        leader.hear_report("scout_2", 5, 1, tick * TICK_S)
        assert leader.update(tick * TICK_S, ALL)
        assert leader.term == (1 if tick * TICK_S < TICK_S + SILENT_S - 1e-9 else 7)


def test_a_leader_follows_one_of_a_higher_term_whom_only_members_hear() -> None:
    """Its link was cut, and is not whole yet."""
    former = Leadership("lead", ALL, 0.0, leads=True)
    former.hear_report("scout_2", 5, 7, 0.1)
    assert former.update(0.1, ALL)
    former.hear_report("scout_2", 5, 8, 0.2)
    assert not former.update(0.2, ALL)
    assert (former.term, former.leader) == (5, "scout_1")


TERMS = [  # the last term, the candidate, its next one
    (0, "lead", 1), (0, "scout_2", 3), (1, "lead", 4), (1, "scout_1", 2), (2, "scout_1", 5), (9, "scout_1", 11),
]  # fmt: skip


@pytest.mark.parametrize(("after", "who", "term"), TERMS)
def test_each_has_terms_of_its_own(after: int, who: str, term: int) -> None:
    assert find_next_term(after, who, ALL) == term
    assert [name for name in ALL if is_term_of(term, name, ALL)] == [who]


def test_strangers_do_not_lead() -> None:
    candidate = Leadership("lead", ALL, 0.0)
    assert not candidate.hear_orders(9, "stranger", 0.0)
    assert candidate.term == 0


def _cuts() -> Iterator[frozenset[str]]:
    yield from (frozenset(), frozenset({"lead"}), frozenset({"lead", "scout_1"}), frozenset({"scout_2"}))


@settings(max_examples=150)
@given(
    st.lists(st.tuples(st.sampled_from(list(_cuts())), st.integers(1, 60)), max_size=6), st.integers(0, 2**16)
)
def test_one_leads_a_second_after_the_network_is_whole(
    history: list[tuple[frozenset[str], int]], seed: int
) -> None:
    """Whatever was cut before, and even if a message of three is lost, one of them leads in the end."""
    draws = Random(seed)
    candidates = {name: Leadership(name, ALL, 0.0, leads=name == "lead") for name in ALL}
    tick = 0

    def run(apart: frozenset[str], ticks: int, loss: float) -> None:
        nonlocal tick
        for _ in range(ticks):
            tick += 1
            now = tick * TICK_S
            leaders = [each for each in candidates.values() if each.leads]
            for leader in leaders:
                for name, other in candidates.items():
                    joined = (name in apart) == (leader.name in apart)
                    if name != leader.name and joined and draws.random() >= loss:
                        other.hear_orders(leader.term, leader.name, now)
            for name, each in candidates.items():
                for sender in ALL:
                    if (sender in apart) == (name in apart):
                        each.hear_report(sender, 0, 0, now)
                each.update(now, [other for other in ALL if (other in apart) == (name in apart)])

    for apart, ticks in history:
        run(apart, ticks, 0.3)
    run(frozenset(), round(1.0 / TICK_S), 0.0)
    assert sum(each.leads for each in candidates.values()) == 1
    assert len({(each.term, each.leader) for each in candidates.values()}) == 1
