"""Spaces of Gymnasium as lists of numbers: those of an observation become readings, those of an action channels."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, prod
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space, spaces
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Continuous, Kind

MOST_NUMBERS = 256
"""The largest number of numbers in an observation or action; more are an image or a scan, unusable as readings."""

Place: TypeAlias = tuple[str | int, ...]
"""The keys and positions that lead to a part of a nested observation or action."""


@dataclass(frozen=True, slots=True)
class SpaceNumber:
    """One number of a space: its name, kind and limits. `whole` numbers are those of a Discrete space, say."""

    name: str
    kind: Kind
    least: float = -inf
    most: float = inf
    whole: bool = False


@dataclass(frozen=True, slots=True)
class _Part:
    """A part of a space that is not nested: its numbers are `first` and the following ones."""

    place: Place
    space: Any
    first: int
    count: int
    offset: NDArray[np.float64]
    """The number subtracted from observed numbers: the first value of a Discrete space."""


class SpaceNumbers:
    """The numbers of a space in order, with the conversion of its elements from and to columns of numbers.

    Parameters
    ----------
    space
        Box, Discrete, MultiDiscrete or MultiBinary, or a Dict or Tuple of these, nested to any depth.
    prefix
        Name of a number on its own, and the beginning of names where the space has none: obs_0, obs_1.
    where
        The environment, for error messages.

    Raises
    ------
    SettingError
        If the space is of another class, or has more than 256 numbers.
    """

    def __init__(self, space: Space[Any], *, prefix: str, where: str) -> None:
        self._space, self._where = space, where
        self.numbers: list[SpaceNumber] = []
        self._parts: list[_Part] = []
        for place, part in self._walk(space, ()):
            self._add(place, part, prefix)
        if not self.numbers:
            raise self._wrong(space, "has no numbers", "wrap the environment so that it has at least one")

    def _walk(self, space: Any, place: Place) -> Iterator[tuple[Place, Any]]:
        if isinstance(space, spaces.Dict):
            for key, inside in space.spaces.items():
                yield from self._walk(inside, (*place, key))
        elif isinstance(space, spaces.Tuple):
            for index, inside in enumerate(space.spaces):
                yield from self._walk(inside, (*place, index))
        elif isinstance(space, spaces.Box | spaces.Discrete | spaces.MultiDiscrete | spaces.MultiBinary):
            yield place, space
        else:
            supported = "Box, Discrete, MultiDiscrete, MultiBinary, Dict and Tuple"
            remedy = f"wrap the environment so that its spaces are of {supported} (gymnasium.wrappers)"
            raise self._wrong(
                space,
                f"is a {type(space).__name__}, which is no list of numbers{_format_place(place)}",
                remedy,
            )

    def _add(self, place: Place, space: Any, prefix: str) -> None:
        shape = tuple(space.shape or ())
        count = prod(shape)
        if len(self.numbers) + count > MOST_NUMBERS:
            problem = f"has more than {MOST_NUMBERS} numbers: shape {shape}{_format_place(place)}"
            remedy = "wrap the environment so that it gives fewer (gymnasium.wrappers.TransformObservation)"
            raise self._wrong(space, problem, remedy)
        names = list(_list_names(place, shape, prefix))
        least, most, kinds = _list_limits(space, count)
        whole = not isinstance(space, spaces.Box) or np.issubdtype(space.dtype, np.integer)
        offset = np.asarray(getattr(space, "start", 0), np.float64).reshape(-1)
        self._parts.append(_Part(place, space, len(self.numbers), count, np.broadcast_to(offset, (count,))))
        self.numbers += [
            SpaceNumber(*row, whole=bool(whole)) for row in zip(names, kinds, least, most, strict=True)
        ]

    def flatten(self, element: Any) -> Column:
        """Return the numbers of an element; NaN where one is infinite. Labels are counted from 0."""
        flat = np.empty(len(self.numbers))
        for part in self._parts:
            value = element
            for key in part.place:
                value = value[key]
            numbers = np.asarray(value, np.float64).reshape(-1)
            if len(numbers) != part.count:
                problem = f"has {len(numbers)} numbers instead of {part.count}{_format_place(part.place)}"
                raise self._wrong(
                    part.space, problem, "correct the environment, so that it keeps to its space"
                )
            flat[part.first : part.first + part.count] = numbers - part.offset
        flat[np.isinf(flat)] = np.nan
        return flat

    def unflatten(self, numbers: Column) -> Any:
        """Return the element of these numbers, which are as the space has them: labels count from its first."""
        values = [
            _make_value(part.space, numbers[part.first : part.first + part.count]) for part in self._parts
        ]
        return self._nest(self._space, iter(values))

    def _nest(self, space: Any, values: Iterator[Any]) -> Any:
        if isinstance(space, spaces.Dict):
            return {key: self._nest(inside, values) for key, inside in space.spaces.items()}
        if isinstance(space, spaces.Tuple):
            return tuple(self._nest(inside, values) for inside in space.spaces)
        return next(values)

    def _wrong(self, space: Any, problem: str, remedy: str) -> SettingError:
        return SettingError(where=self._where, setting=f"space {space!r:.80}", problem=problem, remedy=remedy)


def _list_limits(space: Any, count: int) -> tuple[list[float], list[float], list[Kind]]:
    """Return the least and greatest value and the kind of each number of a space that is not nested."""
    if isinstance(space, spaces.Box):
        low, high = (np.asarray(limit, np.float64).reshape(-1).tolist() for limit in (space.low, space.high))
        return low, high, [BOOLEAN if space.dtype == np.bool_ else Continuous()] * count
    if isinstance(space, spaces.MultiBinary):
        return [0.0] * count, [1.0] * count, [BOOLEAN] * count
    one = isinstance(space, spaces.Discrete)
    sizes = np.reshape(space.n if one else space.nvec, -1).tolist()
    starts = np.broadcast_to(np.reshape(getattr(space, "start", 0), -1), (count,)).tolist()
    pairs = list(zip(starts, sizes, strict=True))
    kinds: list[Kind] = [
        Categorical(tuple(str(each) for each in range(start, start + size))) for start, size in pairs
    ]
    return [float(start) for start, _ in pairs], [float(start + size - 1) for start, size in pairs], kinds


def _make_value(space: Any, numbers: Column) -> Any:
    if isinstance(space, spaces.Discrete):
        return space.dtype.type(numbers[0])
    return numbers.reshape(space.shape).astype(space.dtype)


def _list_names(place: Place, shape: tuple[int, ...], prefix: str) -> Iterator[str]:
    """Name the numbers of a part: position.0 in a Dict, obs_0 elsewhere."""
    keys = [re.sub(r"[^\w]", "_", str(key)) for key in place]
    if not keys or isinstance(place[0], int):
        keys = ["_".join((prefix, *keys[:1])), *keys[1:]]
    joint = "." if place else "_"
    for index in np.ndindex(*shape):
        yield joint.join((".".join(keys), *map(str, index)))


def _format_place(place: Place) -> str:
    return f" at {'.'.join(map(str, place))}" if place else ""


def rename_numbers(
    numbers: Sequence[SpaceNumber], names: Sequence[str] | Mapping[str, str] | None, *, where: str
) -> list[str]:
    """Return the names of numbers: their own, or those given in order or by their own name."""
    own = [number.name for number in numbers]
    if names is None:
        return own
    if isinstance(names, Mapping):
        unknown = [name for name in names if name not in own]
        renamed = [names.get(name, name) for name in own]
        problem = f"rename {unknown[0]!r}, which is not there" if unknown else ""
    else:
        renamed = list(names)
        problem = "" if len(renamed) == len(own) else f"are {len(renamed)} for {len(own)} numbers"
    if not problem and len(set(renamed)) != len(renamed):
        problem = "are not all different"
    if problem:
        remedy = f"give one for each of {', '.join(own)}"
        raise SettingError(where=where, setting="names", problem=problem, remedy=remedy)
    return renamed
