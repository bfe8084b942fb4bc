"""The messages between a squad's coordinator and its members: reports and orders (docs/semantics.md).

Both are sent at every tick and repeat what still holds, so that the next message makes up for a lost one. Times in them
are of the sender's clock; receivers compare them only with other times of the same program.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated, TypeAlias
from zlib import crc32

import msgspec

from understudy.model.features import ReadingKey
from understudy.model.squad import Squad
from understudy.runtime.body import Reading
from understudy.runtime.interpreter import StackFrame

LONGEST_LEASE_S = 60.0
"""The longest time for which an order may hold, s."""
Count: TypeAlias = Annotated[int, msgspec.Meta(ge=0, le=2**53)]
"""A number that is counted up from 0."""
Lease: TypeAlias = Annotated[float, msgspec.Meta(gt=0.0, le=LONGEST_LEASE_S)]
"""The time for which an order holds, s."""
Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=-1e12, le=1e12)]
"""A time by the sender's clock, s; finite."""
OrderId: TypeAlias = tuple[Count, Count]
"""An order: the term in which it was first given, and its number in that term."""
Duty: TypeAlias = tuple[str, dict[str, str]]
"""A behavior and the target of each of its parameters."""
UNREADABLE = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)
"""What decoders raise; RecursionError, if the message is nested too deeply."""


class MemberReport(msgspec.Struct, frozen=True, array_like=True):
    """A member's report to its squad."""

    member: str
    start: Count
    """A random number of the member's program: one that was started again counts its reports from 1 again."""
    sequence: Count
    """The number of the report since this start."""
    sent_s: Seconds
    """When it was sent."""
    term: Count
    """The term of the coordinator that the member obeys; 0 before the first."""
    heard: Count
    """The number of the last message of this coordinator that the member has heard."""
    order: OrderId | None
    """The order that the member executes; None if it executes none, and runs the behavior that it was taught for being
alone."""
    library: str
    """The fingerprint of the member's library."""
    unfit: str
    """Why the member must not be counted, such as "is disarmed"; empty if it is fit."""
    flag: str | None
    """The flag that its behavior has raised."""
    path: list[str]
    """The current state of every level, from the root down."""
    layout: int
    """A checksum of what `readings` are."""
    readings: list[float]
    """A value for each of `list_reported_readings`; NaN where absent."""
    kept: tuple[Orders, Seconds] | None = None
    """While its leader is silent: the leader's last message, and its age in s, for a new leader without memory."""


class Orders(msgspec.Struct, frozen=True, array_like=True):
    """A coordinator's message to all members of its squad."""

    squad: str
    leader: str
    """The agent that leads the squad."""
    term: Count
    """The term of the leader: a candidate that takes over leads in a higher one."""
    start: Count
    """A random number of the leader's program: one that was started again counts its messages from 1 again."""
    sequence: Count
    """The number of the message in the term, since this start."""
    sent_s: Seconds
    """When it was sent."""
    order: OrderId | None
    """The present order; None before the first."""
    lease_s: Lease
    """The time in s for which the order holds; it counts from the arrival of a message that nothing held up."""
    library: str
    """The fingerprint of the coordinator's library."""
    duties: dict[str, Duty | None]
    """What each member does; None: nothing."""
    frames: list[StackFrame]
    """The coordinator's run state, with which another one can take over."""


class UnreadableMessage(Exception):
    """A message that is not of the given type."""


def pack_message(message: MemberReport | Orders) -> bytes:
    """Encode a message."""
    return msgspec.msgpack.encode(message)


def decode_report(data: bytes) -> MemberReport:
    """Decode a report; raise UnreadableMessage if it is none."""
    try:
        return msgspec.msgpack.decode(data, type=MemberReport)
    except UNREADABLE as error:
        raise UnreadableMessage(str(error)) from None


@lru_cache(maxsize=64)
def decode_orders(data: bytes) -> Orders:
    """Decode a coordinator's message, once for all members in one program; raise UnreadableMessage if it is none."""
    try:
        return msgspec.msgpack.decode(data, type=Orders)
    except UNREADABLE as error:
        raise UnreadableMessage(str(error)) from None


def list_reported_readings(
    squad: Squad, readings: Sequence[Reading], targets: Sequence[str]
) -> tuple[ReadingKey, ...]:
    """List the readings that a member reports: all over which the squad has a statistic, of each target.

    Parameters
    ----------
    squad
        The member's squad.
    readings
        The readings that the member offers.
    targets
        The targets of the team.

    Returns
    -------
    tuple
        Pairs of a reading and a target, in an order that member and coordinator both know.
    """
    offered = {reading.name: reading for reading in readings}
    names = dict.fromkeys(each.reading for each in squad.statistics if each.reading is not None)
    if squad.drops is not None:
        names[squad.drops] = None
    keys: list[ReadingKey] = []
    for name in names:
        if name in offered:
            keys += [(name, target) for target in targets] if offered[name].of_targets else [(name, None)]
    return tuple(keys)


def compute_layout(keys: Sequence[ReadingKey]) -> int:
    """Compute the checksum of a list of readings."""
    return crc32(repr(list(keys)).encode())
