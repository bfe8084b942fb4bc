"""Examples: what was shown, the source of everything learned (paper section 3.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from understudy.model.binding import NOTHING_BOUND, Binding


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

    @property
    def pressed(self) -> bool:
        """Whether a press made it: everything but watched."""
        return self.kind != ExampleKind.WATCHED

    @property
    def shown(self) -> bool:
        """Whether the demonstrator said it: a directive or a confirmation."""
        return self.kind in (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION)
