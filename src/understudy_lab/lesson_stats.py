"""Statistics on the size of lessons (paper section 5.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree
from understudy_lab.statistics import format_median
from understudy_lab.study import ResultTable, Row
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
