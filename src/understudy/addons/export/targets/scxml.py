"""Target scxml: a statechart in the W3C's SCXML, with conditions over the ECMAScript data model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from understudy.addons.export.export_size import check_bytes
from understudy.addons.export.javascript_text import FAILED, write_number
from understudy.addons.export.statechart import (
    CHART,
    ChartState,
    ChartTransition,
    Statechart,
    describe_states,
    join_parts,
    spell_part,
)
from understudy.addons.export.target_files import ExportJob, TargetFiles, fill_templates
from understudy.storage.json_text import format_json

NAMESPACE = "http://www.w3.org/2005/07/scxml"
FUNCTIONS_HERE = "functions"
"""What stands for the functions until they are put into the document as they are."""
NOTE = ("function note(level) {", "  if (trace !== null) { trace.push(level); }", "}")
MADE_BY_NPM = ("node_modules/", "package-lock.json")
"""What npm makes in the folder of an export."""


def make_scxml_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to SCXML."""
    hierarchy = job.hierarchy
    chart = Statechart(hierarchy)
    name = f"{chart.root.identifier}.scxml"
    values = {
        "title": hierarchy.name,
        "file": name,
        "root": chart.root.identifier,
        "tick_s": f"{hierarchy.tick_s:g}",
        "notes": "".join(
            f"\nPut in {each.name} yourself, where `{name}` says so: {each.problem}.\n"
            for each in hierarchy.functions_to_write
        ),
    }
    files = {name: check_bytes(hierarchy.name, CHART, _ScxmlDocument(job, chart).write())}
    files["states.json"] = format_json(describe_states(job, chart))
    templates = ("Makefile", "README.md", "package.json", "conformance.cjs", "conformance.cpp")
    files |= fill_templates("scxml", values, *templates)
    return TargetFiles(files, chart.names, ("trace.csv", "conformance-qt", *MADE_BY_NPM))


