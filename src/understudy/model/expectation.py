"""Outcomes: what a lesson promises - from here, the automaton raises this flag within so many seconds."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from understudy.errors import DefinitionError
from understudy.model.binding import NOTHING_BOUND, Binding

LONGEST_S = 86_400.0
"""Nobody waits longer than a day."""


@dataclass(frozen=True, slots=True)
class Expectation:
    """From the moment of `snapshot`, started afresh, the automaton raises `flag` within `within_s` seconds.

    `scenario` is the file of the world it was taken of, as it was then, called `world`; `agent` the one who is to do
    it, of the sort of squads `sort` where it is a coordinator (otherwise ""), `targets` what the parameters stand for.
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
