"""The rows of an experiment: selected by their tasks, and summarized as numbers and as the texts of a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import Any, TypeAlias

import numpy as np

from understudy_lab.statistics import format_median, format_share
from understudy_lab.study import Row

Value: TypeAlias = str | Callable[..., Any]
"""A value of a row: its keys with dots between them, such as `hand.success`, or a function of the row."""
Groups: TypeAlias = Callable[[Any], Mapping[Any, Any]]
"""A function that returns groups of rows, or what is summarized for each group, by their names."""


def read_value(row: Row, of: Value) -> Any:
    """Return a value of a row."""
    return of(row) if callable(of) else reduce(getitem, of.split("."), row)


class Rows(tuple[Row, ...]):
    """Rows of an experiment, in the order of its tasks."""

    def where(self, **task: Any) -> Rows:
        """Return the rows of tasks with these parameters; None: of tasks without the parameter."""
        wanted = task.items()
        return Rows(row for row in self if all(row["task"].get(key) == value for key, value in wanted))

    def filter(self, condition: Callable[..., bool]) -> Rows:
        """Return the rows that meet a condition."""
        return Rows(filter(condition, self))

    def values(self, of: Value) -> list[Any]:
        """Return a value of each row that has it."""
        return [value for row in self if (value := read_value(row, of)) is not None]

    def median(self, of: Value) -> float:
        """Return the median of a value."""
        return float(np.median(self.values(of)))

    @property
    def seeds(self) -> list[int]:
        """The seeds of the tasks, in ascending order."""
        return sorted({row["task"]["seed"] for row in self})

    @property
    def seed_range(self) -> str:
        """The first and the last seed as a text."""
        return f"{self.seeds[0]} to {self.seeds[-1]}"


def group_by(key: str, names: Iterable[Any] | None = None) -> Groups:
    """Return a function that groups rows by a parameter of their tasks.

    `names` are the values that have a group, which may be empty; None: those that occur, in order of their first rows.
    """
    fixed = None if names is None else list(names)

    def group(rows: Sequence[Row]) -> dict[Any, Rows]:
        values = fixed or dict.fromkeys(row["task"][key] for row in rows)
        return {value: Rows(rows).where(**{key: value}) for value in values}

    return group


def group_by_arm(arms: Iterable[str], *keys: str) -> Groups:
    """Return a function that makes a group for each arm of an experiment whose rows have results of all arms.

    `keys` are the values of a row that have results by arm: a group has those of its arm instead. Without keys, all
    results of an arm are under its name, and a group has them beside the others.
    """
    names = list(arms)

    def select(row: Row, arm: str) -> Row:
        return {**row, **({key: row[key].get(arm) for key in keys} if keys else row[arm])}

    return lambda rows: {arm: Rows(select(row, arm) for row in rows) for arm in names}


@dataclass(frozen=True)
class Median:
    """The median of a value with its smallest and largest: as a text, or the number alone."""

    of: Value
    digits: int = 0
    percent: bool = False

    def __call__(self, rows: Rows) -> str:
        """Format the median."""
        return format_median(rows.values(self.of), self.digits, percent=self.percent)

    def number(self, rows: Rows) -> float:
        """Return the median."""
        return rows.median(self.of)


@dataclass(frozen=True)
class Count:
    """The number of rows that meet a condition: as a text such as "19 of 20", or the number alone."""

    condition: Callable[[Row], bool]
    interval: bool = False
    """Whether the text has the 95 % interval of the share."""

    def __call__(self, rows: Rows) -> str:
        """Format the count."""
        count = self.number(rows)
        return format_share(count, len(rows)) if self.interval else f"{count} of {len(rows)}"

    def number(self, rows: Rows) -> int:
        """Return the number of rows."""
        return sum(map(self.condition, rows))

    def share(self, rows: Rows) -> float:
        """Return the share of rows."""
        return self.number(rows) / len(rows)