class _ScxmlDocument:
    """A writer of the document of one statechart."""

    def __init__(self, job: ExportJob, chart: Statechart) -> None:
        self.hierarchy, self.chart, self.text = job.hierarchy, chart, chart.text
        self.rest = self.text.commands({})
        self.computes = any(basic.is_function for basic in self.hierarchy.basics)

    def write(self) -> bytes:
        root = self.chart.root
        heading = {"version": "1.0", "datamodel": "ecmascript", "name": root.identifier}
        document = Element("scxml", {"xmlns": NAMESPACE, **heading, "initial": root.identifier})
        self._data(SubElement(document, "datamodel"))
        SubElement(document, "script").text = FUNCTIONS_HERE
        self._state(document, root)
        failed = SubElement(document, "final", id=FAILED)
        _assign(SubElement(failed, "onentry"), "commands", write_object(self.rest))
        indent(document)
        text = tostring(document, encoding="unicode")
        functions = "".join(f"\n    {line}".rstrip(" ") for line in (*self.text.write_functions(), "", *NOTE))
        functions = functions.replace("]]>", "]]\\u003e")
        text = text.replace(f">{FUNCTIONS_HERE}<", f"><![CDATA[{functions}\n  ]]><", 1)
        return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()

    def _data(self, model: Element) -> None:
        data = {"now": "0", "readings": "{}", "commands": write_object(self.rest), "trace": "null"}
        if self.chart.list_memory():
            data["memory"] = "{}"
        if self.hierarchy.is_coordinator:
            data["issued_at"] = "null"
        for name, value in data.items():
            SubElement(model, "data", id=name, expr=value)

    def _forgotten(self, number: int) -> str:
        """Write the memory of an automaton that starts."""
        counters = ", ".join(f"{name}: 0" for name in self.text.counters[number].values())
        timers = ", ".join(f"{name}: null" for name in self.text.timers[number].values())
        return f"{{entered: now, counters: {{{counters}}}, timers: {{{timers}}}}}"

    def _state(self, parent: Element, state: ChartState) -> None:
        element = SubElement(parent, "final" if state.is_final else "state", id=state.id)
        if state.states:
            element.set("initial", state.states[0].id)
        entry = Element("onentry")
        changes = list(self._changes(state))
        if changes:
            SubElement(entry, "script").text = " ".join(changes)
        if state.basic is not None:
            self._command(entry, state.basic)
        if len(entry):
            element.append(entry)
        if not state.path:
            self._take_events(element, state)
        if state.basic is not None and self.hierarchy.basics[state.basic].is_function:
            self._command(SubElement(element, "transition", event="act"), state.basic)
        beside = state.id.rpartition(".")[0]
        for transition in state.transitions:
            self._transition(element, beside, transition)
        for child in state.states:
            self._state(element, child)

    def _changes(self, state: ChartState) -> Iterator[str]:
        """Write what entering a state changes in the memory."""
        if state.begins is not None:
            yield f"{self.text.memory(state.begins)} = {self._forgotten(state.begins)};"
        if state.owner is None:
            return
        memory = self.text.memory(state.owner)
        yield f"{memory}.entered = now;"
        for effect in state.effects:
            place = ".".join((memory, *self.text.find_memory(state.owner, effect)))
            value = write_number(effect.value)
            if effect.of == "timer":
                value = "now" if effect.action == "set" else "null"
            elif effect.action == "reset":
                value = "0"
            yield f"{place} {'+=' if effect.action == 'increment' else '='} {value};"

    def _take_events(self, element: Element, root: ChartState) -> None:
        """Write the transitions of the events that come from outside, and of errors."""
        start = SubElement(element, "transition", event="start", target=root.id)
        _assign(start, "now", "_event.data.now")
        tick = SubElement(element, "transition", event="tick")
        statements = ["now = _event.data.now;", "readings = take(_event.data.readings);"]
        statements.append("if (trace !== null) { trace = []; }")
        if self.hierarchy.is_coordinator:
            order, issued = (self.text.channels[each.name] for each in self.hierarchy.channels)
            commands = f"{order}: commands.{order}, {issued}: issued_at === now ? 1 : 0"
            statements.append(f"commands = {{{commands}}};")
        SubElement(tick, "script").text = " ".join(statements)
        if self.computes:
            SubElement(tick, "raise", event="act")
        SubElement(tick, "raise", event="decide.0")
        _assign(SubElement(element, "transition", event="trace"), "trace", "[]")
        SubElement(element, "transition", event="error", target=FAILED)

    def _command(self, parent: Element, index: int) -> None:
        basic = self.hierarchy.basics[index]
        if self.hierarchy.is_coordinator:
            order, issued = (each.name for each in self.hierarchy.channels)
            commands = {order: 0.0 if basic.order is None else float(index), issued: 1.0}
            _assign(parent, "commands", write_object(self.text.commands(commands)))
            _assign(parent, "issued_at", "now")
        elif basic.is_function:
            _assign(parent, "commands", f"command_{index}(readings)")
        else:
            _assign(parent, "commands", write_object(self.text.commands(basic.command)))

    @staticmethod
    def _transition(parent: Element, beside: str, transition: ChartTransition) -> None:
        element = SubElement(parent, "transition", event=transition.event)
        if transition.parts:
            element.set("cond", join_parts([spell_part(part) for part in transition.parts]))
        if transition.target is not None:
            element.set("target", f"{beside}.{transition.target}")
        SubElement(element, "script").text = f"note('{transition.level}');"
        if transition.raises is not None:
            SubElement(element, "raise", event=transition.raises)


def _assign(parent: Element, location: str, value: str) -> None:
    SubElement(parent, "assign", location=location, expr=value)


def write_object(values: Mapping[str, float]) -> str:
    """Write numbers by name as an object of JavaScript."""
    return f"{{{', '.join(f'{name}: {write_number(value)}' for name, value in values.items())}}}"
