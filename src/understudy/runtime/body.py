"""The body contract: everything that automata can drive, such as simulated robots, a real robot or a squad.

A body senses one snapshot per tick, as columns over its N agents, and applies one command per agent. A run is

    while True:
        percept = body.sense(keys)          # sense
        commands = decide(percept)          # decide
        body.act(commands)                  # act for one tick
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol, TypeAlias, TypeGuard, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName, join_names
from understudy.model.features import Percept, ReadingKey
from understudy.model.squad import Order
from understudy.model.value_kinds import Column, Kind
from understudy.runtime.engine.tables import Stacks, Tables

Commands: TypeAlias = Mapping[str, Column]
"""Channel -> column [N]: what each agent is to do for one tick."""


@dataclass(frozen=True, slots=True)
class Reading:
    """A reading that a body offers, either of the robot itself or of each of its targets."""

    name: str
    kind: Kind
    unit: str = ""
    of_targets: bool = False
    doc: str = ""


@dataclass(frozen=True, slots=True)
class Channel:
    """A command channel of a body, with the value that it has at rest.

    Without limits a channel takes all finite numbers; with `whole` only whole ones, such as the numbers of actions.
    """

    name: str
    rest: float = 0.0
    unit: str = ""
    doc: str = ""
    least: float = -inf
    most: float = inf
    whole: bool = False


class Body(Protocol):
    """The body of N agents, by whose readings automata sense and by whose channels they act; N = 1 for a single robot.

    Columns are float64 arrays [N]. A reading that is absent is NaN, and any other value is of the reading's kind;
    commands are finite. Each side may change an array that it got, without any effect on the other. Readings, targets
    and channels stay the same as long as the body exists. What is unknown, of another shape or not finite is refused by
    an `UnderstudyError` that names it, before anything has changed. In each tick, `sense` may be called several times,
    and then `act` once; never by two threads at once, but not always by the same one. Neither waits for a robot.

    A body whose worlds can begin again also has `reset` (`Resettable`), one that can go back `snapshot` and `restore`
    (`Rewindable`), and one that holds a device `close`.
    """

    @property
    def agents(self) -> int:
        """The number N of agents."""
        ...

    @property
    def readings(self) -> Sequence[Reading]:
        """The readings that `sense` offers."""
        ...

    @property
    def targets(self) -> Sequence[str]:
        """The names of the targets that readings can refer to."""
        ...

    @property
    def channels(self) -> Sequence[Channel]:
        """The command channels."""
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
        """Take one snapshot of readings.

        Calls within one tick return the same values.

        Parameters
        ----------
        keys
            Pairs (reading, target); the target is None for a reading of the robot itself.

        Returns
        -------
        Percept
            A column [N] for each key, in the reading's unit. NaN where the reading is absent.
        """
        ...

    def act(self, commands: Commands) -> None:
        """Apply commands for one tick.

        Parameters
        ----------
        commands
            A column [N] for each channel. A channel that is left out rests.
        """
        ...


BODY_ATTRIBUTES = ("agents", "readings", "targets", "channels", "tick_s", "time_s", "sense", "act")
"""The names of the attributes that every body has."""


@runtime_checkable
class Rewindable(Protocol):
    """A body whose state can be stored and restored, such as a simulated one."""

    def snapshot(self) -> bytes:
        """Return the whole state.

        Returns
        -------
        bytes
            The state, to be passed to `restore`.
        """
        ...

    def restore(self, snapshot: bytes) -> None:
        """Go back to a snapshot, bit for bit.

        Parameters
        ----------
        snapshot
            What `snapshot` returned.

        Raises
        ------
        FileError
            If it is not a snapshot of such a body.
        """
        ...


def is_rewindable(body: Body) -> TypeGuard[Rewindable]:
    """Return whether the state of a body can be stored and restored; for a body on top of another, that of both."""
    return isinstance(body, Rewindable) and isinstance(getattr(body, "ground", body), Rewindable)


@runtime_checkable
class Viewable(Protocol):
    """A body whose worlds can be drawn, such as a simulated one."""

    def view(self, world: int = 0) -> Any:
        """Return a view of one world as it is now.

        Parameters
        ----------
        world
            The index of the world, from 0.

        Returns
        -------
        Any
            A `understudy.sim.view.WorldView`, which does not change later.
        """
        ...


@runtime_checkable
class Resettable(Protocol):
    """A body whose worlds can be reset, such as a simulated one."""

    def reset(self, seeds: Sequence[int]) -> None:
        """Begin new worlds.

        Parameters
        ----------
        seeds
            The seed of each world.
        """
        ...


@runtime_checkable
class SeededBody(Body, Protocol):
    """A body in worlds that seeds lay out, such as a simulated one, of which there can be others."""

    worlds: int
    robots: int

    def with_seeds(self, seeds: Sequence[int]) -> SeededBody:
        """Make a body like this one in other worlds, at time 0; this one does not change.

        Parameters
        ----------
        seeds
            One whole number from 0 to 2**63 - 1 per world.

        Returns
        -------
        SeededBody
            The body, with as many robots in each world.
        """
        ...


@runtime_checkable
class OrderReceiver(Protocol):
    """A body that passes on orders, that is, a squad. Its channels are ORDER and ISSUED."""

    def index_order(self, order: Order) -> int:
        """Return the number of an order.

        Parameters
        ----------
        order
            An order whose parameters are all bound to targets.

        Returns
        -------
        int
            The value that orders it on the channel ORDER. 0 is the order to idle.
        """
        ...


ORDER, ISSUED = "order", "issued"
"""The channels of a squad: which order stands, and when the state that gives it was entered, s."""


SKILL = "skill"
"""The channel of a body with skills: which one is carried out, with which targets. ISSUED says since when."""


@runtime_checkable
class SkillPerformer(Protocol):
    """A body with skills of its own, such as driving to a place. Its channels are SKILL and ISSUED."""

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets.

        Parameters
        ----------
        name
            Name of the skill.
        binding
            The target of each of its parameters.

        Returns
        -------
        int
            The value that starts it on the channel SKILL, which is 1 at least.
        """
        ...


@dataclass(frozen=True, slots=True)
class FusedPlan:
    """What agents run, if all of it is data, for a body that senses, decides and acts in kernels.

    Column k of a feature vector is the reading `keys[k]`. The kernel `pulse` decides on it with `tables`, changes
    `stacks`, and returns a row of `commands` [B, C], whose columns are the body's channels in order. The body writes to
    `running` [N] the row that each agent got last.
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
    """A body that can run many ticks by itself: simulated worlds, where a tick is too short for Python."""

    def advance(self, plan: FusedPlan, ticks: int, threads: int | None) -> None:
        """Sense, decide and act many times, with the same result as tick by tick.

        Parameters
        ----------
        plan
            What the agents run. They pulse at the body's time.
        ticks
            The number of ticks.
        threads
            The largest number of threads. None: the body chooses.
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


def close_body(body: Body | None) -> None:
    """Close a body if it has a method `close`, as environments that draw have one.

    Parameters
    ----------
    body
        The body; None if it was never made.
    """
    close: object = getattr(body, "close", None)
    if callable(close):
        close()


def list_reading_keys(body: Body) -> tuple[ReadingKey, ...]:
    """List the keys of all readings of a body, of the robot itself and of each target, in declared order."""
    return tuple(
        (reading.name, target)
        for reading in body.readings
        for target in (body.targets if reading.of_targets else (None,))
    )
