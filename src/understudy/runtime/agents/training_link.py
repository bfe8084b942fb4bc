"""The messages between a computer that trains a member and the member: commands and views (docs/agents.md).

A command holds for a short lease, counted on the member's own clock from when it would have arrived if nothing
had held it up. When no further one comes, because the trainer ended, or its computer died, the member does again what
holds for it without a trainer.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import Annotated, TypeAlias

import msgspec
import numpy as np

from understudy.runtime.agents.lateness import LatenessMeter
from understudy.runtime.agents.messages import UNREADABLE, Count, Duty, Seconds, UnreadableMessage
from understudy.runtime.body import Commands

TRAINER_LEASE_S = 0.5
"""The time for which a trainer's command holds, s."""
TrainerLease: TypeAlias = Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]
"""The time for which a trainer's command holds, s."""


class TrainerCommand(msgspec.Struct, frozen=True, array_like=True):
    """A trainer's message to the member that it trains: the command of this tick."""

    trainer: str
    start: Count
    """A random number of the trainer's program: one that was started again counts its messages from 1 again."""
    sequence: Count
    """The number of the message since this start."""
    sent_s: Seconds
    """When it was sent."""
    lease_s: TrainerLease
    commands: dict[str, float]
    """The value of each channel; channels that are left out rest."""
    skill: Duty | None = None
    """The skill that is to be carried out, with its targets."""


class MemberView(msgspec.Struct, frozen=True, array_like=True):
    """A member as a trainer sees it: all its readings at a tick, and where the targets are."""

    member: str
    start: Count
    """A random number of the member's program."""
    sequence: Count
    layout: int
    """A checksum of what `readings` are."""
    readings: list[float]
    """A value for each of `list_reading_keys`; NaN where absent."""
    pose: list[float]
    """The robot's own place and heading: x and y in m, and rad; NaN where unknown."""
    places: dict[str, tuple[float, float]]
    """The places (x, y) of those targets that are known, m."""


def decode_trainer_command(data: bytes) -> TrainerCommand:
    """Decode a trainer's command; raise UnreadableMessage if it is none."""
    try:
        message = msgspec.msgpack.decode(data, type=TrainerCommand)
    except UNREADABLE as error:
        raise UnreadableMessage(str(error)) from None
    if not all(map(isfinite, message.commands.values())):
        raise UnreadableMessage("a command is not finite")
    return message


def decode_member_view(data: bytes) -> MemberView:
    """Decode a member's view; raise UnreadableMessage if the message is none."""
    try:
        return msgspec.msgpack.decode(data, type=MemberView)
    except UNREADABLE as error:
        raise UnreadableMessage(str(error)) from None


def trainer_command_key(member: str) -> str:
    """Return the key of the messages with which a member is driven."""
    return f"drive/{member}"


def view_key(member: str) -> str:
    """Return the key of the views that a member sends."""
    return f"view/{member}"


class TrainerFollower:
    """A member's side of being trained: whether a trainer drives it now, and with which command.

    Parameters
    ----------
    trainer
        The only trainer that it obeys.
    """

    def __init__(self, trainer: str) -> None:
        self.trainer = trainer
        self._message: TrainerCommand | None = None
        self._until_s = -inf
        self._ended: set[int] = set()
        self._lateness = LatenessMeter()

    def receive(self, message: TrainerCommand, now: float) -> bool:
        """Take a message at a time (s) of the member's clock; return False if it is not obeyed."""
        last = self._message
        if message.trainer != self.trainer or message.start in self._ended:
            return False
        if last is not None and message.start == last.start and message.sequence <= last.sequence:
            return False
        late_s = self._lateness.measure(message.start, message.sent_s, now)
        if late_s >= message.lease_s:
            return False
        if last is not None and message.start != last.start:
            self._ended.add(last.start)
        self._message, self._until_s = message, now - late_s + message.lease_s
        return True

    def holds(self, now: float) -> bool:
        """Return whether the trainer drives the member at a time (s) of the member's clock."""
        return now < self._until_s

    @property
    def commands(self) -> Commands:
        """The command of the last message, a column [1] for each channel."""
        values: Mapping[str, float] = {} if self._message is None else self._message.commands
        return {channel: np.array([value]) for channel, value in values.items()}

    @property
    def skill(self) -> Duty | None:
        """The skill of the last message."""
        return None if self._message is None else self._message.skill
