"""Declaration of an experiment: its units, its tables, its goals, and all that is concluded from its rows.

Each class is a function of what a `Conclusion` prepares: the rows of all tasks, unless it says otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import ceil
from typing import TYPE_CHECKING, Any, TypeAlias

from understudy_lab.rows import Count, Groups, Median, Rows, read_value
from understudy_lab.study import ResultTable, Row, StudyFindings, StudyGoal, StudyPlan, Task

if TYPE_CHECKING:
    from understudy_lab.lesson_stats import LiveComparison

Text: TypeAlias = str | Callable[..., str]
"""A text, or a function that writes it."""
Cell: TypeAlias = Callable[..., str]
"""A function that summarizes rows as the text of a cell, such as `Median` and `Count`."""


def write(text: Text, summary: Any) -> str:
    """Return a text."""
    return text if isinstance(text, str) else text(summary)


@dataclass(frozen=True)
class Units:
    """The tasks of a plan: one for each seed and combination of factors, by the names of the task's parameters."""

    factors: Mapping[str, Iterable[Any]]
    by_seed: bool = False
    """Whether all tasks of one seed come before those of the next, instead of all seeds of one combination."""

    def __call__(self, plan: StudyPlan) -> list[Task]:
        """List the tasks."""
        combinations = [
            dict(zip(self.factors, each, strict=True)) for each in product(*self.factors.values())
        ]
        if self.by_seed:
            return [{**each, "seed": seed} for seed in plan.seeds for each in combinations]
        return [{**each, "seed": seed} for each in combinations for seed in plan.seeds]


@dataclass(frozen=True)
class LinePerGroup:
    """A table with a line for each group of rows, and its summaries by the heads of their columns."""

    title: str
    """The title, in which {seeds} and {teachings} stand for the seeds of a group and their number."""
    heads: Sequence[str]
    """The heads of the columns that name a group."""
    groups: Groups
    cells: Mapping[str, Cell]
    name: Callable[[Any], Sequence[str]] = lambda group: (str(group),)
    """A function that returns the texts that name a group."""

    def __call__(self, summary: Any) -> ResultTable:
        """Make the table."""
        groups, cells = self.groups(summary), self.cells.values()
        lines = [(*self.name(group), *(cell(rows) for cell in cells)) for group, rows in groups.items()]
        return ResultTable(fill_title(self.title, groups), (*self.heads, *mark_numbers(self.cells)), lines)


@dataclass(frozen=True)
class ColumnPerGroup:
    """A table with a column for each group of rows, and a line for each summary."""

    title: str
    """The title, in which {seeds} and {teachings} stand for the seeds of a group and their number."""
    groups: Groups
    cells: Mapping[str, Cell]
    head: str = ""
    """The head of the column that names the summaries."""

    def __call__(self, summary: Any) -> ResultTable:
        """Make the table."""
        groups = self.groups(summary)
        lines = [(name, *map(cell, groups.values())) for name, cell in self.cells.items()]
        return ResultTable(fill_title(self.title, groups), (self.head, *mark_numbers(groups)), lines)


def fill_title(title: str, groups: Mapping[Any, Rows]) -> str:
    """Return a title with the seeds of the first group."""
    if "{" not in title:
        return title
    rows = next(iter(groups.values()))
    return title.format(seeds=rows.seed_range, teachings=len(rows.seeds))


def mark_numbers(heads: Iterable[Any]) -> list[str]:
    """Return the heads of columns that hold numbers."""
    return [f"#{head}" for head in heads]


