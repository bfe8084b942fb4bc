"""Declaration of an experiment: its units, its tables, its goals, and all that is concluded from its rows.

Each class is a function of what a `Conclusion` prepares: the rows of all tasks, unless it says otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import ceil
from typing import Any, TypeAlias

from understudy_lab.rows import Count, Groups, Rows
from understudy_lab.study import ResultTable, Row, StudyFindings, StudyGoal, StudyPlan, Task

Text: TypeAlias = str | Callable[[Any], str]
"""A text, or a function that writes it."""
Cell: TypeAlias = Callable[[Rows], str]
"""A function that summarizes rows as the text of a cell, such as `Median` and `Count`."""


def write(text: Text, found: Any) -> str:
    """Return a text."""
    return text if isinstance(text, str) else text(found)


@dataclass(frozen=True)
class Units:
    """The tasks of a plan: one for each seed and combination of factors, by the names of the task's parameters."""

    factors: Mapping[str, Iterable[Any]]
    by_seed: bool = False
    """Whether all tasks of one seed come before those of the next, instead of all seeds of one combination."""

    def __call__(self, plan: StudyPlan) -> list[Task]:
        combinations = [
            dict(zip(self.factors, each, strict=True)) for each in product(*self.factors.values())
        ]
        if self.by_seed:
            return [{**each, "seed": seed} for seed in plan.seeds for each in combinations]
        return [{**each, "seed": seed} for each in combinations for seed in plan.seeds]


@dataclass(frozen=True)
class LinePerGroup:
    """A table with a line for each group of rows, and its summaries by the heads of their columns."""

    title: Text
    heads: Sequence[str]
    """The heads of the columns that name a group."""
    groups: Groups
    cells: Mapping[str, Cell]
    name: Callable[[Any], Sequence[str]] = lambda group: (str(group),)
    """A function that returns the texts that name a group."""

    def __call__(self, found: Any) -> ResultTable:
        lines = [
            (*self.name(group), *(cell(rows) for cell in self.cells.values()))
            for group, rows in self.groups(found).items()
        ]
        return ResultTable(write(self.title, found), (*self.heads, *mark_numbers(self.cells)), lines)


@dataclass(frozen=True)
class ColumnPerGroup:
    """A table with a column for each group of rows, and a line for each summary."""

    title: Text
    groups: Groups
    cells: Mapping[str, Cell]
    head: str = ""
    """The head of the column that names the summaries."""

    def __call__(self, found: Any) -> ResultTable:
        groups = self.groups(found)
        lines = [(name, *map(cell, groups.values())) for name, cell in self.cells.items()]
        return ResultTable(write(self.title, found), (self.head, *mark_numbers(groups)), lines)


def mark_numbers(heads: Iterable[Any]) -> list[str]:
    """Return the heads of columns that hold numbers."""
    return [f"#{head}" for head in heads]


@dataclass(frozen=True)
class Goal:
    """A goal: a number that is to be at least or at most so much.

    `form` writes the number that is wanted and the one that was measured; `wanted` and `measured` replace these texts.
    """

    what: Text
    number: Callable[[Any], float]
    least: float | None = None
    most: float | None = None
    form: str = "{:.0%}"
    wanted: Text = ""
    measured: Text = ""

    def __call__(self, found: Any) -> StudyGoal:
        number = self.number(found)
        if self.most is None:
            held, bound = number >= (self.least or 0.0), self.form.format(self.least)
        else:
            held, bound = number <= self.most, f"at most {self.form.format(self.most)}"
        return StudyGoal(
            write(self.what, found),
            write(self.wanted, found) or bound,
            write(self.measured, found) or self.form.format(number),
            bool(held),
        )


def goals_among(
    select: Callable[[Any], Any], goals: Iterable[Callable[[Any], StudyGoal]], prefix: str = ""
) -> list[Callable[[Any], StudyGoal]]:
    """Return goals of a part of what was prepared, each with a prefix to its subject."""

    def narrow(goal: Callable[[Any], StudyGoal]) -> Callable[[Any], StudyGoal]:
        def judge(found: Any) -> StudyGoal:
            judged = goal(select(found))
            return replace(judged, what=prefix + judged.what)

        return judge

    return [narrow(goal) for goal in goals]


@dataclass(frozen=True)
class CountGoal:
    """A goal: a share of the rows, made a whole number by `whole`, is to meet a condition."""

    what: Text
    share: float
    condition: Callable[[Row], bool]
    whole: Callable[[float], int] = ceil
    groups: Callable[[Any], Rows] = Rows
    """A function that returns the rows that count."""
    measured: Text = ""
    """What else was measured."""

    def __call__(self, found: Any) -> StudyGoal:
        rows, count = self.groups(found), Count(self.condition)
        wanted, reached = self.whole(self.share * len(rows)), count.number(rows)
        return StudyGoal(
            write(self.what, found),
            f"{wanted} of {len(rows)}",
            count(rows) + write(self.measured, found),
            reached >= wanted,
        )


@dataclass(frozen=True)
class Conclusion:
    """All that is concluded from the rows of an experiment.

    Its parts are functions of what `prepare` returns. A table, goal or note that is None or empty is left out.
    """

    headline: Callable[[Any], str]
    tables: Sequence[Callable[[Any], ResultTable | None]]
    goals: Sequence[Callable[[Any], StudyGoal | None]] = ()
    notes: Sequence[Text] = ()
    numbers: Callable[[Any], Mapping[str, Any]] = lambda found: {}
    prepare: Callable[[Rows], Any] = Rows
    """A function that groups or summarizes the rows; all parts receive what it returns."""

    def __call__(self, rows: Sequence[Row]) -> StudyFindings:
        found = self.prepare(Rows(rows))
        tables, goals = ([each(found) for each in parts] for parts in (self.tables, self.goals))
        notes = [write(note, found) for note in self.notes]
        return StudyFindings(
            headline=self.headline(found),
            tables=tuple(table for table in tables if table is not None),
            goals=tuple(goal for goal in goals if goal is not None),
            notes=tuple(note for note in notes if note),
            numbers=self.numbers(found),
        )
