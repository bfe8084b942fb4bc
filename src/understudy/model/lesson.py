"""Examples and lessons: what was shown of one automaton, with its features, states and options.

Examples are the source; transition functions are a build product (ARCHITECTURE section 4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import StrEnum
from math import isfinite, isnan, nan
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.expectation import Expectation
from understudy.model.features import ReadingKey
from understudy.model.kinds import Column


class ExampleKind(StrEnum):
    """How an example came about."""

    DIRECTIVE = "directive"  # the demonstrator switched
    DEFAULT = "default"  # stay, recorded automatically right after a switch
    CONFIRMATION = "confirmation"  # stay, because the demonstrator said so
    WATCHED = "watched"  # accepted in silence


@dataclass(frozen=True, slots=True)
class Example:
    """(state, feature vector, next state), with where it came from.

    `values` follow the lesson's features. `moment` is the row of the lesson's record at the tick of the press
    (None for an example typed into a table); `window` rows before it belong to the same episode, so that a late
    press can be shifted. `own` holds the automaton's own readings then (flags, counters, timers, time in state),
    `binding` what the automaton's parameters stood for. `edited` values are never computed again. One that is
    `quarantined` teaches nothing: the text says why, and without one it teaches as ever.
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

    def __reduce__(self) -> tuple[Any, ...]:
        return _make_example, ({each.name: getattr(self, each.name) for each in fields(self)},)

    @property
    def is_from_press(self) -> bool:
        """Whether a press made it: everything but watched."""
        return self.kind != ExampleKind.WATCHED

    @property
    def is_shown(self) -> bool:
        """Whether the demonstrator said it: a directive or a confirmation."""
        return self.kind in (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION)


def _make_example(kept: dict[str, Any]) -> Example:
    """An example that was pickled; what is absent is the one `nan`, by which equal examples are equal."""
    values = tuple(nan if isnan(value) else value for value in kept["values"])
    own = {name: nan if isnan(value) else value for name, value in kept["own"].items()}
    return Example(**{**kept, "values": values, "own": own})


LEARNER_VERSION = 2
"""Raised whenever the same lesson would give another automaton, so that stored trees are built again. Version 1 let
absence that only watched examples had seen decide.
"""

LONGEST_REACTION_S = 1.0
"""How long before a press its record reaches, so that `reaction_s` can be chosen afterwards."""


BOUNDARIES = ("default keeps the gap", "midpoint")


@dataclass(frozen=True, slots=True)
class TreeOptions:
    """Learn decision trees. `boundary` says where cuts go; lessons with watched examples take midpoints.

    Without `defaults`, what was recorded automatically after a switch teaches nothing. `pruning` is how many examples
    each leaf of a question must set right for the question to stay; 0, as ever unless chosen, prunes nothing.
    """

    boundary: Literal["default keeps the gap", "midpoint"] = "default keeps the gap"
    defaults: bool = True
    pruning: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.pruning) and self.pruning >= 0.0):
            raise DefinitionError(
                what="decision trees",
                problem=f"their pruning is {self.pruning}",
                remedy="give how many examples a leaf must set right: 0 prunes nothing",
            )
        if self.boundary not in BOUNDARIES:
            raise DefinitionError(
                what="decision trees",
                problem=f"their boundary is {self.boundary!r}",
                remedy=f"give {' or '.join(map(repr, BOUNDARIES))}",
            )
        object.__setattr__(self, "pruning", float(self.pruning))  # an int would be another hash


@dataclass(frozen=True, slots=True)
class SklearnOptions:
    """Learn with a classifier of scikit-learn, from an allowed list: unreadable and slower than trees."""

    classifier: str
    parameters: Mapping[str, float | int | str | bool | None] = field(
        default_factory=lambda: MappingProxyType({})
    )


Learner: TypeAlias = TreeOptions | SklearnOptions


@dataclass(frozen=True, slots=True)
class LearnerOptions:
    """What a lesson chose of how it is learned; stored with it.

    `reaction_s`: how late presses come, s (0 to 1). `watched`: silence is consent, record it. `unlearning`: a
    correction puts the bad examples that misled the robot in quarantine.
    """

    reaction_s: float = 0.0
    watched: bool = False
    learner: Learner = TreeOptions()
    unlearning: bool = False

    def __post_init__(self) -> None:
        if not 0.0 <= self.reaction_s <= LONGEST_REACTION_S:
            raise DefinitionError(
                what="lesson options",
                problem=f"reaction_s is {self.reaction_s}",
                remedy=f"give seconds between 0 and {LONGEST_REACTION_S}",
            )
        object.__setattr__(self, "reaction_s", float(self.reaction_s))  # an int would be another hash


@dataclass(frozen=True)
class ReadingLog:
    """All readings of the body at the moments a lesson keeps: each press, the second before it, watched
    ticks.

    `values` [M, K] has a column per key and a row per moment; `seconds` [M] is the demonstrator's time.
    """

    keys: tuple[ReadingKey, ...] = ()
    values: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    seconds: Column = field(default_factory=lambda: np.zeros(0))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ReadingLog)
            and self.keys == other.keys
            and np.array_equal(self.values, other.values, equal_nan=True)
            and np.array_equal(self.seconds, other.seconds)
        )

    def __len__(self) -> int:
        return len(self.seconds)

    def with_rows(self, values: Sequence[Sequence[float]], seconds: Sequence[float]) -> ReadingLog:
        """This record with rows added."""
        added = np.array(values, np.float64).reshape(-1, len(self.keys))
        return ReadingLog(self.keys, np.vstack([self.values, added]), np.append(self.seconds, seconds))


@dataclass(frozen=True, slots=True)
class Lesson:
    """What a demonstrator chose and showed for one automaton, which holds no transition functions here; `outcomes` are
    what it promises.
    """

    automaton: Automaton
    examples: tuple[Example, ...] = ()
    options: LearnerOptions = LearnerOptions()
    record: ReadingLog = ReadingLog()
    outcomes: tuple[Expectation, ...] = ()

    def __post_init__(self) -> None:
        if self.automaton.transitions:
            raise DefinitionError(
                what=f"lesson {self.automaton.name!r}",
                problem="its automaton already has transition functions",
                remedy="a lesson holds what was shown; learn from it to get them",
            )

    @property
    def name(self) -> str:
        """The automaton's name."""
        return self.automaton.name

    @property
    def teaches(self) -> bool:
        """Whether any state gets a transition function from it: a press in that state made an example that counts."""
        learner, stateless = self.options.learner, self.automaton.stateless
        defaults = isinstance(learner, SklearnOptions) or learner.defaults
        lasting = {state.name for state in self.automaton.states if state.flag is None}
        return any(
            example.is_shown or (example.is_from_press and defaults and not stateless)
            for example in self.examples
            if example.state in lasting and not example.quarantined
        )
