"""Inversion of a small matrix in compiled code of one thread.

Linear algebra libraries use several threads, which wait for each other on a busy machine.
"""

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import njit_entry

Floats = NDArray[np.float64]


@njit_entry()
def invert_matrix(matrix: Floats) -> Floats:
    """Invert a symmetric positive definite matrix [n, n] by Gauss-Jordan elimination without pivoting.

    Every number is computed in the same order on every machine, so results are reproducible.
    """
    n = len(matrix)
    swept, column = np.empty((n, n)), np.empty(n)
    for row in range(n):
        for at in range(n):
            swept[row, at] = matrix[row, at]
    for pivot in range(n):
        over = 1.0 / swept[pivot, pivot]
        for row in range(n):
            column[row] = swept[row, pivot]
            swept[row, pivot] = 0.0
        for at in range(n):
            swept[pivot, at] *= over
        swept[pivot, pivot] = over
        for row in range(n):
            factor = column[row]
            if row != pivot and factor != 0.0:
                for at in range(n):
                    swept[row, at] -= factor * swept[pivot, at]
    return swept
