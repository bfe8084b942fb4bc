"""Features: the named values that transition functions use to decide (paper section 3.1).

Most are a reading of the body, possibly about a target. `@feature` makes one from a function of readings, and
`pair_features` one that is the quotient or the difference of two others.
`FlagFeature`, `CounterFeature`, `TimerFeature` and `TimeInState` depend on the automaton itself, not on the body.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib import import_module
from typing import Any, NamedTuple, Self, TypeAlias, cast

from understudy.errors import DefinitionError, UnderstudyError
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.reading_pairs import (
    PairedReading,
    PairOperation,
    PairSide,
    ReadingPair,
    find_pair_kind,
    pair_units,
    refuse_pair,
)
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Kind, clear_infinite

ReadingKey: TypeAlias = tuple[str, str | None]
"""The name of a reading and the name of the target it is about, or None for a reading of the body itself."""

Percept: TypeAlias = Mapping[ReadingKey, Column]
"""All readings of N bodies at one moment: an array of shape [N] by reading and target."""


def format_reading_label(key: ReadingKey) -> str:
    """Format a reading with its target: "range", "range(station)"."""
    name, target = key
    return name if target is None else f"{name}({target})"


def parse_reading_label(label: str) -> ReadingKey:
    """Return the name and the target of a reading from its label, such as "range(station)"."""
    name, opened, rest = label.partition("(")
    target = rest.removesuffix(")")
    if not (name and opened and target) or target == rest or ")" in target:
        return label, None
    return name, target


class ReadingsView:
    """The readings of the robot, or those about one target, as attributes: `robot.heading` is an array of shape [N].

    What is absent is NaN, also where the body gave an infinite number.
    A feature's or behavior's own function takes these as arguments.
    """

    __slots__ = ("_percept", "_target")

    def __init__(self, percept: Percept, target: str | None = None) -> None:
        self._percept, self._target = percept, target

    def __getattr__(self, reading: str) -> Column:
        try:
            return clear_infinite(self._percept[reading, self._target])
        except KeyError:
            of = f"target {self._target!r}" if self._target else "the body"
            raise AttributeError(f"{of} has no reading {reading!r}") from None


def call_user_function(by: str, function: Callable[..., Any], readings: Sequence[ReadingsView]) -> Any:
    """Call a user's function with readings, and turn its failure into a DefinitionError that names `by`.

    Errors that are UnderstudyErrors already are passed on unchanged.
    """
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
    """The module and qualified name of a feature's or behavior's function, by which other processes import it."""

    module: str
    qualified: str

    def find(self) -> Any:
        """Import the function with this name, and unwrap it if a decorator made a feature or behavior of it."""
        member: Any = import_module(self.module)
        for name in self.qualified.split("."):
            member = getattr(member, name)
        return getattr(member, "function", member)


class PartWithFunction:
    """A base class of frozen values that may hold a function, which is pickled by name.

    Copies are the value itself.
    """

    __slots__ = ()

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        values = {each.name: getattr(self, each.name) for each in fields(cast("Any", self))}
        if values["function"] is not None and not isinstance(values["function"], ReadingPair):
            values["function"] = self._name(values["function"])
        return _make_part, (type(self), values)

    def _name(self, function: Any) -> FunctionName:
        name = FunctionName(getattr(function, "__module__", ""), getattr(function, "__qualname__", ""))
        try:
            imported = name.find()
        except (ImportError, AttributeError, ValueError):
            imported = None
        if imported is not function:
            raise DefinitionError(
                what=f"{type(self).__name__.lower()} {getattr(self, 'name', '')!r}",
                problem="another process cannot find its function",
                remedy="define it at the top level of a module",
            )
        return name


def _make_part(kind: type[PartWithFunction], values: dict[str, Any]) -> PartWithFunction:
    function = values["function"]
    imported = function.find() if isinstance(function, FunctionName) else function
    return kind(**{**values, "function": imported})


@dataclass(frozen=True, slots=True)
class Feature(PartWithFunction):
    """A feature of the body: one of its readings, or a function of readings.

    Parameters
    ----------
    name
        Name of the feature.
    kind
        Kind of its values: `Continuous()`, `Toroidal(period)` or `Categorical(labels)`.
    reading
        Name of the body's reading that is the value. Give this or `function`, not both.
    of
        Name of the one parameter whose target the reading is about. None: the reading is about the body itself.
    unit
        Unit of the values, such as "m" or "rad". Empty: none.
    doc
        A sentence for people about what the feature means.
    function
        Function that computes the value instead of `reading`. It takes a `ReadingsView` of the robot and one of each
        parameter's target, and returns a column of N values, one per robot, NaN where absent. A `ReadingPair` is a
        function that is data.
    parameters
        Names of the parameters, bound where an automaton uses the feature. With `of`, it is set to that.
    fresh
        Value, 0 or 1, in the tick in which the automaton enters a state, because a coordinator's switch restarts its
        members and thereby clears their flags. None: the value is read as in any other tick.

    Raises
    ------
    DefinitionError
        If there is not exactly one of `reading` and `function`, or `kind` or `fresh` is none of the above.
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
                remedy="give 0 or 1, or None if switches leave it unchanged",
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

    @property
    def pair(self) -> ReadingPair | None:
        """The quotient or the difference of readings that the feature is; None for any other feature."""
        return self.function if isinstance(self.function, ReadingPair) else None


