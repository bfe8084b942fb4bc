"""The structure of an experiment: tasks that can run in any order, and findings from all their rows.

All of it is plain data, so that tasks can run in other processes, and rows can be stored in a file and compared with
the published ones. `understudy experiment` runs studies of the laboratory, and those of other packages.
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
"""The parameters of one piece of work: names, numbers, a seed."""
Row: TypeAlias = Mapping[str, Any]
"""The result of one task as JSON data; NaN becomes None."""


@dataclass(frozen=True)
class StudyPlan:
    """The extent of a run: teaching seeds, whether it is the quick version, and a folder of external data."""

    seeds: Sequence[int]
    quick: bool = False
    data: Path | None = None


@dataclass(frozen=True)
class ResultTable:
    """A table of texts; a column whose name begins with # holds numbers."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class StudyGoal:
    """A goal: its subject, the wanted value and the measured value as texts, and whether it was reached."""

    what: str
    wanted: str
    measured: str
    held: bool


@dataclass(frozen=True)
class StudyFindings:
    """The findings from all rows; `numbers` repeats the tables as data, `notes` explains what is surprising."""

    headline: str
    tables: Sequence[ResultTable] = ()
    goals: Sequence[StudyGoal] = ()
    notes: Sequence[str] = ()
    numbers: Mapping[str, Any] = field(default_factory=dict)

    @property
    def misses(self) -> tuple[StudyGoal, ...]:
        """The goals that were not reached."""
        return tuple(goal for goal in self.goals if not goal.held)


@dataclass(frozen=True)
class Study:
    """An experiment: what is done for each seed, and what follows from all of it.

    Parameters
    ----------
    name
        The name, which is that of the entry point for a study of another package.
    seeds
        The teaching seeds of the whole experiment.
    quick
        The number of seeds of its quick version.
    tasks
        Function that returns the tasks of a plan, as JSON data, all different. The tasks of the quick plan are among
        those of the whole one.
    work
        Function that does one task, in any process, and returns its row as JSON data, where NaN becomes None. It
        depends on nothing but the task: a row is the same on every machine, except for the keys in `varies`.
    conclude
        Function from all rows, in the order of the tasks, to the findings; each row has its task under "task".
    draw
        Function from the same rows to a figure of Matplotlib.
    worlds
        Scenarios whose kernels are compiled before the tasks begin.
    needs
        Install commands of optional modules; without them, `tasks` leaves out the part that needs them.
    varies
        Keys of a row that depend on the machine, such as times.
    check_machine
        Function that raises an UnderstudyError on a machine that cannot run the study.
    in_real_time
        Whether tasks run one after the other.
    question
        The question that it answers; those of the laboratory have theirs in `QUESTIONS`.
    """

    name: str
    seeds: range
    quick: int
    tasks: Callable[[StudyPlan], Sequence[Task]]
    work: Callable[[Task], Row]
    conclude: Callable[[Sequence[Row]], StudyFindings]
    draw: Callable[[Sequence[Row]], Figure]
    worlds: Sequence[str] = ()
    needs: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    varies: Sequence[str] = ()
    check_machine: Callable[[], None] = lambda: None
    in_real_time: bool = False
    question: str = ""
