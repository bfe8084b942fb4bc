"""How speeds are measured: everything that is compared takes turns, round by round, and medians are told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any, Protocol

Row = dict[str, Any]


class Subject(Protocol):
    """What is measured: robots that can be set back to the start, and run."""

    robots: int

    def reset(self) -> None:
        """Back to the start; not measured."""
        ...

    def run(self, ticks: int) -> None:
        """Run for so many ticks."""
        ...


@dataclass(frozen=True)
class Case:
    """One row to measure: `make` gives the subject, which runs `ticks` from the start in every round."""

    task: str
    make: Callable[[], Subject]
    threads: int
    ticks: int


@dataclass(frozen=True)
class Goal:
    """What a measurement must reach: `value` of the rows at least `least` (or at most `most`)."""

    what: str
    value: Callable[[Sequence[Row]], float]
    least: float | None = None
    most: float | None = None

    def of(self, rows: Sequence[Row]) -> Row:
        """The goal beside what was reached."""
        value = self.value(rows)
        passed = (self.least is None or value >= self.least) and (self.most is None or value <= self.most)
        limits = {"least": self.least, "most": self.most}
        given = {key: limit for key, limit in limits.items() if limit is not None}
        return {"what": self.what, "value": value, **given, "passed": passed}


def measure(cases: Sequence[Case], *, rounds: int) -> list[Row]:
    """A row per case, of robot-ticks per second: the median over rounds in which the cases take turns.

    A round before them does not count: it compiles, and fills caches. `spread` is the range between the quartiles
    as a share of the median; `slowest` and `fastest` are the rounds at the ends.
    """
    subjects = [case.make() for case in cases]
    speeds: list[list[float]] = [[] for _ in cases]
    for _ in range(rounds + 1):
        for case, subject, measured in zip(cases, subjects, speeds, strict=True):
            subject.reset()
            measured.append(subject.robots * case.ticks / seconds(subject, case.ticks))
    return [
        _row(case, subject, sorted(measured[1:]))
        for case, subject, measured in zip(cases, subjects, speeds, strict=True)
    ]


def seconds(subject: Subject, ticks: int) -> float:
    """How long so many ticks take."""
    began = perf_counter()
    subject.run(ticks)
    return perf_counter() - began


def _row(case: Case, subject: Subject, speeds: Sequence[float]) -> Row:
    middle = median(speeds)
    quarter = len(speeds) // 4
    return {
        "task": case.task,
        "robots": subject.robots,
        "threads": case.threads,
        "robot_ticks_per_s": middle,
        "spread": (speeds[-1 - quarter] - speeds[quarter]) / middle,
        "slowest": speeds[0],
        "fastest": speeds[-1],
        "ticks": case.ticks,
        "rounds": len(speeds),
    }


def speed(rows: Iterable[Row], task: str, robots: int, *, threads: int | None = None) -> float:
    """Robot-ticks per second of a row; without threads, of the fastest."""
    return max(
        float(row["robot_ticks_per_s"])
        for row in rows
        if row["task"] == task and row["robots"] == robots and threads in (None, row["threads"])
    )


def result(rows: Sequence[Row], goals: Sequence[Goal]) -> Row:
    """What a measurement tells: rows, goals, and whether all were reached."""
    told = [goal.of(rows) for goal in goals]
    return {"results": list(rows), "goals": told, "passed": all(goal["passed"] for goal in told)}
