"""Lessons and examples: everything that a demonstrator chose and showed for one automaton.

Examples are the source; transition functions are learned from them and can be learned again (docs/learning.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import StrEnum
from functools import cached_property
from math import isnan, nan
from typing import TYPE_CHECKING, Any

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.drawing import Axes, call_markup, call_plot, format_number_of, format_repr
from understudy.model.example_source import ExampleSource
from understudy.model.features import ReadingKey
from understudy.model.learner_options import LearnerOptions, SklearnOptions
from understudy.model.property import Property
from understudy.model.value_kinds import Column

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from understudy.model.library import Kit


class ExampleKind(StrEnum):
    """The way in which an example was recorded.

    "directive": the demonstrator switched to another state. "default": added automatically right after a switch, to
    stay in the new state. "confirmation": the demonstrator confirmed the current state. "watched": the demonstrator
    watched a decision of the robot and did not object.
    """

    DIRECTIVE = "directive"  # the demonstrator switched
    DEFAULT = "default"  # stay, recorded automatically right after a switch
    CONFIRMATION = "confirmation"  # stay, because the demonstrator said so
    WATCHED = "watched"  # accepted in silence


@dataclass(frozen=True, slots=True)
class Example:
    """One training example: in `state`, given these feature values, the next state is `next`.

    Parameters
    ----------
    number
        Number of the example, unique within its lesson.
    state
        Name of the state in which the example was recorded.
    values
        Feature vector, in the order of the automaton's features. NaN means absent.
    next
        Name of the state that should come next; `state` itself to stay.
    kind
        How the example was recorded.
    correction
        True if it corrects a decision of the robot.
    edited
        True if a person edited the values, which are then never computed from the record again.
    moment
        Row of the lesson's `record` at which it was recorded. None for an example typed into a table.
    window
        Number of rows before `moment` that belong to the same episode, and to which a late press may be shifted.
    own
        Values of the automaton's own features at that moment (flags, counters, timers, time in state), by name.
    binding
        Targets to which the automaton's parameters were bound at that moment.
    quarantined
        Reason why the example is left out of learning. Empty: it is used.
    reaction_s
        Reaction time of the person who pressed, in s. None: that of the lesson.
    source
        Place in a recording that it was made from. None: a session recorded it, or a person typed it.
    """

    number: int
    state: str
    values: tuple[float, ...]
    next: str
    kind: ExampleKind
    correction: bool = False
    edited: bool = False
    moment: int | None = None
    window: int = 0
    own: Mapping[str, float] = field(default_factory=dict)
    binding: Binding = NOTHING_BOUND
    quarantined: str = ""
    reaction_s: float | None = None
    source: ExampleSource | None = None

    def __repr__(self) -> str:
        answer = "stay" if self.next == self.state else f"go to {self.next}"
        values = ", ".join(f"{value:.4g}" for value in self.values)
        facts = [
            f"in {self.state} {answer}",
            f"values ({values})",
            *(["in quarantine"] if self.quarantined else []),
        ]
        return format_repr(self, f"{self.number} ({self.kind})", *facts)

    def __reduce__(self) -> tuple[Any, ...]:
        return _make_example, ({each.name: getattr(self, each.name) for each in fields(self)},)

    @property
    def is_from_press(self) -> bool:
        """True for every example except watched ones: a press of the demonstrator recorded it."""
        return self.kind != ExampleKind.WATCHED

    @property
    def is_shown(self) -> bool:
        """True for directives and confirmations, which the demonstrator gave on purpose."""
        return self.kind in (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION)


def _make_example(attributes: dict[str, Any]) -> Example:
    """Build an unpickled example in which all absent values are the object `math.nan`.

    Only then do equal examples compare equal, because Python finds NaNs in tuples equal only if they are one
    object.
    """
    values = tuple(nan if isnan(value) else value for value in attributes["values"])
    own = {name: nan if isnan(value) else value for name, value in attributes["own"].items()}
    return Example(**{**attributes, "values": values, "own": own})


class ReadingLog:
    """All readings of the body at the moments a lesson keeps: presses, the second before each, and watched ticks.

    A log never changes.

    Parameters
    ----------
    keys
        The readings: a name and a target each.
    values
        A row per moment and a column per key, shape [M, K]; NaN where absent.
    seconds
        The time of each moment on the demonstrator's clock in s, shape [M].
    """

    def __init__(
        self,
        keys: tuple[ReadingKey, ...] = (),
        values: NDArray[np.float64] | None = None,
        seconds: Column | None = None,
    ) -> None:
        self.keys = keys
        self._columns: Sequence[Sequence[float]] = ()
        self._seconds: Sequence[float] | Column = () if seconds is None else seconds
        if values is not None:
            self.__dict__["values"] = values

    @classmethod
    def from_columns(
        cls, keys: tuple[ReadingKey, ...], columns: Sequence[Sequence[float]], seconds: Sequence[float]
    ) -> ReadingLog:
        """Make a log of a column per key; NumPy is imported only when its arrays are read."""
        log = cls(keys)
        log._columns, log._seconds = columns, seconds
        return log

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """A row per moment and a column per key; NaN where absent."""
        import numpy as np

        return np.column_stack(self._columns) if self._columns else np.zeros((len(self), len(self.keys)))

    @cached_property
    def seconds(self) -> Column:
        """The time of each moment on the demonstrator's clock in s."""
        import numpy as np

        return np.array(self._seconds, np.float64)

    def __eq__(self, other: object) -> bool:
        import numpy as np

        return (
            isinstance(other, ReadingLog)
            and self.keys == other.keys
            and np.array_equal(self.values, other.values, equal_nan=True)
            and np.array_equal(self.seconds, other.seconds)
        )

    def __repr__(self) -> str:
        facts = format_number_of(len(self), "moment"), format_number_of(len(self.keys), "reading")
        return format_repr(self, f"of {facts[0]}", facts[1])

    def __len__(self) -> int:
        return len(self._seconds)

    def with_rows(self, values: Sequence[Sequence[float]], seconds: Sequence[float]) -> ReadingLog:
        """Make a record with rows added at the end; this one stays unchanged."""
        import numpy as np

        added = np.array(values, np.float64).reshape(len(values), len(self.keys))
        return ReadingLog(self.keys, np.vstack([self.values, added]), np.append(self.seconds, seconds))


