"""Pulses of compiled programs, as `interpreter.py` defines them, for N agents on tables (see `tables.py`)."""

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import njit_entry, njit_inner, uint64

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Records = NDArray[np.void]
TableArrays = tuple[Records, Records, Records, Records]
"""nodes, states, instances, changes"""
StackArrays = tuple[Ints, Ints, Floats, Floats]
"""root [N], state [N, D], entered [N, D], memory [N, M]"""

# Nothing here makes an array, so none need be counted: with reference counts (nrt) a pulse takes ten times as long.
# What is `njit_inlined` becomes part of its callers; they must be `njit_without_counting` too, since it then counts
# as they do. What is `njit_force_inlined` has its types inferred by itself first.
njit_without_counting = njit_entry(nogil=True, _nrt=False)
njit_inlined = njit_inner(nogil=True, _nrt=False, inline="always")
njit_force_inlined = njit_inner(nogil=True, _nrt=False, forceinline=True)

# As in tables.py, which a kernel file cannot import.
STAY = -1
FLAG, COUNTER, TIMER, TIME, FALLEN, RISEN = range(6)
OWN_SOURCE_BITS = 3
SET, ADD, CLOCK = 0, 1, 2
ASKED = -(2**31)
LARGEST = 1.7976931348623157e308


@njit_inlined
def make_unsigned(index: int) -> int:
    """Convert an index so that it cannot count from the end, a check that would take time."""
    return uint64(index)


@njit_inlined
def compute_elapsed(now: float, since: float) -> float:
    """Return the seconds from one time to another, rounded as by the interpreter; NaN where `since` is."""
    steps = 1e9 if now < 4194304.0 else 1e6
    return float(np.floor((now - since) * steps + 0.5) / steps)


@njit_inlined
def read_own_feature(
    source: int, agent: int, level: int, row: Floats, now: float, tables: TableArrays, stacks: StackArrays
) -> float:
    """Read a feature of the automaton at a level itself."""
    _, states, _, _ = tables
    _, state, entered, memory = stacks
    own_source, which = (-1 - source) & ((1 << OWN_SOURCE_BITS) - 1), (-1 - source) >> OWN_SOURCE_BITS
    if own_source == FLAG:
        if states[state[agent, level]].child < 0:
            return 0.0
        return 1.0 if states[state[agent, level + 1]].flag == which else 0.0
    if own_source >= FALLEN:
        return row[which] if entered[agent, level] != now else float(own_source - FALLEN)
    if own_source == COUNTER:
        count = memory[agent, which]
        return 0.0 if count != count else count
    return compute_elapsed(now, memory[agent, which] if own_source == TIMER else entered[agent, level])


@njit_inlined
def query_tree(
    asks: int, agent: int, level: int, row: Floats, now: float, tables: TableArrays, stacks: StackArrays
) -> int:
    """Query a transition. The answer is STAY, ASKED, or a state as -2 minus its index."""
    nodes = tables[0]
    while asks >= 0:
        node = nodes[asks]
        source = node.source
        x = row[source] if source >= 0 else read_own_feature(source, agent, level, row, now, tables, stacks)
        present = (
            node.inside if (node.low <= x) & (x < node.high) else node.outside
        )  # quicker without a branch
        asks = present if abs(x) <= LARGEST else node.absent  # which is false for NaN and what is infinite
    return asks


@njit_inlined
def start_instance(
    agent: int, level: int, instance: int, now: float, tables: TableArrays, stacks: StackArrays
) -> None:
    """Start an instance in its start state, with its memory cleared."""
    _, state, entered, memory = stacks
    begun = tables[2][instance]
    state[agent, level] = begun.start
    entered[agent, level] = now
    for slot in range(begun.memory, begun.stop):
        memory[agent, slot] = np.nan


@njit_inlined
def switch_state(
    agent: int, level: int, following: int, now: float, tables: TableArrays, stacks: StackArrays
) -> None:
    """Enter a state: start its behavior, and apply the changes of that start."""
    _, states, _, changes = tables
    _, state, entered, memory = stacks
    state[agent, level] = following
    entered[agent, level] = now
    into = states[following]
    if into.child >= 0:
        start_instance(agent, level + 1, into.child, now, tables, stacks)
    for index in range(into.changes, into.stop):
        change = changes[index]
        before = memory[agent, change.slot]
        if change.action == SET:
            memory[agent, change.slot] = change.value
        elif change.action == ADD:
            memory[agent, change.slot] = (0.0 if before != before else before) + change.value
        else:
            memory[agent, change.slot] = now


