"""Name the cycles of an automaton as findings: chatter, longer cycles, and repeated orders of coordinators."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from understudy.addons.checks.verification.cycles import TICK_S, Cycle, CycleFinder, CycleSearch
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.subject import Subject, join_conditions, name_evidence
from understudy.errors import join_names

HELD = "readings of this cell occur: whether the world gives them is not decided here"
FLAGS = "members raise the flags that are waited for"
RESETS = "no member raises its flag in the very tick in which it is restarted"


def find_cycles(subject: Subject, tick_s: float | None, unfinished: list[str]) -> Iterator[Finding]:
    """Find chatter and cycles; add to `unfinished` the automaton's name if the search had to be given up."""
    search = CycleFinder(subject.level, tick_s or TICK_S).search()
    if not search.is_finished:
        unfinished.append(subject.label)
    for cycle in _sort_cycles(search):
        yield _make_finding(subject, cycle, tick_s)
    if any(_list_orders(subject, range(len(subject.level.leaves)))):
        finished = {cycle.states for cycle in search.cycles}
        for cycle in _sort_cycles(CycleFinder(subject.level, tick_s or TICK_S, flags_vary=True).search()):
            orders = _list_orders(subject, cycle.states)
            is_endless = len(set(orders)) == 1 or subject.level.space.full in cycle.boxes
            if cycle.states not in finished and is_endless and None not in orders:
                yield _make_repetition(subject, cycle, list(dict.fromkeys(map(str, orders))))


def _sort_cycles(search: CycleSearch) -> list[Cycle]:
    """Sort cycles, the shortest first."""
    return sorted(search.cycles, key=lambda cycle: (len(cycle.states), cycle.states))


def _make_repetition(subject: Subject, cycle: Cycle, orders: list[str]) -> Finding:
    """Make the finding of states that follow each other whenever members raise flags, for all other readings.

    Either all give the same order, or nothing but flags leads from one to the next.
    """
    names = [subject.level.automaton.states[state].name for state in cycle.states]
    cells = subject.make_cells(cycle.boxes)
    there = join_conditions(cells)
    where = "" if there == "always" else f" where {there}"
    return Finding(
        FindingKind.REPEATED_ORDER,
        Severity.WARNING,
        subject.label,
        f"{subject.label} orders {join_names(orders)} again and again{where}: {' → '.join((*names, names[0]))}.",
        tuple(names),
        (FLAGS, *([] if there == "always" else [HELD])),
        cells,
        remedy=f"Show what to order in {names[0]} once the members are done, or remove one of the states.",
    )


def _make_finding(subject: Subject, cycle: Cycle, tick_s: float | None) -> Finding:
    automaton = subject.level.automaton
    names = [automaton.states[state].name for state in cycle.states]
    cells = subject.make_cells(cycle.boxes)
    there = join_conditions(cells)
    where = "whatever it reads" if there == "always" else f"where {there}"
    examples = subject.find_examples_inside(*cycle.boxes)
    orders = [order for order in _list_orders(subject, cycle.states) if order is not None]
    assumptions = [] if there == "always" or examples else [HELD]
    if cycle.resets:
        assumptions.append(RESETS)
    if cycle.clocked and tick_s is None:
        assumptions.append(f"a tick lasts {TICK_S} s")
    route = " → ".join((*names, names[0]))
    pace = _describe_pace(cycle)
    if orders:
        kind = FindingKind.REPEATED_ORDER
        same = len(set(orders)) == 1
        what = (
            f"gives the order {orders[0]} again" if same else f"gives the orders {join_names(orders)} in turn"
        )
        sentence = (
            f"{subject.label} {what} without end, {pace}, {where}: {route}; its members begin anew each time."
        )
    elif len(names) == 2 and not cycle.nested:
        kind = FindingKind.CHATTER
        sentence = f"{names[0]} and {names[1]} undo each other {where}: {route}, {pace}."
    else:
        kind = FindingKind.CYCLE
        below = " (and what they run begins anew)" if cycle.nested else ""
        sentence = f"{join_names(names)} follow each other without end {where}: {route}, {pace}{below}."
    return Finding(
        kind,
        Severity.WARNING,
        subject.label,
        sentence,
        tuple(names),
        tuple(dict.fromkeys(assumptions)),
        cells,
        examples,
        _remedy(names, examples),
    )


def _describe_pace(cycle: Cycle) -> str:
    """Describe how often a cycle comes back to its first state, or that it switches at every tick."""
    least, most = min(cycle.ticks), max(cycle.ticks)
    if most == len(cycle.states):
        return "at every tick"
    return f"every {most} ticks" if least == most else f"every {least} to {most} ticks"


def _list_orders(subject: Subject, states: Iterable[int]) -> list[str | None]:
    """Return the order that each state gives; None for states that give none."""
    orders: list[str | None] = []
    for index in states:
        state = subject.level.automaton.states[index]
        behavior = subject.library.kit.behaviors.get(state.behavior or "")
        is_order = behavior is not None and behavior.order is not None
        orders.append(subject.library.format_call(state.behavior or "", state.binding) if is_order else None)
    return orders


def _remedy(names: list[str], examples: tuple[int, ...]) -> str:
    return (
        f"Put the robot into {names[0]} there{name_evidence(examples)}, and show whether it stays or goes to "
        f"{names[1]}; then the same in {names[1]}."
    )
