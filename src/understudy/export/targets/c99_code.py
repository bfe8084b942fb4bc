"""The C source of an export as a whole: helpers, automata, commands, path."""

from __future__ import annotations

from collections.abc import Iterator

from understudy.export.code_text import INDENT
from understudy.export.target_files import ExportJob
from understudy.export.targets.c99_source import GENERATED, CSource, write_comment
from understudy.export.targets.cpp_names import CNames
from understudy.model.kinds import Categorical

HELPERS = {
    "elapsed(": """/* The rounding is that of Understudy, so that equally many ticks always give the same number. */
static double elapsed(double now, double since)
{
    const double steps = now < 4194304.0 ? 1e9 : 1e6;
    return floor((now - since) * steps + 0.5) / steps;
}
""",
    "finite_or_absent(": """static $real finite_or_absent($real x)
{
    return is_absent(x - x) ? ($real)NAN : x;
}
""",
    "wrap(": """static $real wrap($real x, $real period)
{
    $real wrapped = $fmod(x, period);
    if (wrapped < 0)
        wrapped += period;
    return wrapped >= period ? 0 : wrapped;
}
""",
    "to_label(": """static int to_label($real x, int labels)
{
    return x >= 0 && x < ($real)labels ? (int)x : -1;
}
""",
    "absolute(": """static $real absolute($real x)
{
    return $fabs(x);
}
""",
    "root(": """static $real root($real x)
{
    return $sqrt(x);
}
""",
    "lesser(": """static $real lesser($real x, $real y)
{
    return is_absent(x) || is_absent(y) ? ($real)NAN : x < y ? x : y;
}
""",
    "greater(": """static $real greater($real x, $real y)
{
    return is_absent(x) || is_absent(y) ? ($real)NAN : x > y ? x : y;
}
""",
    "or_rest(": """static $real or_rest($real x, $real rest)
{
    return is_absent(x - x) ? rest : x;
}
""",
}
"""Functions that a source contains if it calls them."""


class CCode:
    """A writer of the source."""

    def __init__(self, job: ExportJob, names: CNames, source: CSource) -> None:
        self.job, self.names, self.source = job, names, source
        self.hierarchy, self.single = job.hierarchy, job.single_precision
        self.real = "float" if self.single else "double"

    def write(self) -> str:
        """Write the source."""
        p = self.names.prefix
        body = "\n".join(self._body())
        functions = {"$real": self.real, "$fmod": "fmod", "$fabs": "fabs", "$sqrt": "sqrt"}
        if self.single:
            functions |= {"$fmod": "fmodf", "$fabs": "fabsf", "$sqrt": "sqrtf"}
        helpers = []
        for called, text in HELPERS.items():
            if f" {called}" in body or f"({called}" in body:
                for key, value in functions.items():
                    text = text.replace(key, value)
                helpers.append(text)
        check = (
            "" if self.single else f"typedef char {p}_needs_64_bit_double[sizeof(double) == 8 ? 1 : -1];\n"
        )
        return "\n".join([f"{self._begin()}{check}", *helpers, body]) + "\n"

    def _begin(self) -> str:
        p = self.names.prefix
        functions = f'#include "{p}_functions.h"\n' if self.hierarchy.functions_to_write else ""
        return f"""/* {write_comment(self.hierarchy.name)}, {GENERATED} */

#include "{p}.h"
{functions}
#ifdef __FAST_MATH__
#error "absent readings are NaN, which -ffast-math does not allow"
#endif

#define STAY (-1)
#define NO_TREE (-2)
#define is_absent(x) ((x) != (x))

#ifdef {p.upper()}_TRACE
#define ANSWER(number, outcome) do {{ m->leaf = (number); return (outcome); }} while (0)
#define BEFORE(number, state_before) \\
    const uint8_t level = m->traced++; \\
    m->trace[level].automaton = (number); \\
    m->trace[level].before = (int)(state_before)
#define AFTER(state_after) \\
    m->trace[level].leaf = m->leaf; \\
    m->trace[level].after = (int)(state_after)
#else
#define ANSWER(number, outcome) return (outcome)
#define BEFORE(number, state_before) ((void)0)
#define AFTER(state_after) ((void)0)
#endif
"""

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
