"""Expectations of a lesson: tests that the automaton raises a flag within a time after a stored moment."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from understudy.errors import DefinitionError
from understudy.model.binding import NOTHING_BOUND, Binding

LONGEST_S = 86_400.0
"""The longest time, in seconds, that an expectation may allow: one day."""


@dataclass(frozen=True, slots=True)
class Expectation:
    """A test of a lesson: from a stored situation, the automaton must raise a flag in time.

    The automaton is restarted in that situation and must raise `flag` within `within_s` seconds. `snapshot` is
    the state of the simulated world then, `scenario` the content of that world's scenario file, and `world` the
    world's name. `agent` is the number of the robot that is tested or, if `sort` is not empty, of the
    coordinator of a squad of the sort `sort`. `targets` binds the automaton's parameters.
    """

    flag: str
    within_s: float
    world: str
    scenario: str
    snapshot: bytes
    agent: int = 0
    sort: str = ""
    targets: Binding = NOTHING_BOUND

    def __post_init__(self) -> None:
        if not (isfinite(self.within_s) and 0.0 < self.within_s <= LONGEST_S):
            raise DefinitionError(
                what="an outcome",
                problem=f"it is to come within {self.within_s:g} s",
                remedy=f"give seconds above 0, and at most {LONGEST_S:g}",
            )

    def __str__(self) -> str:
        bound = "".join(f", {parameter} = {target}" for parameter, target in self.targets.items())
        return f"{self.flag} within {self.within_s:g} s in {self.world}{bound}"
