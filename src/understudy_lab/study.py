"""An experiment: pieces of work that can be done in any order, and what follows from all of them.

All of it is plain data, so that pieces can be done in other processes, kept in a file, and compared with what was
published.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Task: TypeAlias = Mapping[str, Any]
"""Which piece of work: names, numbers, a seed."""
Row: TypeAlias = Mapping[str, Any]
"""What a piece came to, as JSON says it: what was absent is None."""


@dataclass(frozen=True)
class Plan:
    """What is to be run: teaching seeds; whether it is the quick version; a folder of data from elsewhere."""

    seeds: Sequence[int]
    quick: bool = False
    data: Path | None = None


@dataclass(frozen=True)
class Table:
    """A table of texts. A column whose name begins with # holds numbers."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Goal:
    """Something to reach: what, what was wanted and what was measured, in words."""

    what: str
    wanted: str
    measured: str
    held: bool


@dataclass(frozen=True)
class Findings:
    """What follows from the rows. `numbers` has what the tables tell, for programs; `notes` what surprises in it."""

    headline: str
    tables: Sequence[Table] = ()
    goals: Sequence[Goal] = ()
    notes: Sequence[str] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)

    @property
    def misses(self) -> tuple[Goal, ...]:
        """The goals that were not reached."""
        return tuple(goal for goal in self.goals if not goal.held)


@dataclass(frozen=True)
class Experiment:
    """A published experiment.

    `tasks` says which pieces a plan takes; `work` does one, always with the same outcome on every machine, but for what
    is in `varies`. `conclude` and `draw` are given the rows in the order of the tasks. `needs` are modules that
    some of it asks for, each with what to install; without them `tasks` leaves that part out.
    """

    name: str
    seeds: range
    quick: int
    tasks: Callable[[Plan], Sequence[Task]]
    work: Callable[[Task], Row]
    conclude: Callable[[Sequence[Row]], Findings]
    draw: Callable[[Sequence[Row]], Figure]
    worlds: Sequence[str] = ()
    needs: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    varies: Sequence[str] = ()
