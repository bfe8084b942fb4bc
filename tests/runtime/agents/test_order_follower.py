"""Orders on a lease: a table of what a member does with each message, to check by hand."""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple

import msgspec
import pytest

from understudy.runtime.agents.messages import (
    Orders,
    UnreadableMessage,
    decode_orders,
    decode_report,
    pack_message,
)
from understudy.runtime.agents.order_follower import OrderFollower, Refusal

LEASE_S = 1.0
APART_S = 1000.0
"""By how much the leader's clock is ahead of the member's, s."""


def orders(
    term: int, sequence: int, order: tuple[int, int] | None, leader: str = "lead", *, start: int = 1
) -> Orders:
    """A coordinator's message: `scout` runs `go`, everybody else nothing."""
    return Orders(
        squad="pair", leader=leader, term=term, start=start, sequence=sequence, sent_s=0.0, order=order,
        lease_s=LEASE_S, library="L", duties={"scout": ("go", {}), "other": None}, frames=[],
    )  # fmt: skip


class Arrival(NamedTuple):
    """A message that arrives, or none; whether it is refused; what is executed then, and whether it begins anew."""

    at_s: float
    message: Orders | None
    refused: Refusal | None
    executes: tuple[int, int] | None
    anew: bool
    held_s: float = 0.0
    """The time for which the network held it up."""


STORIES: dict[str, list[Arrival]] = {
    "an order, renewed": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True),
        Arrival(0.5, orders(1, 2, (1, 1)), None, (1, 1), False),
        Arrival(1.4, None, None, (1, 1), False),  # 0.9 s after the last one
    ],
    "the lease ends, and comes back": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True),
        Arrival(0.99, None, None, (1, 1), False),
        Arrival(1.0, None, None, None, True),
        Arrival(1.5, orders(1, 9, (1, 1)), None, (1, 1), True),
    ],
    "the same again is a new order": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True),
        Arrival(0.1, orders(1, 2, (1, 2)), None, (1, 2), True),
    ],
    "doubled and overtaken": [
        Arrival(0.0, orders(1, 5, (1, 2)), None, (1, 2), True),
        Arrival(0.1, orders(1, 5, (1, 2)), Refusal.LATE, (1, 2), False),
        Arrival(0.2, orders(1, 4, (1, 1)), Refusal.LATE, (1, 2), False),
        Arrival(1.05, None, None, None, True),  # what was refused renewed nothing
    ],
    "held up: the lease counts from when it would have come": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True),
        Arrival(0.9, orders(1, 2, (1, 1)), None, (1, 1), False, held_s=0.6),
        Arrival(1.25, None, None, (1, 1), False),
        Arrival(1.35, None, None, None, True),  # not at 1.9
    ],
    "held up for longer than it holds": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True),
        Arrival(1.2, orders(1, 2, (1, 1)), Refusal.STALE, None, True, held_s=1.1),
        Arrival(1.3, orders(1, 14, (1, 1)), None, (1, 1), True),
    ],
    "the first one counts as on time, and later ones tell that it was not": [
        Arrival(0.0, orders(1, 1, (1, 1)), None, (1, 1), True, held_s=0.5),
        Arrival(0.1, orders(1, 6, (1, 1)), None, (1, 1), False),
        Arrival(0.2, orders(1, 7, (1, 2)), None, (1, 2), True, held_s=0.6),
        Arrival(0.65, None, None, None, True),
    ],
    "a leader that was started again in the same term": [
        Arrival(0.0, orders(1, 900, (1, 1)), None, (1, 1), True),
        Arrival(0.9, orders(1, 1, (1, 1), start=2), None, (1, 1), True),
        Arrival(1.0, orders(1, 901, (1, 1)), Refusal.LATE, (1, 1), False),  # a late one of before
        Arrival(1.1, orders(1, 2, (1, 2), start=2), None, (1, 2), True),
    ],
    "a deputy takes over, and restarts nobody": [
        Arrival(0.0, orders(1, 5, (1, 2)), None, (1, 2), True),
        Arrival(0.6, orders(2, 1, (1, 2), "deputy"), None, (1, 2), False),
        Arrival(0.7, orders(1, 6, (1, 3)), Refusal.OLDER, (1, 2), False),  # the former one is back
        Arrival(0.8, orders(2, 2, (2, 3), "deputy"), None, (2, 3), True),
    ],
    "two leaders after a split: the higher term": [
        Arrival(0.0, orders(3, 1, (3, 1)), None, (3, 1), True),
        Arrival(0.1, orders(2, 9, (2, 1), "deputy"), Refusal.OLDER, (3, 1), False),
        Arrival(0.2, orders(4, 1, (2, 2), "deputy"), None, (2, 2), True),
    ],
    "a leader in a term of another one": [
        Arrival(0.0, orders(2, 1, (2, 1), "lead"), Refusal.UNNAMED, None, False)
    ],
    "nobody's order": [Arrival(0.0, orders(1, 1, (1, 1), "stranger"), Refusal.UNNAMED, None, False)],
    "no order yet": [Arrival(0.0, orders(1, 1, None), None, None, False)],
}


