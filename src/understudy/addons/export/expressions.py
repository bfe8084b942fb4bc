"""Translation of Python functions of features and behaviors into expressions that every export target can write.

Only simple arithmetic on readings is translated; `docs/exporting.md` lists what that is. Anything else is refused with
the reason, so that an export says what is missing instead of computing something else.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from operator import add, mul, sub, truediv
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

from understudy.model.reading_pairs import PairedReading, PairSide, ReadingPair

ARITHMETIC: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARED: Mapping[type[ast.cmpop], str] = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}
COMPARISONS = tuple(COMPARED.values())
FUNCTIONS: Mapping[str, tuple[str, int]] = {
    "abs": ("abs", 1),
    "absolute": ("abs", 1),
    "sqrt": ("sqrt", 1),
    "minimum": ("minimum", 2),
    "maximum": ("maximum", 2),
    "where": ("where", 3),
    "isnan": ("isnan", 1),
}
"""NumPy's functions that are translated: the operation and the number of its operands."""


@dataclass(frozen=True, slots=True)
class Number:
    """A constant of an expression.

    Python computes two constants in 32-bit floats if one `is_single`, a float32 of NumPy; that is not translated.
    """

    value: float
    is_single: bool = False


@dataclass(frozen=True, slots=True)
class ReadingValue:
    """A reading in an expression; `parameter` is the argument whose target it is about, None for the robot itself."""

    reading: str
    parameter: str | None


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation on expressions: one of ARITHMETIC, COMPARISONS or FUNCTIONS, by name."""

    name: str
    operands: tuple[Expression, ...]

    @property
    def is_condition(self) -> bool:
        """True if the result is true or false instead of a number."""
        return self.name in COMPARISONS or self.name == "isnan"


Expression: TypeAlias = Number | ReadingValue | Operation


class NotTranslatable(Exception):
    """A part of a function that is no simple arithmetic; the message says which."""


@dataclass(frozen=True, slots=True)
class TranslatedFunction:
    """The translation of a Python function: its expressions, or why there are none, and the readings that it uses.

    `results` has the expression of a feature under "", and those of a behavior by channel. It is empty if `problem`
    says why the function cannot be translated. `readings` are pairs of a reading and the parameter, or None.
    """

    results: Mapping[str, Expression]
    readings: tuple[tuple[str, str | None], ...]
    problem: str = ""


def translate_function(function: Callable[..., Any], parameters: Sequence[str]) -> TranslatedFunction:
    """Translate the function of a feature or behavior; `parameters` are its arguments after the robot."""
    if isinstance(function, ReadingPair):
        looked = tuple((each.reading, each.of) for each in function.readings)
        return TranslatedFunction({"": _translate_side(function)}, tuple(dict.fromkeys(looked)))
    if hasattr(function, "__wrapped__"):  # its source text is that of the inner function
        return TranslatedFunction({}, (), "it is wrapped in another function")
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return TranslatedFunction({}, (), "its source text is not available")
    statement = tree.body[0]
    if not isinstance(statement, ast.FunctionDef):
        return TranslatedFunction({}, (), "it is not a plain function")
    arguments = [each.arg for each in statement.args.args]
    owners = dict(zip(arguments, (None, *parameters), strict=False))
    looked = tuple(
        dict.fromkeys(
            (each.attr, owners[each.value.id])
            for each in ast.walk(statement)
            if isinstance(each, ast.Attribute)
            and isinstance(each.value, ast.Name)
            and each.value.id in owners
        )
    )
    try:
        return TranslatedFunction(_Translator(function, owners).translate_body(statement.body), looked)
    except NotTranslatable as problem:
        return TranslatedFunction({}, looked, str(problem))


def _translate_side(side: PairSide) -> Expression:
    """Translate a pair of readings, or one of its sides."""
    if isinstance(side, PairedReading):
        return ReadingValue(side.reading, side.of)
    return Operation(side.operation.sign, (_translate_side(side.left), _translate_side(side.right)))


class _Translator:
    def __init__(self, function: Callable[..., Any], owners: Mapping[str, str | None]) -> None:
        code = getattr(function, "__code__", None)
        hidden = () if code is None else (*code.co_freevars, *code.co_varnames)
        self.globals: Mapping[str, Any] = {
            name: value for name, value in getattr(function, "__globals__", {}).items() if name not in hidden
        }
        self.owners = owners
        self.locals: dict[str, Expression] = {}

    def translate_body(self, body: Sequence[ast.stmt]) -> Mapping[str, Expression]:
        for statement in body:
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                continue  # a docstring
            if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
                target = statement.targets[0]
                if isinstance(target, ast.Name) and target.id not in self.owners:
                    self.locals[target.id] = self.translate(statement.value)
                    continue
            if isinstance(statement, ast.Return) and statement.value is not None:
                return self._results(statement.value)
            raise _refuse(statement)
        raise NotTranslatable("it returns nothing")

    def _results(self, value: ast.expr) -> Mapping[str, Expression]:
        if not isinstance(value, ast.Dict):
            return {"": self.translate(value)}
        results: dict[str, Expression] = {}
        for key, each in zip(value.keys, value.values, strict=True):
            if not (isinstance(key, ast.Constant) and isinstance(key.value, str)):
                raise _refuse(value)
            results[key.value] = self.translate(each)
        return results

    def translate(self, node: ast.expr) -> Expression:
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inner = self.number(node.operand)
            return (
                Number(-inner.value, inner.is_single)
                if isinstance(inner, Number)
                else Operation("neg", (inner,))
            )
        if isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
            return _combine(node, self.number(node.left), self.number(node.right))
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARED:
            sides = self.number(node.left), self.number(node.comparators[0])
            _check_single(node, *sides)
            return Operation(COMPARED[type(node.ops[0])], sides)
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, ast.Name) and node.id in self.locals:
            return self.locals[node.id]
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id in self.owners
        ):
            return ReadingValue(node.attr, self.owners[node.value.id])
        return self._constant(node)

    def number(self, node: ast.expr) -> Expression:
        expression = self.translate(node)
        if isinstance(expression, Operation) and expression.is_condition:
            raise _refuse(node)
        return expression

    def _call(self, node: ast.Call) -> Expression:
        name = self._function_name(node.func)
        if name not in FUNCTIONS or node.keywords or len(node.args) != FUNCTIONS[name][1]:
            raise _refuse(node)
        operation, _ = FUNCTIONS[name]
        if operation != "where":
            operands = tuple(self.number(each) for each in node.args)
            _check_single(node, *operands)
            return Operation(operation, operands)
        condition = self.translate(node.args[0])
        if not (isinstance(condition, Operation) and condition.is_condition):
            raise _refuse(node)
        chosen = tuple(self.number(each) for each in node.args[1:])
        _check_single(node, *chosen)
        return Operation("where", (condition, *chosen))

    def _function_name(self, node: ast.expr) -> str:
        if isinstance(node, ast.Name) and node.id == "abs" and "abs" not in self.globals:
            return "abs"
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = self.globals.get(node.value.id)
            if isinstance(module, ModuleType) and module.__name__ == "numpy":
                return node.attr
        return ""

    def _constant(self, node: ast.expr) -> Number:
        value: Any = None
        if isinstance(node, ast.Constant):
            value = node.value
        elif isinstance(node, ast.Name) and node.id not in self.owners:
            value = self.globals.get(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = self.globals.get(node.value.id)
            value = getattr(module, node.attr, None) if isinstance(module, ModuleType) else None
        is_single = isinstance(value, np.float32)
        if isinstance(value, bool) or not (is_single or isinstance(value, int | float)):
            raise _refuse(node)
        if not isfinite(value):
            raise _refuse(node)
        return Number(float(value), is_single)


def _check_single(node: ast.expr, *operands: Expression) -> None:
    """Refuse constants of which one is a float32, with which Python would compute in single precision."""
    constants = [each for each in operands if isinstance(each, Number)]
    if len(constants) == len(operands) and any(each.is_single for each in constants):
        raise _refuse(node)


def _combine(node: ast.BinOp, left: Expression, right: Expression) -> Expression:
    """Combine two expressions; two constants become one, in double precision as Python computes them."""
    name = ARITHMETIC[type(node.op)]
    _check_single(node, left, right)
    if not (isinstance(left, Number) and isinstance(right, Number)):
        return Operation(name, (left, right))
    compute = {"+": add, "-": sub, "*": mul, "/": truediv}[name]
    try:
        value = compute(left.value, right.value)
    except ZeroDivisionError:
        raise _refuse(node) from None
    if not isfinite(value):
        raise _refuse(node)
    return Number(value)


def _refuse(node: ast.AST) -> NotTranslatable:
    text = " ".join(ast.unparse(node).split())
    return NotTranslatable(f"{text[:60]!r} is not simple arithmetic on readings")
