"""Find orders that no member of a squad has a behavior for, and statistics of flags that an order resets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.levels import Level, build_hierarchy, list_levels
from understudy.addons.checks.verification.subject import Subject
from understudy.errors import join_names
from understudy.model.automaton import State
from understudy.model.library import Library
from understudy.model.squad import Assignment, Order, Squad, Statistic


@dataclass(frozen=True)
class SquadMembers:
    """A squad, and the library of the members in each of its roles, by the role's name."""

    squad: Squad
    libraries: Mapping[str, Library]


def find_orders_without_behavior(subject: Subject) -> Iterator[Finding]:
    """Find states of a coordinator whose order names a behavior that the members meant do not have."""
    members = subject.members
    if members is None:
        return
    for state in subject.level.automaton.states:
        if state.behavior is None or state.behavior in subject.library.taught:
            continue
        order = _find_order(subject.library, state)
        if order is None:
            missing = {state.behavior: list(members.libraries)}
        else:
            missing = {
                duty.behavior: roles
                for duty in order.duties
                if not any(
                    _has(members.libraries[role], duty.behavior) for role in _list_roles(duty, members)
                )
                and (roles := _list_roles(duty, members))
            }
        for behavior, roles in missing.items():
            yield Finding(
                FindingKind.MISSING_BEHAVIOR,
                Severity.ERROR,
                subject.label,
                f"State {state.name} orders {behavior}, for which no member ({join_names(roles)}) has a behavior.",
                (state.name,),
                remedy=f"Teach {behavior} to the members, or let the state order something else.",
            )


def mark_statistics(root: Level, library: Library, members: SquadMembers) -> None:
    """Mark, for each state of a coordinator, the statistics of flags that its order keeps at their reset value.

    Statistics that can leave this value in the very tick in which the order restarts the members are marked, too.
    """
    statistics = {
        each.name: each
        for each in members.squad.statistics
        if each.flag is not None and each.reset_value is not None
    }
    for level in list_levels(root):
        quiet, instant = {}, {}
        for index, state in enumerate(level.automaton.states):
            if level.children[index] is not None:
                continue
            raising = {
                name: _list_raising(each, library, state, members) for name, each in statistics.items()
            }
            quiet[index] = frozenset(name for name, levels in raising.items() if not levels)
            instant[index] = frozenset(
                name for name, levels in raising.items() if any(_raises_at_once(levels, statistics[name]))
            )
        level.quiet, level.instant = quiet, instant


def _find_order(library: Library, state: State) -> Order | None:
    behavior = library.kit.behaviors.get(state.behavior or "")
    return None if behavior is None else behavior.order


def _list_roles(duty: Assignment, members: SquadMembers) -> list[str]:
    return [role for role in members.libraries if duty.role in (None, role)]


def _has(library: Library, behavior: str) -> bool:
    return behavior in library.taught or behavior in library.kit.behaviors


def _list_raising(statistic: Statistic, library: Library, state: State, members: SquadMembers) -> list[Level]:
    """List the automata that a state orders and that can raise the flag of a statistic."""
    order = _find_order(library, state)
    levels = []
    for duty in order.duties if order is not None else ():
        for role in _list_roles(duty, members):
            of_role = members.libraries[role]
            if duty.behavior in of_role.taught and statistic.role in (None, role):
                level = build_hierarchy(of_role, duty.behavior)
                if statistic.flag in level.possible_flags:
                    levels.append(level)
    return levels


def _raises_at_once(levels: list[Level], statistic: Statistic) -> Iterator[bool]:
    """Yield whether each automaton can raise the flag of a statistic from its start state."""
    for level in levels:
        states = level.automaton.states
        yield any(states[following].flag == statistic.flag for following in level.exits[0])
