"""Text of questions about values, for targets whose comparisons look like those of C."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, isfinite

from understudy.export.conformance import MS_PER_S
from understudy.export.decisions import ValueCondition
from understudy.export.single_precision import MOST_COUNT

MOST_MS = 2**32
"""One more than the largest time, in ms, that an unsigned number of 32 bits holds."""


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


C_WORDS = ("&&", "||", "!", "1", "0")
PYTHON_WORDS = ("and", "or", "not ", "True", "False")


def write_operation(name: str, operands: Sequence[str], functions: Mapping[str, str]) -> str:
    """Write an operation of a translated function in a language with the operators of C.

    Parameters
    ----------
    name
        The operation: an operator, `neg`, `where`, or one of `functions`.
    operands
        The text of each operand.
    functions
        The names of the functions for the other operations.

    Returns
    -------
    str
        The expression.
    """
    if name in ("+", "-", "*", "/", "<", "<=", ">", ">="):
        return f"({operands[0]} {name} {operands[1]})"
    if name == "neg":
        return f"(-{operands[0]})"
    if name == "where":
        return f"({operands[0]} ? {operands[1]} : {operands[2]})"
    return f"{functions[name]}({', '.join(operands)})"


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
    found = ceil(seconds * MS_PER_S)
    while (found - 1) / MS_PER_S >= seconds:
        found -= 1
    while found / MS_PER_S < seconds:
        found += 1
    return found
