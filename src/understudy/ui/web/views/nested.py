"""Nested automata as plain data: the states of those that an automaton runs, and when they go from one to another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from understudy.model.automaton import Automaton, Transition
from understudy.model.binding import called
from understudy.model.describe import shown
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import Vectors, conditions
from understudy.ui.controller import formatting
from understudy.ui.web.views.scene import Plain


class Nested:
    """The trained automata that an automaton runs, directly or through others, each put in words once."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[Automaton, Plain]] = {}

    def below(self, automaton: Automaton, library: Library) -> Plain:
        """By name, what a page draws of them."""
        found: Plain = {}
        left = [automaton]
        while left:
            for state in left.pop().states:
                name = state.behavior
                if name is not None and name in library.taught and name not in found:
                    inner = library.automaton(name)
                    found[name] = self._drawn(inner, library)
                    left.append(inner)
        return found

    def _drawn(self, automaton: Automaton, library: Library) -> Plain:
        known = self._known.get(automaton.name)
        if known is None or known[0] is not automaton:
            known = automaton, _drawn(automaton, library, library.taught[automaton.name].lesson)
            self._known[automaton.name] = known
        return known[1]


def _drawn(automaton: Automaton, library: Library, lesson: Lesson | None) -> Plain:
    return {
        "states": [
            {
                "name": state.name,
                "flag": state.flag is not None,
                "runs": None if state.behavior is None else called(state.behavior, state.binding),
                "automaton": state.behavior if state.behavior in library.taught else None,
            }
            for state in automaton.states
        ],
        "edges": [
            {"from": state, "to": following, "when": when}
            for state, function in automaton.transitions.items()
            for following, when in ways(automaton, function, (), shown(lesson, state))
            if following != state
        ],
    }


def ways(
    automaton: Automaton, function: Transition, directed: Sequence[str], vectors: Vectors
) -> Iterator[tuple[str, list[str]]]:
    """Where a transition function learned from such vectors leads, and when; of a classifier, where it was directed."""
    if not isinstance(function, Tree):
        for following in directed:
            yield following, ["decided by a classifier of scikit-learn"]
        return
    found: Mapping[int, Sequence[Any]] = conditions(function, automaton.features, vectors)
    for outcome, texts in found.items():
        if outcome != STAY:
            yield automaton.state_names[outcome], [formatting.signed(text) for text in texts]
