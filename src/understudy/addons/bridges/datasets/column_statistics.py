"""Statistics of columns with which LeRobot normalizes what its policies see."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}


def summarize_columns(values: NDArray[np.generic]) -> Mapping[str, list[float] | list[int]]:
    """Summarize each column of an array.

    Parameters
    ----------
    values
        Numbers or booleans, shape [T] or [T, n]. NaN (absent) and infinite values are left out; a column without
        other values has zeros.

    Returns
    -------
    Mapping
        Lists with one number per column: `min`, `max`, `mean`, `std` and the quantiles `q01`, `q10`, `q50`, `q90` and
        `q99`. `count` is a list of one number, T.
    """
    columns = np.asarray(values, dtype=np.float64).reshape(len(values), -1).T
    present = [column[np.isfinite(column)] for column in columns]
    present = [column if len(column) else np.zeros(1) for column in present]
    with np.errstate(over="ignore", invalid="ignore"):  # sums of the largest numbers; JSON has no infinity
        quantiles = [np.quantile(column, list(QUANTILES.values())) for column in present]
        computed = {
            "min": [column.min() for column in present],
            "max": [column.max() for column in present],
            "mean": [column.mean() for column in present],
            "std": [column.std() for column in present],
            **{name: [each[number] for each in quantiles] for number, name in enumerate(QUANTILES)},
        }
    return {"count": [len(values)]} | {
        name: [float(np.nan_to_num(number)) for number in numbers] for name, numbers in computed.items()
    }