@dataclass(frozen=True)
class Goal:
    """A goal: a number with a least or largest acceptable value."""

    what: str
    number: str | Median | Callable[..., float]
    """A function that returns the number, or the keys of a value: of rows, its median counts."""
    form: str = ".0%"
    """The format of the number that is wanted and of the one that was measured, or a text with the format in braces."""
    least: float | None = None
    most: float | None = None
    wanted: Text = ""
    """A text that replaces the number that is wanted."""
    measured: Callable[..., str] | None = None
    """A function that writes what was measured instead of the number."""

    def __call__(self, summary: Any) -> StudyGoal:
        """Measure the goal."""
        number = self._find_number(summary)
        held = number >= (self.least or 0.0) if self.most is None else number <= self.most
        bound = self._format(self.least) if self.most is None else f"at most {self._format(self.most)}"
        measure = self.number if isinstance(self.number, Median) else self.measured
        measured = self._format(number) if measure is None else measure(summary)
        return StudyGoal(self.what, write(self.wanted, summary) or bound, measured, bool(held))

    def _find_number(self, summary: Any) -> float:
        if isinstance(self.number, Median):
            return self.number.number(summary)
        if isinstance(self.number, str):
            return float(
                summary.median(self.number) if isinstance(summary, Rows) else read_value(summary, self.number)
            )
        return self.number(summary)

    def _format(self, number: float | None) -> str:
        return self.form.format(number) if "{" in self.form else format(number, self.form)


def goals_among(
    select: Callable[[Any], Any], goals: Iterable[Callable[[Any], StudyGoal]], prefix: str = ""
) -> list[Callable[[Any], StudyGoal]]:
    """Return goals of a part of what was prepared, each with a prefix to its subject."""

    def narrow(goal: Callable[[Any], StudyGoal]) -> Callable[[Any], StudyGoal]:
        def judge(summary: Any) -> StudyGoal:
            judged = goal(select(summary))
            return replace(judged, what=prefix + judged.what)

        return judge

    return [narrow(goal) for goal in goals]


@dataclass(frozen=True)
class CountGoal:
    """A goal: a share of the rows, made a whole number by `whole`, is to meet a condition."""

    what: str
    share: float
    condition: Callable[[Row], bool]
    whole: Callable[[float], int] = ceil
    groups: Callable[[Any], Rows] = Rows
    """A function that returns the rows that count."""
    measured: Text = ""
    """What else was measured."""

    def __call__(self, summary: Any) -> StudyGoal:
        """Measure the goal."""
        rows, count = self.groups(summary), Count(self.condition)
        wanted, reached = self.whole(self.share * len(rows)), count.number(rows)
        return StudyGoal(
            self.what,
            f"{wanted} of {len(rows)}",
            count(rows) + write(self.measured, summary),
            reached >= wanted,
        )


@dataclass(frozen=True)
class Conclusion:
    """All that is concluded from the rows of an experiment.

    Its parts are functions of what `prepare` returns. A table, goal or note that is None or empty is left out.
    """

    headline: Callable[[Any], str]
    tables: Sequence[Callable[[Any], ResultTable | None]]
    goals: Sequence[Callable[[Any], StudyGoal | None]] | Callable[[Any], Sequence[StudyGoal]] = ()
    notes: Sequence[Text] | Callable[[Any], Sequence[str]] = ()
    numbers: Callable[[Any], Mapping[str, Any]] = lambda summary: {}
    prepare: Callable[[Rows], Any] = Rows
    """A function that groups or summarizes the rows; all parts receive what it returns."""
    live: LiveComparison | None = None
    """The comparison of rows that were taught live, which the other parts leave out, with those that were not."""

    def __call__(self, rows: Sequence[Row]) -> StudyFindings:
        """Conclude from the rows of all tasks."""
        every = Rows(rows)
        summary = self.prepare(every.where(method=None) if self.live else every)
        tables = [table for each in self.tables if (table := each(summary)) is not None]
        judged = self.goals(summary) if callable(self.goals) else [judge(summary) for judge in self.goals]
        goals = [goal for goal in judged if goal is not None]
        if self.live and (pairs := self.live.pair(every))[0]:
            tables.append(self.live.make_table(pairs))
            goals += self.live.list_goals(pairs)
        notes = self.notes(summary) if callable(self.notes) else [write(note, summary) for note in self.notes]
        return StudyFindings(
            headline=self.headline(summary),
            tables=tuple(tables),
            goals=tuple(goals),
            notes=tuple(filter(None, notes)),
            numbers=self.numbers(summary),
        )
