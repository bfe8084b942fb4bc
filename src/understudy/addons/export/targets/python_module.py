"""Target python: one file for Python 3.9 and newer and MicroPython, which needs the standard library only."""

from __future__ import annotations

import keyword
import sys
from collections.abc import Iterator, Mapping, Sequence
from math import isinf

from understudy.addons.export.condition_text import (
    INDENT,
    PYTHON_BLOCKS,
    PYTHON_WORDS,
    Operand,
    RoutineText,
    Spelling,
)
from understudy.addons.export.decisions import Answer
from understudy.addons.export.exported_trace import format_trace_header
from understudy.addons.export.hierarchy import FeatureSource, GroundExpression
from understudy.addons.export.identifiers import make_identifier, make_identifiers
from understudy.addons.export.target_files import (
    TEMPLATES,
    ExportJob,
    FileByHand,
    TargetFiles,
    fill_template,
    fill_templates,
)
from understudy.addons.export.targets.cpp_names import name_functions
from understudy.model.value_kinds import Categorical, Kind, Toroidal

RESERVED = frozenset((*(each.lower() for each in keyword.kwlist), "conformance", "math", "sys"))
MODULES = (
    RESERVED | {each.lower() for each in sys.stdlib_module_names} | {"machine", "micropython", "network"}
)
"""Modules that `import` finds before, or that others would miss: those of the standard library and of MicroPython."""

PYTHON_FUNCTIONS = {
    "/": "_divide",
    "abs": "abs",
    "isnan": "_is_absent",
    "sqrt": "_root",
    "minimum": "_lesser",
    "maximum": "_greater",
}
"""The functions of operations in exported Python."""

ARITHMETIC = (TEMPLATES / "python" / "arithmetic.py.in").read_text(encoding="utf-8").rstrip()
"""Functions that translated expressions call."""


