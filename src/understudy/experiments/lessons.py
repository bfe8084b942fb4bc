"""Lessons in numbers: how small those are that robots learn from (paper section 5.1)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from understudy.model.library import Taught
from understudy.model.tree import Tree
from understudy.training.demonstrators.teacher import Teaching


def described(taught: Taught, seconds: float) -> dict[str, Any]:
    """One lesson as plain data: how many features, states and press-made examples it has, the nodes of the tree of
    each state that has one, and how long it took to teach, s.
    """
    automaton, lesson = taught.automaton, taught.lesson
    examples = () if lesson is None else lesson.examples
    return {
        "name": automaton.name,
        "features": len(automaton.features),
        "states": len(automaton.states),
        "examples": sum(example.pressed for example in examples),
        "nodes": nodes(taught),
        "seconds": round(seconds, 1),
    }


def nodes(taught: Taught) -> list[int]:
    """How many nodes each state's tree has, of the states that have one, in declared order."""
    trees = (taught.automaton.transitions.get(name) for name in taught.automaton.state_names)
    return [len(tree.nodes) for tree in trees if isinstance(tree, Tree)]


def lessons_of(teaching: Teaching) -> list[dict[str, Any]]:
    """The lessons of one teaching, in the order in which they were taught."""
    accounts: Mapping[str, Any] = teaching.accounts
    return [
        described(teaching.library.taught[name], account.seconds)
        for name, account in accounts.items()
        if name in teaching.library.taught
    ]
