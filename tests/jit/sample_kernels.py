"""Kernels for tests: one that can be compiled, one that cannot, and one that ends the process that compiles it."""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.jit.decorators import njit_entry, njit_inner


@njit_inner()
def add(a: float, b: float) -> float:
    """Add."""
    return a + b


@njit_entry()
def add_up(numbers: Any) -> float:
    """Add up an array of numbers."""
    total = 0.0
    for index in range(len(numbers)):
        total = add(total, numbers[index])
    return total


@njit_entry()
def double(number: float, mark: Any) -> float:
    """Double a number, with or without a mark."""
    return number + number if mark is None else 2.0 * number


double.generalize = lambda arguments: (arguments[0], True)


@njit_entry()
def name_type(numbers: Any) -> str:
    """Do what Numba cannot compile."""
    return type(numbers).__name__ + str(np.finfo)
