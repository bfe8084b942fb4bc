"""The C header of an export: its types and functions."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.export.conformance import MS_PER_S
from understudy.export.exported_trace import format_trace_header
from understudy.export.target_files import ExportJob
from understudy.export.targets.c99_names import CNames
from understudy.export.targets.c99_source import INDENT, CSource, quote_for_c, write_comment
from understudy.model.kinds import Categorical, Toroidal

GENERATED = "exported by Understudy. This file was generated: teach it again instead of editing it."


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
            yield f"{INDENT}{kind} {self.names.readings[str(slot)]}; /* {self._describe(slot.kind, slot.unit)} */"
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

    @staticmethod
    def _describe(kind: object, unit: str) -> str:
        if isinstance(kind, Categorical):
            labels = ", ".join(f"{index} {label}" for index, label in enumerate(kind.labels))
            return write_comment(labels)
        period = f"in [0, {kind.period!r}), " if isinstance(kind, Toroidal) else ""
        return write_comment(f"{period}{unit or 'no unit'}")
