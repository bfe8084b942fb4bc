"""A foraging world as plain data, for drawing and for looking at."""

from __future__ import annotations

from typing import NamedTuple


class SourceView(NamedTuple):
    """One source of food, for drawing."""

    x: float
    y: float
    amount: int
    at_first: int


class ForageView(NamedTuple):
    """One world as plain data, for drawing."""

    width: float
    height: float
    reach: float
    radius: float
    time_s: float
    x: float
    y: float
    heading: float
    stored: int
    capacity: int
    delivered: int
    station: tuple[float, float]
    sources: tuple[SourceView, ...]


class Frame(NamedTuple):
    """A moment of a run: the world, and what its robot is doing (the name of a state or behavior)."""

    view: ForageView
    doing: str