@pytest.mark.parametrize("story", STORIES)
def test_stories(story: str) -> None:
    follower = OrderFollower("scout", ["lead", "deputy"])
    for arrival in STORIES[story]:
        if arrival.message is not None:
            sent_s = APART_S + arrival.at_s - arrival.held_s
            message = msgspec.structs.replace(arrival.message, sent_s=sent_s)
            assert follower.receive(message, arrival.at_s) == arrival.refused, arrival
        assert follower.update(arrival.at_s) == arrival.anew, arrival
        assert follower.order == arrival.executes, arrival
        assert follower.duty == (None if arrival.executes is None else ("go", {}))


def test_a_coordinator_of_another_library_is_refused_where_asked() -> None:
    message = orders(1, 1, (1, 1))
    assert OrderFollower("scout", ["lead"], library="M").receive(message, 0.0) is Refusal.LIBRARY
    assert OrderFollower("scout", ["lead"], library="L").receive(message, 0.0) is None


def test_who_has_nothing_to_do_has_an_order_all_the_same() -> None:
    follower = OrderFollower("other", ["lead"])
    follower.receive(orders(1, 1, (1, 1)), 0.0)
    assert follower.update(0.0)
    assert follower.order == (1, 1)
    assert follower.duty is None


DEEP = b"\x91" * 100_000 + b"\xc0"
UNREADABLE = [
    msgspec.structs.replace(orders(1, 1, None), lease_s=lease_s) for lease_s in (nan, inf, 0.0, -1.0, 1e9)
] + [msgspec.structs.replace(orders(1, 1, None), sent_s=sent_s) for sent_s in (nan, inf, -inf)]
UNREADABLE += [orders(-1, 1, None), orders(2**60, 1, None), orders(1, -1, None), orders(1, 1, (1, 2**60))]


@pytest.mark.parametrize("message", UNREADABLE)
def test_messages_with_impossible_numbers_are_unreadable(message: Orders) -> None:
    with pytest.raises(UnreadableMessage):
        decode_orders(pack_message(message))


def test_messages_that_are_nested_deeply_are_unreadable() -> None:
    """An element more than a message has is skipped by the decoder, however deep it is."""
    packed = pack_message(orders(1, 1, (1, 1)))
    with pytest.raises(UnreadableMessage):
        decode_orders(bytes([packed[0] + 1]) + packed[1:] + DEEP)


@pytest.mark.parametrize(
    "data", [b"", b"\xc1", b"hello", b"\x93\x01\x02\x03", pack_message(orders(1, 1, None))[:-3]]
)
def test_what_is_no_message_is_said_to_be_none(data: bytes) -> None:
    for decode in (decode_orders, decode_report):
        with pytest.raises(UnreadableMessage):
            decode(data)
