"""Text of JavaScript for targets whose conditions are JavaScript: values, expressions and functions of a hierarchy.

It keeps to ECMAScript 5, as the ECMAScript data model of SCXML does.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from math import isinf

from understudy.addons.export.condition_text import (
    C_WORDS,
    ExpressionText,
    Operand,
    Spelling,
    write_condition,
)
from understudy.addons.export.decisions import ValueCondition
from understudy.addons.export.hierarchy import FeatureSource, Hierarchy
from understudy.addons.export.identifiers import make_identifiers
from understudy.addons.export.target_files import TEMPLATES
from understudy.model.behaviors import StateEffect
from understudy.model.value_kinds import Categorical, Toroidal

FAILED = "failed"
"""The state in which a statechart ends if a condition cannot be evaluated."""
FUNCTIONS = "javascript/functions.js"
"""The template of the functions that conditions call."""

JAVASCRIPT_FUNCTIONS = {
    "abs": "Math.abs",
    "isnan": "absent",
    "sqrt": "Math.sqrt",
    "minimum": "Math.min",
    "maximum": "Math.max",
}
"""The functions of operations in JavaScript."""


class JavaScriptText(ExpressionText):
    """A writer of JavaScript for one hierarchy.

    Conditions refer to `now`, `readings.NAME`, and `memory.AUTOMATON` with `entered`, `counters.NAME` and
    `timers.NAME`.
    """

    functions = JAVASCRIPT_FUNCTIONS

    def __init__(self, hierarchy: Hierarchy) -> None:
        self.hierarchy = hierarchy
        self.readings = make_identifiers([str(each) for each in hierarchy.readings], what="readings")
        self.channels = make_identifiers([each.name for each in hierarchy.channels], what="channels")
        self.automata = make_identifiers(
            [each.name for each in hierarchy.automata], what="automata", reserved=(FAILED,)
        )
        self.counters = [
            make_identifiers(each.counters, what=f"counters of {each.name!r}") for each in hierarchy.automata
        ]
        self.timers = [
            make_identifiers(each.timers, what=f"timers of {each.name!r}") for each in hierarchy.automata
        ]
        self.spelling = Spelling(*C_WORDS[:3], "true", "false", write_number, str, str)

    def condition(self, condition: ValueCondition, number: int, source: FeatureSource) -> str:
        """Write a question about a value of an automaton, by its index; not about a flag."""
        return write_condition(condition, self._operand(number, source), self.spelling)

    def _operand(self, number: int, source: FeatureSource) -> Operand:
        memory = self.memory(number)
        if source.sort == "counter":
            return Operand("real", f"{memory}.counters.{self._counter(number, source.index)}")
        if source.sort == "time in state":
            return Operand("real", f"elapsed(now, {memory}.entered)")
        if source.sort == "timer":
            text = f"elapsed(now, {memory}.timers.{self._timer(number, source.index)})"
            return Operand("real", text, f"absent({text})")
        text = f"value_{source.index}(readings)"
        if source.sort == "reading":
            text = self.write_slot(source.index)
        if source.fresh is not None:
            text = f"({memory}.entered === now ? {write_number(source.fresh)} : {text})"
        sort = "label" if isinstance(source.kind, Categorical) else "real"
        return Operand(sort, text, f"absent({text})")

    def memory(self, number: int) -> str:
        """Write what an automaton remembers: the time at which it entered its state, its counters and timers."""
        return f"memory.{self.automata[self.hierarchy.automata[number].name]}"

    def _counter(self, number: int, index: int) -> str:
        return self.counters[number][self.hierarchy.automata[number].counters[index]]

    def _timer(self, number: int, index: int) -> str:
        return self.timers[number][self.hierarchy.automata[number].timers[index]]

    def find_memory(self, number: int, effect: StateEffect) -> tuple[str, str]:
        """Return where a counter or timer is kept: "counters" or "timers", and its identifier."""
        memory = self.counters if effect.of == "counter" else self.timers
        return f"{effect.of}s", memory[number][effect.name]

    def write_slot(self, slot: int) -> str:
        """Write a reading."""
        return f"readings.{self.readings[str(self.hierarchy.readings[slot])]}"

    def commands(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the value of each channel, by its identifier, where a command sets some."""
        return {
            self.channels[each.name]: float(values.get(each.name, each.rest))
            for each in self.hierarchy.channels
        }

    def write_functions(self) -> Iterator[str]:
        """Write the functions that conditions and commands call, as lines."""
        yield from (TEMPLATES / FUNCTIONS).read_text(encoding="utf-8").splitlines()
        yield from ("", "function take(given) {", "  return {")
        yield from (f"    {name}: number(given.{name})," for name in self.readings.values())
        yield from ("  };", "}")
        for index in self.hierarchy.feature_functions:
            yield from self._value(index)
        for index, basic in enumerate(self.hierarchy.basics):
            if basic.is_function:
                yield from self._command(index)

    def _value(self, index: int) -> Iterator[str]:
        value = self.hierarchy.computed[index]
        yield from ("", f"// {_comment(value.name)}")
        if value.expression is None:
            yield self._refuse(f"feature {value.name}", f"value_{index}")
            text = "NaN"
        else:
            text = self.write_expression(value.expression)
            if isinstance(value.kind, Categorical):
                text = f"label({text}, {len(value.kind.labels)})"
            elif isinstance(value.kind, Toroidal):
                text = f"wrap({text}, {write_number(value.kind.period)})"
            else:
                text = f"finite({text}, NaN)"
        yield from (f"function value_{index}(readings) {{", f"  return {text};", "}")

    def _command(self, index: int) -> Iterator[str]:
        basic = self.hierarchy.basics[index]
        yield from ("", f"// {_comment(basic.name)}")
        if basic.problem:
            yield self._refuse(f"behavior {basic.name}", f"command_{index}")
        fields = []
        for channel in self.hierarchy.channels:
            usual = text = write_number(basic.command.get(channel.name, channel.rest))
            at = basic.computed.get(channel.name)
            expression = None if at is None else self.hierarchy.computed[at].expression
            if expression is not None:
                text = f"finite({self.write_expression(expression)}, {usual})"
            fields.append(f"{self.channels[channel.name]}: {text}")
        yield from (f"function command_{index}(readings) {{", f"  return {{{', '.join(fields)}}};", "}")

    def _refuse(self, name: str, called: str) -> str:
        """Write a statement that keeps the code from being loaded until a function is written."""
        function = next(each for each in self.hierarchy.functions_to_write if each.name == name)
        return f"throw new Error({json.dumps(function.refuse(f'write {called} and remove this line'))});"


def write_number(value: float) -> str:
    """Write a number so that JavaScript reads the same double."""
    if isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _comment(text: str) -> str:
    return " ".join(text.encode("ascii", "replace").decode().split())
