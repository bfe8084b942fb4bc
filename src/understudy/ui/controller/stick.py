"""Sticks that drive a robot: how far one leans, and which behaviors are held, become a command."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import hypot, isfinite

from understudy.errors import SettingError
from understudy.model.behaviors import Behavior
from understudy.runtime.body import ISSUED, SKILL, Channel
from understudy.ui.controller.key_bindings import Arrow

DEAD_ZONE = 0.12
"""How far a stick leans at most, as a share of the whole way, that counts as at rest."""
DRIVE, TURN = "drive", "turn"


@dataclass(frozen=True, slots=True)
class StickPosition:
    """The position of a stick, from -1 to 1 each: `right` and `up`, and the indices of the behaviors that are held."""

    right: float = 0.0
    up: float = 0.0
    held: frozenset[int] = frozenset()

    @property
    def is_resting(self) -> bool:
        """Whether it leans no farther than the dead zone, and nothing is held."""
        return not self.held and hypot(self.right, self.up) <= DEAD_ZONE


AT_REST = StickPosition()


@dataclass(frozen=True, slots=True)
class StickAxis:
    """A channel that an axis of the stick commands, and its values at both ends and at rest."""

    channel: str
    low: float
    rest: float
    high: float
    whole: bool = False

    def scale(self, lean: float) -> float:
        """Return the command for a position of the axis, from -1 to 1."""
        value = self.rest + (lean * (self.high - self.rest) if lean > 0 else -lean * (self.low - self.rest))
        return float(round(value)) if self.whole else value


@dataclass(frozen=True, slots=True)
class HeldBehavior:
    """A behavior that is carried out while its button is held, by the channels that the stick does not command."""

    name: str
    command: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class StickLayout:
    """What a stick and the buttons beside it command.

    `right` and `up` are the axes of the stick, None for one that does nothing.
    """

    channels: tuple[Channel, ...]
    right: StickAxis | None
    up: StickAxis | None
    held: tuple[HeldBehavior, ...]

    def list_ways(self) -> list[Arrow]:
        """List the ways in which the stick commands anything."""
        axes: list[tuple[StickAxis | None, Arrow, Arrow]] = [
            (self.up, "up", "down"),
            (self.right, "right", "left"),
        ]
        ways: list[Arrow] = []
        for axis, high, low in axes:
            if axis is not None:
                ways += [high] * (axis.high != axis.rest) + [low] * (axis.low != axis.rest)
        return ways

    def make_command(self, stick: StickPosition) -> list[float]:
        """Return the command of each channel; within the dead zone the stick is at rest, and from there it grows."""
        commands = {each.name: each.rest for each in self.channels}
        lean = hypot(stick.right, stick.up)
        share = 0.0 if lean <= DEAD_ZONE else (min(lean, 1.0) - DEAD_ZONE) / (1 - DEAD_ZONE) / lean
        for axis, way in ((self.right, stick.right), (self.up, stick.up)):
            if axis is not None:
                commands[axis.channel] = axis.scale(max(-1.0, min(1.0, way * share)))
        for index in sorted(stick.held):
            if index < len(self.held):
                commands.update(self.held[index].command)
        return list(commands.values())


def lay_out_stick(channels: Sequence[Channel], behaviors: Mapping[str, Behavior]) -> StickLayout:
    """Lay out a stick for the channels of a body.

    Up drives ahead, and right turns right, if there are such channels; otherwise right raises the first channel, and up
    the second. Basic behaviors that command other channels are held as buttons. SettingError if there is no channel
    that a stick can command.
    """
    usable = [each for each in channels if each.name not in (SKILL, ISSUED)]
    names = [each.name for each in usable]
    if not usable:
        raise SettingError(
            where="drive",
            setting="the robot",
            problem="has no channel that a stick can command",
            remedy="teach it with presses instead: understudy studio",
        )
    if DRIVE in names or TURN in names:
        sides, ahead = (next((each for each in usable if each.name == name), None) for name in (TURN, DRIVE))
        right = None if sides is None else _flip(_make_axis(sides, behaviors))
    else:
        sides, ahead = usable[0], usable[1] if len(usable) > 1 else None
        right = _make_axis(sides, behaviors)
    up = None if ahead is None else _make_axis(ahead, behaviors)
    on_stick = {each.name for each in (sides, ahead) if each is not None}
    return StickLayout(
        tuple(channels), right, up, tuple(_list_held(behaviors, {*names} - on_stick, on_stick))
    )


def _make_axis(channel: Channel, behaviors: Mapping[str, Behavior]) -> StickAxis:
    """Make an axis that reaches the limits of its channel, or else as far as behaviors do; by 1 if none commands it."""
    values = [
        float(each.command[channel.name]) for each in behaviors.values() if channel.name in each.command
    ]
    reached = [channel.rest, *(values or (channel.rest - 1, channel.rest + 1))]
    return StickAxis(
        channel.name,
        channel.least if isfinite(channel.least) else min(reached),
        channel.rest,
        channel.most if isfinite(channel.most) else max(reached),
        channel.whole,
    )


def _flip(axis: StickAxis) -> StickAxis:
    return StickAxis(axis.channel, axis.high, axis.rest, axis.low, axis.whole)


def _list_held(
    behaviors: Mapping[str, Behavior], others: set[str], on_stick: set[str]
) -> Iterator[HeldBehavior]:
    """Yield a behavior for each command of other channels, called as the behavior that leaves the stick alone."""
    names: dict[tuple[tuple[str, float], ...], str] = {}
    moves = {name: bool(on_stick & set(each.command)) for name, each in behaviors.items()}
    for name in sorted(behaviors, key=lambda each: moves[each]):
        command = behaviors[name].command
        own = tuple((channel, float(command[channel])) for channel in sorted(others & set(command)))
        if own and behaviors[name].function is None:
            names.setdefault(own, name)
    for own, name in names.items():
        called = " ".join(f"{channel} {value:g}" for channel, value in own) if moves[name] else name
        yield HeldBehavior(called, dict(own))
