"""Pulses of compiled programs: what `interpreter.py` defines, for N agents on tables (see `tables.py`)."""

import numpy as np
from numpy.typing import NDArray

from understudy._jit_kernels import entry, njit, uint64

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Records = NDArray[np.void]
Tables = tuple[Records, Records, Records, Records]
"""nodes, states, instances, changes"""
Stacks = tuple[Ints, Ints, Floats, Floats]
"""root [N], state [N, D], entered [N, D], memory [N, M]"""

# Nothing here makes an array, so none need be counted: with reference counts (nrt) a pulse takes ten times as long.
# What is `within` becomes part of its callers; they must be `bare` too, since it then counts as they do. What is
# `joined` is compiled by itself first.
bare = entry(cache=True, nogil=True, _nrt=False)
within = njit(cache=True, nogil=True, _nrt=False, inline="always")
joined = njit(cache=True, nogil=True, _nrt=False, forceinline=True)

# As in tables.py, which a kernel file cannot import.
STAY = -1
FLAG, COUNTER, TIMER, TIME, FALLEN, RISEN = range(6)
SORT_BITS = 3
SET, ADD, CLOCK = 0, 1, 2
ASKED = -(2**31)


@within
def unsigned(index: int) -> int:
    """An index that cannot count from the end: to ask whether it does takes time."""
    return uint64(index)  # type: ignore[no-any-return]


@within
def elapsed(now: float, since: float) -> float:
    """Seconds from one time to another, rounded as the interpreter does; NaN where `since` is."""
    return float(np.floor((now - since) * 1e9 + 0.5) / 1e9)


@within
def own(
    source: int, agent: int, level: int, row: Floats, now: float, tables: Tables, stacks: Stacks
) -> float:
    """What the automaton at a level reads of itself."""
    _, states, _, _ = tables
    _, state, entered, memory = stacks
    sort, which = (-1 - source) & ((1 << SORT_BITS) - 1), (-1 - source) >> SORT_BITS
    if sort == FLAG:
        if states[state[agent, level]].child < 0:
            return 0.0
        return 1.0 if states[state[agent, level + 1]].flag == which else 0.0
    if sort >= FALLEN:
        return row[which] if entered[agent, level] != now else float(sort - FALLEN)
    if sort == COUNTER:
        count = memory[agent, which]
        return 0.0 if count != count else count
    return elapsed(now, memory[agent, which] if sort == TIMER else entered[agent, level])


@within
def walk(asks: int, agent: int, level: int, row: Floats, now: float, tables: Tables, stacks: Stacks) -> int:
    """What a transition answers: STAY, ASKED, or a state as -2 - its index."""
    nodes = tables[0]
    while asks >= 0:
        node = nodes[asks]
        source = node.source
        x = row[source] if source >= 0 else own(source, agent, level, row, now, tables, stacks)
        present = (
            node.inside if (node.low <= x) & (x < node.high) else node.outside
        )  # quicker without a branch
        asks = present if x == x else node.absent
    return asks


@within
def begin(agent: int, level: int, instance: int, now: float, tables: Tables, stacks: Stacks) -> None:
    """Start an instance: in its start state, its memory cleared."""
    _, state, entered, memory = stacks
    begun = tables[2][instance]
    state[agent, level] = begun.start
    entered[agent, level] = now
    for slot in range(begun.memory, begun.stop):
        memory[agent, slot] = np.nan


@within
def switch(agent: int, level: int, following: int, now: float, tables: Tables, stacks: Stacks) -> None:
    """Enter a state: start what it runs, and change what starting that changes."""
    _, states, _, changes = tables
    _, state, entered, memory = stacks
    state[agent, level] = following
    entered[agent, level] = now
    into = states[following]
    if into.child >= 0:
        begin(agent, level + 1, into.child, now, tables, stacks)
    for index in range(into.changes, into.stop):
        change = changes[index]
        before = memory[agent, change.slot]
        if change.action == SET:
            memory[agent, change.slot] = change.value
        elif change.action == ADD:
            memory[agent, change.slot] = (0.0 if before != before else before) + change.value
        else:
            memory[agent, change.slot] = now


