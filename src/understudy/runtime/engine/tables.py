"""Tables: programs as arrays, and the run state of N agents as arrays - all that kernels see of either.

Kernels take these tuples apart by position, so an order changed here is changed in every kernel file too.
Everywhere, -1 means "none".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FLAG, COUNTER, TIMER, TIME, FALLEN, RISEN = range(6)
SORTS = 8
"""What an automaton reads of itself; as the source of a node: -1 - (sort + SORTS * (flag id, memory slot or column)).

FALLEN and RISEN are columns that read 0 or 1 in the tick in which the state was entered.
"""

SET, ADD, CLOCK = 0, 1, 2
"""What a change does to a memory slot: becomes the value (NaN: as if never set), grows by it, becomes the time."""

ASKED = -(2**31)
"""In place of a tree: a transition function that Python has to ask."""

NODE = np.dtype(
    [("low", "f8"), ("high", "f8"), ("source", "i4"), ("inside", "i4"), ("outside", "i4"), ("absent", "i4")],
    align=True,
)
"""One question: is low <= x < high? `source` is where x comes from: a column, or one of the automaton's own.

What follows is `inside`, `outside`, or `absent` where x is NaN: a node (>= 0), -1 to stay, or a state, as -2 - its
index. 32 bytes: a cache line holds two.
"""

STATE = np.dtype(
    [("asks", "i4"), ("child", "i4"), ("basic", "i4"), ("flag", "i4"), ("changes", "i4"), ("stop", "i4")],
    align=True,
)
"""A state of a ground instance. `asks` is what its transition begins with, spelled as what follows a node, or ASKED.

It runs the instance `child` or, where that is -1, the basic behavior `basic`, and raises the flag with the id `flag`.
Entering it does the changes from `changes` up to `stop`.
"""

INSTANCE = np.dtype([("start", "i4"), ("memory", "i4"), ("stop", "i4")], align=True)
"""A ground instance: its start state's index, and its memory slots from `memory` up to `stop`."""

CHANGE = np.dtype([("action", "i4"), ("slot", "i4"), ("value", "f8")], align=True)
"""A change of a counter or timer: SET, ADD or CLOCK, and the memory slot it is kept in."""


class Tables(NamedTuple):
    """Programs as arrays; a state's index counts the states of all instances."""

    nodes: NDArray[np.void]
    states: NDArray[np.void]
    instances: NDArray[np.void]
    changes: NDArray[np.void]


class Stacks(NamedTuple):
    """The run state of N agents; rows are independent.

    `root` [N] is the instance an agent runs, or -1 - the basic behavior. `state` and `entered` [N, D] are the state's
    index and the time it was entered, level by level; `memory` [N, M] has counters, and timers as the time they were
    set; NaN where never set. What lies below the levels that run means nothing.
    """

    root: NDArray[np.int32]
    state: NDArray[np.int32]
    entered: NDArray[np.float64]
    memory: NDArray[np.float64]

    def copy(self) -> Stacks:
        """The same, in arrays of its own."""
        return Stacks(self.root.copy(), self.state.copy(), self.entered.copy(), self.memory.copy())
