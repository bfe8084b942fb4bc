"""Target c99: a header and a source in C, with programs that prove them on this computer and on microcontrollers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from understudy.addons.export.condition_text import INDENT
from understudy.addons.export.conformance import MS_PER_S, ConformanceTick
from understudy.addons.export.exported_trace import format_trace_header
from understudy.addons.export.target_files import ExportJob, TargetFiles, fill_template, fill_templates
from understudy.addons.export.targets.c99_source import (
    GENERATED,
    CSource,
    describe_slot,
    quote_for_c,
    write_comment,
)
from understudy.addons.export.targets.cpp_names import CNames, name_for_c
from understudy.model.value_kinds import Categorical

MADE = (
    "conformance",
    "sanitized",
    "traced",
    "trace.csv",
    "embedded-m3.elf",
    "embedded-avr.elf",
    "embedded-avr.log",
)
"""The files that the Makefile makes."""

ZEPHYR = ("CMakeLists.txt", "prj.conf", "src/main.c")
"""The files of a program for Zephyr."""

BITS = {
    "float": {"bits": "uint32_t", "but_sign": "0x7fffffffUL", "infinity": "0x7f800000UL"},
    "double": {"bits": "uint64_t", "but_sign": "0x7fffffffffffffffULL", "infinity": "0x7ff0000000000000ULL"},
}
"""The bits of each type of numbers: whole numbers as large, all bits but the sign, and those of infinity."""

MOST_EMBEDDED_BYTES = 14_000
"""The space for conformance rows in the flash of an ATmega328P, beside the program."""


def make_c99_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to C."""
    names = name_for_c(job.hierarchy)
    writer = _CFiles(job, names)
    functions = writer.source.write_functions()
    return TargetFiles(
        writer.make_files(),
        names.by_sort,
        (*MADE, *(f"{names.prefix}-{name}" for name in ("m3.o", "avr.o"))),
        by_hand={} if functions is None else {f"{names.prefix}_functions.h": functions},
    )


