"""Quotients and differences of two readings, which are data: they can be stored, exported and read.

A pair takes the place of a feature's Python function. Each of its two sides is a reading, or another pair, as in
(x_ahead - x) / speed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, TypeAlias

from understudy.errors import DefinitionError
from understudy.model.value_kinds import Column, Continuous, Kind, Toroidal

if TYPE_CHECKING:
    from understudy.model.features import ReadingsView


DEEPEST = 3
"""The largest number of pairs within each other, that of ((a - b) / c) - d."""


class PairOperation(StrEnum):
    """Whether a pair is the quotient or the difference of its sides."""

    QUOTIENT = "quotient"
    DIFFERENCE = "difference"

    @property
    def sign(self) -> str:
        """The sign between the two sides: "/" or "-"."""
        return "/" if self is PairOperation.QUOTIENT else "-"


@dataclass(frozen=True, slots=True)
class PairedReading:
    """A reading as one side of a pair.

    Parameters
    ----------
    reading
        Name of the body's reading.
    of
        Name of the parameter whose target it is about. None: it is about the body itself.
    name
        Name by which people know it: that of the kit's feature. Empty: that of the reading.
    """

    reading: str
    of: str | None = None
    name: str = ""

    def format(self, binding: Mapping[str, str]) -> str:
        """Format it with the target of its parameter: "range(ball)"."""
        name = self.name or self.reading
        return name if self.of is None else f"{name}({binding.get(self.of, self.of)})"


@dataclass(frozen=True, slots=True)
class ReadingPair:
    """The quotient or the difference of two readings, as the function of a feature.

    It is absent (NaN) where a side is absent, and a quotient also where its divisor is 0.

    Parameters
    ----------
    operation
        Which of the two it is.
    left
        The dividend, or what is subtracted from.
    right
        The divisor, or what is subtracted.

    Raises
    ------
    DefinitionError
        If more than three pairs are within each other.
    """

    operation: PairOperation
    left: PairSide
    right: PairSide

    def __post_init__(self) -> None:
        if self.depth > DEEPEST:
            raise refuse_pair(str(self), f"more than {DEEPEST} pairs are within each other")

    @property
    def depth(self) -> int:
        """The number of pairs within each other: 1 if both sides are readings."""
        return 1 + max(each.depth if isinstance(each, ReadingPair) else 0 for each in (self.left, self.right))

    def __str__(self) -> str:
        return self.format({})

    def __call__(self, robot: ReadingsView, *targets: ReadingsView) -> Column:
        """Compute its values [N] from the readings of the robot, and of the target of each of `parameters`."""
        return self._compute(dict(zip((None, *self.parameters), (robot, *targets), strict=True)))

    def _compute(self, views: Mapping[str | None, ReadingsView]) -> Column:
        import numpy as np  # imported here, so that documents can be read without it

        left, right = (
            each._compute(views) if isinstance(each, ReadingPair) else getattr(views[each.of], each.reading)
            for each in (self.left, self.right)
        )
        if self.operation is PairOperation.DIFFERENCE:
            return np.asarray(left - right)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            quotient = left / right
        return np.where(np.isfinite(quotient), quotient, np.nan)

    @property
    def readings(self) -> tuple[PairedReading, ...]:
        """The readings that it is computed from, each once, from left to right."""
        return tuple(dict.fromkeys(self._list_readings()))

    def _list_readings(self) -> Iterator[PairedReading]:
        for side in (self.left, self.right):
            if isinstance(side, ReadingPair):
                yield from side._list_readings()
            else:
                yield side

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters whose targets its readings are about, each once, from left to right."""
        return tuple(dict.fromkeys(each.of for each in self.readings if each.of is not None))

    def format(self, binding: Mapping[str, str]) -> str:
        """Format it with the targets of its parameters: "range(ball) / speed"."""
        return f"{_format_side(self.left, binding)} {self.operation.sign} {_format_side(self.right, binding)}"

    @property
    def sentence(self) -> str:
        """What it is, in words."""
        verb = "divided by" if self.operation is PairOperation.QUOTIENT else "less"
        return f"{_format_side(self.left, {})} {verb} {_format_side(self.right, {})}."


