"""Contradictions between drivers that a person settled, one by one or by trusting one driver in everything."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from understudy.addons.recordings.driver_contradictions import (
    DriverContradiction,
    find_driver_contradictions,
    settle_driver_contradictions,
)
from understudy.model.lesson import Lesson


class DriverSettlement(NamedTuple):
    """The decision which of two drivers is right about a state and the next states that they chose.

    It also holds for the contradiction that is found when the labels changed, and the lesson was made again.
    """

    state: str
    drivers: tuple[str, str]
    nexts: tuple[str, str]
    trust: str

    @classmethod
    def from_contradiction(cls, contradiction: DriverContradiction, trust: str) -> DriverSettlement:
        """Make the settlement of a contradiction in favor of one of its drivers."""
        return cls(contradiction.state, contradiction.drivers, contradiction.nexts, trust)

    def list_matching(self, lesson: Lesson) -> list[DriverContradiction]:
        """List the contradictions of a lesson that this settles."""
        return [
            each
            for each in find_driver_contradictions(lesson)
            if (each.state, each.drivers, each.nexts) == self[:3]
        ]


class SettledContradiction(NamedTuple):
    """A contradiction, and the driver whose examples were kept."""

    contradiction: DriverContradiction
    trust: str


class SettledLesson(NamedTuple):
    """A lesson in which contradictions were settled: those that were, and those that are left."""

    lesson: Lesson
    settled: tuple[SettledContradiction, ...]
    open: tuple[DriverContradiction, ...]


def settle_lesson(
    lesson: Lesson, settlements: Sequence[DriverSettlement], trust: str | None
) -> SettledLesson:
    """Settle contradictions of a lesson: first one by one, then the others of a driver who is trusted."""
    settled: dict[DriverSettlement, SettledContradiction] = {}
    for chosen in settlements:
        while matching := chosen.list_matching(lesson):
            settled.setdefault(chosen, SettledContradiction(matching[0], chosen.trust))
            lesson = settle_driver_contradictions(lesson, chosen.trust, matching)
    left = find_driver_contradictions(lesson)
    if trust is not None:
        settled |= dict(_list_trusted(left, trust))
        lesson = settle_driver_contradictions(lesson, trust)
        left = find_driver_contradictions(lesson)
    return SettledLesson(lesson, tuple(settled.values()), left)


def _list_trusted(
    contradictions: Sequence[DriverContradiction], trust: str
) -> Iterator[tuple[DriverSettlement, SettledContradiction]]:
    for each in contradictions:
        if trust in each.drivers:
            yield DriverSettlement.from_contradiction(each, trust), SettledContradiction(each, trust)
