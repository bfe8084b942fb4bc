"""How large a patrol would be in one piece: the states of its automata without hierarchy (section 5.1, Summary)."""

from __future__ import annotations

from understudy.model.library import Library
from understudy_lab.patrol.practice import ROBOTS


def states_of(library: Library, behavior: str) -> int:
    """How many states a behavior has in one piece; a basic one is a state."""
    if behavior not in library.taught:
        return 1
    states = library.automaton(behavior).states
    return sum(states_of(library, state.behavior) for state in states if state.behavior is not None)


def ordered(robots: Library, coordinators: Library, behavior: str) -> list[int]:
    """What each state of a coordinator's behavior in one piece has its robots do: how many states that is."""
    if behavior not in coordinators.taught:
        return [states_of(robots, behavior)]
    states = coordinators.automaton(behavior).states
    return [
        count
        for state in states
        if state.behavior is not None
        for count in ordered(robots, coordinators, state.behavior)
    ]


def flattened(robots: Library, coordinators: Library, behavior: str) -> tuple[int, int]:
    """The states of a coordinated behavior in one piece: of one robot, and of all together, who act side by side."""
    counts = ordered(robots, coordinators, behavior)
    return sum(counts), sum(count**ROBOTS for count in counts)
