"""Units of thresholds in conditions."""

from __future__ import annotations

from math import pi

from understudy.errors import SettingError, join_names

FACTORS = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "°": pi / 180.0, "deg": pi / 180.0},
    "m/s": {"m/s": 1.0, "cm/s": 0.01},
    "rad/s": {"rad/s": 1.0, "°/s": pi / 180.0, "deg/s": pi / 180.0},
}
"""By the unit of a reading, the number of it in each unit that a threshold can have."""


def convert_threshold(number: float, unit: str, *, of: str, to: str) -> float:
    """Convert a threshold to the unit of what it is compared with.

    Parameters
    ----------
    number
        The threshold.
    unit
        Its unit, as written; empty without one.
    of
        The words for what it is compared with, for errors.
    to
        The unit of that; empty if it has none.

    Returns
    -------
    float
        The threshold in the unit `to`.

    Raises
    ------
    SettingError
        If the unit is missing, does not fit, or is needless.
    """
    known = FACTORS.get(to, {to: 1.0} if to else {"": 1.0})
    if unit in known:
        return number * known[unit]
    written = f"{number:g}{'' if unit == '°' else ' '}{unit}" if unit else f"{number:g}"
    in_one_of = f"write it in {join_names(known, word='or')}"
    if not to:
        problem, remedy = f"{written!r} has a unit, but {of} has none", f"write {number:g}"
    elif not unit:
        problem = f"{written!r} has no unit, but {of} is in {to}"
        remedy = f"write {_join(number, to)}" if len(known) == 1 else in_one_of
    else:
        problem, remedy = f"{written!r} does not fit: {of} is in {to}", in_one_of
    raise SettingError(where="condition", setting="threshold", problem=problem, remedy=remedy)


def _join(number: float, unit: str) -> str:
    return f"{number:g} {unit}"
