"""What a robot was taught for while it sees nothing. Then all readings are absent, always the same, so that each state
has one answer, and what is pressed there once outvotes every example that was recorded by itself.
"""

from __future__ import annotations

from math import isnan, nan

from understudy.model.automaton import START
from understudy.model.example import ExampleKind
from understudy.model.library import Taught
from understudy.model.tree import STAY

TURNS = ("left", "right")
FINDS, SWINGS, WALKS_ON, RESTS = "keeps turning to one side", "swings left and right", "walks on", "rests"


def states_unseeing(taught: Taught) -> list[str]:
    """The states that it goes through from the start while it sees nothing; the last is that it stays in, or the one
    that it comes back to.
    """
    automaton = taught.automaton
    names, nothing = automaton.state_names, [nan] * len(automaton.features)
    passed = [START.name]
    while True:
        tree = automaton.transitions.get(passed[-1])
        outcome = STAY if tree is None else tree.decide(nothing)
        if outcome == STAY or names[outcome] == passed[-1]:
            return passed
        passed.append(names[outcome])
        if passed[-1] in passed[:-1]:
            return passed


def does_unseeing(states: list[str]) -> str:
    """What that comes to, in the end."""
    last = states[-1]
    again = set(states[states.index(last) :])
    if again >= set(TURNS):
        return SWINGS
    if again & set(TURNS):
        return FINDS
    return RESTS if last == START.name else WALKS_ON


def turned_back(taught: Taught) -> dict[str, int]:
    """How often a turn to either side was pressed into the other one while nothing was seen."""
    lesson = taught.lesson
    presses = [
        (example.state, example.next)
        for example in (() if lesson is None else lesson.examples)
        if example.kind is ExampleKind.DIRECTIVE and all(map(isnan, example.values))
    ]
    left, right = TURNS
    return {left: presses.count((left, right)), right: presses.count((right, left))}
