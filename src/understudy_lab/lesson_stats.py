"""Statistics on the size of lessons (paper section 5.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree
from understudy_lab.statistics import format_median
from understudy_lab.study import Row
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
    """Return the number of press-made examples of each row, whose `lessons` are grouped by learner."""
    return [sum(each["examples"] for lessons in row["lessons"].values() for each in lessons) for row in rows]


def lessons_in(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """Return the cells of a table of lessons over all rows, with a last row for their total.

    The cells are: agent, automaton, examples, seconds, states, features.
    """
    made = []
    for who, lessons in rows[0]["lessons"].items():
        for index, lesson in enumerate(lessons):
            of = [row["lessons"][who][index] for row in rows]
            cells = (format_median([each[key] for each in of]) for key in ("examples", "seconds"))
            made.append((who, lesson["name"], *cells, str(lesson["states"]), str(lesson["features"])))
    return [*made, ("all", "", format_median(examples_in(rows)), "", "", "")]