class _CFiles:
    def __init__(self, job: ExportJob, names: CNames) -> None:
        self.job, self.names, self.hierarchy = job, names, job.hierarchy
        self.single = job.single_precision
        self.source = CSource(job.hierarchy, names, single_precision=self.single)
        self.real = "float" if self.single else "double"

    def make_files(self) -> dict[str, bytes]:
        p = self.names.prefix
        values = self.values()
        header = "".join(f"{line}\n" for line in CHeader(self.job, self.names, self.source).write()).encode()
        source = CCode(self.job, self.names, self.source).write()
        files = {f"{p}.h": header, f"{p}.c": source}
        files |= fill_templates("c99", values, "conformance.c", "embedded.c", "Makefile", "README.md")
        files |= fill_templates("c99", {}, "cortex-m3/start.c", "cortex-m3/m3.ld")
        files |= fill_templates("c99", values, *(f"zephyr/{name}" for name in ZEPHYR))
        files[f"arduino/{p}/{p}.ino"] = fill_template("c99/arduino.ino", values)
        files |= {f"arduino/{p}/{p}.h": header, f"arduino/{p}/{p}.c": source}
        files["embedded_rows.h"] = self.rows().encode()
        return files

    def values(self) -> dict[str, str]:
        p, hierarchy = self.names.prefix, self.hierarchy
        readings = [
            (self.names.readings[str(slot)], isinstance(slot.kind, Categorical), str(slot), slot.unit)
            for slot in hierarchy.readings
        ]
        channels = [self.names.channels[channel.name] for channel in hierarchy.channels]
        samples = [
            f"// readings.{each} = ...;  ({'index of a label' if is_label else write_comment(unit) or 'a number'})"
            for each, is_label, _, unit in readings
        ]
        used = [f"(void)commands.{channel};" for channel in channels]
        notes = [
            f"\nWrite {each.name} yourself, in `{p}_functions.h`, which later exports keep: {each.problem}."
            for each in hierarchy.functions_to_write
        ]
        if self.single:
            notes.append("\nNumbers are single precision, times whole milliseconds.")
        return {
            "name": p,
            "NAME": p.upper(),
            "title": hierarchy.name,
            "real": self.real,
            "parse": "strtof" if self.single else "strtod",
            "parse_time": "(uint32_t)strtoul(time, NULL, 10)" if self.single else "strtod(time, NULL)",
            "read": "\n".join(
                f"{INDENT * 2}READ_{'LABEL' if is_label else 'REAL'}({each});"
                for each, is_label, _, _ in readings
            ),
            "check": "\n".join(f"{INDENT * 2}CHECK_REAL({channel});" for channel in channels),
            "check_row": "\n".join(
                f"{INDENT * 2}right = right && commands.{channel} == row.commands.{channel};"
                for channel in channels
            ),
            "clock": "milliseconds (it may overflow)" if self.single else "seconds",
            "tick_s": f"{hierarchy.tick_s:g}",
            "arduino_now": "millis()" if self.single else "millis() / 1000.0",
            "arduino_readings": "\n".join(f"{INDENT}{line}" for line in samples),
            "arduino_commands": "\n".join(f"{INDENT}{line}" for line in used),
            "zephyr_now": "k_uptime_get_32()" if self.single else "(double)k_uptime_get() / 1000.0",
            "zephyr_readings": "\n".join(f"{INDENT * 2}/* {line[3:]} */" for line in samples),
            "zephyr_commands": "\n".join(f"{INDENT * 2}{line}" for line in used),
            "notes": "".join(f"{note}\n" for note in notes),
        }

    # Rows for computers without files

    def rows(self) -> str:
        hierarchy = self.hierarchy
        size = 4 if self.single else 8
        each = size * (1 + len(hierarchy.readings) + len(hierarchy.channels)) + 2 * hierarchy.depth + 8
        chosen = _choose_rows(
            self.job.conformance.ticks, self.job.conformance.recorded, max(20, MOST_EMBEDDED_BYTES // each)
        )
        lines = [f"#define ROWS {len(chosen)}", "static const row_type rows[ROWS] PROGMEM = {"]
        for tick in chosen:
            readings = [
                ("-1" if value != value else str(int(value)))
                if isinstance(slot.kind, Categorical)
                else ("ABSENT" if value != value else self.source.write_real(value))
                for slot, value in zip(hierarchy.readings, tick.readings, strict=True)
            ]
            expected = tick.expected
            commands = [self.source.write_real(value) for value in expected.commands]
            flags = [str(flag + 1) for flag in expected.flags]
            time = f"{int(tick.time)}UL" if self.single else repr(float(tick.time))
            lists = (readings or ["0"], commands or ["0"], list(map(str, expected.path)), flags)
            text = ", ".join(f"{{{', '.join(each)}}}" for each in lists)
            lines.append(
                f"{INDENT}{{{time}, {text}, {len(expected.path)}, {int(tick.starts)}, {expected.basic}}},"
            )
        return "\n".join([*lines, "};"]) + "\n"


def _choose_rows(ticks: Sequence[ConformanceTick], recorded: int, most: int) -> list[ConformanceTick]:
    """Choose rows that fit into a small memory: half from lessons, half from walks, each from the start of a run."""
    lessons = list(ticks[: min(recorded, most // 2)])
    return [*lessons, *ticks[recorded : recorded + most - len(lessons)]]


class CHeader:
    """A writer of the header."""

    def __init__(self, job: ExportJob, names: CNames, source: CSource) -> None:
        self.job, self.names, self.source = job, names, source
        self.hierarchy, self.single = job.hierarchy, job.single_precision

    def write(self) -> Iterator[str]:
        """Write the header, line by line."""
        p, hierarchy = self.names.prefix, self.hierarchy
        guard = f"{p.upper()}_H"
        yield from (
            f"/* {write_comment(hierarchy.name)}, {GENERATED} */",
            f"#ifndef {guard}", f"#define {guard}", "", "#include <math.h>", "#include <stdint.h>", "",
            "#ifdef __cplusplus", 'extern "C" {', "#endif", "",
        )  # fmt: skip
        yield f"typedef {'float' if self.single else 'double'} {p}_real;"
        if self.single:
            yield f"typedef uint32_t {p}_time; /* ms; it may overflow */"
            yield f"typedef int32_t {p}_count;"
        else:
            yield f"typedef double {p}_time; /* s */"
            yield f"typedef double {p}_count;"
        kinds = [each.kind for each in hierarchy.readings]
        most = max((len(kind.labels) for kind in kinds if isinstance(kind, Categorical)), default=0)
        yield f"typedef {'int8_t' if most < 128 else 'int16_t'} {p}_label; /* the index of a label, -1 if absent */"
        yield f"typedef uint8_t {p}_state;"
        yield ""
        yield f"#define {p.upper()}_LEVELS {hierarchy.depth} /* the most automata that are active at a time */"
        tick_ms = max(1, round(hierarchy.tick_s * MS_PER_S))
        yield f"#define {p.upper()}_TICK_MS {tick_ms} /* the tick with which it was taught */"
        yield f'#define {p.upper()}_TRACE_HEADER "{quote_for_c(format_trace_header(self.job))}"'
        yield ""
        yield "/* The basic behaviors. */"
        yield "enum {"
        for index, basic in enumerate(hierarchy.basics):
            yield f"{INDENT}{p.upper()}_{self.names.basics[basic.name].upper()} = {index},"
        yield from ("};", "", "/* The states of each automaton. */", "enum {")
        for automaton in hierarchy.automata:
            for index, state in enumerate(automaton.states):
                of = self.names.automata[automaton.name].upper()
                called = self.names.states[f"{automaton.name}/{state.name}"].upper()
                yield f"{INDENT}{p.upper()}_{of}_IN_{called} = {index},"
        yield from ("};", "", "typedef struct {")
        for slot in hierarchy.readings:
            is_label = isinstance(slot.kind, Categorical)
            kind = f"{p}_label" if is_label else f"{p}_real"
            yield f"{INDENT}{kind} {self.names.readings[str(slot)]}; /* {describe_slot(slot)} */"
        if not hierarchy.readings:
            yield f"{INDENT}uint8_t nothing;"
        yield from (f"}} {p}_readings;", "", "typedef struct {")
        for channel in hierarchy.channels:
            unit = f" {write_comment(channel.unit)}" if channel.unit else ""
            yield f"{INDENT}{p}_real {self.names.channels[channel.name]}; /*{unit} {channel.rest:g} at rest */"
        if not hierarchy.channels:
            yield f"{INDENT}{p}_real nothing;"
        yield from (f"}} {p}_commands;", "", "typedef struct {")
        for number, automaton in enumerate(hierarchy.automata):
            yield f"{INDENT}struct {{"
            yield from (f"{INDENT * 2}{line}" for line in self.source.write_memory(number))
            yield f"{INDENT}}} {self.names.automata[automaton.name]};"
        if hierarchy.is_coordinator:
            yield f"{INDENT}uint8_t issued;"
        yield from (
            f"#ifdef {p.upper()}_TRACE", f"{INDENT}int leaf;", f"{INDENT}uint8_t traced;",
            f"{INDENT}struct {{", f"{INDENT * 2}int automaton, before, leaf, after;",
            f"{INDENT}}} trace[{p.upper()}_LEVELS];", "#endif", f"}} {p}_machine;", "",
        )  # fmt: skip
        yield from (
            "/* Begin at a time. */",
            f"void {p}_start({p}_machine *m, {p}_time now);",
            "/* Make all readings absent. */",
            f"void {p}_clear_readings({p}_readings *r);",
            "/* Decide on one snapshot of readings and write the commands; return the basic behavior that runs. */",
            f"uint8_t {p}_step({p}_machine *m, const {p}_readings *r, {p}_time now, {p}_commands *commands);",
            "/* Write the state of every level, the root first, and the flag that it has raised, from 1 (0: none). */",
            f"uint8_t {p}_path(const {p}_machine *m, uint8_t *states, uint8_t *flags);",
            "", "#ifdef __cplusplus", "}", "#endif", "#endif",
        )  # fmt: skip


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
        values = {"real": real, "f": f, **BITS[real]}
        for helper in fill_template("c99/helpers.c.in", values).decode().split("\n\n"):
            match = re.search(r"\w+\(", helper)
            if match is not None and (f" {match[0]}" in body or f"({match[0]}" in body):
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
        numbers = [
            self.names.readings[str(slot)]
            for slot in hierarchy.readings
            if not isinstance(slot.kind, Categorical)
        ]
        yield from ("{", f"{INDENT}uint8_t basic;")
        if numbers:
            yield f"{INDENT}{p}_readings present;"
        yield from (f"#ifdef {p.upper()}_TRACE", f"{INDENT}m->traced = 0;", "#endif")
        if numbers:
            questions = f" ||\n{INDENT * 2}".join(f"is_infinite(&r->{each})" for each in numbers)
            yield f"{INDENT}if ({questions}) {{ /* which is absent, like NaN */"
            yield f"{INDENT * 2}present = *r;"
            yield from (f"{INDENT * 2}make_absent(&present.{each});" for each in numbers)
            yield from (f"{INDENT * 2}r = &present;", f"{INDENT}}}")
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
