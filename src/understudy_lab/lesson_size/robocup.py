"""Summary of a RoboCup team's lessons, read from a folder of JSON files and learned here.

How many examples are decided as shown if each is left out in turn:

    python -m understudy_lab.lesson_size.robocup FOLDER_OF_ROBOCUP_LESSONS
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from understudy.errors import FileError
from understudy.learning.tree_growth import grow_tree
from understudy.model.automaton import USUAL_FLAGS
from understudy.model.tree import STAY, Tree
from understudy.model.value_kinds import Categorical, Continuous, Kind
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
    return len(_grow(state, lesson, range(len(state.examples)), flags_first=False).nodes)


def _grow(state: RobocupState, lesson: RobocupLesson, chosen: Sequence[int], *, flags_first: bool) -> Tree:
    """Grow the tree of a state from some of its examples."""
    names, examples = _names(lesson), [state.examples[each] for each in chosen]
    kinds: list[Kind] = [
        Continuous() if attribute.kind == "continuous" else Categorical(tuple(attribute.values or ()))
        for attribute in state.attributes
    ]
    return grow_tree(
        np.array([example.x for example in examples]).reshape(len(examples), len(kinds)),
        np.array([names[example.y] for example in examples]),
        np.array([0 if example.default else 1 for example in examples]),
        kinds,
        states=len(names),
        current=names[state.state],
        flags=_list_flags(lesson) if flags_first else (),
        silence=flags_first,
    )


def _list_flags(lesson: RobocupLesson) -> list[int]:
    """List the flags by index, as in a table: *done* and *failed*, if they have no examples of their own."""
    taught = {state.state for state in lesson.states if state.examples}
    return [
        index
        for name, index in _names(lesson).items()
        if name.casefold() in USUAL_FLAGS and name not in taught
    ]


def count_right(folder: Path, *, flags_first: bool) -> tuple[int, int]:
    """Leave out each example of the lessons in a folder in turn, and predict it from the others of its state.

    Parameters
    ----------
    folder
        The folder of lessons.
    flags_first
        Whether flags are told apart first, as lessons are learned by default; otherwise by the highest gain.

    Returns
    -------
    tuple[int, int]
        The number of examples that are decided as shown, and that of all. A state is kept without other examples.
    """
    right = total = 0
    for lesson in _read(folder):
        names = _names(lesson)
        for state in lesson.states:
            everything = range(len(state.examples))
            for left, example in enumerate(state.examples):
                others = [each for each in everything if each != left]
                tree = _grow(state, lesson, others, flags_first=flags_first) if others else None
                decided = STAY if tree is None else tree.decide(example.x)
                decided = names[state.state] if decided == STAY else decided
                right, total = right + (decided == names[example.y]), total + 1
    return right, total


if __name__ == "__main__":
    for order in ("flags first", "gain first"):
        right, total = count_right(Path(sys.argv[1]), flags_first=order == "flags first")
        sys.stdout.write(f"{order}: {right} of {total} ({right / total:.1%})\n")
