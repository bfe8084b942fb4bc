"""The view: what a demonstrator can see of a session at one moment, and nothing more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from understudy.training.trainee import Mode


@dataclass(frozen=True, slots=True)
class SessionView:
    """One moment of a session as a person sees it.

    `features` has the current value of each chosen feature by its label ("distance_to(A)"); absent is NaN, a
    categorical value is its label's index. `path` is the current state of every level; `flag` is what the
    automaton under training has raised.
    """

    time_s: float
    mode: Mode
    state: str
    path: tuple[str, ...]
    flag: str | None
    features: Mapping[str, float]
    states: tuple[str, ...]
    targets: Mapping[str, str]
    waiting: str | None  # the state of a press that acts at the next tick
    examples: int
    undoable: str | None
    redoable: str | None
