"""Kinds of feature values: continuous, toroidal (on a circle) and categorical (paper section 3.1).

Every value is one float. NaN means absent, in any kind; what comes out infinite is absent, too, once it is decided on.
A categorical value is the index of its label.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import isfinite, isnan, nan, tau
from typing import TYPE_CHECKING, TypeAlias

from understudy.errors import KindError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TAU = tau
"""The full circle in radians, 2π."""
ABSENT = nan
"""The value of an absent feature or reading: NaN."""
Column: TypeAlias = "NDArray[np.float64]"
"""An array of float64 values, one per agent; NaN where absent."""


LARGEST = 1.7976931348623157e308
"""The largest finite value. One beyond it, on either side, is infinite, and counts as absent."""


def clear_infinite(values: Column) -> Column:
    """Make infinite values absent.

    Parameters
    ----------
    values
        Values, any shape. NaN (absent) stays NaN.

    Returns
    -------
    Column
        The values, with NaN in place of infinity of either sign; the same array if none is infinite.
    """
    import numpy as np  # imported here, as in `Toroidal.wrap`

    infinite = np.isinf(values)
    return np.where(infinite, ABSENT, values) if infinite.any() else values


@dataclass(frozen=True, slots=True)
class Continuous:
    """The kind of values that lie on a line, such as distances."""

    def __str__(self) -> str:
        return "continuous"

    def check(self, value: float, *, where: str) -> float:
        """Refuse an infinite value.

        Parameters
        ----------
        value
            A number, or NaN for absent.
        where
            Where the value comes from, for the error message.

        Returns
        -------
        float
            The value, unchanged.

        Raises
        ------
        KindError
            If the value is infinite.
        """
        if not (isfinite(value) or isnan(value)):
            raise KindError(
                where=where, problem=f"{value} is not finite", remedy="give a number, or leave it absent"
            )
        return value


@dataclass(frozen=True, slots=True)
class Toroidal:
    """The kind of values that lie on a circle, such as angles; they are kept in [0, period).

    Parameters
    ----------
    period
        Length of the circle, in the unit of the values. Positive and finite; 2π by default, for angles in radians.

    Raises
    ------
    KindError
        If `period` is not positive and finite.
    """

    period: float = TAU

    def __post_init__(self) -> None:
        if not (self.period > 0 and isfinite(self.period)):
            raise KindError(
                where="toroidal kind",
                problem=f"its period is {self.period}",
                remedy="give a positive, finite period",
            )
        object.__setattr__(self, "period", float(self.period))  # as files spell it

    def __str__(self) -> str:
        return f"toroidal({self.period!r})"

    def wrap(self, values: Column) -> Column:
        """Wrap values onto the circle.

        Parameters
        ----------
        values
            Values, any shape. NaN (absent) stays NaN.

        Returns
        -------
        Column
            The values modulo the period, in [0, period).
        """
        import numpy as np  # imported here: a command that only reads a library starts 0.1 s sooner without NumPy

        wrapped: Column = np.mod(values, self.period)
        return np.where(wrapped >= self.period, 0.0, wrapped)  # mod rounds tiny negatives up to the period

    def check(self, value: float, *, where: str) -> float:
        """Refuse an infinite value, and wrap any other onto the circle.

        Parameters
        ----------
        value
            A number, or NaN for absent, which stays NaN.
        where
            Where the value comes from, for the error message.

        Returns
        -------
        float
            The value modulo the period, in [0, period).

        Raises
        ------
        KindError
            If the value is infinite.
        """
        if isnan(value):
            return value
        if not isfinite(value):
            raise KindError(
                where=where, problem=f"{value} is not finite", remedy="give a number, or leave it absent"
            )
        wrapped = value % self.period
        return 0.0 if wrapped >= self.period else wrapped


@dataclass(frozen=True, slots=True)
class Categorical:
    """The kind of values that are one of a few labels; a value is the index of its label.

    Parameters
    ----------
    labels
        The labels: at least one, all different, none empty, without "|" and without spaces around them.

    Raises
    ------
    KindError
        If the labels break one of these rules.
    """

    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        if isinstance(self.labels, str):
            raise KindError(
                where="categorical kind",
                problem=f"its labels are {self.labels!r}",
                remedy="give them as a tuple: Categorical(('no', 'yes'))",
            )
        if not self.labels or len(set(self.labels)) != len(self.labels) or not all(self.labels):
            raise KindError(
                where="categorical kind",
                problem=f"its labels are {list(self.labels)}",
                remedy="give at least one label, each of them once and none empty",
            )
        for label in self.labels:
            if "|" in label or label != label.strip():
                raise KindError(
                    where="categorical kind",
                    problem=f"{label!r} cannot be written to a table",
                    remedy="give labels without | and without spaces around them",
                )

    def __str__(self) -> str:
        return f"categorical({'|'.join(self.labels)})"

    def check(self, value: float, *, where: str) -> float:
        """Refuse a value that is not the index of a label.

        Parameters
        ----------
        value
            Index of a label, from 0, or NaN for absent.
        where
            Where the value comes from, for the error message.

        Returns
        -------
        float
            The value, unchanged.

        Raises
        ------
        KindError
            If the value is not the index of a label.
        """
        if isnan(value) or (0 <= value < len(self.labels) and value == int(value)):
            return value
        raise KindError(
            where=where,
            problem=f"{value} is not the index of a label",
            remedy=f"the labels are 0 to {len(self.labels) - 1}: {', '.join(self.labels)}",
        )


Kind: TypeAlias = Continuous | Toroidal | Categorical
"""The kind of a feature's values."""

BOOLEAN = Categorical(("no", "yes"))
"""The kind of yes-or-no values: 0 is "no", 1 is "yes"."""
NO, YES = 0.0, 1.0

KIND_SPELLED = re.compile(r"(continuous|boolean|toroidal|categorical)(?:\((.*)\))?", re.DOTALL)
"""The pattern of a kind as files write it."""


def parse_kind(text: str, *, where: str) -> Kind:
    """Parse a kind as files write it: continuous, boolean, toroidal(6.28) or categorical(no|yes).

    Refuse other text with a KindError that names `where`.
    """
    match = KIND_SPELLED.fullmatch(text.strip())
    name, inside = match.groups() if match else (None, None)
    if name == "continuous" and inside is None:
        return Continuous()
    if name == "boolean" and inside is None:
        return BOOLEAN
    if name == "toroidal":
        try:
            return Toroidal() if inside is None else Toroidal(float(inside))
        except ValueError:
            pass
    if name == "categorical" and inside is not None:
        return Categorical(tuple(inside.split("|")))
    raise KindError(
        where=where,
        problem=f"{text!r} is not a kind",
        remedy="write continuous, boolean, toroidal(PERIOD) or categorical(LABEL|LABEL|…)",
    )


def parse_value(text: str, kind: Kind, *, where: str) -> float:
    """Parse a feature value as tables write it: a number, a label, or an empty text if absent (NaN).

    Refuse other text with a KindError that names `where`.
    """
    text = text.strip()
    if not text:
        return ABSENT
    if isinstance(kind, Categorical):
        if text not in kind.labels:
            raise KindError(
                where=where,
                problem=f"{text!r} is not one of its labels",
                remedy=f"the labels are {', '.join(kind.labels)}",
            )
        return float(kind.labels.index(text))
    try:
        value = float("nan" if "_" in text else text)  # Python's own 1_000 is most likely a slip here
    except ValueError:
        value = nan
    if not isfinite(value):
        raise KindError(
            where=where, problem=f"{text!r} is not a number", remedy="give a number, or leave it empty"
        )
    return kind.check(value, where=where)