def make_python_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to Python."""
    hierarchy = job.hierarchy
    readings = make_identifiers(
        [str(each) for each in hierarchy.readings], what="readings", reserved=RESERVED
    )
    channels = {each.name: each.name for each in hierarchy.channels}
    module = make_identifier(hierarchy.name, MODULES).lower()
    source = PythonSource(job, readings)
    functions = source.write_functions()
    called = sorted(name_functions(hierarchy).values())
    values = {
        "module": module,
        "title": hierarchy.name,
        "quoted_title": hierarchy.name.replace("\\", "\\\\").replace('"', '\\"'),
        "tick_s": f"{hierarchy.tick_s:g}",
        "arithmetic": ARITHMETIC,
        "functions": f"\nfrom {module}_functions import {', '.join(called)}\n" if called else "",
        "code": "\n".join(source.write()),
        "notes": "".join(
            f"\nWrite {each.name} yourself, in `{module}_functions.py`, which later exports keep: {each.problem}.\n"
            for each in hierarchy.functions_to_write
        ),
    }
    files = {f"{module}.py": fill_template("python/module.py.in", values)}
    files["conformance.py"] = fill_template("python/conformance.py.in", values)
    files |= fill_templates("python", values, "Makefile", "README.md")
    by_hand = {} if functions is None else {f"{module}_functions.py": functions}
    return TargetFiles(files, {"readings": readings, "channels": channels}, ("trace.csv",), by_hand=by_hand)


class PythonSource(RoutineText):
    """A writer of the parts of the module that depend on the hierarchy."""

    blocks, functions = PYTHON_BLOCKS, PYTHON_FUNCTIONS

    def __init__(self, job: ExportJob, readings: Mapping[str, str]) -> None:
        self.job, self.hierarchy, self.readings = job, job.hierarchy, readings
        self.spelling = Spelling(*PYTHON_WORDS, self.write_real, str, str)

    def write_real(self, value: float) -> str:
        """Write a number."""
        if isinf(value):
            return "_INFINITE" if value > 0 else "-_INFINITE"
        return repr(float(value))

    def write(self) -> Iterator[str]:
        """Write the parts of the module, line by line."""
        hierarchy = self.hierarchy
        yield f"TRACE_HEADER = {format_trace_header(self.job)!r}"
        yield f"TICK_S = {hierarchy.tick_s!r}"
        yield from self._tuple("READINGS", [self.readings[str(slot)] for slot in hierarchy.readings])
        yield from self._tuple("CHANNELS", [channel.name for channel in hierarchy.channels])
        yield from self._tuple("FLAGS", list(hierarchy.flags))
        yield from self._tuple("BASICS", [basic.name for basic in hierarchy.basics])
        yield from self._tuple("AUTOMATA", [automaton.name for automaton in hierarchy.automata])
        yield from ("# For each automaton, its states.", "STATES = (")
        yield from (
            f"{INDENT}({_items([state.name for state in each.states])})," for each in hierarchy.automata
        )
        yield from (
            ")",
            "# For each state, what it runs: (True, automaton) or (False, basic behavior).",
            "_CHILDREN = (",
        )
        for automaton in hierarchy.automata:
            children = [(state.child.is_automaton, state.child.index) for state in automaton.states]
            yield f"{INDENT}({_items(children)}),"
        yield from (")", "# For each state, the index of the flag that it raises, -1 if none.", "_RAISES = (")
        for automaton in hierarchy.automata:
            flags = [-1 if state.flag is None else state.flag for state in automaton.states]
            yield f"{INDENT}({_items(flags)}),"
        yield from (")", f"_ROOT = {hierarchy.root.index}", "")
        for index in hierarchy.feature_functions:
            yield from self._computed(index)
        for number in range(len(hierarchy.automata)):
            yield from self._automaton(number)
        yield from self._dispatch()
        yield from self._commands()

    @staticmethod
    def _tuple(name: str, items: list[str]) -> Iterator[str]:
        yield f"{name} = ({_items(items)})"

    def _computed(self, index: int) -> Iterator[str]:
        value = self.hierarchy.computed[index]
        if value.expression is None:
            yield f"_value_{index} = {name_functions(self.hierarchy)[f'feature {value.name}']}"
            return
        yield from (
            "",
            f"def _value_{index}(r):",
            f"{INDENT}# {_comment(value.name)}",
            f"{INDENT}return {self.write_value(value.kind, value.expression)}",
            "",
        )

    def write_value(self, kind: Kind, expression: GroundExpression) -> str:
        """Write the value of an expression as one of a kind."""
        text = self.write_expression(expression)
        if isinstance(kind, Categorical):
            return f"_to_label({text}, {len(kind.labels)})"
        if isinstance(kind, Toroidal):
            return f"_wrap({text}, {kind.period!r})"
        return f"_finite({text}, ABSENT)"

    def write_functions(self) -> FileByHand | None:
        """Write the module of the functions that could not be translated; None if there are none."""
        stubs: dict[str, str] = {}
        called = name_functions(self.hierarchy)
        for function in self.hierarchy.functions_to_write:
            name, text = function.name, function.refuse("write it and remove this line")
            declared, last = f"def {called[name]}(r):", 'return float("nan")'
            if name.startswith("behavior "):
                declared, last = f"def {called[name]}(r, command):", "pass  # set the channels of command"
            # The module must not be imported before the function is written.
            stubs[called[name]] = f"\nraise NotImplementedError({text!r})\n\n\n{declared}\n{INDENT}{last}\n"
        title = self.hierarchy.name.replace("\\", "\\\\").replace('"', '\\"')
        begin = f'"""Functions of {title} to write. Later exports keep this file."""\n'
        return FileByHand(begin, stubs) if stubs else None

    def write_slot(self, slot: int) -> str:
        """Write a reading in an expression; `r` has them by their identifier."""
        return f"r[{self.readings[str(self.hierarchy.readings[slot])]!r}]"

    def write_choice(self, condition: str, yes: str, no: str) -> str:
        """Write an expression that is one of two."""
        return f"({yes} if {condition} else {no})"

    def write_operand(self, number: int, state: int | None, source: FeatureSource) -> Operand:
        """Write the value of a feature of an automaton, for the tree of a state; None is the tree of all states."""
        if source.sort == "flag":
            return Operand("flag", self._flag(number, state, source.index))
        if source.sort == "counter":
            return Operand("real", f"m.counters[{number}][{source.index}]")
        if source.sort == "time in state":
            return Operand("real", f"_elapsed(now, m.entered[{number}])")
        if source.sort == "timer":
            timer = f"m.timers[{number}][{source.index}]"
            return Operand("real", f"_elapsed(now, {timer})", f"{timer} is None", f"{timer} is not None")
        text = f"_value_{source.index}(r)"
        if source.sort == "reading":
            text = self.write_slot(source.index)
        if source.fresh is not None:
            text = f"({source.fresh!r} if m.entered[{number}] == now else {text})"
        sort = "label" if isinstance(source.kind, Categorical) else "real"
        return Operand(sort, text, f"_is_absent({text})")

    def _flag(self, number: int, state: int | None, flag: int) -> str:
        if state is None:
            return f"m.flag_below({number}) == {flag}"
        raising = self.hierarchy.find_raising(number, state, flag)
        return " or ".join(f"m.states[{below}] == {index}" for below, index in raising) or "False"

    def write_answer(self, answer: Answer) -> Sequence[str]:
        """Write the end of a routine."""
        return [f"m.leaf = {answer.leaf}", f"return {answer.outcome}"]

    def write_call(self, routine: str) -> str:
        """Write that another routine goes on."""
        return f"return {routine}(m, r, now)"

    def _automaton(self, number: int) -> Iterator[str]:
        automaton = self.hierarchy.automata[number]
        which: dict[int, str] = {}
        for decision in automaton.decisions:
            called = f"_tree_{number}_{decision.states[0]}"
            which |= dict.fromkeys(decision.states, f"{called}_0")
            for index, routine in enumerate(decision.routines):
                names = ", ".join(automaton.states[state].name for state in decision.states)
                yield from ("", f"def {called}_{index}(m, r, now):")
                yield f"{INDENT}# {_comment(f'{automaton.name} in {names}')}"
                yield from self.write_step(routine, number, decision.state, called, 1)
                yield ""
        trees_text = [which.get(index, "None") for index in range(len(automaton.states))]
        yield f"_TREES_{number} = ({', '.join(trees_text)},)"
        yield from ("", f"def _start_{number}(m, now):")
        yield f"{INDENT}m.states[{number}] = 0"
        yield f"{INDENT}m.entered[{number}] = now"
        yield f"{INDENT}m.counters[{number}] = [0.0] * {len(automaton.counters)}"
        yield f"{INDENT}m.timers[{number}] = [None] * {len(automaton.timers)}"
        yield from ("", "", f"def _enter_{number}(m, state, now):")
        yield f"{INDENT}m.states[{number}] = state"
        yield f"{INDENT}m.entered[{number}] = now"
        for index, state in enumerate(automaton.states):
            lines = [f"_start_{state.child.index}(m, now)"] if state.child.is_automaton else []
            for effect in state.effects:
                memory = f"m.{effect.of}s[{number}][{automaton.find_memory(effect)}]"
                if effect.of == "counter":
                    value = self.write_real(effect.value) if effect.action != "reset" else "0.0"
                    lines.append(f"{memory} {'+=' if effect.action == 'increment' else '='} {value}")
                else:
                    lines.append(f"{memory} = {'now' if effect.action == 'set' else 'None'}")
            if lines:
                yield f"{INDENT}if state == {index}:"
                yield from (f"{INDENT * 2}{line}" for line in lines)
        yield ""

    def _dispatch(self) -> Iterator[str]:
        for name in ("TREES", "start", "enter"):
            parts = [f"_{name}_{number}" for number in range(len(self.hierarchy.automata))]
            yield f"_{name.upper()} = ({', '.join(parts)},)"
        yield ""

    def _commands(self) -> Iterator[str]:
        hierarchy = self.hierarchy
        if hierarchy.is_coordinator:
            order, issued = (channel.name for channel in hierarchy.channels)
            yield from ("", "def _command(m, basic, r, now):")
            issued_text = "1.0 if m.issued == now else 0.0"
            yield f"{INDENT}return {{{order!r}: float(basic), {issued!r}: {issued_text}}}"
            return
        yield "_COMMANDS = ("
        for basic in hierarchy.basics:
            command = {each.name: basic.command.get(each.name, each.rest) for each in hierarchy.channels}
            yield f"{INDENT}{{{', '.join(f'{name!r}: {self.write_real(value)}' for name, value in command.items())}}},"
        yield ")"
        yield from (
            "",
            "",
            "def _command(m, basic, r, now):",
            f"{INDENT}command = dict(_COMMANDS[basic])",
        )
        for index, basic in enumerate(hierarchy.basics):
            if basic.problem:
                called = name_functions(hierarchy)[f"behavior {basic.name}"]
                yield from (f"{INDENT}if basic == {index}:", f"{INDENT * 2}{called}(r, command)")
            if basic.computed:
                yield f"{INDENT}if basic == {index}:"
                for channel, computed in basic.computed.items():
                    expression = hierarchy.computed[computed].expression
                    if expression is not None:
                        text = self.write_expression(expression)
                        yield f"{INDENT * 2}command[{channel!r}] = _finite({text}, command[{channel!r}])"
        yield f"{INDENT}return command"


def _items(items: Sequence[object]) -> str:
    return "".join(f"{each!r}, " for each in items).rstrip(" ") if items else ""


def _comment(text: str) -> str:
    return " ".join(text.split())