def _format_side(side: PairSide, binding: Mapping[str, str]) -> str:
    return f"({side.format(binding)})" if isinstance(side, ReadingPair) else side.format(binding)


PairSide: TypeAlias = PairedReading | ReadingPair
"""One side of a pair."""


def find_pair_kind(operation: PairOperation, left: Kind, right: Kind) -> Kind | None:
    """Find the kind of a pair of values of two kinds; None if there is no such pair.

    Parameters
    ----------
    operation
        Quotient or difference.
    left
        Kind of the dividend, or of what is subtracted from.
    right
        Kind of the divisor, or of what is subtracted.

    Returns
    -------
    Kind or None
        Quotients and differences of continuous values are continuous. The difference of two angles of the same period
        is an angle again. Angles have no quotients, and labels neither.
    """
    if isinstance(left, Continuous) and isinstance(right, Continuous):
        return left
    if operation is PairOperation.DIFFERENCE and isinstance(left, Toroidal) and left == right:
        return left
    return None


_FACTOR = re.compile(r"([^\s/*·^()\d²³⁻]+)(?:\^?(-?\d+|[²³]))?")
_RAISED = {"²": 2, "³": 3}


def divide_units(left: str, right: str) -> str:
    """Divide units: "m" by "m/s" is "s", and equal units give none.

    Parameters
    ----------
    left
        Unit of the dividend, such as "m", "m/s^2" or "rad/s". Empty: none.
    right
        Unit of the divisor.

    Returns
    -------
    str
        Unit of the quotient. A unit that is not made of names, "/", "*" and powers stays whole, in parentheses.
    """
    powers = _parse_unit(left)
    for name, power in _parse_unit(right).items():
        powers[name] = powers.get(name, 0) - power
    above = [_format_power(name, power) for name, power in powers.items() if power > 0]
    below = [_format_power(name, -power) for name, power in powers.items() if power < 0]
    text = "*".join(above)
    if not below:
        return text
    divisor = below[0] if len(below) == 1 else f"({'*'.join(below)})"
    return f"{text or '1'}/{divisor}"


def _parse_unit(unit: str) -> dict[str, int]:
    """Return the power of each name in a unit."""
    powers: dict[str, int] = {}
    above, *below = unit.strip().split("/")
    if len(below) > 1:
        return {f"({unit})": 1}
    for side, sign in ((above, 1), (below[0].strip("()") if below else "", -1)):
        for factor in filter(None, re.split(r"[*·\s]+", side)):
            if factor == "1":
                continue
            match = _FACTOR.fullmatch(factor)
            if match is None:
                return {f"({unit})": 1}
            power = match[2] or "1"
            powers[match[1]] = powers.get(match[1], 0) + sign * (_RAISED.get(power) or int(power))
    return powers


def _format_power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


def pair_units(operation: PairOperation, left: str, right: str) -> str | None:
    """Return the unit of a pair; None for a difference of different units, which has none.

    Parameters
    ----------
    operation
        Quotient or difference.
    left
        Unit of the dividend, or of what is subtracted from. Empty: none.
    right
        Unit of the divisor, or of what is subtracted.

    Returns
    -------
    str or None
        The unit.
    """
    if operation is PairOperation.QUOTIENT:
        return divide_units(left, right)
    return left if left == right else None


def refuse_pair(text: str, problem: str) -> DefinitionError:
    """Make the error about a pair that is none; `text` is what was given."""
    return DefinitionError(
        what=f"feature {text!r}",
        problem=problem,
        remedy="divide numbers, or subtract numbers of the same unit or angles: 'gap / speed', 'heading - course'",
    )