def feature(kind: Kind, *, unit: str = "") -> Callable[[Callable[..., Column]], Feature]:
    """Make a decorator that turns a function of readings into a feature.

    The function's name and docstring become those of the feature. Its arguments after the first are the parameters.

    Parameters
    ----------
    kind
        Kind of the values that the function returns.
    unit
        Unit of the values, such as "m" or "rad". Empty: none.

    Returns
    -------
    Callable[[Callable[..., Column]], Feature]
        A decorator. The function it takes gets a `ReadingsView` of the robot and one more for each parameter, and
        returns a column of N values, one per robot, NaN where absent.

    Examples
    --------
    >>> @feature(Continuous(), unit="m")
    ... def gap(robot, target):
    ...     "Distance to the target, less the robot's radius of 0.1 m."
    ...     return target.distance - 0.1
    >>> gap.parameters
    ('target',)
    """

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
    """A feature that is "yes" while the automaton run by the current state has raised a flag, else "no".

    It is "no" if the current state runs a basic behavior, which raises no flags.

    Parameters
    ----------
    name
        Name of the flag.
    kind
        Kind of the values: yes or no, `BOOLEAN`.
    unit
        Empty: the values have no unit.
    parameters
        Empty: the feature has no parameters.
    """

    name: str
    kind: Kind = BOOLEAN
    unit: str = ""
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CounterFeature:
    """A feature whose value is a counter of the automaton; counters are 0 when the automaton starts.

    Parameters
    ----------
    name
        Name of the counter.
    kind
        Kind of the values: `Continuous()`.
    unit
        Empty: the values have no unit.
    parameters
        Empty: the feature has no parameters.
    """

    name: str
    kind: Kind = Continuous()
    unit: str = ""
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimerFeature:
    """A feature whose value is the number of seconds since a timer of the automaton was set.

    It is absent (NaN) while the timer is not set.

    Parameters
    ----------
    name
        Name of the timer.
    kind
        Kind of the values: `Continuous()`.
    unit
        Unit of the values: "s".
    parameters
        Empty: the feature has no parameters.
    """

    name: str
    kind: Kind = Continuous()
    unit: str = "s"
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimeInState:
    """A feature whose value is the number of seconds since the automaton entered its current state.

    Parameters
    ----------
    name
        Name of the feature.
    kind
        Kind of the values: `Continuous()`.
    unit
        Unit of the values: "s".
    parameters
        Empty: the feature has no parameters.
    """

    name: str = "time_in_state"
    kind: Kind = Continuous()
    unit: str = "s"
    parameters: tuple[str, ...] = ()


OwnFeature: TypeAlias = FlagFeature | CounterFeature | TimerFeature | TimeInState
"""A feature that depends on the automaton itself."""
AnyFeature: TypeAlias = Feature | OwnFeature
"""A feature of the body or of the automaton itself."""