@njit_inlined
def descend_levels(
    agent: int, level: int, row: Floats, now: float, tables: TableArrays, stacks: StackArrays
) -> int:
    """Query, switch and descend from a level on; return the basic behavior, or -1 minus a level that waits."""
    states, state = tables[1], stacks[1]
    while True:
        current = make_unsigned(state[agent, level])
        answer = query_tree(states[current].asks, agent, level, row, now, tables, stacks)
        if answer == ASKED:
            return -1 - int(level)
        if answer != STAY and -2 - answer != current:
            current = make_unsigned(-2 - answer)
            switch_state(agent, level, current, now, tables, stacks)
        if states[current].child < 0:
            return int(states[current].basic)
        level += make_unsigned(1)


@njit_force_inlined
def pulse_agent(agent: int, row: Floats, now: float, tables: TableArrays, stacks: StackArrays) -> int:
    """Run one tick of one agent on its feature vector [F], and return the basic behavior to run.

    If a transition function has to be called in Python, return -1 minus the level at which the agent waits for
    `resume_pulse`.
    """
    which = make_unsigned(agent)
    root = stacks[0][which]
    if root < 0:
        return int(-1 - root)
    return descend_levels(which, make_unsigned(0), row, now, tables, stacks)


@njit_inner(nogil=True, _nrt=False)
def resume_pulse(
    agent: int, level: int, following: int, row: Floats, now: float, tables: TableArrays, stacks: StackArrays
) -> int:
    """Continue a pulse that waits at a level, given the next state's index or STAY; return as `pulse_agent`."""
    states, state = tables[1], stacks[1]
    current = state[agent, level]
    if following != STAY and following != current:
        current = following
        switch_state(agent, level, current, now, tables, stacks)
    if states[current].child < 0:
        return int(states[current].basic)
    return descend_levels(agent, level + 1, row, now, tables, stacks)


@njit_without_counting
def pulse_agents(
    columns: Floats,
    now: float,
    tables: TableArrays,
    stacks: StackArrays,
    out_basic: Ints,
    first: int,
    stop: int,
) -> None:
    """Run one tick of the agents from `first` up to `stop`, on the columns of features [F, N]."""
    root = stacks[0]
    for agent in range(first, stop):  # as `pulse_agent` does, without the call
        if root[agent] < 0:
            out_basic[agent] = -1 - root[agent]
        else:
            out_basic[agent] = descend_levels(agent, 0, columns[:, agent], now, tables, stacks)


@njit_without_counting
def resume_agents(
    agents: Ints,
    following: Ints,
    columns: Floats,
    now: float,
    tables: TableArrays,
    stacks: StackArrays,
    out_basic: Ints,
) -> None:
    """Resume agents that wait, given the next state's index or STAY for each."""
    for index in range(len(agents)):
        agent = agents[index]
        level = -1 - out_basic[agent]
        out_basic[agent] = resume_pulse(
            agent, level, following[index], columns[:, agent], now, tables, stacks
        )


@njit_without_counting
def gather_feature_vectors(
    agents: Ints, basic: Ints, sources: Ints, columns: Floats, now: float, tables: TableArrays, stacks: StackArrays,
    out_values: Floats,
) -> None:  # fmt: skip
    """Collect the feature vectors [n, K], from their sources [K], of n agents at the levels where they wait."""
    for index in range(len(agents)):
        agent = agents[index]
        level = -1 - basic[agent]
        for position in range(len(sources)):
            source = sources[position]
            out_values[index, position] = (
                columns[source, agent]
                if source >= 0
                else read_own_feature(source, agent, level, columns[:, agent], now, tables, stacks)
            )


@njit_without_counting
def start_agents(chosen: Bools, now: float, tables: TableArrays, stacks: StackArrays) -> None:
    """Start the roots of the chosen agents [N] again."""
    root = stacks[0]
    for agent in range(len(root)):
        if chosen[agent]:
            stacks[2][agent, 0] = now
            if root[agent] >= 0:
                start_instance(agent, 0, root[agent], now, tables, stacks)
