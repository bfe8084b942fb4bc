"""The semantics once more, straight from ARCHITECTURE section 3: recursive, over plain dictionaries.

An automaton is a dictionary: parameters, features, states, transitions. Nothing is linked beforehand:
parameters are looked up level by level, time is counted in ticks, memory is a dictionary per running
automaton.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, nan
from typing import Any

Memory = dict[str, Any]

Automata = dict[str, Any]
TICK_S = 0.1

CHANGES: dict[str, Callable[[Any, int], None]] = {
    "lap": lambda memory, tick: memory["counters"].update(laps=memory["counters"].get("laps", 0) + 1),
    "three_laps": lambda memory, tick: memory["counters"].update(laps=3),
    "no_laps": lambda memory, tick: memory["counters"].update(laps=0),
    "click": lambda memory, tick: memory["timers"].update(watch=tick),
    "unclick": lambda memory, tick: memory["timers"].pop("watch", None),
}


def change_nothing(memory: Memory, tick: int) -> None:
    """What starting most basic behaviors changes."""


def begin(automata: Automata, name: str, tick: int) -> dict[str, Any] | None:
    """Starting an automaton puts it in its start state and clears its flags, counters and timers."""
    if name not in automata:
        return None
    return {"state": "start", "since": tick, "flags": set(), "counters": {}, "timers": {}, "child": None}


def pulse(
    automata: Automata,
    name: str,
    memory: dict[str, Any] | None,
    bound: dict[str, str],
    percept: Any,
    tick: int,
) -> tuple[str, dict[str, str]]:
    """One pulse of behavior `name`; the basic behavior that issues its command, and its binding."""
    if memory is None:
        return name, bound
    me = automata[name]
    before = memory["state"]
    after = ask(me, memory, bound, percept, tick)
    if after != before:
        state = me["states"][after]
        memory.update(state=after, since=tick, child=None)
        if "flag" in state:
            memory["flags"].add(state["flag"])
        if "behavior" in state:
            memory["child"] = begin(automata, state["behavior"], tick)
            CHANGES.get(state["behavior"], change_nothing)(memory, tick)
    state = me["states"][memory["state"]]
    if "behavior" not in state:
        return "idle", {}
    below = {parameter: bound.get(value, value) for parameter, value in state["binding"].items()}
    return pulse(automata, state["behavior"], memory["child"], below, percept, tick)


def ask(me: dict[str, Any], memory: dict[str, Any], bound: dict[str, str], percept: Any, tick: int) -> str:
    """Step 1: the next state. Flag states are terminal; a state without a function keeps itself."""
    tree = me["transitions"].get(memory["state"])
    if tree is None or memory["flags"]:
        return str(memory["state"])
    values = [value(feature, memory, bound, percept, tick) for feature in me["features"]]
    answer = walk(tree, values)
    return str(memory["state"] if answer is None else answer)


def value(feature: Any, memory: dict[str, Any], bound: dict[str, str], percept: Any, tick: int) -> float:
    kind, *rest = feature
    if kind == "flag":  # of the automaton in the current state; a basic behavior raises none
        return float(memory["child"] is not None and rest[0] in memory["child"]["flags"])
    if kind == "counter":
        return float(memory["counters"].get(rest[0], 0))
    if kind == "timer":
        return seconds(tick, memory["timers"][rest[0]]) if rest[0] in memory["timers"] else nan
    if kind == "time":
        return seconds(tick, memory["since"])
    reading, of = rest
    return float(percept[reading, bound.get(of, of)])


def seconds(tick: int, since: int) -> float:
    return round((tick - since) * TICK_S, 6)


def walk(tree: Any, values: list[float]) -> str | None:
    """The answer of a tree: a state's name, or None to stay. Absent goes its own way in every test."""
    if tree is None or tree[0] == "leaf":
        return None if tree is None else tree[1]
    test, feature, *rest = tree
    x = values[feature]
    if test == "absent":
        return walk(rest[0] if isnan(x) else rest[1], values)
    if test == "label":
        branches, away = rest
        return walk(away if isnan(x) else branches[int(x)], values)
    low, high, inside, outside, away = rest
    if isnan(x):
        return walk(away, values)
    if test == "below":
        return walk(inside if x < high else outside, values)
    between = low <= x < high if low <= high else not high <= x < low
    return walk(inside if between else outside, values)