@dataclass(frozen=True, slots=True)
class BoundFeature:
    """A feature with the targets that its parameters are bound to, as an automaton uses it.

    Parameters
    ----------
    feature
        The feature.
    binding
        For each parameter of the feature, the name of a target or of a parameter of the automaton.

    Raises
    ------
    DefinitionError
        If `binding` does not bind exactly the feature's parameters.
    """

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
        if isinstance(self.feature, Feature) and self.feature.pair is not None:
            return self.feature.pair.format(self.binding)
        return format_bound_name(self.feature.name, self.binding, self.feature.parameters)

    @property
    def kind(self) -> Kind:
        """The kind of the feature's values."""
        return self.feature.kind

    @property
    def is_own(self) -> bool:
        """True if the feature depends on the automaton itself (flag, counter, timer or time), not on the body."""
        return not isinstance(self.feature, Feature)


def pair_features(operation: PairOperation, left: BoundFeature, right: BoundFeature) -> BoundFeature:
    """Make the feature that is the quotient or the difference of two features.

    Parameters
    ----------
    operation
        Quotient or difference.
    left
        The dividend, or what is subtracted from: a reading, or a pair of readings.
    right
        The divisor, or what is subtracted.

    Returns
    -------
    BoundFeature
        The feature. Its parameters are A, B and so on, one for each target, which `left` and `right` are bound to.

    Raises
    ------
    DefinitionError
        If a side has a Python function or belongs to the automaton, if there is no such pair of their kinds, as of
        angles to divide, or if numbers of different units are subtracted.
    """
    parameters: dict[str, str] = {}
    for name in (*_list_owners(left), *_list_owners(right)):
        parameters.setdefault(name, chr(ord("A") + len(parameters)))
    text = f"{left} {operation.sign} {right}"
    pair = ReadingPair(operation, *(_make_side(each, parameters, text) for each in (left, right)))
    kind = find_pair_kind(operation, left.kind, right.kind)
    if kind is None:
        raise refuse_pair(text, f"{left} is {left.kind}, and {right} is {right.kind}")
    unit = pair_units(operation, left.feature.unit, right.feature.unit)
    if unit is None:
        units = [each.feature.unit or "no unit" for each in (left, right)]
        raise refuse_pair(text, f"{left} is in {units[0]}, and {right} in {units[1]}")
    binding = Binding({parameter: name for name, parameter in parameters.items()})
    return BoundFeature(make_pair_feature(pair, kind, unit), binding)


def make_pair_feature(pair: ReadingPair, kind: Kind, unit: str) -> Feature:
    """Make the feature of a pair of readings, whose name is what it is computed of."""
    return Feature(str(pair), kind, unit=unit, doc=pair.sentence, function=pair, parameters=pair.parameters)


def _list_owners(bound: BoundFeature) -> tuple[str, ...]:
    """List the targets, or parameters of the automaton, that a feature is about, in the order of its parameters."""
    return tuple(bound.binding[parameter] for parameter in bound.feature.parameters)


def _make_side(bound: BoundFeature, parameters: Mapping[str, str], text: str) -> PairSide:
    """Make a side of a pair, whose parameters have new names, by what they are bound to."""
    feature = bound.feature
    if not isinstance(feature, Feature) or (feature.reading is None and feature.pair is None):
        raise refuse_pair(text, f"{bound} is no reading")
    if feature.fresh is not None:
        raise refuse_pair(text, f"{bound} is reset by switches of a coordinator")
    renamed = {old: parameters[name] for old, name in bound.binding.items()}
    if feature.pair is not None:
        return _rename(feature.pair, renamed)
    name = "" if feature.name == feature.reading else feature.name
    return PairedReading(feature.reading or "", renamed[feature.of] if feature.of else None, name)


def _rename(side: PairSide, parameters: Mapping[str, str]) -> PairSide:
    if isinstance(side, ReadingPair):
        return ReadingPair(side.operation, _rename(side.left, parameters), _rename(side.right, parameters))
    return side if side.of is None else PairedReading(side.reading, parameters[side.of], side.name)