@dataclass(frozen=True, slots=True)
class Lesson:
    """A lesson: everything a demonstrator chose and showed for one automaton.

    Parameters
    ----------
    automaton
        The automaton's states, features and parameters, without transition functions.
    examples
        The examples.
    options
        How to learn from the examples.
    record
        Readings at the moments of the examples, from which features can be computed again.
    properties
        What the learned automaton must do, or never do, from stored moments on.
    goal
        What success means in any world: a property of seeded worlds, whose seeds are not used. None: that a flag is
        raised, or that the goal of the world is reached.
    kit
        What the automaton needs and no program defines, such as the readings and commands of a recording. None: all
        that it uses is defined elsewhere.

    Raises
    ------
    DefinitionError
        If the automaton has transition functions.
    """

    automaton: Automaton
    examples: tuple[Example, ...] = ()
    options: LearnerOptions = LearnerOptions()
    record: ReadingLog = field(default_factory=ReadingLog)
    properties: tuple[Property, ...] = ()
    goal: Property | None = None
    kit: Kit | None = None

    def __post_init__(self) -> None:
        if self.automaton.transitions:
            raise DefinitionError(
                what=f"lesson {self.automaton.name!r}",
                problem="its automaton already has transition functions",
                remedy="a lesson holds examples only; learn from it to get transition functions",
            )

    def __repr__(self) -> str:
        automaton, states = self.automaton, len(self.automaton.states)
        facts = [format_number_of(len(self.examples), "example"), format_number_of(states, "state")]
        return format_repr(
            self, repr(self.name), *facts, format_number_of(len(automaton.features), "feature")
        )

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_lesson_html", self)

    @property
    def name(self) -> str:
        """The name of the lesson's automaton."""
        return self.automaton.name

    @classmethod
    def from_frame(
        cls,
        frame: object,
        *,
        name: str | None = None,
        automaton: Automaton | None = None,
        flags: Sequence[str] | None = None,
    ) -> Lesson:
        """Make a lesson of a data frame with one row per example, the table that `to_frame` makes.

        The columns `state`, `next` and `kind`, and one FEATURE:KIND for each feature, may come in any order. Rows are
        counted from 0 in errors.

        Parameters
        ----------
        frame
            A data frame of Polars, pandas, pyarrow or another package that narwhals knows. A missing cell, None or
            NaN, is an absent value (NaN).
        name
            Name of the lesson; that of `automaton`, or else "lesson", if None.
        automaton
            The automaton whose states and features the examples are of; its transition functions are left out. None:
            the states are `start` and all that the frame names, in alphabetical order, each running the behavior of
            its own name, and each feature is the body's reading of its own name.
        flags
            Names of the states in which the automaton stops and raises a flag, if `automaton` is None. None: "done"
            and "failed", if they have no examples of their own.

        Returns
        -------
        Lesson
            The lesson, with default options and without a record of readings.

        Raises
        ------
        ExtraMissing
            If narwhals is not installed.
        DefinitionError
            If the frame has no examples, a wrong or missing column, or a cell that its column cannot have.
        """
        from understudy.model.example_frame import parse_example_frame

        return parse_example_frame(frame, name=name, automaton=automaton, flags=flags)

    def to_frame(self, backend: str | None = None) -> Any:
        """Make a data frame of the examples, one row each, the table that `understudy learn table` reads from CSV.

        The frame has the states, the kind and the feature values of each example. It does not have corrections,
        quarantine, sources, the record of readings, the options, or what the states run.

        Parameters
        ----------
        backend
            The package that makes the frame: "polars", "pandas" or "pyarrow". None: the first of them, in this order,
            that is installed.

        Returns
        -------
        DataFrame or Table
            The columns `state`, `next` and `kind`, and one FEATURE:KIND for each feature, in the feature's unit. Labels
            are texts. An absent value is null (NaN in pandas).

        Raises
        ------
        ExtraMissing
            If narwhals is not installed.
        SettingError
            If the package is not installed, or is another one.
        """
        from understudy.model.example_frame import make_example_frame

        return make_example_frame(self, backend=backend)

    @property
    def teaches(self) -> bool:
        """True if at least one state gets a transition function from it.

        A state gets one if a press in that state made an example that is used.
        """
        learner, stateless = self.options.learner, self.automaton.stateless
        defaults = isinstance(learner, SklearnOptions) or learner.defaults
        lasting = {state.name for state in self.automaton.states if state.flag is None}
        return any(
            example.is_shown or (example.is_from_press and defaults and not stateless)
            for example in self.examples
            if example.state in lasting and not example.quarantined
        )

    def plot(
        self,
        x: str,
        y: str,
        *,
        state: str | None = None,
        at: Mapping[str, float | str] | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Plot the examples of a state and the learned decisions in the plane of two features.

        Labels, angles and absent values have their places on the axes, too. Next states differ in color, marker and
        hatch. A tree that decides on further features is shown for one value of each, which the plot names.

        Parameters
        ----------
        x
            The feature to the right, such as "distance_to(A)", or "distance_to" if no other has this name.
        y
            The feature upward.
        state
            Name of the state. None: the only one with examples.
        at
            Values of further features, by name: numbers, or labels. Those left out are at the median of the examples,
            their mean direction, or their most common label.
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes.

        Raises
        ------
        UnknownName
            If the lesson has no such feature, state or label.
        SettingError
            If the state is missing or has no examples, or `x` and `y` are one feature.
        """
        return call_plot("lesson_plot:plot_lesson", self, x, y, state=state, at=at, ax=ax)
