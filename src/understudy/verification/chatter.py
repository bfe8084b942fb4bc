"""Name the cycles of an automaton as findings: chatter, longer cycles, and repeated orders of coordinators."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.errors import join_names
from understudy.verification.cycles import TICK_S, Cycle, CycleFinder, CycleSearch
from understudy.verification.finding import Finding, FindingKind, Severity
from understudy.verification.subject import Subject, join_conditions, name_examples

HELD = "readings of this cell occur: whether the world gives them is not decided here"
RESETS = "no member raises its flag in the very tick in which it is restarted"


def find_cycles(subject: Subject, tick_s: float | None, unfinished: list[str]) -> Iterator[Finding]:
    """Find chatter and cycles; add to `unfinished` the automaton's name if the search had to be given up."""
    search = CycleFinder(subject.level, tick_s or TICK_S).search()
    if not search.is_finished:
        unfinished.append(subject.label)
    for cycle in _without_repeats(search):
        yield _make_finding(subject, cycle, tick_s)


def _without_repeats(search: CycleSearch) -> Iterator[Cycle]:
    """Yield the cycles, shortest first."""
    yield from sorted(search.cycles, key=lambda cycle: (len(cycle.states), cycle.states))


def _make_finding(subject: Subject, cycle: Cycle, tick_s: float | None) -> Finding:
    automaton = subject.level.automaton
    names = [automaton.states[state].name for state in cycle.states]
    cells = subject.make_cells(cycle.boxes)
    there = join_conditions(cells)
    where = "whatever it reads" if there == "always" else f"where {there}"
    shown = tuple(number for box in cycle.boxes for number in subject.find_examples_inside(box))
    shown = tuple(sorted(set(shown)))
    orders = _orders(subject, cycle)
    assumptions = [] if there == "always" or shown else [HELD]
    if cycle.resets:
        assumptions.append(RESETS)
    if cycle.clocked and tick_s is None:
        assumptions.append(f"a tick lasts {TICK_S} s")
    route = " → ".join((*names, names[0]))
    pace = "at every tick" if cycle.ticks == len(names) else f"every {cycle.ticks} ticks"
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
        shown,
        _remedy(names, shown),
    )


def _orders(subject: Subject, cycle: Cycle) -> list[str]:
    """Return the orders that the states of a cycle give; empty for robots."""
    found = []
    for index in cycle.states:
        state = subject.level.automaton.states[index]
        behavior = subject.library.kit.behaviors.get(state.behavior or "")
        if behavior is None or behavior.order is None:
            return []
        found.append(subject.library.format_call(behavior.name, state.binding))
    return found


def _remedy(names: list[str], shown: tuple[int, ...]) -> str:
    seen = f" ({name_examples(shown)} {'has' if len(shown) == 1 else 'have'} such readings)" if shown else ""
    return (
        f"Put the robot into {names[0]} there{seen}, and show whether it stays or goes to {names[1]}; "
        f"then the same in {names[1]}."
    )
