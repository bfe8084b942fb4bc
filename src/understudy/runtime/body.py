"""The body contract: anything an automaton can drive - simulated robots, a real robot, a squad.

A body senses one snapshot per tick as columns over its N agents, and obeys one command per agent. A run is

    while True:
        percept = body.sense(keys)          # sense
        commands = decide(percept)          # decide
        body.act(commands)                  # act: obey for one tick
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, TypeGuard, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName, join_names
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column, Kind
from understudy.model.squad import Order
from understudy.runtime.engine.tables import Stacks, Tables

Commands: TypeAlias = Mapping[str, Column]
"""Channel -> column [N]: what each agent is to do for one tick."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A reading that a body offers: of itself, or of each of its targets."""

    name: str
    kind: Kind
    unit: str = ""
    of_targets: bool = False
    doc: str = ""


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel that a body obeys, with the value at which it rests."""

    name: str
    rest: float = 0.0
    unit: str = ""
    doc: str = ""


class Body(Protocol):
    """What an automaton senses with and acts through; N agents at once, a single robot has N = 1."""

    @property
    def agents(self) -> int:
        """N."""
        ...

    @property
    def readings(self) -> Sequence[Reading]:
        """What it can sense."""
        ...

    @property
    def targets(self) -> Sequence[str]:
        """The names that readings of targets can refer to."""
        ...

    @property
    def channels(self) -> Sequence[Channel]:
        """What it obeys."""
        ...

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        ...

    @property
    def time_s(self) -> float:
        """The body's own clock, s."""
        ...

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """One snapshot: a column [N] for each key; NaN where absent. Twice in a tick it is the same."""
        ...

    def act(self, commands: Commands) -> None:
        """Obey for one tick; a channel that `commands` leaves out rests."""
        ...


@runtime_checkable
class Rewindable(Protocol):
    """A body whose state can be kept and brought back: simulated ones."""

    def snapshot(self) -> bytes:
        """The whole state, for `restore`."""
        ...

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit; FileError where it is not one of this body."""
        ...


def is_rewindable(body: Body) -> TypeGuard[Rewindable]:
    """Whether the state of a body can be kept and brought back; of one that stands on another, that of both."""
    return isinstance(body, Rewindable) and isinstance(getattr(body, "ground", body), Rewindable)


@runtime_checkable
class Resettable(Protocol):
    """A body whose worlds can begin anew: simulated ones."""

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin anew, a world per seed."""
        ...


@runtime_checkable
class OrderReceiver(Protocol):
    """A body that passes orders on: a squad. Its channels are ORDER and ISSUED."""

    def index_order(self, order: Order) -> int:
        """The number of an order whose parameters are ground, for the channel ORDER; 0 orders to idle."""
        ...


ORDER, ISSUED = "order", "issued"
"""The channels of a squad: which order stands, and when the state that gives it was entered, s."""


@dataclass(frozen=True, slots=True)
class FusedPlan:
    """What agents run, where all of it is data: for a body that senses, decides and acts in kernels.

    Column k of a feature vector is the reading `keys[k]`. `pulse` in `runtime/_kernels.py` decides on it with `tables`
    and changes `stacks`; it answers a row of `commands` [B, C], whose columns are the body's channels in order, and
    `running` [N] is to say which row each agent was given last.
    """

    tables: Tables
    stacks: Stacks
    keys: tuple[ReadingKey, ...]
    commands: NDArray[np.float64]
    running: NDArray[np.int32]
    lead: tuple[Any, Any] | None = None
    """Coordinators above the agents, as `_squad_kernels.py` sees them: bands and leads."""


@runtime_checkable
class Fused(Protocol):
    """A body that can go on for many ticks by itself: simulated ones, whose ticks are too quick for Python."""

    def advance(self, plan: FusedPlan, ticks: int, threads: int | None) -> None:
        """Sense, decide and act so many times, exactly as tick by tick, in at most `threads` threads (None: the
        body's choice). Agents pulse at the body's time.
        """
        ...


def check_reading_keys(
    keys: Sequence[ReadingKey], *, readings: Sequence[Reading], targets: Sequence[str], where: str
) -> None:
    """Refuse readings that a body does not have: UnknownName, or SettingError for a missing or needless target."""
    of_targets = {reading.name: reading.of_targets for reading in readings}
    for name, target in keys:
        if name not in of_targets:
            raise UnknownName(what="reading", name=name, where=where, known=list(of_targets))
        if of_targets[name] and target is None:
            remedy = f"give one of {join_names(targets)}: ({name!r}, TARGET)"
            raise SettingError(
                where=where, setting=f"reading {name!r}", problem="needs a target", remedy=remedy
            )
        if target is not None and not of_targets[name]:
            problem, remedy = f"takes no target, and {target!r} is given", f"give ({name!r}, None)"
            raise SettingError(where=where, setting=f"reading {name!r}", problem=problem, remedy=remedy)
        if target is not None and target not in targets:
            raise UnknownName(what="target", name=target, where=where, known=targets)


def list_reading_keys(body: Body) -> tuple[ReadingKey, ...]:
    """Keys of all readings of a body, of itself and of each target, in declared order."""
    return tuple(
        (reading.name, target)
        for reading in body.readings
        for target in (body.targets if reading.of_targets else (None,))
    )
