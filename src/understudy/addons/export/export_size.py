"""Sizes of hierarchies in targets that write out every use of an automaton, measured before anything is written.

A statechart, and the nodes of a behavior tree, repeat an automaton in each state that runs it, and a tree in each state
that decides with it. So a large lesson can become larger than programs read, or than there is memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from understudy.addons.export.decisions import Branch, Continuation, Step, ValueCondition
from understudy.addons.export.hierarchy import Hierarchy
from understudy.errors import DefinitionError

MOST_BYTES = 32 * 2**20
"""The largest size of a statechart or a behavior tree, which programs read as a whole."""
MOST_RULES = 100_000
"""The largest number of answers of all trees, written out: transitions of a statechart, ends of a behavior tree."""
MOST_NESTED = 200
"""The most questions that are asked in one another; readers of XML take some hundred nested elements."""


@dataclass(frozen=True, slots=True)
class WrittenSize:
    """The size of something that is written out.

    `states` is the number of its states, `rules` that of the answers of its trees, `weight` that of all questions on
    the ways to them that hold, and `nested` the largest number of questions in one another, in one routine.
    """

    states: int = 0
    rules: int = 0
    weight: int = 0
    nested: int = 0


Weigh: TypeAlias = Callable[[int, int, ValueCondition], int | bool]
"""A function of an automaton, a state and a question: its weight, or its answer if that is always the same."""


def measure_hierarchy(hierarchy: Hierarchy, weigh: Weigh) -> WrittenSize:
    """Measure a hierarchy in which every use of an automaton is written out, and the tree of every state in it.

    Parameters
    ----------
    hierarchy
        The hierarchy.
    weigh
        The weight of each question. States that share a tree and see the same flags are taken to be alike.

    Returns
    -------
    WrittenSize
        The size of its root.
    """
    sizes: list[WrittenSize] = []
    for number, automaton in enumerate(hierarchy.automata):
        by_tree: dict[tuple[int, frozenset[int]], WrittenSize] = {}
        parts = [WrittenSize(states=len(automaton.states))]
        flags = {source.index for source in automaton.features if source.sort == "flag"}
        decisions = {state: each for each in automaton.decisions for state in each.states}
        for index, state in enumerate(automaton.states):
            if state.child.is_automaton:
                parts.append(sizes[state.child.index])
            if index not in decisions:
                parts.append(WrittenSize(rules=1))
                continue
            raised = frozenset(flag for flag in flags if hierarchy.find_raising(number, index, flag))
            key = decisions[index].states[0], raised
            if key not in by_tree:
                by_tree[key] = measure_rules(decisions[index].routines, partial(weigh, number, index))
            parts.append(by_tree[key])
        sizes.append(
            WrittenSize(
                sum(each.states for each in parts),
                sum(each.rules for each in parts),
                sum(each.weight for each in parts),
                max(each.nested for each in parts),
            )
        )
    return sizes[hierarchy.root.index] if hierarchy.root.is_automaton else WrittenSize()


def measure_rules(routines: Sequence[Step], weigh: Callable[[ValueCondition], int | bool]) -> WrittenSize:
    """Measure a tree as rules: its answers, each with the questions that hold on the way to it.

    Parameters
    ----------
    routines
        The tree.
    weigh
        The weight of each question, or its answer.

    Returns
    -------
    WrittenSize
        The size, without states.
    """
    sizes: dict[int, WrittenSize] = {}
    waiting = [0]
    while waiting:  # no recursion: noise grows trees deep
        routine = waiting[-1]
        later = [each for each in _list_continuations(routines[routine]) if each not in sizes]
        if later:
            waiting.extend(later)
        else:
            sizes[waiting.pop()], _ = _measure_step(routines[routine], sizes, weigh)
    return sizes[0]


def _list_continuations(step: Step) -> Iterator[int]:
    while isinstance(step, Branch):
        yield from _list_continuations(step.yes)
        step = step.no
    if isinstance(step, Continuation):
        yield step.routine


def _measure_step(
    step: Step, sizes: Mapping[int, WrittenSize], weigh: Callable[[ValueCondition], int | bool]
) -> tuple[WrittenSize, int]:
    """Measure a step with all that follows, and how many of its own routine's questions are in one another."""
    branches: list[Branch] = []
    while isinstance(step, Branch):
        branches.append(step)
        step = step.no
    size = sizes[step.routine] if isinstance(step, Continuation) else WrittenSize(rules=1)
    nested = 0
    for branch in reversed(branches):
        weight = weigh(branch.condition)
        if weight is False:
            continue
        yes, yes_nested = _measure_step(branch.yes, sizes, weigh)
        if weight is True:
            size, nested = yes, yes_nested
            continue
        nested = 1 + max(nested, yes_nested)
        size = WrittenSize(
            rules=size.rules + yes.rules,
            weight=size.weight + yes.weight + weight * yes.rules,
            nested=max(nested, size.nested, yes.nested),
        )
    return size, nested


def refuse_size(name: str, what: str, has: str, most: str) -> DefinitionError:
    """Make the error for an automaton that is too large for a target.

    Parameters
    ----------
    name
        Name of the automaton.
    what
        What it would become: "a statechart".
    has
        What there would be too much of, with the number.
    most
        How much is written.

    Returns
    -------
    DefinitionError
        The error, which names targets that write nothing twice.
    """
    return DefinitionError(
        what=f"automaton {name!r}",
        problem=f"as {what} it has {has}; at most {most} are written",
        remedy="export it to c99 or python, which write every automaton and every tree once",
    )


def check_bytes(name: str, what: str, document: bytes) -> bytes:
    """Return a document, or refuse it with DefinitionError if it is larger than MOST_BYTES.

    Parameters
    ----------
    name
        Name of the automaton.
    what
        What it is: "a statechart".
    document
        The document.

    Returns
    -------
    bytes
        The document.
    """
    if len(document) > MOST_BYTES:
        raise refuse_size(name, what, format_bytes(len(document)), format_bytes(MOST_BYTES))
    return document


def format_bytes(count: int) -> str:
    """Format a number of bytes as MiB."""
    return f"{count / 2**20:.1f} MiB".replace(".0 MiB", " MiB")
