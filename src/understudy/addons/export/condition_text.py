"""Text of routines, questions and expressions, for targets whose conditions look like those of C."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, isfinite

from understudy.addons.export.conformance import MS_PER_S
from understudy.addons.export.decisions import Answer, Branch, Continuation, Step, ValueCondition
from understudy.addons.export.expressions import Number
from understudy.addons.export.hierarchy import FeatureSource, GroundExpression, Hierarchy, SlotValue
from understudy.addons.export.single_precision import MOST_COUNT

INDENT = "    "

MOST_MS = 2**32
"""One more than the largest time, in ms, that an unsigned number of 32 bits holds."""
C_WORDS = ("&&", "||", "!", "1", "0")
PYTHON_WORDS = ("and", "or", "not ", "True", "False")
C_BLOCKS = ("if ({}) {{", "}} else if ({}) {{", "} else {", "}")
PYTHON_BLOCKS = ("if {}:", "elif {}:", "else:", "")


@dataclass(frozen=True, slots=True)
class Operand:
    """A value in exported code, as text.

    `sort` is "real" (a floating-point number, NaN if absent), "label" (an index), "flag" (a condition), "ms" or "count"
    (whole numbers). `present` is a condition that holds if the value is not absent; None if it always holds, or if
    comparisons with an absent value are false by themselves. `absent` is the condition that it is absent.
    """

    sort: str
    text: str
    absent: str = ""
    present: str | None = None


@dataclass(frozen=True, slots=True)
class Spelling:
    """The spelling of the parts of a condition in one programming language."""

    both: str  # "&&"
    either: str
    negate: str
    true: str
    false: str
    real: Callable[[float], str]
    whole: Callable[[int], str]
    count: Callable[[int], str]


class ExpressionText(ABC):
    """A writer of the expressions of a hierarchy in one programming language.

    `functions` has the names of the functions for operations that are no operators.
    """

    hierarchy: Hierarchy
    spelling: Spelling
    functions: Mapping[str, str]

    @abstractmethod
    def write_slot(self, slot: int) -> str:
        """Write a reading in an expression, as a number."""

    def write_choice(self, condition: str, yes: str, no: str) -> str:
        """Write an expression that is one of two."""
        return f"({condition} ? {yes} : {no})"

    def write_expression(self, expression: GroundExpression) -> str:
        """Write an expression of readings."""
        if isinstance(expression, Number):
            return f"({self.spelling.real(expression.value)})"
        if isinstance(expression, SlotValue):
            return self.write_slot(expression.slot)
        name, operands = expression.name, [self.write_expression(each) for each in expression.operands]
        if name in self.functions:
            return f"{self.functions[name]}({', '.join(operands)})"
        if name == "neg":
            return f"(-{operands[0]})"
        return self.write_choice(*operands) if name == "where" else f"({operands[0]} {name} {operands[1]})"


class RoutineText(ExpressionText):
    """A writer of the routines of trees in one programming language, beside their expressions.

    `blocks` are the lines of a chain of conditions: the first, the following ones, the last, and its end, if any.
    """

    blocks: tuple[str, str, str, str]

    @abstractmethod
    def write_operand(self, number: int, state: int | None, source: FeatureSource) -> Operand:
        """Write the value of a feature of an automaton, for the tree of a state; None is the tree of all states."""

    @abstractmethod
    def write_answer(self, answer: Answer) -> Sequence[str]:
        """Write the end of a routine."""

    @abstractmethod
    def write_call(self, routine: str) -> str:
        """Write that another routine goes on."""

    def write_step(
        self, step: Step, number: int, state: int | None, called: str, indent: int
    ) -> Iterator[str]:
        """Write what follows at a place of a tree; `called` begins the names of its routines."""
        pad = INDENT * indent
        if isinstance(step, Continuation):
            yield f"{pad}{self.write_call(f'{called}_{step.routine}')}"
        if isinstance(step, Answer):
            yield from (f"{pad}{line}" for line in self.write_answer(step))
        if not isinstance(step, Branch):
            return
        features = self.hierarchy.automata[number].features
        begin, following, last, end = self.blocks
        while isinstance(step, Branch):
            operand = self.write_operand(number, state, features[step.condition.feature])
            yield f"{pad}{begin.format(write_condition(step.condition, operand, self.spelling))}"
            yield from self.write_step(step.yes, number, state, called, indent + 1)
            begin, step = following, step.no
        yield f"{pad}{last}"
        yield from self.write_step(step, number, state, called, indent + 1)
        if end:
            yield f"{pad}{end}"


def write_condition(condition: ValueCondition, operand: Operand, spelling: Spelling) -> str:
    """Write a question about a value as a condition in a language."""
    comparison = condition.comparison
    if comparison == "absent":
        return operand.absent
    if operand.sort == "flag":
        if operand.text == spelling.false:
            return spelling.true if condition.low == 0.0 else spelling.false
        return f"{spelling.negate}({operand.text})" if condition.low == 0.0 else operand.text
    if comparison == "label":
        return f"{operand.text} == {int(condition.low)}"
    below_high, from_high = _compare(operand, condition.high, spelling)
    below_low, from_low = _compare(operand, condition.low, spelling)
    text = {
        "below": below_high,
        "from": from_low,
        "inside": f"{from_low} {spelling.both} {below_high}",
        "outside": f"{below_low} {spelling.either} {from_high}",
        "across": f"{from_low} {spelling.either} {below_high}",
        "between": f"{below_low} {spelling.both} {from_high}",
    }[comparison]
    if operand.present is None:
        return text
    return f"{operand.present} {spelling.both} ({text})"


def _compare(operand: Operand, cut: float, spelling: Spelling) -> tuple[str, str]:
    """Write that a value is below a cut, and that it is not (and not absent)."""
    if operand.sort == "real":
        literal = spelling.real(cut)
        return f"{operand.text} < {literal}", f"{operand.text} >= {literal}"
    least, most, write = (1, MOST_MS, spelling.whole)
    whole = round_up_to_ms(cut) if operand.sort == "ms" else cut
    if operand.sort == "count":
        least, most, write = 1 - MOST_COUNT, MOST_COUNT, spelling.count
        whole = ceil(cut) if isfinite(cut) else cut
    if whole < least:
        return spelling.false, spelling.true
    if whole >= most:
        return spelling.true, spelling.false
    return f"{operand.text} < {write(int(whole))}", f"{operand.text} >= {write(int(whole))}"


def round_up_to_ms(seconds: float) -> float:
    """Return the smallest whole number of ms that is not less than a time in s, as the interpreter compares them."""
    if not isfinite(seconds):
        return seconds
    ms = ceil(seconds * MS_PER_S)
    while (ms - 1) / MS_PER_S >= seconds:
        ms -= 1
    while ms / MS_PER_S < seconds:
        ms += 1
    return ms
