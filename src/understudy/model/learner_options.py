"""The options for learning from a lesson, which are stored with it: the method, and how presses are understood."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from types import MappingProxyType
from typing import Literal, TypeAlias

from understudy.errors import DefinitionError

LEARNER_VERSION = 2
"""The version of the learner, raised whenever the same lesson would give another automaton.

Trees stored by older versions are learned again. Version 1 let trees decide on the absence of a value even if only
watched examples had it absent.
"""

LONGEST_REACTION_S = 1.0
"""The number of seconds before each press that the record keeps; `reaction_s` cannot be longer."""


BOUNDARIES = ("default keeps the gap", "midpoint")
"""The rules for thresholds that `TreeOptions.boundary` may name."""
ORDERS = ("gain first", "flags first")
"""The orders of tests that `TreeOptions.order` may name."""


@dataclass(frozen=True, slots=True)
class TreeOptions:
    """The settings for learning decision trees.

    Parameters
    ----------
    boundary
        Where a threshold lies between two neighboring values. "default keeps the gap": beside the value that
        the demonstrator showed, if the other value belongs to defaults only. "midpoint": in the middle.
        Stateless automata and lessons with watched examples always use midpoints.
    defaults
        Whether to learn from the examples that were recorded automatically after a switch.
    pruning
        Tests are removed that save at most this many examples from a wrong decision, for each leaf that they
        add. 0 removes none.
    order
        Which of the possible tests is selected. "flags first": one that tells exactly when a flag is raised, if there
        is one; and four watched examples or more, beyond all presses for a decision, limit it. "gain first": the one
        with the highest gain ratio, as in C4.5.

    Raises
    ------
    DefinitionError
        If `pruning` is negative, infinite or NaN, or `boundary` or `order` is neither of the two.
    """

    boundary: Literal["default keeps the gap", "midpoint"] = "default keeps the gap"
    defaults: bool = True
    pruning: float = 0.0
    order: Literal["gain first", "flags first"] = "flags first"

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
        if self.order not in ORDERS:
            raise DefinitionError(
                what="decision trees",
                problem=f"their order is {self.order!r}",
                remedy=f"give {' or '.join(map(repr, ORDERS))}",
            )
        object.__setattr__(self, "pruning", float(self.pruning))  # an int would be another hash


@dataclass(frozen=True, slots=True)
class SklearnOptions:
    """The settings for learning with a classifier of scikit-learn, which gives no readable conditions.

    Parameters
    ----------
    classifier
        Class name of the classifier, such as "SVC". `understudy.learning.sklearn_adapter.ALLOWED` lists those that
        can be used; `learn` refuses others.
    parameters
        Parameters of the classifier by name; the same list says which.
    """

    classifier: str
    parameters: Mapping[str, float | int | str | bool | None] = field(
        default_factory=lambda: MappingProxyType({})
    )


Learner: TypeAlias = TreeOptions | SklearnOptions
"""The learning method of a lesson and its options."""


@dataclass(frozen=True, slots=True)
class LearnerOptions:
    """The options for learning from a lesson, which are stored with it.

    Parameters
    ----------
    reaction_s
        Reaction time by which the demonstrator's presses are too late, in s from 0 to 1.
    watched
        Whether to record the robot's decisions as examples if the demonstrator watches and does not object.
    learner
        The learning method and its options; decision trees by default.
    unlearning
        Whether a correction puts the examples that misled the robot in quarantine.
    live
        Whether the robot decides by itself from the first press on, and learns at every press. False: it does what
        it was told last until it is tested, as in the paper.

    Raises
    ------
    DefinitionError
        If `reaction_s` is not from 0 to 1.
    """

    reaction_s: float = 0.0
    watched: bool = False
    learner: Learner = TreeOptions()
    unlearning: bool = False
    live: bool = False

    def __post_init__(self) -> None:
        if not 0.0 <= self.reaction_s <= LONGEST_REACTION_S:
            raise DefinitionError(
                what="lesson options",
                problem=f"reaction_s is {self.reaction_s}",
                remedy=f"give seconds between 0 and {LONGEST_REACTION_S}",
            )
        object.__setattr__(self, "reaction_s", float(self.reaction_s))  # an int would be another hash
