"""Target btcpp: trees for BehaviorTree.CPP 4, which Groot2 opens, with their nodes in C++."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import indent, tostring

from understudy.addons.export.condition_text import INDENT
from understudy.addons.export.export_size import check_bytes
from understudy.addons.export.exported_trace import format_trace_header
from understudy.addons.export.target_files import (
    TEMPLATES,
    ExportJob,
    FileByHand,
    TargetFiles,
    fill_template,
    fill_templates,
)
from understudy.addons.export.targets.btcpp_nodes import NodeWriter
from understudy.addons.export.targets.btcpp_tree import WHAT, TreeWriter
from understudy.addons.export.targets.c99_source import write_comment
from understudy.addons.export.targets.cpp_names import TreeNames, name_for_trees
from understudy.addons.export.targets.python_module import ARITHMETIC, PythonSource
from understudy.model.value_kinds import Categorical


def make_btcpp_files(job: ExportJob) -> TargetFiles:
    """Make the files of an export to BehaviorTree.CPP."""
    names = name_for_trees(job.hierarchy)
    c, nodes, p = names.c, NodeWriter(job.hierarchy, names), names.c.prefix
    by_hand: dict[str, FileByHand] = {}
    functions = nodes.write_functions()
    if functions is not None:
        by_hand[f"{p}_functions.hpp"] = functions
    rows = _ConformanceTables(job, names)
    python = rows.write_functions()
    if python is not None:
        by_hand[f"{p}_functions.py"] = python
    values = _list_values(job, names, nodes, rows)
    trees = TreeWriter(job.hierarchy, names).write()
    trees.append(nodes.write_models())
    indent(trees)
    files = {
        f"{p}.xml": check_bytes(
            job.hierarchy.name, WHAT, tostring(trees, encoding="utf-8", xml_declaration=True) + b"\n"
        ),
        f"{p}.hpp": fill_template("btcpp/nodes.hpp.in", values),
        "understudy_nodes.hpp": (TEMPLATES / "btcpp" / "understudy_nodes.hpp").read_bytes(),
        "conformance.py": fill_template("btcpp/conformance.py.in", values),
        "conformance.cpp": fill_template("btcpp/conformance.cpp.in", values),
    }
    files |= fill_templates("btcpp", values, "Makefile", "README.md")
    return TargetFiles(files, c.by_sort, ("conformance", "trace.csv"), by_hand=by_hand)


def _list_values(
    job: ExportJob, names: TreeNames, nodes: NodeWriter, rows: _ConformanceTables
) -> dict[str, str]:
    """List what the templates are filled in with."""
    hierarchy, p = job.hierarchy, names.c.prefix
    channels = [names.c.channels[channel.name] for channel in hierarchy.channels]
    has_functions, called = bool(names.c.functions), ", ".join(sorted(names.c.functions.values()))
    return {
        "name": p,
        "NAME": p.upper(),
        "title": hierarchy.name,
        "comment": write_comment(hierarchy.name),
        "tick_s": f"{hierarchy.tick_s:g}",
        "types": "\n".join(nodes.write_types()),
        "functions": f'#include "{p}_functions.hpp"\n\n' if has_functions else "",
        "python_functions": f"from {p}_functions import {called}\n" if has_functions else "",
        "classes": "\n".join(nodes.write_classes()),
        "automata": "\n".join(rows.write_automata()),
        "root": str(hierarchy.root.index),
        "read": "\n".join(
            f"{INDENT * 2}readings.{names.c.readings[str(slot)]} = "
            f"{'to_label' if isinstance(slot.kind, Categorical) else 'to_number'}(fields[at++]);"
            for slot in hierarchy.readings
        ),
        "check": "\n".join(
            f"{INDENT * 2}right = right && std::strtod(fields[at++].c_str(), nullptr) == commands.{channel};"
            for channel in channels
        ),
        "arithmetic": ARITHMETIC,
        "code": "\n".join(rows.write()),
        "notes": "".join(
            f"\nWrite {each.name} yourself, in `{p}_functions.hpp` and, for `make test`, in `{p}_functions.py`: "
            f"{each.problem}. Later exports keep these files.\n"
            for each in hierarchy.functions_to_write
        ),
    }


class _ConformanceTables:
    """A writer of what the programs know that run the trees on the conformance rows."""

    def __init__(self, job: ExportJob, names: TreeNames) -> None:
        self.job, self.names, self.hierarchy = job, names, job.hierarchy
        self.python = PythonSource(job, names.c.readings)

    def write_automata(self) -> Iterator[str]:
        """Write the automata for C++."""
        for number, automaton in enumerate(self.hierarchy.automata):
            states = [
                f'{{"{self.names.state(automaton, index)}", {str(state.child.is_automaton).lower()}, '
                f"{state.child.index}, {0 if state.flag is None else state.flag + 1}}}"
                for index, state in enumerate(automaton.states)
            ]
            key = self.names.memory[number, "state", 0]
            yield f'{INDENT}{{"{key}", {{{", ".join(states)}}}}},'

    def write(self) -> Iterator[str]:
        """Write the tables and functions for Python."""
        hierarchy, c = self.hierarchy, self.names.c
        yield f"TRACE_HEADER = {format_trace_header(self.job)!r}"
        yield f"READINGS = {tuple(c.readings[str(slot)] for slot in hierarchy.readings)!r}"
        labels = {c.readings[str(slot)] for slot in hierarchy.readings if isinstance(slot.kind, Categorical)}
        yield f"LABELS = {tuple(sorted(labels))!r}"
        yield f"CHANNELS = {tuple(c.channels[channel.name] for channel in hierarchy.channels)!r}"
        yield f"BASICS = {tuple(c.basics[basic.name] for basic in hierarchy.basics)!r}"
        yield f"ROOT = {hierarchy.root.index}"
        yield "# Of each automaton: the keys of its state and leaf; its states: name, what runs, and the flag."
        yield "AUTOMATA = ("
        for number, automaton in enumerate(hierarchy.automata):
            keys = [self.names.memory[number, sort, 0] for sort in ("state", "leaf")]
            states = tuple(
                (
                    self.names.state(automaton, index),
                    state.child.is_automaton,
                    state.child.index,
                    0 if state.flag is None else state.flag + 1,
                )
                for index, state in enumerate(automaton.states)
            )
            yield f"{INDENT}({keys[0]!r}, {keys[1]!r}, {states!r}),"
        yield from (")", "# Of each automaton: the states that have a tree.", "DECIDING = (")
        for automaton in hierarchy.automata:
            deciding = tuple(index for index, state in enumerate(automaton.states) if state.tree is not None)
            yield f"{INDENT}{deciding!r},"
        yield from (")", "COMPUTED = {")
        for index, node in self.names.nodes.items():
            yield f"{INDENT}{node!r}: {self._compute(index)},"
        yield from ("}", "COMMANDS = (")
        for index in range(len(hierarchy.basics)):
            yield f"{INDENT}{self._command(index)},"
        yield ")"

    def _compute(self, index: int) -> str:
        value = self.hierarchy.computed[index]
        if value.expression is None:
            return f"lambda r: {self.names.c.functions[f'feature {value.name}']}(**r)"
        return f"lambda r: {self.python.write_value(value.kind, value.expression)}"

    def _command(self, index: int) -> str:
        """Write the function from the ports of a basic behavior to its commands."""
        hierarchy, basic, channels = self.hierarchy, self.hierarchy.basics[index], self.names.c.channels
        if hierarchy.is_coordinator:
            order, issued = (channels[channel.name] for channel in hierarchy.channels)
            issue = 'float(r["since"] == r["now"])'
            return f'lambda r: {{{order!r}: r["order"], {issued!r}: {issue}}}'
        rest = {channels[each.name]: each.rest for each in hierarchy.channels}
        if basic.problem:
            function = self.names.c.functions[f"behavior {basic.name}"]
            return f"lambda r: {{**{rest!r}, **{function}(**r)}}"
        if not basic.computed:
            return "lambda r: r"
        items = []
        for channel in hierarchy.channels:
            text = repr(channel.rest)
            if channel.name in basic.computed:
                expression = hierarchy.computed[basic.computed[channel.name]].expression
                if expression is not None:
                    text = f"_finite({self.python.write_expression(expression)}, {text})"
            items.append(f"{channels[channel.name]!r}: {text}")
        return f"lambda r: {{{', '.join(items)}}}"

    def write_functions(self) -> FileByHand | None:
        """Write the module of the functions that could not be translated; None if there are none."""
        stubs: dict[str, str] = {}
        for function in self.hierarchy.functions_to_write:
            name, called = function.name, self.names.c.functions[function.name]
            takes = ", ".join(self.names.c.readings[each] for each in function.readings)
            returns = "the value" if name.startswith("feature ") else "a dictionary of commands by channel"
            text = (
                f"{name} could not be translated ({function.problem}): return {returns} and remove this line"
            )
            stubs[called] = (
                f"\nraise NotImplementedError({text!r})\n\n\ndef {called}({takes}):\n{INDENT}pass\n"
            )
        if not stubs:
            return None
        begin = f'"""Functions of {write_comment(self.hierarchy.name)} to write. Later exports keep this file."""\n'
        return FileByHand(begin, stubs)
