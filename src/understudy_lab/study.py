"""The structure of an experiment: tasks that can run in any order, and findings from all their rows.

All of it is plain data, so that tasks can run in other processes, and rows can be stored in a file and compared with
the published ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from understudy.errors import UnknownName

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
    """A published experiment.

    `tasks` returns the tasks of a plan; `work` runs one, with the same result on every machine except for the keys in
    `varies`. `conclude` and `draw` receive the rows in the order of the tasks. `needs` maps optional modules to their
    install commands; without them `tasks` leaves out the part that needs them.
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


QUESTIONS: Mapping[str, str] = MappingProxyType(
    {
        "forage": "Can a robot be taught to forage, and how well does it forage then?",
        "repertoire": "Which behaviors can be taught with few examples each, and how well do robots perform them?",
        "servoing": "When does memory help a robot that follows what its camera sees?",
        "novices": "Can people without experience teach a robot in five minutes?",
        "coached": "Do people who follow the coach teach better, and with fewer examples?",
        "hierarchy": "Does a robot learn with fewer examples when a task is taught in layers?",
        "learners": "What do other learners achieve with the same few decisions?",
        "ablation": "Which parts of the method matter, and how much?",
        "patrol": "Can a team be taught the patrol of the paper, and what does its coordinator contribute?",
        "roles": "What is a team of different robots worth, and what does its coordinator contribute?",
        "swarm": "Can two hundred robots and three levels of coordinators be taught, and can ten thousand do the same?",
        "unlearning": "Can bad examples be found from the corrections that they made necessary?",
        "slips": "How many corrections does unlearning save people who press wrong buttons and press late?",
        "transfer": "Do behaviors taught in the 2-D world work in simulated physics with rendered cameras?",
        "recordings": "Can a robot be taught by recordings of a stick, without any press?",
        "small": "How small are the lessons from which robots learn?",
    }
)
"""The question of each experiment, in the order of the list."""

FOLDERS: Mapping[str, str] = MappingProxyType(
    {
        "repertoire": "behavior_suite",
        "coached": "coaching_benefit",
        "learners": "baselines",
        "roles": "mixed_teams",
        "slips": "noisy_teachers",
        "transfer": "sim_to_sim",
        "small": "lesson_size",
    }
)
"""The folders of experiments whose name differs from their folder's; published rows contain the names."""


def find_experiment(name: str) -> Study:
    """Return an experiment by its name."""
    if name not in QUESTIONS:
        raise UnknownName(what="experiment", name=name, where="the catalog", known=list(QUESTIONS))
    found: Study = import_module(f"understudy_lab.{FOLDERS.get(name, name)}.study").EXPERIMENT
    return found


def folder_of(name: str) -> Path:
    """Return the folder of an experiment, with its README and its published result."""
    return Path(__file__).parent / FOLDERS.get(name, name)
