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

from understudy.entry_points import STUDIES, list_entry_points, load_instance
from understudy.errors import SettingError, UnknownName

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
    install commands; without them `tasks` leaves out the part that needs them. `check_machine` raises UnderstudyError
    on a machine that cannot run it. Tasks `in_real_time` run one after the other.
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
    """The question that an experiment of another package answers; those of this package have theirs in `QUESTIONS`."""


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
        "networks": "Do robots with a computer each work together as well over a network that loses messages?",
        "swarm": "Can two hundred robots and three levels of coordinators be taught, and can ten thousand do the same?",
        "wrong_feature": "How often is a switch learned on the wrong feature, and does the order of tests change it?",
        "unlearning": "Can bad examples be found from the corrections that they made necessary?",
        "slips": "How many corrections does unlearning save people who press wrong buttons and press late?",
        "transfer": "Do behaviors taught in the 2-D world work in simulated physics with rendered cameras?",
        "recordings": "Can a robot be taught by recordings of a stick, without any press?",
        "counterexamples": "Do lessons in worlds in which a robot fails help more than lessons at random places?",
        "searches": "How much sooner than chance does a directed search find worlds in which a robot seldom fails?",
        "small": "How small are the lessons from which robots learn?",
    }
)
"""The question of each experiment, in the order of the list."""

FOLDERS: Mapping[str, str] = MappingProxyType(
    {
        "repertoire": "behavior_suite",
        "coached": "coaching_benefit",
        "learners": "baselines",
        "networks": "lossy_networks",
        "roles": "mixed_teams",
        "slips": "noisy_teachers",
        "transfer": "sim_to_sim",
        "small": "lesson_size",
    }
)
"""The folders of experiments whose name differs from their folder's; published rows contain the names."""


REMEDY = "let the entry point name a Study of understudy_lab.study"


def list_questions() -> dict[str, str]:
    """Return the question of each experiment by its name; those of other packages come last.

    If an experiment of another package cannot be loaded, the reason replaces its question.
    """
    questions = dict(QUESTIONS)
    for name in sorted(list_entry_points(STUDIES)):
        try:
            questions.setdefault(name, find_experiment(name).question)
        except SettingError as error:
            questions[name] = str(error)
    return questions


def find_experiment(name: str) -> Study:
    """Return an experiment of this package, or of another one that offers it as an entry point, by its name."""
    others = sorted(list_entry_points(STUDIES))
    if name not in QUESTIONS and name in others:
        return load_instance(name, STUDIES, Study, where="understudy experiment", remedy=REMEDY)
    if name not in QUESTIONS:
        raise UnknownName(what="experiment", name=name, where="the catalog", known=[*QUESTIONS, *others])
    study: Study = import_module(f"understudy_lab.{FOLDERS.get(name, name)}.study").EXPERIMENT
    return study


def folder_of(name: str) -> Path:
    """Return the folder of an experiment, with its README and its published result."""
    return Path(__file__).parent / FOLDERS.get(name, name)
