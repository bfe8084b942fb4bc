"""Features: named readings that transitions are decided on (paper section 3.1).

Most are data: a reading of the body, possibly of a target. `@feature` makes one from a function of readings.
`FlagFeature`, `CounterFeature`, `TimerFeature` and `TimeInState` read the automaton itself rather than the body.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib import import_module
from typing import Any, NamedTuple, Self, TypeAlias, cast

from understudy.errors import DefinitionError, UnderstudyError
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.kinds import BOOLEAN, Column, Continuous, Kind

ReadingKey: TypeAlias = tuple[str, str | None]
"""A reading and the target it is of, or None for a reading of the body itself."""

Percept: TypeAlias = Mapping[ReadingKey, Column]
"""One snapshot of a body: columns [N] by reading and target."""


class ReadingsView:
    """What a function sees of the robot or of one target: its readings as attributes, columns [N]."""

    __slots__ = ("_percept", "_target")

    def __init__(self, percept: Percept, target: str | None = None) -> None:
        self._percept, self._target = percept, target

    def __getattr__(self, reading: str) -> Column:
        try:
            return self._percept[reading, self._target]
        except KeyError:
            of = f"target {self._target!r}" if self._target else "the body"
            raise AttributeError(f"{of} has no reading {reading!r}") from None


def call_user_function(by: str, function: Callable[..., Any], readings: Sequence[ReadingsView]) -> Any:
    """What a function of somebody's own makes of readings; its failure becomes one paragraph that names it."""
    try:
        return function(*readings)
    except UnderstudyError:
        raise
    except Exception as error:
        raise DefinitionError(
            what=by,
            problem=f"its function failed: {type(error).__name__}: {error}",
            remedy="correct the function; what it is given are readings of the body, columns of floats",
        ) from error


class FunctionName(NamedTuple):
    """Where the function of a feature or behavior is found, which is sent to other processes by name."""

    module: str
    qualified: str

    def find(self) -> Any:
        """What has this name; the function itself where a decorator made a feature or behavior of it."""
        found: Any = import_module(self.module)
        for name in self.qualified.split("."):
            found = getattr(found, name)
        return getattr(found, "function", found)


class PartWithFunction:
    """A frozen value that may hold a function: copied as it is, and pickled with the function's name."""

    __slots__ = ()

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        values = {each.name: getattr(self, each.name) for each in fields(cast("Any", self))}
        if values["function"] is not None:
            values["function"] = self._name(values["function"])
        return _make_part, (type(self), values)

    def _name(self, function: Any) -> FunctionName:
        name = FunctionName(getattr(function, "__module__", ""), getattr(function, "__qualname__", ""))
        try:
            found = name.find()
        except (ImportError, AttributeError, ValueError):
            found = None
        if found is not function:
            raise DefinitionError(
                what=f"{type(self).__name__.lower()} {getattr(self, 'name', '')!r}",
                problem="another process cannot find its function",
                remedy="define it at the top level of a module",
            )
        return name


def _make_part(kind: type[PartWithFunction], values: dict[str, Any]) -> PartWithFunction:
    function = values["function"]
    found = function.find() if isinstance(function, FunctionName) else function
    return kind(**{**values, "function": found})


@dataclass(frozen=True, slots=True)
class Feature(PartWithFunction):
    """A feature of the body: `reading` of the target bound to parameter `of`, or a function of readings.

    A function takes the robot's Readings and one Readings per parameter, and returns a column [N]. `fresh` (0 or 1) is
    what it reads in the tick in which the automaton's state was entered: what of a coordinator's members' flags is
    left when a switch restarts the members. None: a switch changes nothing about it.
    """

    name: str
    kind: Kind
    reading: str | None = None
    of: str | None = None
    unit: str = ""
    doc: str = ""
    function: Callable[..., Column] | None = field(default=None, compare=False)
    parameters: tuple[str, ...] = ()
    fresh: float | None = None

    def __post_init__(self) -> None:
        if self.fresh not in (None, 0.0, 1.0):
            raise DefinitionError(
                what=f"feature {self.name!r}",
                problem=f"it is to read {self.fresh!r} after a switch",
                remedy="give 0 or 1, or None where a switch does not matter",
            )
        if not isinstance(self.kind, Kind):
            raise DefinitionError(
                what=f"feature {self.name!r}",
                problem=f"its kind is {self.kind!r}",
                remedy="give Continuous(), Toroidal(period) or Categorical(labels)",
            )
        if (self.reading is None) == (self.function is None):
            raise DefinitionError(
                what=f"feature {self.name!r}",
                problem="it needs exactly one of a reading and a function",
                remedy="name the body's reading, or decorate a function with @feature",
            )
        if self.of is not None:
            object.__setattr__(self, "parameters", (self.of,))


def feature(kind: Kind, *, unit: str = "") -> Callable[[Callable[..., Column]], Feature]:
    """Make a feature of a function: its name, its docstring, and a parameter for each argument after the first."""

    def build(function: Callable[..., Column]) -> Feature:
        _, *parameters = inspect.signature(function).parameters
        return Feature(
            function.__name__,
            kind,
            unit=unit,
            doc=inspect.cleandoc(function.__doc__ or ""),
            function=function,
            parameters=tuple(parameters),
        )

    return build


@dataclass(frozen=True, slots=True)
class FlagFeature:
    """Whether the automaton in the current state has raised this flag; a basic behavior raises none."""

    name: str
    kind: Kind = BOOLEAN
    unit: str = ""
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CounterFeature:
    """The value of one of the automaton's counters; 0 when the automaton starts."""

    name: str
    kind: Kind = Continuous()
    unit: str = ""
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimerFeature:
    """Seconds since one of the automaton's timers was set; absent when it never was."""

    name: str
    kind: Kind = Continuous()
    unit: str = "s"
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimeInState:
    """Seconds since the automaton entered its current state."""

    name: str = "time_in_state"
    kind: Kind = Continuous()
    unit: str = "s"
    parameters: tuple[str, ...] = ()


OwnFeature: TypeAlias = FlagFeature | CounterFeature | TimerFeature | TimeInState
AnyFeature: TypeAlias = Feature | OwnFeature


@dataclass(frozen=True, slots=True)
class BoundFeature:
    """A feature as an automaton uses it: with its parameters bound."""

    feature: AnyFeature
    binding: Binding = NOTHING_BOUND

    def __post_init__(self) -> None:
        if set(self.binding) != set(self.feature.parameters):
            raise DefinitionError(
                what=f"feature {self.feature.name!r}",
                problem=f"it binds {sorted(self.binding)}",
                remedy=f"bind exactly its parameters: {sorted(self.feature.parameters)}",
            )

    def __str__(self) -> str:
        return format_bound_name(self.feature.name, self.binding, self.feature.parameters)

    @property
    def kind(self) -> Kind:
        """The kind of its values."""
        return self.feature.kind

    @property
    def is_own(self) -> bool:
        """Whether it reads the automaton itself rather than the body."""
        return not isinstance(self.feature, Feature)