@within
def descend(agent: int, level: int, row: Floats, now: float, tables: Tables, stacks: Stacks) -> int:
    """Query, switch and go down, from a level on. The basic behavior, or -1 - the level that Python must ask."""
    states, state = tables[1], stacks[1]
    while True:
        current = unsigned(state[agent, level])
        answer = walk(states[current].asks, agent, level, row, now, tables, stacks)
        if answer == ASKED:
            return -1 - int(level)
        if answer != STAY and -2 - answer != current:
            current = unsigned(-2 - answer)
            switch(agent, level, current, now, tables, stacks)
        if states[current].child < 0:
            return int(states[current].basic)
        level += unsigned(1)


@joined
def pulse(agent: int, row: Floats, now: float, tables: Tables, stacks: Stacks) -> int:
    """One tick of one agent on its feature vector [F]: the basic behavior to run.

    Where a transition function has to be asked: -1 - the level at which the agent waits for `resume`.
    """
    which = unsigned(agent)
    root = stacks[0][which]
    if root < 0:
        return int(-1 - root)
    return descend(which, unsigned(0), row, now, tables, stacks)


@bare
def resume(
    agent: int, level: int, following: int, row: Floats, now: float, tables: Tables, stacks: Stacks
) -> int:
    """Go on with a pulse that waits at a level, given the next state's index or STAY; answers as `pulse`."""
    states, state = tables[1], stacks[1]
    current = state[agent, level]
    if following != STAY and following != current:
        current = following
        switch(agent, level, current, now, tables, stacks)
    if states[current].child < 0:
        return int(states[current].basic)
    return descend(agent, level + 1, row, now, tables, stacks)


@bare
def pulse_all(
    columns: Floats, now: float, tables: Tables, stacks: Stacks, out_basic: Ints, first: int, stop: int
) -> None:
    """One tick of the agents from `first` up to `stop`, on the columns of features [F, N]."""
    root = stacks[0]
    for agent in range(first, stop):  # as `pulse` does, without the call
        if root[agent] < 0:
            out_basic[agent] = -1 - root[agent]
        else:
            out_basic[agent] = descend(agent, 0, columns[:, agent], now, tables, stacks)


@bare
def resume_all(
    agents: Ints,
    following: Ints,
    columns: Floats,
    now: float,
    tables: Tables,
    stacks: Stacks,
    out_basic: Ints,
) -> None:
    """Resume agents that wait, given the next state's index or STAY for each."""
    for index in range(len(agents)):
        agent = agents[index]
        level = -1 - out_basic[agent]
        out_basic[agent] = resume(agent, level, following[index], columns[:, agent], now, tables, stacks)


@bare
def vectors(
    agents: Ints, basic: Ints, sources: Ints, columns: Floats, now: float, tables: Tables, stacks: Stacks,
    out_values: Floats,
) -> None:  # fmt: skip
    """The feature vectors [n, K], from their sources [K], of n agents at the levels where they wait."""
    for index in range(len(agents)):
        agent = agents[index]
        level = -1 - basic[agent]
        for position in range(len(sources)):
            source = sources[position]
            out_values[index, position] = (
                columns[source, agent]
                if source >= 0
                else own(source, agent, level, columns[:, agent], now, tables, stacks)
            )


@bare
def start_all(chosen: Bools, now: float, tables: Tables, stacks: Stacks) -> None:
    """Start the roots of the agents chosen [N] afresh."""
    root = stacks[0]
    for agent in range(len(root)):
        if chosen[agent]:
            stacks[2][agent, 0] = now
            if root[agent] >= 0:
                begin(agent, 0, root[agent], now, tables, stacks)
