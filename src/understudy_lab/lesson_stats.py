"""Statistics on the size of lessons (paper section 5.1), and what live teaching saves of it, paired by seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree
from understudy_lab.declaration import Goal
from understudy_lab.rows import Median, Rows, Value, read_value
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row, StudyGoal
from understudy_lab.teachers.live_teacher import LIVE
from understudy_lab.teachers.teacher import TeachingResult


def describe_lesson(taught: TrainedAutomaton, seconds: float) -> dict[str, Any]:
    """Return the size of a lesson: features, states, press-made examples, nodes of each tree, teaching time in s."""
    automaton, lesson = taught.automaton, taught.lesson
    examples = () if lesson is None else lesson.examples
    return {
        "name": automaton.name,
        "features": len(automaton.features),
        "states": len(automaton.states),
        "examples": sum(example.is_from_press for example in examples),
        "nodes": nodes(taught),
        "seconds": round(seconds, 1),
    }


def nodes(taught: TrainedAutomaton) -> list[int]:
    """Return the number of nodes of each state's tree, for the states that have one, in declared order."""
    trees = (taught.automaton.transitions.get(name) for name in taught.automaton.state_names)
    return [len(tree.nodes) for tree in trees if isinstance(tree, Tree)]


def lessons_of(teaching: TeachingResult) -> list[dict[str, Any]]:
    """Return the description of each lesson of one teaching, in the order of teaching."""
    accounts: Mapping[str, Any] = teaching.accounts
    return [
        describe_lesson(teaching.library.taught[name], account.seconds)
        for name, account in accounts.items()
        if name in teaching.library.taught
    ]


def examples_in(rows: Sequence[Row]) -> list[int]:
    """Return the number of press-made examples of each row, in all its lessons."""
    return [
        sum(lesson["examples"] for lessons in _by_learner(row).values() for lesson in lessons) for row in rows
    ]


@dataclass(frozen=True)
class LessonTable:
    """A table of the lessons of rows, with a last line for all of them.

    `lessons` of a row are a list, or lists by learner.
    """

    learner: str | None = None
    """The head of the column that names the learners; None without such a column."""

    def __call__(self, rows: Sequence[Row]) -> ResultTable:
        """Make the table."""
        heads = ["automaton", "#examples", "#seconds", "#states", "#features"]
        lines, total = [], format_median(examples_in(rows))
        for learner, lessons in _by_learner(rows[0]).items():
            for index, lesson in enumerate(lessons):
                of = [_by_learner(row)[learner][index] for row in rows]
                cells = (format_median([each[key] for each in of]) for key in ("examples", "seconds"))
                lines.append(
                    [learner, lesson["name"], *cells, str(lesson["states"]), str(lesson["features"])]
                )
        if self.learner is None:
            seconds = format_median([sum(lesson["seconds"] for lesson in row["lessons"]) for row in rows])
            lines = [*(line[1:] for line in lines), ["all", total, seconds, "", ""]]
        else:
            heads, lines = [self.learner, *heads], [*lines, ["all", "", total, "", "", ""]]
        return ResultTable("Teaching effort per automaton: median (smallest–largest)", heads, lines)


def _by_learner(row: Row) -> Mapping[str, Sequence[Mapping[str, Any]]]:
    return row["lessons"] if isinstance(row["lessons"], Mapping) else {"": row["lessons"]}


LIVE_TEACHINGS = 5
"""The number of teachings of a team that are also taught live."""
MOST_EXAMPLES = 0.6
"""The largest share of the examples of the paper's training, median over teachings."""
CLOSE = 0.02
"""The largest loss in a measure between 0 and 1, median over teachings."""

Pairs: TypeAlias = tuple[Rows, Rows]
"""The live teachings, and those by the paper's training with the same seeds."""


@dataclass(frozen=True)
class LiveComparison:
    """The cost and the results of live teaching, compared with those of the paper's training.

    Parameters
    ----------
    examples
        The number of examples of a teaching.
    results
        Its results, from 0 to 1, by their names.
    """

    examples: Value
    results: Mapping[str, Value]

    def pair(self, rows: Rows) -> Pairs:
        """Find the live teachings, and the other one of each."""
        by_task = {tuple(row["task"].items()): row for row in rows.where(method=None)}
        pairs = [
            (row, other)
            for row in rows.where(method=LIVE)
            if (other := by_task.get(tuple(_list_others(row)))) is not None
        ]
        return Rows(live for live, _ in pairs), Rows(other for _, other in pairs)

    def make_table(self, pairs: Pairs) -> ResultTable:
        """Return the table of examples and of results in percent, by both ways."""
        share = format_median(self._compare(pairs, self.examples, np.divide), 2)
        cells = {"examples": Median(self.examples)}
        cells |= {name: Median(of, 1, percent=True) for name, of in self.results.items()}
        lines = [(name, *map(cell, pairs)) for name, cell in cells.items()]
        return ResultTable(
            f"Taught live, and by the paper's training with the same seeds, {pairs[0].seed_range}: median (smallest–"
            "largest)",
            ("", "#taught live", "#the paper's training"),
            [lines[0], ("examples, relative to the paper's training", share, "1"), *lines[1:]],
        )

    def list_goals(self, pairs: Pairs) -> list[StudyGoal]:
        """Return the goals: at most 60 % of the examples, and results that are hardly worse."""
        fewer = Goal(
            "taught live: examples, relative to the paper's training",
            lambda pairs: float(np.median(self._compare(pairs, self.examples, np.divide))),
            most=MOST_EXAMPLES,
            form=".2f",
            wanted=f"at most {MOST_EXAMPLES}",
        )
        return [fewer(pairs), *(self._judge(name, of, pairs) for name, of in self.results.items())]

    def _judge(self, name: str, of: Value, pairs: Pairs) -> StudyGoal:
        apart = float(np.median(self._compare(pairs, of, np.subtract)))
        what, wanted = f"taught live: {name}, difference in points", f"at least -{100 * CLOSE:.0f}"
        return StudyGoal(what, wanted, f"{100 * apart:+.1f}", apart >= -CLOSE)

    def _compare(self, pairs: Pairs, of: Value, how: np.ufunc) -> list[float]:
        return [
            float(how(read_value(live, of), read_value(other, of)))
            for live, other in zip(*pairs, strict=True)
        ]


def _list_others(row: Row) -> Iterable[tuple[str, object]]:
    return ((key, value) for key, value in row["task"].items() if key != "method")
