"""Lessons in numbers: how small those are that robots learn from (paper section 5.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from understudy.model.library import TrainedAutomaton
from understudy.model.tree import Tree
from understudy_lab.statistics import format_median
from understudy_lab.study import Row
from understudy_lab.teachers.teacher import TeachingResult


def describe_lesson(taught: TrainedAutomaton, seconds: float) -> dict[str, Any]:
    """One lesson as plain data: how many features, states and press-made examples it has, the nodes of the tree of
    each state that has one, and how long it took to teach, s.
    """
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
    """How many nodes each state's tree has, of the states that have one, in declared order."""
    trees = (taught.automaton.transitions.get(name) for name in taught.automaton.state_names)
    return [len(tree.nodes) for tree in trees if isinstance(tree, Tree)]


def lessons_of(teaching: TeachingResult) -> list[dict[str, Any]]:
    """The lessons of one teaching, in the order in which they were taught."""
    accounts: Mapping[str, Any] = teaching.accounts
    return [
        describe_lesson(teaching.library.taught[name], account.seconds)
        for name, account in accounts.items()
        if name in teaching.library.taught
    ]


def examples_in(rows: Sequence[Row]) -> list[int]:
    """How many press-made examples each row's lessons hold, of rows whose `lessons` are by who learned them."""
    return [sum(each["examples"] for lessons in row["lessons"].values() for each in lessons) for row in rows]


def lessons_in(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """What each lesson took over all rows, as cells: who, automaton, examples, seconds, states, features; then all."""
    made = []
    for who, lessons in rows[0]["lessons"].items():
        for index, lesson in enumerate(lessons):
            of = [row["lessons"][who][index] for row in rows]
            cells = (format_median([each[key] for each in of]) for key in ("examples", "seconds"))
            made.append((who, lesson["name"], *cells, str(lesson["states"]), str(lesson["features"])))
    return [*made, ("all", "", format_median(examples_in(rows)), "", "", "")]
