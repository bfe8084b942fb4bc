"""The C source of an exported hierarchy: one function per automaton for each step of a pulse, no recursion, no heap."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from understudy.addons.export.condition_text import C_BLOCKS, C_WORDS, INDENT, Operand, RoutineText, Spelling
from understudy.addons.export.decisions import Answer, TreeRoutines
from understudy.addons.export.hierarchy import (
    FeatureSource,
    FunctionToWrite,
    GroundAutomaton,
    GroundExpression,
    Hierarchy,
    ReadingSlot,
)
from understudy.addons.export.single_precision import round_to_single
from understudy.addons.export.target_files import FileByHand
from understudy.addons.export.targets.cpp_names import CNames
from understudy.model.tree import STAY
from understudy.model.value_kinds import Categorical, Kind, Toroidal

GENERATED = "exported by Understudy. This file was generated: teach it again instead of editing it."

C_FUNCTIONS = {
    "abs": "absolute",
    "isnan": "is_absent",
    "sqrt": "root",
    "minimum": "lesser",
    "maximum": "greater",
}
"""The functions of operations in exported C."""


class CSource(RoutineText):
    """A writer of the parts of the source that depend on the hierarchy."""

    blocks, functions = C_BLOCKS, C_FUNCTIONS

    def __init__(self, hierarchy: Hierarchy, names: CNames, *, single_precision: bool) -> None:
        self.hierarchy, self.names, self.single = hierarchy, names, single_precision
        self.spelling = Spelling(*C_WORDS, self.write_real, lambda ms: f"{ms}UL", str)

    def write_real(self, value: float) -> str:
        """Write a floating-point constant of the export's precision."""
        if np.isinf(value):
            return "INFINITY" if value > 0 else "-INFINITY"
        text = f"{round_to_single(value):.9g}" if self.single else repr(float(value))
        if not any(each in text for each in ".e"):
            text += ".0"
        return f"{text}f" if self.single else text

    # What an automaton remembers

    def keeps_entry(self, automaton: GroundAutomaton) -> bool:
        """Return whether an automaton remembers when it entered its state."""
        timed = any(each.sort == "time in state" or each.fresh is not None for each in automaton.features)
        return timed or self.hierarchy.is_coordinator

    def write_memory(self, number: int) -> list[str]:
        """Write the members of the structure in which an automaton's state is kept."""
        automaton, p = self.hierarchy.automata[number], self.names.prefix
        lines = [f"{p}_state state;"]
        if self.keeps_entry(automaton):
            lines.append(f"{p}_time entered;")
        if automaton.counters:
            lines.append(f"{p}_count counters[{len(automaton.counters)}]; /* {_list(automaton.counters)} */")
        if automaton.timers:
            count = len(automaton.timers)
            lines.append(f"{p}_time timers[{count}]; /* {_list(automaton.timers)} */")
            lines.append(f"uint8_t is_set[{count}]; /* whether each timer is set */")
        return lines

    # Values

    def write_operand(self, number: int, state: int | None, source: FeatureSource) -> Operand:
        """Write the value of a feature of an automaton, for the tree of a state; None is the tree of all states."""
        automaton = self.hierarchy.automata[number]
        memory = f"m->{self.names.automata[automaton.name]}"
        if source.sort == "flag":
            return Operand("flag", self._flag(number, state, source.index))
        if source.sort == "counter":
            text = f"{memory}.counters[{source.index}]"
            return Operand("count" if self.single else "real", text)
        if source.sort == "time in state":
            return self._elapsed(f"{memory}.entered")
        if source.sort == "timer":
            is_set = f"{memory}.is_set[{source.index}]"
            elapsed = self._elapsed(f"{memory}.timers[{source.index}]")
            return Operand(elapsed.sort, elapsed.text, f"!{is_set}", is_set)
        if source.sort == "reading":
            text = f"r->{self.names.readings[str(self.hierarchy.readings[source.index])]}"
        else:
            text = f"value_{source.index}(r)"
        is_label = isinstance(source.kind, Categorical)
        if source.fresh is not None:
            fresh = str(int(source.fresh)) if is_label else self.write_real(source.fresh)
            text = f"({memory}.entered == now ? {fresh} : {text})"
        return (
            Operand("label", text, f"{text} < 0") if is_label else Operand("real", text, f"is_absent({text})")
        )

    def _elapsed(self, since: str) -> Operand:
        if self.single:
            return Operand("ms", f"(uint32_t)(now - {since})")
        return Operand("real", f"elapsed(now, {since})")

    def _flag(self, number: int, state: int | None, flag: int) -> str:
        """Write whether the automaton that a state runs has raised a flag."""
        called = [self.names.automata[each.name] for each in self.hierarchy.automata]
        if state is None:
            return f"flag_{flag}_{called[number]}(m)"
        raising = self.hierarchy.find_raising(number, state, flag)
        return " || ".join(f"m->{called[below]}.state == {index}" for below, index in raising) or "0"

    # Trees

    def write_answer(self, answer: Answer) -> Sequence[str]:
        """Write the end of a routine."""
        return [f"ANSWER({answer.leaf}, {'STAY' if answer.outcome == STAY else answer.outcome});"]

    def write_call(self, routine: str) -> str:
        """Write that another routine goes on."""
        return f"return {routine}(m, r, now);"

    def write_automaton(self, number: int) -> Iterator[str]:
        """Write the functions of an automaton: start, next state, enter a state, pulse."""
        automaton = self.hierarchy.automata[number]
        called, p = self.names.automata[automaton.name], self.names.prefix
        yield f"/* {write_comment(automaton.name)} */"
        yield from self._write_start(number, called)
        takes = f"({p}_machine *m, const {p}_readings *r, {p}_time now)"
        for decision in automaton.decisions:
            yield from self._write_tree(number, decision, called, takes)
        yield f"static int next_{called}{takes}"
        yield "{"
        yield from (f"{INDENT}(void)m; (void)r; (void)now;", f"{INDENT}switch (m->{called}.state) {{")
        for decision in automaton.decisions:
            for index in decision.states:
                yield f"{INDENT}case {index}: /* {write_comment(automaton.states[index].name)} */"
            yield f"{INDENT * 2}return tree_{called}_{decision.states[0]}_0(m, r, now);"
        yield from (f"{INDENT}default:", f"{INDENT * 2}ANSWER(NO_TREE, STAY);", f"{INDENT}}}", "}", "")
        yield from self._write_enter(number, called)
        yield from self._write_pulse(number, called, takes)

    def _write_start(self, number: int, called: str) -> Iterator[str]:
        automaton, p = self.hierarchy.automata[number], self.names.prefix
        yield f"static void start_{called}({p}_machine *m, {p}_time now)"
        yield from ("{", f"{INDENT}(void)now;", f"{INDENT}m->{called}.state = 0;")
        if self.keeps_entry(automaton):
            yield f"{INDENT}m->{called}.entered = now;"
        for index in range(len(automaton.counters)):
            yield f"{INDENT}m->{called}.counters[{index}] = 0;"
        for index in range(len(automaton.timers)):
            yield f"{INDENT}m->{called}.is_set[{index}] = 0;"
        yield from ("}", "")

    def _write_tree(self, number: int, decision: TreeRoutines, called: str, takes: str) -> Iterator[str]:
        automaton = self.hierarchy.automata[number]
        name = f"tree_{called}_{decision.states[0]}"
        lines = []
        for index, routine in enumerate(decision.routines):
            lines += [f"static int {name}_{index}{takes}", "{", f"{INDENT}(void)m; (void)r; (void)now;"]
            lines += [*self.write_step(routine, number, decision.state, name, 1), "}", ""]
        if decision.state is None:
            text = "\n".join(lines)
            flags = dict.fromkeys(each.index for each in automaton.features if each.sort == "flag")
            for flag in flags:
                if f"flag_{flag}_{called}(m)" in text:
                    yield from self._write_flag(number, decision.states, called, flag)
        for index in range(1, len(decision.routines)):
            yield f"static int {name}_{index}{takes};"
        yield from lines

    def _write_flag(self, number: int, states: Sequence[int], called: str, flag: int) -> Iterator[str]:
        """Write a function that says whether the automaton run by the current state has raised a flag."""
        yield f"static int flag_{flag}_{called}(const {self.names.prefix}_machine *m)"
        yield from ("{", f"{INDENT}switch (m->{called}.state) {{")
        for index in states:
            raised = self._flag(number, index, flag)
            if raised != "0":
                yield from (f"{INDENT}case {index}:", f"{INDENT * 2}return {raised};")
        yield from (f"{INDENT}default:", f"{INDENT * 2}return 0;", f"{INDENT}}}", "}", "")

    def _write_enter(self, number: int, called: str) -> Iterator[str]:
        automaton, p = self.hierarchy.automata[number], self.names.prefix
        yield f"static void enter_{called}({p}_machine *m, int next, {p}_time now)"
        yield from ("{", f"{INDENT}(void)now;", f"{INDENT}m->{called}.state = ({p}_state)next;")
        if self.keeps_entry(automaton):
            yield f"{INDENT}m->{called}.entered = now;"
        cases = []
        for index, state in enumerate(automaton.states):
            lines = []
            if state.child.is_automaton:
                lines.append(
                    f"start_{self.names.automata[self.hierarchy.automata[state.child.index].name]}(m, now);"
                )
            for effect in state.effects:
                at = automaton.find_memory(effect)
                memory, is_set = f"m->{called}.{effect.of}s[{at}]", f"m->{called}.is_set[{at}]"
                if effect.of == "counter":
                    value = str(int(effect.value)) if self.single else self.write_real(effect.value)
                    value = "0" if effect.action == "reset" else value
                    lines.append(f"{memory} {'+=' if effect.action == 'increment' else '='} {value};")
                elif effect.action == "set":
                    lines.append(f"{memory} = now; {is_set} = 1;")
                else:
                    lines.append(f"{is_set} = 0;")
            if lines:
                cases.append((index, state.name, lines))
        if cases:
            yield f"{INDENT}switch (next) {{"
            for index, name, lines in cases:
                yield f"{INDENT}case {index}: /* {write_comment(name)} */"
                yield from (f"{INDENT * 2}{line}" for line in [*lines, "break;"])
            yield from (f"{INDENT}default:", f"{INDENT * 2}break;", f"{INDENT}}}")
        yield from ("}", "")

    def _write_pulse(self, number: int, called: str, takes: str) -> Iterator[str]:
        automaton = self.hierarchy.automata[number]
        yield f"static uint8_t pulse_{called}{takes}"
        yield from (
            "{",
            f"{INDENT}int next;",
            f"{INDENT}BEFORE({number}, m->{called}.state);",
            f"{INDENT}next = next_{called}(m, r, now);",
            f"{INDENT}if (next != STAY && next != (int)m->{called}.state)",
            f"{INDENT * 2}enter_{called}(m, next, now);",
            f"{INDENT}AFTER(m->{called}.state);",
        )
        if self.hierarchy.is_coordinator:
            yield f"{INDENT}m->issued = (uint8_t)(m->{called}.entered == now);"
        yield f"{INDENT}switch (m->{called}.state) {{"
        for index, state in enumerate(automaton.states):
            runs = str(state.child.index)
            if state.child.is_automaton:
                below = self.names.automata[self.hierarchy.automata[state.child.index].name]
                runs = f"pulse_{below}(m, r, now)"
            if runs != "0":
                yield f"{INDENT}case {index}: /* {write_comment(state.name)} */"
                yield f"{INDENT * 2}return {runs};"
        yield from (f"{INDENT}default:", f"{INDENT * 2}return 0;", f"{INDENT}}}", "}", "")

    # Computed values

    def write_computed(self, index: int) -> Iterator[str]:
        """Write the function of a computed value."""
        value, p = self.hierarchy.computed[index], self.names.prefix
        is_label = isinstance(value.kind, Categorical)
        if value.expression is None:
            yield f"static {'int' if is_label else f'{p}_real'} value_{index}(const {p}_readings *r)"
            yield from ("{", f"{INDENT}return {self.names.functions[f'feature {value.name}']}(r);", "}", "")
            return
        yield f"/* {write_comment(value.name)} */"
        yield f"static {'int' if is_label else f'{p}_real'} value_{index}(const {p}_readings *r)"
        yield from ("{", f"{INDENT}(void)r;")
        yield from (f"{INDENT}return {self.write_value(value.kind, value.expression)};", "}", "")

    def write_value(self, kind: Kind, expression: GroundExpression) -> str:
        """Write the value of an expression as one of a kind."""
        text = self.write_expression(expression)
        if isinstance(kind, Categorical):
            return f"to_label({text}, {len(kind.labels)})"
        if isinstance(kind, Toroidal):
            return f"wrap(finite_or_absent({text}), {self.write_real(kind.period)})"
        return f"finite_or_absent({text})"

    def write_functions(self) -> FileByHand | None:
        """Write the header of the functions that could not be translated; None if there are none."""
        p, stubs = self.names.prefix, {}
        kinds = {f"feature {each.name}": each.kind for each in self.hierarchy.computed}
        for function in self.hierarchy.functions_to_write:
            is_label = isinstance(kinds.get(function.name), Categorical)
            called = self.names.functions[function.name]
            declared = f"{'int' if is_label else f'{p}_real'} {called}(const {p}_readings *r)"
            last = f"{INDENT}return {'-1' if is_label else f'({p}_real)NAN'};\n"
            if function.name.startswith("behavior "):
                declared, last = f"void {called}(const {p}_readings *r, {p}_commands *commands)", ""
            error = write_error(function)
            stubs[called] = f"static inline {declared}\n{{\n{INDENT}(void)r;\n{error}\n{last}}}\n"
        return self.keep_by_hand(stubs, f"arduino/{p}/{p}_functions.h")

    def keep_by_hand(self, stubs: Mapping[str, str], *copies: str) -> FileByHand | None:
        """Make the header of functions to write out of what stands for each; None if there are none."""
        begin = f"/* Functions of {write_comment(self.hierarchy.name)} to write. Later exports keep this file. */\n"
        return FileByHand(begin, stubs, copies) if stubs else None

    def write_slot(self, slot: int) -> str:
        """Write a reading in an expression, as a number."""
        reading, p = self.hierarchy.readings[slot], self.names.prefix
        text = f"r->{self.names.readings[str(reading)]}"
        if isinstance(reading.kind, Categorical):
            return f"({text} < 0 ? ({p}_real)NAN : ({p}_real){text})"
        return text


def quote_for_c(text: str) -> str:
    """Make a text fit to stand in a string of C, which has the same bytes."""
    return "".join(
        chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}"
        for byte in text.encode("utf-8")
    )


def describe_slot(slot: ReadingSlot) -> str:
    """Describe the values of a reading in a comment of C: its labels, or its range and unit."""
    if isinstance(slot.kind, Categorical):
        return write_comment(", ".join(f"{index} {label}" for index, label in enumerate(slot.kind.labels)))
    period = f"in [0, {slot.kind.period!r}), " if isinstance(slot.kind, Toroidal) else ""
    return write_comment(f"{period}{slot.unit or 'no unit'}")


def write_error(function: FunctionToWrite) -> str:
    """Write the #error line that stops the compiler at a function that could not be translated."""
    text = write_comment(function.refuse("write it in place of this line"))
    plain = text.replace("\\", "/").replace('"', "'")
    return f'#error "{plain}"'


def write_comment(text: str) -> str:
    """Make a text fit to stand in a comment of C, on one line."""
    plain = " ".join(text.encode("ascii", "replace").decode().split())
    return plain.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").rstrip("\\")


def _list(names: Sequence[str]) -> str:
    return write_comment(", ".join(names))
