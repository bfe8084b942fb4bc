"""The C source of an export as a whole: helpers, automata, commands, path."""

from __future__ import annotations

import re
from collections.abc import Iterator

from understudy.addons.export.code_text import INDENT
from understudy.addons.export.target_files import ExportJob, fill_template
from understudy.addons.export.targets.c99_source import GENERATED, CSource, write_comment
from understudy.addons.export.targets.cpp_names import CNames
from understudy.model.kinds import Categorical


class CCode:
    """A writer of the source."""

    def __init__(self, job: ExportJob, names: CNames, source: CSource) -> None:
        self.names, self.source, self.hierarchy, self.single = (
            names,
            source,
            job.hierarchy,
            job.single_precision,
        )

    def write(self) -> bytes:
        """Write the source."""
        p, body = self.names.prefix, "\n".join(self._body())
        check = f"typedef char {p}_needs_64_bit_double[sizeof(double) == 8 ? 1 : -1];\n"
        values = {
            "title": write_comment(self.hierarchy.name),
            "generated": GENERATED,
            "name": p,
            "NAME": p.upper(),
            "functions": f'#include "{p}_functions.h"\n' if self.hierarchy.functions_to_write else "",
            "code": "\n".join(["" if self.single else check, *self._list_helpers(body), body]),
        }
        return fill_template("c99/source.c.in", values)

    def _list_helpers(self, body: str) -> Iterator[str]:
        """Yield the functions of the template that a body calls."""
        real, f = ("float", "f") if self.single else ("double", "")
        for helper in fill_template("c99/helpers.c.in", {"real": real, "f": f}).decode().split("\n\n"):
            found = re.search(r"\w+\(", helper)
            if found is not None and (f" {found[0]}" in body or f"({found[0]}" in body):
                yield f"{helper.rstrip()}\n"

    def _body(self) -> Iterator[str]:
        p, hierarchy = self.names.prefix, self.hierarchy
        automata = [
            line for number in range(len(hierarchy.automata)) for line in self.source.write_automaton(number)
        ]
        text = "\n".join(automata)
        for index in range(len(hierarchy.computed)):
            if f"value_{index}(r)" in text:
                yield from self.source.write_computed(index)
        yield from automata
        yield from self._step()
        yield from self._path()
        yield f"void {p}_clear_readings({p}_readings *r)"
        yield from ("{", f"{INDENT}(void)r;")
        for slot in hierarchy.readings:
            absent = "-1" if isinstance(slot.kind, Categorical) else f"({p}_real)NAN"
            yield f"{INDENT}r->{self.names.readings[str(slot)]} = {absent};"
        yield "}"

    def _step(self) -> Iterator[str]:
        p, hierarchy = self.names.prefix, self.hierarchy
        root = self.names.automata[hierarchy.automata[hierarchy.root.index].name]
        yield from (
            f"void {p}_start({p}_machine *m, {p}_time now)",
            "{",
            f"{INDENT}start_{root}(m, now);",
            "}",
            "",
        )
        yield f"uint8_t {p}_step({p}_machine *m, const {p}_readings *r, {p}_time now, {p}_commands *commands)"
        yield from ("{", f"{INDENT}uint8_t basic;")
        yield from (f"#ifdef {p.upper()}_TRACE", f"{INDENT}m->traced = 0;", "#endif")
        yield f"{INDENT}basic = pulse_{root}(m, r, now);"
        if hierarchy.is_coordinator:
            order, issued = (self.names.channels[channel.name] for channel in hierarchy.channels)
            yield f"{INDENT}commands->{order} = ({p}_real)basic;"
            yield f"{INDENT}commands->{issued} = ({p}_real)m->issued;"
            yield from (f"{INDENT}return basic;", "}", "")
            return
        if not hierarchy.channels:
            yield f"{INDENT}commands->nothing = 0;"
        for channel in hierarchy.channels:
            rest = self.source.write_real(channel.rest)
            yield f"{INDENT}commands->{self.names.channels[channel.name]} = {rest};"
        yield f"{INDENT}switch (basic) {{"
        for basic in hierarchy.basics:
            lines = [
                f"commands->{self.names.channels[channel]} = {self.source.write_real(value)};"
                for channel, value in basic.command.items()
            ]
            for computes, computed in basic.computed.items():
                expression = hierarchy.computed[computed].expression
                at_rest = next(each.rest for each in hierarchy.channels if each.name == computes)
                if expression is not None:
                    text = self.source.write_expression(expression)
                    called = self.names.channels[computes]
                    lines.append(f"commands->{called} = or_rest({text}, {self.source.write_real(at_rest)});")
            if basic.problem:
                lines = [f"{self.names.functions[f'behavior {basic.name}']}(r, commands);"]
            if lines:
                yield f"{INDENT}case {p.upper()}_{self.names.basics[basic.name].upper()}:"
                yield from (f"{INDENT * 2}{line}" for line in [*lines, "break;"])
        yield from (
            f"{INDENT}default:",
            f"{INDENT * 2}break;",
            f"{INDENT}}}",
            f"{INDENT}return basic;",
            "}",
            "",
        )

    def _path(self) -> Iterator[str]:
        p, hierarchy = self.names.prefix, self.hierarchy
        yield f"uint8_t {p}_path(const {p}_machine *m, uint8_t *states, uint8_t *flags)"
        yield from ("{", f"{INDENT}uint8_t level = 0;", f"{INDENT}int automaton = {hierarchy.root.index};")
        yield from (
            f"{INDENT}while (automaton >= 0) {{",
            f"{INDENT * 2}flags[level] = 0;",
            f"{INDENT * 2}switch (automaton) {{",
        )
        for number, automaton in enumerate(hierarchy.automata):
            yield f"{INDENT * 2}case {number}:"
            yield f"{INDENT * 3}automaton = -1;"
            yield f"{INDENT * 3}states[level] = m->{self.names.automata[automaton.name]}.state;"
            yield f"{INDENT * 3}switch (states[level]) {{"
            for index, state in enumerate(automaton.states):
                line = f"flags[level] = {1 + (state.flag or 0)};" if state.flag is not None else ""
                if state.child.is_automaton:
                    line = f"automaton = {state.child.index};"
                if line:
                    yield from (f"{INDENT * 3}case {index}:", f"{INDENT * 4}{line}", f"{INDENT * 4}break;")
            yield from (
                f"{INDENT * 3}default:",
                f"{INDENT * 4}break;",
                f"{INDENT * 3}}}",
                f"{INDENT * 3}break;",
            )
        yield from (
            f"{INDENT * 2}default:", f"{INDENT * 3}automaton = -1;", f"{INDENT * 3}break;",
            f"{INDENT * 2}}}", f"{INDENT * 2}level++;", f"{INDENT}}}", f"{INDENT}return level;", "}", "",
        )  # fmt: skip
