"""Summary of a RoboCup team's lessons, read from a folder of JSON files and learned here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from understudy.errors import FileError
from understudy.learning.tree_growth import grow_tree
from understudy.model.kinds import Categorical, Continuous, Kind
from understudy_lab.statistics import spread


class RobocupFeature(msgspec.Struct):
    """A feature: continuous, or categorical with its labels."""

    name: str
    kind: str
    values: list[str] | None = None


class RobocupExample(msgspec.Struct):
    """An example: feature vector, next state, and whether it is an automatic default."""

    x: list[float]
    y: str
    default: bool


class RobocupState(msgspec.Struct):
    """A state with its examples and the number of nodes in the tree that the team's own learner made."""

    state: str
    attributes: list[RobocupFeature]
    examples: list[RobocupExample]
    original_tree_nodes: int


class RobocupLesson(msgspec.Struct):
    """The lesson of one automaton."""

    automaton: str
    states: list[RobocupState]


def summary(folder: Path) -> dict[str, Any]:
    """Return the number of lessons in a folder, and the spread of their features, states, examples and tree nodes.

    Nodes are counted in the team's own trees and in those learned here from the same examples.
    """
    lessons = list(_read(folder))
    states = [state for lesson in lessons for state in lesson.states if state.examples]
    examples = [sum(len(state.examples) for state in lesson.states) for lesson in lessons]
    learned = [_nodes(state, lesson) for lesson in lessons for state in lesson.states if state.examples]
    return {
        "lessons": len(lessons),
        "trees": len(states),
        "all_examples": sum(examples),
        "spread": {
            "features": spread([len(_features(lesson)) for lesson in lessons]),
            "states": spread([len(_names(lesson)) for lesson in lessons]),
            "examples": spread(examples),
            "nodes": spread(learned),
            "original nodes": spread([state.original_tree_nodes for state in states]),
        },
    }


def _read(folder: Path) -> Iterator[RobocupLesson]:
    paths = sorted(folder.glob("*.json"))
    if not paths:
        raise FileError(
            path=folder, place="", problem="there are no lessons in it", remedy="name their folder"
        )
    for path in paths:
        try:
            yield msgspec.json.decode(path.read_bytes(), type=RobocupLesson)
        except msgspec.DecodeError as error:
            raise FileError(
                path=path, place="", problem=str(error), remedy="give a lesson as the folder's README says"
            ) from None


def _features(lesson: RobocupLesson) -> set[str]:
    return {attribute.name for state in lesson.states for attribute in state.attributes}


def _names(lesson: RobocupLesson) -> Mapping[str, int]:
    """Return the index of each state that a lesson names."""
    named = [state.state for state in lesson.states]
    named += [example.y for state in lesson.states for example in state.examples]
    return {name: index for index, name in enumerate(dict.fromkeys(named))}


def _nodes(state: RobocupState, lesson: RobocupLesson) -> int:
    """Return the number of nodes in the tree learned here for a state."""
    names = _names(lesson)
    kinds: list[Kind] = [
        Continuous() if attribute.kind == "continuous" else Categorical(tuple(attribute.values or ()))
        for attribute in state.attributes
    ]
    tree = grow_tree(
        np.array([example.x for example in state.examples]).reshape(len(state.examples), len(kinds)),
        np.array([names[example.y] for example in state.examples]),
        np.array([0 if example.default else 1 for example in state.examples]),
        kinds,
        states=len(names),
        current=names[state.state],
    )
    return len(tree.nodes)
