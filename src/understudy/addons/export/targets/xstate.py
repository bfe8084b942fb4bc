"""Target xstate: the configuration of a machine for XState 5 as JSON, and a module with what it names."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from understudy.addons.export.export_size import check_bytes
from understudy.addons.export.statechart import (
    CHART,
    ChartState,
    ChartTransition,
    FlagQuestion,
    Part,
    Statechart,
    describe_states,
    join_parts,
    spell_part,
)
from understudy.addons.export.target_files import ExportJob, TargetFiles, fill_template, fill_templates
from understudy.addons.export.targets.scxml import MADE_BY_NPM
from understudy.storage.json_text import format_json


def make_xstate_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to XState."""
    hierarchy = job.hierarchy
    chart = Statechart(hierarchy)
    machine = _Machine(job, chart)
    config = machine.configure()
    values = {
        "title": hierarchy.name,
        "root": chart.root.identifier,
        "tick_s": f"{hierarchy.tick_s:g}",
        "functions": "\n".join(chart.text.write_functions()),
        "guards": "\n".join(machine.write_guards()),
        "actions": "\n".join(machine.write_actions()),
        "notes": "".join(
            f"\nPut in {each.name} yourself, where `machine.mjs` says so: {each.problem}.\n"
            for each in hierarchy.functions_to_write
        ),
    }
    files = {
        "machine.json": check_bytes(hierarchy.name, CHART, format_json(config)),
        "states.json": format_json(describe_states(job, chart)),
        "machine.mjs": fill_template("xstate/machine.mjs.in", values),
        **fill_templates("xstate", values, "Makefile", "README.md", "package.json", "conformance.mjs"),
    }
    return TargetFiles(files, chart.names, ("trace.csv", *MADE_BY_NPM))


class _Machine:
    """A writer of the machine of one statechart; conditions and actions that it names are collected."""

    def __init__(self, job: ExportJob, chart: Statechart) -> None:
        self.hierarchy, self.chart, self.text = job.hierarchy, chart, chart.text
        self.guards: dict[str, tuple[Part, ...]] = {}
        self.raised: dict[str, None] = {}

    def configure(self) -> dict[str, Any]:
        """Make the configuration."""
        root = self.chart.root
        context: dict[str, Any] = {
            "now": 0,
            "readings": {},
            "commands": self.text.commands({}),
            "memory": {},
            "issued_at": None,
            "trace": None,
        }
        states = {root.identifier: self._state(root)}
        return {"id": "machine", "initial": root.identifier, "context": context, "states": states}

    def _state(self, state: ChartState) -> dict[str, Any]:
        node: dict[str, Any] = {"id": state.id, "description": state.title}
        if state.is_final:
            node["type"] = "final"
        entry = [*self._changes(state)]
        if state.basic is not None:
            entry.append(self._command(state.basic))
        if entry:
            node["entry"] = entry
        on = self._outside_events(state) if not state.path else {}
        if state.basic is not None and self.hierarchy.basics[state.basic].is_function:
            on["act"] = {"actions": [self._command(state.basic)]}
        for transition in state.transitions:
            on.setdefault(transition.event, []).append(self._transition(transition))
        if on:
            node["on"] = on
        if state.states:
            node["initial"] = state.states[0].identifier
            node["states"] = {child.identifier: self._state(child) for child in state.states}
        return node

    def _changes(self, state: ChartState) -> Iterator[dict[str, Any]]:
        """Yield the actions that change the memory when a state is entered."""
        if state.begins is not None:
            counters = list(self.text.counters[state.begins].values())
            timers = list(self.text.timers[state.begins].values())
            of = self._memory(state.begins)
            yield _act("begin", {"automaton": of, "counters": counters, "timers": timers})
        if state.owner is None:
            return
        yield _act("enter", {"automaton": self._memory(state.owner)})
        for effect in state.effects:
            of, name = self.text.find_memory(state.owner, effect)
            changed = {"automaton": self._memory(state.owner), "of": of, "name": name}
            yield _act(effect.action, {**changed, "value": effect.value})

    def _memory(self, number: int) -> str:
        return self.text.memory(number).removeprefix("memory.")

    def _command(self, index: int) -> Any:
        basic = self.hierarchy.basics[index]
        if self.hierarchy.is_coordinator:
            order, issued = (each.name for each in self.hierarchy.channels)
            commands = {order: 0.0 if basic.order is None else float(index), issued: 1.0}
            return _act("order", self.text.commands(commands))
        if basic.is_function:
            return f"command_{index}"
        return _act("command", self.text.commands(basic.command))

    def _outside_events(self, root: ChartState) -> dict[str, Any]:
        first = ["raise act"] if any(each.is_function for each in self.hierarchy.basics) else []
        raised = [*first, "raise decide.0"]
        self.raised |= {name.removeprefix("raise "): None for name in raised}
        return {
            "start": {"target": root.identifier, "reenter": True, "actions": ["take time"]},
            "tick": {"actions": ["take readings", *raised]},
            "trace": {"actions": ["begin trace"]},
        }

    def _transition(self, transition: ChartTransition) -> dict[str, Any]:
        written: dict[str, Any] = {}
        if transition.parts:
            guard = join_parts([spell_part(part) for part in transition.parts])
            self.guards[guard] = transition.parts
            written["guard"] = guard
        if transition.target is not None:
            written["target"] = transition.target
        written["actions"] = [_act("note", {"level": transition.level})]
        if transition.raises is not None:
            self.raised[transition.raises] = None
            written["actions"].append(f"raise {transition.raises}")
        return written

    def write_guards(self) -> Iterator[str]:
        """Write the conditions that the configuration names, as lines of an object."""
        for name, parts in self.guards.items():
            plain = [part for part in parts if isinstance(part, str)]
            conditions = [_ask_flag(part) for part in parts if isinstance(part, FlagQuestion)]
            if plain:
                conditions.append(f"({{ context: {{ now, readings, memory }} }}) => {join_parts(plain)}")
            whole = conditions[0] if len(conditions) == 1 else f"and([{', '.join(conditions)}])"
            yield f"  {json.dumps(name)}:\n    {whole},"

    def write_actions(self) -> Iterator[str]:
        """Write the actions that the configuration names and that differ between exports."""
        for event in self.raised:
            yield f'  "raise {event}": raise({{ type: "{event}" }}),'
        for index, basic in enumerate(self.hierarchy.basics):
            if basic.is_function:
                name = f"command_{index}"
                yield f"  {name}: assign(({{ context }}) => ({{ commands: {name}(context.readings) }})),"
        if self.hierarchy.is_coordinator:
            order, issued = (self.text.channels[each.name] for each in self.hierarchy.channels)
            yield '  "take readings": assign(({ context, event }) => ({'
            yield "    ...takeReadings(context, event),"
            commands = f"{order}: context.commands.{order}, {issued}: Number(context.issued_at === event.now)"
            yield f"    commands: {{ {commands} }},"
            yield "  })),"


def _act(name: str, params: Any) -> dict[str, Any]:
    return {"type": name, "params": params}


def _ask_flag(question: FlagQuestion) -> str:
    conditions = [f'stateIn("#{state}")' for state in question.states]
    whole = conditions[0] if len(conditions) == 1 else f"or([{', '.join(conditions)}])"
    return whole if question.is_raised else f"not({whole})"
