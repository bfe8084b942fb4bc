"""Hierarchies as nested states with transitions, for the targets that are statecharts.

Every use of an automaton becomes a compound state of its own, so that the innermost active state says the whole path.
A tree becomes a list of transitions of which the first whose condition holds is taken, and the last has none.

A statechart asks the innermost states first, but Understudy decides from the root down, all levels in one tick. So a
tick raises one internal event after the other: `decide.0` is for the states of the root alone, `decide.1` for those
below, and so on. A transition of one level raises the event of the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from understudy.addons.export.decisions import Answer, Continuation, Step, ValueCondition
from understudy.addons.export.export_size import (
    MOST_BYTES,
    MOST_RULES,
    format_bytes,
    measure_hierarchy,
    refuse_size,
)
from understudy.addons.export.exported_trace import NO_TREE, format_trace_header
from understudy.addons.export.hierarchy import GroundAutomaton, Hierarchy
from understudy.addons.export.identifiers import make_identifiers
from understudy.addons.export.javascript_text import JavaScriptText
from understudy.addons.export.target_files import ExportJob
from understudy.model.behaviors import StateEffect

MOST_STATES = 10_000
"""The largest number of states of a statechart."""
CHART = "a statechart"
WRITTEN_OUT = "since every use of an automaton is written out, and the tree of every state in it"


@dataclass(frozen=True, slots=True)
class FlagQuestion:
    """The question whether one of some states, by their id, is active, or whether none is."""

    states: tuple[str, ...]
    is_raised: bool


Part: TypeAlias = FlagQuestion | str
"""A part of a condition: a question about states, or JavaScript."""


@dataclass(frozen=True, slots=True)
class ChartTransition:
    """What happens at an event if all parts of a condition hold.

    `target` is the identifier of a state beside this one; None: the state stays. `level` is what a trace has of the
    decision. `raises` is the event that it raises, if any.
    """

    event: str
    parts: tuple[Part, ...]
    target: str | None
    level: str
    raises: str | None = None


@dataclass(frozen=True, slots=True)
class ChartState:
    """A state: `identifier` is unique beside its siblings, `id` in the whole statechart.

    `path` has the index of the state at each level, and `flags` the flag that it raises, -1 if none. `begins` is the
    index of an automaton that starts when the state is entered, and `owner` that of the automaton it is a state of;
    both are None if the automaton has nothing to remember. `basic` is the index of the basic behavior that an
    innermost state runs.
    """

    identifier: str
    id: str
    title: str
    is_final: bool
    path: tuple[int, ...]
    flags: tuple[int, ...]
    basic: int | None
    begins: int | None
    owner: int | None
    effects: tuple[StateEffect, ...]
    states: tuple[ChartState, ...]
    transitions: tuple[ChartTransition, ...]

    def list_innermost(self) -> Iterator[ChartState]:
        """Yield the innermost states in order."""
        if not self.states:
            yield self
        for state in self.states:
            yield from state.list_innermost()


def check_statechart_size(hierarchy: Hierarchy) -> None:
    """Refuse a hierarchy of which the statechart would be too large, with DefinitionError."""
    parts = _ChartParts(hierarchy)

    def weigh(number: int, index: int, condition: ValueCondition) -> int | bool:
        part = parts.write(condition, number, index, "")  # shorter than where it is nested
        return part if isinstance(part, bool) else len(spell_part(part))

    size = measure_hierarchy(hierarchy, weigh)
    for count, most, of in (
        (size.states, MOST_STATES, "states, since every use of an automaton is written out"),
        (size.rules, MOST_RULES, f"transitions, {WRITTEN_OUT}"),
    ):
        if count > most:
            raise refuse_size(hierarchy.name, CHART, f"{count} {of}", str(most))
    if size.weight > MOST_BYTES:
        text = f"{format_bytes(size.weight)} of conditions, {WRITTEN_OUT}"
        raise refuse_size(hierarchy.name, CHART, text, format_bytes(MOST_BYTES))


class _ChartParts:
    """A writer of the parts of conditions of a hierarchy, with the identifiers of states."""

    def __init__(self, hierarchy: Hierarchy) -> None:
        self.hierarchy = hierarchy
        self.text = JavaScriptText(hierarchy)
        self.states = [
            make_identifiers([state.name for state in each.states], what=f"states of {each.name!r}")
            for each in hierarchy.automata
        ]

    def write(self, condition: ValueCondition, number: int, index: int, here: str) -> Part | bool:
        """Write a question of a state, which is `here`, as a part of a condition, or its answer if it has only one."""
        automata = self.hierarchy.automata
        source = automata[number].features[condition.feature]
        if source.sort != "flag":
            return self.text.condition(condition, number, source)
        is_raised = condition.low != 0.0
        raising = tuple(
            f"{here}.{self.states[below][automata[below].states[state].name]}"
            for below, state in self.hierarchy.find_raising(number, index, source.index)
        )
        return FlagQuestion(raising, is_raised) if raising else not is_raised


class Statechart:
    """The statechart of a hierarchy: its root state, and the names and text that its conditions are made of."""

    def __init__(self, hierarchy: Hierarchy) -> None:
        self.hierarchy, self._parts = hierarchy, _ChartParts(hierarchy)
        self.text, self._states = self._parts.text, self._parts.states
        self._remembers = [_needs_memory(each) for each in hierarchy.automata]
        name = hierarchy.automata[hierarchy.root.index].name
        identifier = self.text.automata[name]
        index = hierarchy.root.index
        self.root = ChartState(
            identifier, identifier, name, False, (), (), None, self._memory(index), None, (),
            self._children(index, identifier, (), ()), tuple(self._stays_in_flags(index, identifier, 0)),
        )  # fmt: skip

    @property
    def names(self) -> dict[str, dict[str, str]]:
        """The identifiers of names, as a manifest has them."""
        states = {
            f"{automaton.name}/{name}": identifier
            for automaton, names in zip(self.hierarchy.automata, self._states, strict=True)
            for name, identifier in names.items()
        }
        text = self.text
        return {
            "readings": dict(text.readings),
            "channels": dict(text.channels),
            "automata": dict(text.automata),
            "states": states,
        }

    def list_memory(self) -> list[int]:
        """List the automata that have something to remember, by index."""
        return [number for number, needed in enumerate(self._remembers) if needed]

    def _memory(self, number: int) -> int | None:
        return number if self._remembers[number] else None

    def _children(
        self, number: int, parent: str, path: tuple[int, ...], flags: tuple[int, ...]
    ) -> tuple[ChartState, ...]:
        automaton = self.hierarchy.automata[number]
        return tuple(
            self._state(number, index, parent, path, flags) for index in range(len(automaton.states))
        )

    def _state(
        self, number: int, index: int, parent: str, path: tuple[int, ...], flags: tuple[int, ...]
    ) -> ChartState:
        automaton = self.hierarchy.automata[number]
        state, child = automaton.states[index], automaton.states[index].child
        identifier = self._states[number][state.name]
        path, flags = (*path, index), (*flags, -1 if state.flag is None else state.flag)
        here = f"{parent}.{identifier}"
        below = self.hierarchy.automata if child.is_automaton else self.hierarchy.basics
        is_final = state.flag is not None
        return ChartState(
            identifier,
            here,
            f"raises {self.hierarchy.flags[state.flag]}"
            if state.flag is not None
            else below[child.index].name,
            is_final,
            path,
            flags,
            None if child.is_automaton else child.index,
            self._memory(child.index) if child.is_automaton else None,
            self._memory(number),
            state.effects,
            self._children(child.index, here, path, flags) if child.is_automaton else (),
            () if is_final else tuple(self._transitions(number, index, parent, len(path) - 1)),
        )

    def _transitions(self, number: int, index: int, parent: str, depth: int) -> Iterator[ChartTransition]:
        automaton = self.hierarchy.automata[number]
        state = automaton.states[index]
        here = f"{parent}.{self._states[number][state.name]}"
        event = f"decide.{depth}"
        if state.tree is None:
            yield self._transition(event, (), number, index, Answer(-1, NO_TREE), depth)
        else:
            routines = next(each.routines for each in automaton.decisions if index in each.states)
            for parts, answer in self._rules(routines, number, index, here):
                yield self._transition(event, parts, number, index, answer, depth)
        if state.child.is_automaton:
            yield from self._stays_in_flags(state.child.index, here, depth + 1)

    def _transition(
        self, event: str, parts: tuple[Part, ...], number: int, index: int, answer: Answer, depth: int
    ) -> ChartTransition:
        states = self.hierarchy.automata[number].states
        after = index if answer.outcome < 0 else answer.outcome
        return ChartTransition(
            event,
            parts,
            None if after == index else self._states[number][states[after].name],
            f"{number}.{index}.{answer.leaf}.{after}",
            f"decide.{depth + 1}" if states[after].child.is_automaton else None,
        )

    def _stays_in_flags(self, number: int, parent: str, depth: int) -> Iterator[ChartTransition]:
        """Yield what a trace has of flag states, which have no transitions of their own."""
        for index, state in enumerate(self.hierarchy.automata[number].states):
            if state.flag is not None:
                active = FlagQuestion((f"{parent}.{self._states[number][state.name]}",), True)
                yield self._transition(
                    f"decide.{depth}", (active,), number, index, Answer(-1, NO_TREE), depth
                )

    def _rules(
        self, routines: Sequence[Step], number: int, index: int, here: str
    ) -> Iterator[tuple[tuple[Part, ...], Answer]]:
        """Yield the answers of a tree in the order of asking: the first whose condition holds is the right one.

        What a branch goes on with if its question does not hold needs no condition, since all that follows from yes
        comes before it.
        """
        waiting: list[tuple[Step, tuple[Part, ...]]] = [(routines[0], ())]
        while waiting:
            step, parts = waiting.pop()
            if isinstance(step, Answer):
                yield parts, step
            elif isinstance(step, Continuation):
                waiting.append((routines[step.routine], parts))
            else:
                part = self._parts.write(step.condition, number, index, here)
                if part is not True:
                    waiting.append((step.no, parts))
                if part is True:
                    waiting.append((step.yes, parts))
                elif part is not False:
                    waiting.append((step.yes, (*parts, part)))


def _needs_memory(automaton: GroundAutomaton) -> bool:
    """Return whether conditions ask for counters, timers or the time of entry, or states change them."""
    return bool(automaton.counters or automaton.timers) or any(
        source.sort == "time in state" or source.fresh is not None for source in automaton.features
    )


def join_parts(parts: Sequence[str]) -> str:
    """Join JavaScript conditions that must all hold."""
    if len(parts) == 1:
        return parts[0]
    return " && ".join(f"({part})" if "||" in part else part for part in parts)


def spell_part(part: Part) -> str:
    """Spell a part of a condition with the predicate In of SCXML."""
    if isinstance(part, str):
        return part
    condition = " || ".join(f"In('{state}')" for state in part.states)
    if part.is_raised:
        return condition
    return f"!({condition})" if len(part.states) > 1 else f"!{condition}"


def describe_states(job: ExportJob, chart: Statechart) -> dict[str, Any]:
    """Describe what each innermost state is in numbers, as conformance files have them."""
    return {
        "trace_header": format_trace_header(job),
        "flags": list(job.hierarchy.flags),
        "basics": [basic.name for basic in job.hierarchy.basics],
        "readings": list(chart.text.readings.values()),
        "channels": list(chart.text.channels.values()),
        "states": {
            state.id: {"path": state.path, "flags": state.flags, "basic": state.basic}
            for state in chart.root.list_innermost()
        },
    }
