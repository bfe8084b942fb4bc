"""Translated functions computed in 32-bit floats throughout, as exported code of single precision computes them.

NumPy computes with a number of its own, such as `np.float64(0.1)` or `np.sqrt(2.0)`, in double precision even beside
readings that are 32-bit floats, so that the Python function itself is no reference for single precision.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.export.expressions import Expression, Number, ReadingValue, translate_function
from understudy.model.features import ReadingsView

Single: TypeAlias = NDArray[Any]

OPERATIONS: Mapping[str, Callable[..., Single]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "neg": np.negative,
    "abs": np.abs,
    "isnan": np.isnan,
    "sqrt": np.sqrt,
    "minimum": np.minimum,
    "maximum": np.maximum,
    "where": np.where,
}


def compute_in_single(function: Callable[..., Any], parameters: Sequence[str]) -> Callable[..., Any]:
    """Return a function that computes in 32-bit floats; the function itself if it cannot be translated."""
    translated = translate_function(function, parameters)
    if translated.problem:
        return function

    def computed(*views: ReadingsView) -> Any:
        by_owner = dict(zip((None, *parameters), views, strict=True))
        found = {name: _evaluate(each, by_owner) for name, each in translated.results.items()}
        return found[""] if set(found) == {""} else found

    return computed


def _evaluate(expression: Expression, views: Mapping[str | None, ReadingsView]) -> Single:
    if isinstance(expression, Number):
        return np.array([expression.value], np.float32)
    if isinstance(expression, ReadingValue):
        value: Single = getattr(views[expression.parameter], expression.reading)
        return value.astype(np.float32)
    return OPERATIONS[expression.name](*(_evaluate(each, views) for each in expression.operands))
